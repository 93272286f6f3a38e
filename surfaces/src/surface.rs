//! The contactable surface: a frame, a convex polygon in it, and how well both are known.

mod check;
mod record;

use nalgebra::{Isometry3, Point2, Point3, Vector3};
use serde::{Deserialize, Serialize};

use record::SurfaceRecord;

use crate::{ConvexPolygon, EdgeKind, Error, ThinBody, edge};

/// Where a surface is known from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Extracted from a scan.
    Scan,
    /// A face of a mesh of the environment.
    Mesh,
    /// Given in a file of surfaces.
    #[default]
    File,
    /// The ground under the robot's feet at the start, from its own kinematics.
    Robot,
}

/// A plane convex surface that a robot may touch.
///
/// Frame S: x and y are tangents, z is the normal that points out of the body, toward the free
/// space; the origin is at the centroid of the points the surface was made from. A contact holds
/// when the patch frame C lies in S's plane with z_C = +z_S and C's polygon inside S's polygon.
#[allow(non_snake_case)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "SurfaceRecord", into = "SurfaceRecord")]
pub struct Surface {
    /// Name, unique in its set.
    pub id: String,
    /// Pose of S in W.
    pub X_WS: Isometry3<f64>,
    /// The convex polygon in S, counter-clockwise about z_S, m.
    pub polygon: ConvexPolygon,
    /// Rings of the outline in S before it was made convex, the outer one first, then holes, m;
    /// may be empty.
    pub outline: Vec<Vec<[f64; 2]>>,
    /// What ends the face at each edge of each ring, from a corner to the next; empty where all
    /// edges are real.
    pub outline_edges: Vec<Vec<EdgeKind>>,
    /// The same of the polygon's edges, in their order; empty where all are real.
    pub polygon_edges: Vec<EdgeKind>,
    /// Distance by which uncertainty shrinks the polygon at its edges that are no seams, m; the
    /// largest of [`Self::edge_insets_m`] where there are any.
    pub inset_m: f64,
    /// The same edge by edge of the polygon, in their order; empty where it is [`Self::inset_m`].
    pub edge_insets_m: Vec<f64>,
    /// Distance by which the face may go on beyond the polygon, m: the body behind it is wider by
    /// that.
    pub edge_m: f64,
    /// Depth that the body behind the face may have, m, where it is more than every body is taken
    /// to have: nothing was seen of what lies there.
    pub depth_m: f64,
    /// Number of points the plane was fitted to; 0 when it was not fitted.
    pub inliers: usize,
    /// Root mean square distance of those points from the plane, m.
    pub rms_m: f64,
    /// Covariance of (rotation about x_S, rotation about y_S, offset along z_S): rad, rad, m.
    pub plane_covariance: Option<[[f64; 3]; 3]>,
    /// Where the surface is known from.
    pub source: Source,
    /// Name of the plane face of which this is one convex piece: surfaces that name the same face
    /// lie in one plane and may overlap.
    pub face: Option<String>,
}

/// Corners of two outlines nearer than this are one, m: pieces of a face are moved one by one.
const SAME_CORNER_M: f64 = 0.005;

impl Surface {
    /// A surface known exactly: no inset, no points, no covariance, source [`Source::File`].
    #[allow(non_snake_case)]
    pub fn new(id: impl Into<String>, X_WS: Isometry3<f64>, polygon: ConvexPolygon) -> Self {
        Self {
            id: id.into(),
            X_WS,
            polygon,
            outline: Vec::new(),
            outline_edges: Vec::new(),
            polygon_edges: Vec::new(),
            inset_m: 0.0,
            edge_insets_m: Vec::new(),
            edge_m: 0.0,
            depth_m: 0.0,
            inliers: 0,
            rms_m: 0.0,
            plane_covariance: None,
            source: Source::default(),
            face: None,
        }
    }

    /// The unit outward normal z_S, in W.
    #[allow(non_snake_case)]
    pub fn normal_W(&self) -> Vector3<f64> {
        self.X_WS.rotation * Vector3::z()
    }

    /// The polygon in which patches must lie: [`Self::polygon`] shrunk by [`Self::insets_m`]; None
    /// when nothing is left of it.
    pub fn effective_polygon(&self) -> Option<ConvexPolygon> {
        self.polygon.inset_edges(&self.insets_m())
    }

