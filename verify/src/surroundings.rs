//! What stands around the robot: the bodies behind faces, and obstacles.

use nalgebra::{Matrix4, Vector3};
use plan::Plan;
use surfaces::{Face, Source};

use crate::distance::Solid;
use crate::posture::{column, inverse_point, point};
use crate::{Options, region};

/// Everything that is not the robot, in W.
pub(crate) struct Surroundings {
    pub bodies: Vec<Body>,
}

/// The hull of points in W, and all that is within the margin of it across the axis.
pub(crate) struct Body {
    pub name: String,
    /// The face whose body it is.
    face: Option<String>,
    points: Vec<Vector3<f64>>,
    axis: Vector3<f64>,
    margin_m: f64,
    pub solid: Solid,
    pub bounds: Bounds,
}

impl Surroundings {
    /// What is behind every face of the plan: all points within [`Face::body_margin_m`] of the region
    /// in its plane, as deep as the plan takes bodies to be or the face says; and the obstacles.
    ///
    /// The bodies that a solver kept away from hold all of that and may hold more.
    pub fn new(plan: &Plan) -> Self {
        let mut bodies = Vec::new();
        let mut add = |name, face, frame: &Matrix4<f64>, points: Vec<Vector3<f64>>, margin_m| {
            let axis = column(frame, 2);
            bodies.push(Body {
                bounds: Bounds::new(frame, &points, margin_m),
                name,
                face,
                solid: Solid::widened(points.iter().copied(), &axis, margin_m),
                points,
                axis,
                margin_m,
            });
        };
        // A face of a mesh has the mesh itself behind it.
        let has_own = |face: &&Face| face.source != Source::Mesh || plan.obstacles.is_empty();
        for face in plan.faces.iter().filter(has_own) {
            let pose = face.X_WF.to_homogeneous();
            let depth = plan.thin_body_m.max(face.depth_m);
            for part in region::convex_parts(face) {
                let at = |z: f64| {
                    let corners = part.iter().map(|p| point(&pose, &p.push(z)));
                    corners.collect::<Vec<_>>()
                };
                let points = [at(0.0), at(-depth)].concat();
                add(
                    format!("face {}", face.id),
                    Some(face.id.to_string()),
                    &pose,
                    points,
                    face.body_margin_m(),
                );
            }
        }
        for obstacle in &plan.obstacles {
            let points = obstacle.points_W.iter().map(|p| p.coords).collect();
            add(
                format!("obstacle {}", obstacle.id),
                obstacle.surface.clone(),
                &Matrix4::identity(),
                points,
                0.0,
            );
        }
        Self { bodies }
    }
}

impl Body {
    /// Whether a link in contact with a face may touch this body, and how far the body rises over the
    /// face's plane, m: the touched face's own body, and what lies wholly behind its plane.
    pub fn rise_over(&self, touched: &Face, options: &Options) -> Option<f64> {
        if self.face.as_deref() == Some(touched.id.as_str()) {
            return Some(0.0);
        }
        let plane = touched.X_WF.to_homogeneous();
        let rise = self
            .points
            .iter()
            .map(|p| inverse_point(&plane, p).z)
            .fold(f64::NEG_INFINITY, f64::max)
            + self.margin_m * self.axis.cross(&column(&plane, 2)).norm();
        (rise <= options.same_plane_m).then_some(rise.max(0.0))
    }
}

/// Centre and radius of a ball around a body, m.
pub(crate) type Ball = (Vector3<f64>, f64);

/// A box around a body, along the axes of a frame.
pub(crate) struct Bounds {
    frame: Matrix4<f64>,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Bounds {
    /// Of points and all that is within the margin of their hull across the frame's z axis.
    fn new(frame: &Matrix4<f64>, points: &[Vector3<f64>], margin_m: f64) -> Self {
        let far = Vector3::repeat(f64::INFINITY);
        let inside = points.iter().map(|p| inverse_point(frame, p));
        let (low, high) = inside.fold((far, -far), |(low, high), p| (low.inf(&p), high.sup(&p)));
        let beside = Vector3::new(margin_m, margin_m, 0.0);
        Self {
            frame: *frame,
            low: low - beside,
            high: high + beside,
        }
    }

    /// A distance that the body has from a ball at least, m.
    pub fn least_m(&self, (centre, radius): &Ball) -> f64 {
        let p = inverse_point(&self.frame, centre);
        let beside = (self.low - p).sup(&(p - self.high)).sup(&Vector3::zeros());
        beside.norm() - radius
    }
}
