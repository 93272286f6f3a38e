//! A connected plane face of the world: what a robot may touch.

mod goes_on;
mod inset;
mod record;

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::pose::Pose;
use crate::{Error, Region, beyond_world};
#[cfg(test)]
pub(crate) use inset::tests::faces;
use record::FaceRecord;

/// Name of a face, unique in its terrain.
#[derive(
    Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(transparent)]
pub struct FaceId(String);

impl FaceId {
    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl<T: Into<String>> From<T> for FaceId {
    fn from(name: T) -> Self {
        Self(name.into())
    }
}

impl std::fmt::Display for FaceId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

/// How well a plane was fitted to points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// Number of points.
    pub points: usize,
    /// Root mean square distance of the points from the plane, m.
    pub rms_m: f64,
}

/// From where edges were seen, and how well.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EdgeView {
    /// Where the sensor was, in W, m; on the free side of the face.
    #[schemars(with = "[f64; 3]")]
    pub eye_W: Point3<f64>,
    /// Standard deviation of an edge's place in the image, as an angle, rad. Edges that the border
    /// of the view cuts have none: the border is where it is.
    pub sigma_rad: f64,
    /// Covariance in F of the plane that the edges were found in, where that was another one than
    /// the face's: views of a face that are made one keep their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane_covariance: Option<[[f64; 3]; 3]>,
}

/// Where a face is known from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
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

/// One connected plane face of the world.
///
/// Frame F: x and y are tangents, z is the normal that points out of the body, toward the free
/// space; the origin lies in the plane. A contact holds when the patch frame C lies in F's plane with
/// z_C = +z_F and C's polygon inside the part of the region that is surely the face's
/// ([`Self::inset_region`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "FaceRecord", into = "FaceRecord")]
pub struct Face {
    /// Name, unique in its terrain.
    pub id: FaceId,
    /// Pose of F in W.
    pub X_WF: Isometry3<f64>,
    /// The region in F, m, with what is known of its edges.
    pub region: Region,
    /// Covariance of (rotation about x_F, rotation about y_F, offset along z_F): rad, rad, m.
    pub plane_covariance: Option<[[f64; 3]; 3]>,
    /// How well the plane was fitted; None where none was.
    pub fit: Option<Fit>,
    /// How the edges were seen: [`crate::Edge::view`] counts these; none where they are known
    /// exactly. The body behind the face goes on along the rays of the first.
    pub views: Vec<EdgeView>,
    /// How deep behind the plane its body goes on along the rays that saw it (against the normal where nothing is known
    /// of these), m: nothing was seen of what lies there. No deeper than the eye is high over the plane.
    pub depth_m: f64,
    /// Where the face is known from.
    pub source: Source,
    /// The roles whose patches may touch it, whatever its shape: none at all where the list is empty. Without a list
    /// its shape decides.
    pub roles: Option<Vec<String>>,
    /// Coefficient of friction that it has at most with whatever touches it; without one the patches' own count.
    pub friction: Option<f64>,
}

impl Face {
    /// A face known exactly: no fit, no covariance, source [`Source::File`].
    pub fn new(id: impl Into<FaceId>, X_WF: Isometry3<f64>, region: Region) -> Self {
        Self {
            id: id.into(),
            X_WF,
            region,
            plane_covariance: None,
            fit: None,
            views: Vec::new(),
            depth_m: 0.0,
            source: Source::default(),
            roles: None,
            friction: None,
        }
    }

    /// A rectangle known exactly, `size_m` along x_F and y_F, F in its middle.
    ///
    /// # Errors
    /// As [`Region::new`] where a side is no positive length.
    pub fn rectangle(
        id: impl Into<FaceId>,
        X_WF: Isometry3<f64>,
        size_m: [f64; 2],
    ) -> Result<Self, Error> {
        let [a, b] = size_m.map(|side| 0.5 * side);
        let corners = [[-a, -b], [a, -b], [a, b], [-a, b]];
        let region = Region::new([corners.map(Point2::from).to_vec()])?;
        Ok(Self::new(id, X_WF, region))
    }

    /// The coefficient of friction with a patch of this own one: the lesser of both.
    pub fn friction_with(&self, patch: f64) -> f64 {
        self.friction.map_or(patch, |own| own.min(patch))
    }

