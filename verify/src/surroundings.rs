//! What stands around the robot: the bodies behind faces, and obstacles.

use nalgebra::{Matrix4, Vector3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use plan::Plan;
use surfaces::{Face, Source};

use crate::TOLERANCES;
use crate::convex_parts::convex_parts;
use crate::posture::{column, inverse_point, point};
use crate::solid::{Ball, Solid, extremes, over, vector};

/// Everything that is not the robot, in W.
pub(crate) struct Surroundings {
    pub bodies: Vec<Body>,
    /// The boxes along W's axes around them.
    boxes: Bvh,
}

/// The hull of points in W.
pub(crate) struct Body {
    pub name: String,
    /// The face whose body it is.
    face: Option<String>,
    points: Vec<Vector3<f64>>,
    pub solid: Solid,
    pub bounds: Bounds,
}

impl Surroundings {
    /// What is behind every face of the plan, as deep as the plan takes bodies to be or the face
    /// says; and the obstacles.
    ///
    /// The bodies that a solver keeps away from hold all of that and reach farther, by what the edges
    /// of a scanned face may be off.
    pub fn new(plan: &Plan) -> Self {
        let mut bodies = Vec::new();
        let mut add = |name, face, frame: &Matrix4<f64>, points: Vec<Vector3<f64>>| {
            bodies.push(Body {
                bounds: Bounds::new(frame, &points),
                name,
                face,
                solid: Solid::hull(points.iter().copied(), 0.0),
                points,
            });
        };
        // A face of a mesh has the mesh itself behind it.
        let has_own = |face: &&Face| face.source != Source::Mesh || plan.obstacles.is_empty();
        for face in plan.faces.iter().filter(has_own) {
            let pose = face.X_WF.to_homogeneous();
            // What a face hides lies behind it along the rays that saw it, down to a plane parallel to it.
            let eye = face.views.first().map(|view| view.eye_W.coords);
            let height_m = eye.map(|eye| inverse_point(&pose, &eye).z);
            let hidden = |p: Vector3<f64>| match (eye, height_m) {
                (Some(eye), Some(z)) if z > 0.0 => p + (p - eye) * (face.depth_m / z).min(1.0),
                (Some(_), _) => p,
                (None, _) => p - column(&pose, 2) * face.depth_m,
            };
            for part in convex_parts(face) {
                let at = |z: f64| {
                    let corners = part.iter().map(|p| point(&pose, &p.push(z)));
                    corners.collect::<Vec<_>>()
                };
                let front = at(0.0);
                let hidden = front.iter().copied().map(hidden).collect();
                let points = [front, at(-plan.thin_body_m), hidden].concat();
                let name = format!("face {}", face.id);
                add(name, Some(face.id.to_string()), &pose, points);
            }
        }
        for obstacle in &plan.obstacles {
            let points = obstacle.points_W.iter().map(|p| p.coords).collect();
            let name = format!("obstacle {}", obstacle.id);
            let frame = Matrix4::identity();
            add(name, obstacle.surface.clone(), &frame, points);
        }
        let around = |body: &Body| {
            let (low, high) = extremes(body.points.iter().copied());
            Aabb::new(vector(&low), vector(&high))
        };
        let boxes: Vec<Aabb> = bodies.iter().map(around).collect();
        let boxes = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        Self { bodies, boxes }
    }

    /// The bodies that may be within `distance_m` of any of some balls, in their order.
    pub fn near(&self, balls: impl Iterator<Item = Ball>, distance_m: f64) -> Vec<&Body> {
        let corners = balls.flat_map(|(centre, radius)| {
            [-1.0, 1.0].map(|side| centre.add_scalar(side * (radius + distance_m)))
        });
        let (low, high) = extremes(corners);
        let asked = Aabb::new(vector(&low), vector(&high));
        let mut found: Vec<u32> = self.boxes.intersect_aabb(&asked).collect();
        found.sort_unstable();
        let found = found.into_iter();
        found.filter_map(|i| self.bodies.get(i as usize)).collect()
    }
}

impl Body {
    /// Whether a link in contact with a face may touch this body, and how far the body rises over the
    /// face's plane, m: the touched face's own body, and what lies wholly behind its plane.
    pub fn rise_over(&self, touched: &Face) -> Option<f64> {
        if self.face.as_deref() == Some(touched.id.as_str()) {
            return Some(0.0);
        }
        let plane = touched.X_WF.to_homogeneous();
        let heights = self.points.iter().map(|p| inverse_point(&plane, p).z);
        let rise = heights.fold(f64::NEG_INFINITY, f64::max);
        (rise <= same_plane_m(touched)).then_some(rise.max(0.0))
    }

    /// The part that rises over the plane of a face, of a body that does: what a link in contact with
    /// the face keeps away from. Into which convex bodies the rest was cut does not matter.
    pub fn above(&self, touched: &Face) -> Solid {
        let plane = touched.X_WF.to_homogeneous();
        let height = |p: &Vector3<f64>| inverse_point(&plane, p).z - same_plane_m(touched);
        Solid::hull(over(&self.points, height), 0.0)
    }
}

/// How far what lies behind a face's plane may rise over it, m.
fn same_plane_m(face: &Face) -> f64 {
    match face.source {
        Source::Mesh => TOLERANCES.same_plane_mesh_m,
        Source::Scan | Source::File | Source::Robot => TOLERANCES.same_plane_m,
    }
}

/// A box around a body, along the axes of a frame.
pub(crate) struct Bounds {
    frame: Matrix4<f64>,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Bounds {
    /// Of points.
    fn new(frame: &Matrix4<f64>, points: &[Vector3<f64>]) -> Self {
        let (low, high) = extremes(points.iter().map(|p| inverse_point(frame, p)));
        Self {
            frame: *frame,
            low,
            high,
        }
    }

    /// A distance that the body has from a ball at least, m.
    pub fn least_m(&self, (centre, radius): &Ball) -> f64 {
        let p = inverse_point(&self.frame, centre);
        let beside = (self.low - p).sup(&(p - self.high)).sup(&Vector3::zeros());
        beside.norm() - radius
    }
}