    /// The distance by which uncertainty shrinks the polygon at each of its edges, m: nothing at
    /// seams, beyond which the face goes on.
    pub fn insets_m(&self) -> Vec<f64> {
        if !self.edge_insets_m.is_empty() {
            return self.edge_insets_m.clone();
        }
        let of_edge = |i: usize| match self.polygon_edges.get(i) {
            Some(EdgeKind::Seam) => 0.0,
            _ => self.inset_m,
        };
        (0..self.polygon.vertices().len()).map(of_edge).collect()
    }

    /// Shrinks the polygon by these distances at its edges, in their order, m.
    pub fn set_insets(&mut self, insets_m: Vec<f64>) {
        self.inset_m = insets_m.iter().copied().fold(0.0, f64::max);
        self.edge_insets_m = if self.inset_m > 0.0 {
            insets_m
        } else {
            Vec::new()
        };
    }

    /// The polygon's vertices in W, counter-clockwise about the normal, m.
    #[allow(non_snake_case)]
    pub fn vertices_W(&self) -> Vec<Point3<f64>> {
        let vertices = self.polygon.vertices().iter();
        vertices.map(|v| self.point_W(v)).collect()
    }

    /// The point of the plane at `p_S` (m, in S), in W.
    #[allow(non_snake_case)]
    pub fn point_W(&self, p_S: &Point2<f64>) -> Point3<f64> {
        self.X_WS * Point3::new(p_S.x, p_S.y, 0.0)
    }

    /// The signed distance of a point of W from the plane, positive on the free side, m.
    #[allow(non_snake_case)]
    pub fn height_of(&self, p_W: &Point3<f64>) -> f64 {
        self.X_WS.inverse_transform_point(p_W).z
    }

    /// Whether all the points are on the body's side of the plane, up to `tol_m`.
    ///
    /// What lies there cannot be touched by a link whose patch rests on the surface: such bodies
    /// (the prism behind the surface, its neighbours in the same plane, the riser under a tread)
    /// are excepted from that link's collision constraints.
    #[allow(non_snake_case)]
    pub fn is_behind(&self, points_W: &[Point3<f64>], tol_m: f64) -> bool {
        points_W.iter().all(|p| self.height_of(p) <= tol_m)
    }

    /// Whether both are convex pieces of one connected part of a face: of one outline.
    pub fn shares_outline(&self, other: &Self) -> bool {
        let corner = |s: &Self| {
            let [x, y] = *s.outline.first()?.first()?;
            Some(s.point_W(&Point2::new(x, y)))
        };
        let sizes = |s: &Self| s.outline.iter().map(Vec::len).collect::<Vec<_>>();
        let near = |a: Point3<f64>, b: Point3<f64>| (a - b).norm() < SAME_CORNER_M;
        self.face.is_some()
            && self.face == other.face
            && sizes(self) == sizes(other)
            && corner(self)
                .zip(corner(other))
                .is_some_and(|(a, b)| near(a, b))
    }

    /// Says what ends the face at each edge of each ring of the outline; the polygon's edges inherit
    /// from those along which they lie ([`edge::kinds_of`]).
    pub fn set_outline_edges(&mut self, kinds: Vec<Vec<EdgeKind>>) {
        self.polygon_edges = edge::kinds_of(&self.polygon, &self.outline, &kinds);
        self.outline_edges = kinds;
    }

    /// What ends the face at an edge of a ring of the outline.
    pub fn outline_edge(&self, ring: usize, edge: usize) -> EdgeKind {
        let kinds = self.outline_edges.get(ring);
        let kind = kinds.and_then(|kinds| kinds.get(edge));
        kind.copied().unwrap_or_default()
    }

    /// The polygon, widened by [`Self::edge_m`], extruded against the normal by `thickness_m` or by
    /// [`Self::depth_m`] where that is more.
    pub fn thin_body(&self, thickness_m: f64) -> ThinBody {
        ThinBody::new(self, thickness_m.max(self.depth_m))
    }

    /// Checks everything that a polygon does not check by itself.
    ///
    /// # Errors
    /// [`Error::Surface`] with the id and one of [`Error::BadNumber`], [`Error::Outline`],
    /// [`Error::EdgeCount`], [`Error::OutlineSeam`], [`Error::NonUnitQuaternion`],
    /// [`Error::BadCovariance`].
    pub fn validate(&self) -> Result<(), Error> {
        self.check().map_err(|cause| Error::Surface {
            id: self.id.clone(),
            cause: Box::new(cause),
        })
    }
}