    /// The unit outward normal z_F, in W.
    pub fn normal_W(&self) -> Vector3<f64> {
        self.X_WF.rotation * Vector3::z()
    }

    /// The point of the plane at `p_F` (m, in F), in W.
    pub fn point_W(&self, p_F: &Point2<f64>) -> Point3<f64> {
        self.X_WF * Point3::new(p_F.x, p_F.y, 0.0)
    }

    /// The outer ring's vertices in W, counter-clockwise about the normal, m.
    pub fn vertices_W(&self) -> Vec<Point3<f64>> {
        let outer = self.region.rings()[0].vertices.iter();
        outer.map(|v| self.point_W(v)).collect()
    }

    /// The signed distance of a point of W from the plane, positive on the free side, m.
    pub fn height_of(&self, p_W: &Point3<f64>) -> f64 {
        self.X_WF.inverse_transform_point(p_W).z
    }

    /// Whether all the points are on the body's side of the plane, up to `tol_m`.
    ///
    /// What lies there cannot be touched by a link whose patch rests on the face: such bodies (the
    /// body behind the face, its neighbours in the same plane, the riser under a tread) are excepted
    /// from that link's collision constraints.
    pub fn is_behind(&self, points_W: &[Point3<f64>], tol_m: f64) -> bool {
        points_W.iter().all(|p| self.height_of(p) <= tol_m)
    }

    /// Checks everything that a region does not check by itself.
    ///
    /// # Errors
    /// [`Error::Part`] with the id and the [`Error::Value`].
    pub fn validate(&self) -> Result<(), Error> {
        self.check()
            .map_err(|cause| cause.of_face(self.id.as_str()))
    }

    fn check(&self) -> Result<(), Error> {
        Isometry3::try_from(Pose::from(&self.X_WF))?;
        Error::check_not_negative("depth_m", self.depth_m)?;
        if let Some(friction) = self.friction.filter(|own| !(own.is_finite() && *own > 0.0)) {
            let expected = "a positive number; a face that nothing may touch has \"roles\": []";
            return Err(Error::bad("friction", friction, expected));
        }
        if let Some(fit) = &self.fit {
            Error::check_not_negative("rms_m", fit.rms_m)?;
        }
        let seen = self.region.segments().filter_map(|(edge, _)| edge.view);
        if let Some(view) = seen.max().filter(|view| *view >= self.views.len()) {
            return Err(Error::bad(
                "view",
                view as f64,
                "the index of one of the views",
            ));
        }
        for view in &self.views {
            Error::check_not_negative("sigma_rad", view.sigma_rad)?;
            if let Some(value) = beyond_world(view.eye_W.coords.as_slice()) {
                return Err(Error::bad("eye_W", value, "a coordinate of the world"));
            }
            let height_m = self.height_of(&view.eye_W);
            if height_m <= 0.0 {
                return Err(Error::bad("eye_W's height", height_m, "above the face"));
            }
            view.plane_covariance
                .as_ref()
                .map_or(Ok(()), check_covariance)?;
        }
        self.plane_covariance
            .as_ref()
            .map_or(Ok(()), check_covariance)
    }
}

/// A covariance is finite, symmetric and has no negative eigenvalue, up to rounding.
pub(crate) fn check_covariance(rows: &[[f64; 3]; 3]) -> Result<(), Error> {
    let wrong = |why: String| {
        let what = "plane_covariance is not symmetric and positive semi-definite";
        Err(Error::Value(format!("{what}: {why}")))
    };
    let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
    let scale = matrix.abs().max();
    if !matrix.iter().all(|c| c.is_finite()) {
        return wrong("an entry is not finite".into());
    }
    // 1e-9 of the largest entry: what a product of f64 matrices or a printed number may be off.
    let tolerance = 1e-9 * scale;
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let (upper, lower) = (rows[i][j], rows[j][i]);
        if (upper - lower).abs() > tolerance {
            let entries = format!("entry ({i}, {j}) is {upper}, entry ({j}, {i}) is {lower}");
            return wrong(entries);
        }
    }
    let smallest = matrix.symmetric_eigenvalues().min();
    if smallest < -tolerance {
        return wrong(format!("its smallest eigenvalue is {smallest}"));
    }
    Ok(())
}
