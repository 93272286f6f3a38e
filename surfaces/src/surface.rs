//! The contactable surface: a frame, a convex polygon in it, and how well both are known.

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::pose::PoseRecord;
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
    /// Distance by which uncertainty shrinks the polygon, m.
    pub inset_m: f64,
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

    /// The polygon in which patches must lie: [`Self::polygon`] shrunk by [`Self::inset_m`]; None
    /// when nothing is left of it.
    pub fn effective_polygon(&self) -> Option<ConvexPolygon> {
        self.polygon.inset(self.inset_m)
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

    fn check(&self) -> Result<(), Error> {
        Isometry3::try_from(PoseRecord::from(&self.X_WS))?;
        for (field, value) in [
            ("inset_m", self.inset_m),
            ("edge_m", self.edge_m),
            ("depth_m", self.depth_m),
            ("rms_m", self.rms_m),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::BadNumber {
                    field: field.into(),
                    value,
                    expected: "a finite number ≥ 0",
                });
            }
        }
        for (ring, points) in self.outline.iter().enumerate() {
            check_ring(points).map_err(|cause| Error::Outline {
                ring,
                cause: Box::new(cause),
            })?;
        }
        self.check_edges()?;
        self.plane_covariance
            .as_ref()
            .map_or(Ok(()), check_covariance)
    }

    /// One kind an edge, or none at all; outlines have no seams.
    fn check_edges(&self) -> Result<(), Error> {
        let counted = |field: String, found: usize, edges: usize| {
            (found == edges).then_some(()).ok_or(Error::EdgeCount {
                field,
                found: format!("{found} kinds"),
                expected: format!("{edges} edges"),
            })
        };
        if !self.polygon_edges.is_empty() {
            let edges = self.polygon.vertices().len();
            counted("polygon_edges".into(), self.polygon_edges.len(), edges)?;
        }
        if self.outline_edges.is_empty() {
            return Ok(());
        }
        if self.outline_edges.len() != self.outline.len() {
            return Err(Error::EdgeCount {
                field: "outline_edges".into(),
                found: format!("kinds of {} rings", self.outline_edges.len()),
                expected: format!("{} rings", self.outline.len()),
            });
        }
        for (ring, (points, kinds)) in self.outline.iter().zip(&self.outline_edges).enumerate() {
            let field = format!("outline_edges of ring {ring}");
            counted(field, kinds.len(), points.len())?;
            if let Some(edge) = kinds.iter().position(|kind| *kind == EdgeKind::Seam) {
                return Err(Error::OutlineSeam { ring, edge });
            }
        }
        Ok(())
    }
}

/// A ring needs three finite points; it need not be convex.
fn check_ring(points: &[[f64; 2]]) -> Result<(), Error> {
    if points.len() < 3 {
        return Err(Error::TooFewVertices {
            count: points.len(),
        });
    }
    match points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        Some(vertex) => Err(Error::NonFiniteVertex {
            vertex,
            point: points[vertex].to_vec(),
        }),
        None => Ok(()),
    }
}

/// A covariance is finite, symmetric and has no negative eigenvalue, up to rounding.
fn check_covariance(rows: &[[f64; 3]; 3]) -> Result<(), Error> {
    let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
    let scale = matrix.abs().max();
    if !matrix.iter().all(|c| c.is_finite()) {
        let why = "an entry is not finite".into();
        return Err(Error::BadCovariance { why });
    }
    // 1e-9 of the largest entry: what a product of f64 matrices or a printed number may be off.
    let tolerance = 1e-9 * scale;
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let (upper, lower) = (rows[i][j], rows[j][i]);
        if (upper - lower).abs() > tolerance {
            let why = format!("entry ({i}, {j}) is {upper}, entry ({j}, {i}) is {lower}");
            return Err(Error::BadCovariance { why });
        }
    }
    let smallest = matrix.symmetric_eigenvalues().min();
    if smallest < -tolerance {
        let why = format!("its smallest eigenvalue is {smallest}");
        return Err(Error::BadCovariance { why });
    }
    Ok(())
}

/// Whether a number that is left out of files is.
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// A surface as it stands in a file, not yet checked.
#[allow(non_snake_case)]
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceRecord {
    id: String,
    X_WS: PoseRecord,
    polygon: Vec<[f64; 2]>,
    #[serde(default)]
    outline: Vec<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    outline_edges: Vec<Vec<EdgeKind>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    polygon_edges: Vec<EdgeKind>,
    #[serde(default)]
    inset_m: f64,
    #[serde(default, skip_serializing_if = "is_zero")]
    edge_m: f64,
    #[serde(default, skip_serializing_if = "is_zero")]
    depth_m: f64,
    #[serde(default)]
    inliers: usize,
    #[serde(default)]
    rms_m: f64,
    #[serde(default)]
    plane_covariance: Option<[[f64; 3]; 3]>,
    #[serde(default)]
    source: Source,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    face: Option<String>,
}

impl TryFrom<SurfaceRecord> for Surface {
    type Error = Error;

    fn try_from(record: SurfaceRecord) -> Result<Self, Error> {
        let named = |cause: Error| Error::Surface {
            id: record.id.clone(),
            cause: Box::new(cause),
        };
        let surface = Self {
            X_WS: record.X_WS.try_into().map_err(&named)?,
            polygon: record.polygon.try_into().map_err(&named)?,
            id: record.id,
            outline: record.outline,
            outline_edges: record.outline_edges,
            polygon_edges: record.polygon_edges,
            inset_m: record.inset_m,
            edge_m: record.edge_m,
            depth_m: record.depth_m,
            inliers: record.inliers,
            rms_m: record.rms_m,
            plane_covariance: record.plane_covariance,
            source: record.source,
            face: record.face,
        };
        surface.validate()?;
        Ok(surface)
    }
}

impl From<Surface> for SurfaceRecord {
    fn from(surface: Surface) -> Self {
        Self {
            X_WS: PoseRecord::from(&surface.X_WS),
            polygon: surface.polygon.into(),
            id: surface.id,
            outline: surface.outline,
            outline_edges: surface.outline_edges,
            polygon_edges: surface.polygon_edges,
            inset_m: surface.inset_m,
            edge_m: surface.edge_m,
            depth_m: surface.depth_m,
            inliers: surface.inliers,
            rms_m: surface.rms_m,
            plane_covariance: surface.plane_covariance,
            source: surface.source,
            face: surface.face,
        }
    }
}
