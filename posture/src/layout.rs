//! Which variable of the problem stands where in a step, and what of its contacts stays the same.

use nalgebra::{Matrix3, Point2, Vector3};
use surfaces::ConvexPolygon;

use crate::Config;
use crate::problem::Problem;

/// A joint with less of the robot's mass beyond it than this part of all, and no contact, is held.
const SMALL_MASS: f64 = 0.03;
/// Of a patch's half width this part, or this length, is left at least.
const LEFT_PART: f64 = 0.4;
const LEFT_M: f64 = 0.010;

/// Which variable stands where in a step.
pub(crate) struct Layout {
    /// Column of each body's joint; `None` where the joint is held.
    pub column: Vec<Option<usize>>,
    /// Number of columns of the configuration.
    pub nq: usize,
    /// First column of each force point, contact by contact; empty where not loaded.
    pub force: Vec<Vec<usize>>,
    /// Number of columns.
    pub n: usize,
}

impl Layout {
    /// The bodies whose joints are free to move, each with its column.
    pub fn joints(&self) -> impl Iterator<Item = (usize, usize)> {
        let columns = self.column.iter().enumerate().skip(1);
        columns.filter_map(|(body, column)| Some((body, (*column)?)))
    }

    /// Joints with no contact and little mass beyond them are held: they matter to no constraint.
    pub fn new(problem: &Problem, contacts: &[ContactModel]) -> Self {
        let robot = problem.robot;
        let mut subtree: Vec<f64> = robot.bodies.iter().map(|b| b.mass_kg).collect();
        let mut carries = vec![false; robot.bodies.len()];
        for contact in contacts {
            carries[contact.body] = true;
        }
        for i in (1..robot.bodies.len()).rev() {
            if let Some(p) = robot.bodies[i].parent {
                subtree[p] += subtree[i];
                carries[p] |= carries[i];
            }
        }
        let mut column = vec![None; robot.bodies.len()];
        let mut next = 6;
        for i in 1..robot.bodies.len() {
            if carries[i] || subtree[i] > SMALL_MASS * robot.mass_kg {
                column[i] = Some(next);
                next += 1;
            }
        }
        let nq = next;
        let mut force = Vec::new();
        for (contact, model) in problem.contacts.iter().zip(contacts) {
            let points = if contact.loaded {
                model.force_points.len()
            } else {
                0
            };
            force.push((0..points).map(|k| next + 3 * k).collect());
            next += 3 * points;
        }
        Self {
            column,
            nq,
            force,
            n: next,
        }
    }
}

/// A contact with everything that does not change between iterates.
pub(crate) struct ContactModel {
    pub body: usize,
    /// Radius of the ball of a point patch, m.
    pub radius: Option<f64>,
    /// How much farther inside an area a ball stays than the margin, m.
    pub inside_m: f64,
    /// Vertices of the patch in C.
    pub vertices: Vec<Point2<f64>>,
    /// Points where forces act, in C: the patch shrunk by the CoM margin, or the one of a ball.
    pub force_points: Vec<Point2<f64>>,
    /// Axes in W in which the forces are written: two tangents and the normal.
    pub axes: Matrix3<f64>,
    /// Largest tangential force over the normal one.
    pub mu: f64,
}

/// Faces whose normals have a smaller upward part than this are pushed against, not stood on.
const WALL: f64 = 0.5;

/// The direction in which a contact is loaded, as far as the others tell: by the weight, and by what
/// pushes off walls.
fn load_W(problem: &Problem, index: usize) -> Vector3<f64> {
    let others = problem.contacts.iter().enumerate();
    let others = others.filter(|(i, other)| *i != index && other.loaded);
    let normals = others.map(|(_, other)| other.normal_W());
    let pushed: Vector3<f64> = normals.filter(|n| n.z < WALL).sum();
    pushed - Vector3::z()
}

impl ContactModel {
    pub fn new(problem: &Problem, index: usize, config: &Config) -> Self {
        let contact = &problem.contacts[index];
        let patch = &problem.robot.patches[contact.patch];
        let axes = contact.X_WC.rotation.to_rotation_matrix().into_inner();
        let radius = patch.point_radius_m();
        let inside_m = radius.zip(contact.area()).map_or(0.0, |(radius, area)| {
            let inset = |inset_m: f64| area.polygon.inset(config.patch_margin_m + inset_m);
            ball_inset_m(radius, |inset_m| inset(inset_m).is_some())
        });
        Self {
            body: patch.body,
            radius,
            inside_m,
            vertices: patch.polygon.clone(),
            force_points: force_points(&patch.polygon, config.com_margin_m),
            axes: robot_model::pyramid_axes_W(&axes, &load_W(problem, index)),
            mu: contact.friction * config.friction_use,
        }
    }
}

/// How far inside a face a ball stays, m: by its radius, so that it is over the face as a whole; on a face that is narrow
/// for it, which it touches with a point all the same, by less, so that at least half of the face's width is left.
///
/// `leaves` says whether an inset leaves anything of the face.
pub fn ball_inset_m(radius_m: f64, leaves: impl Fn(f64) -> bool) -> f64 {
    let mut insets_m = [1.0, 0.5, 0.25].into_iter().map(|part| part * radius_m);
    insets_m
        .find(|inset_m| leaves(2.0 * inset_m))
        .unwrap_or(0.0)
}

/// By how much a patch is shrunk for a margin, m: a narrow one until 10 mm of its half width are left, or 40 %
/// where that is less, and not at all where it is no polygon.
pub fn patch_inset_m(polygon: &[Point2<f64>], margin_m: f64) -> f64 {
    let Ok(patch) = ConvexPolygon::new(polygon.to_vec()) else {
        return 0.0;
    };
    let c = patch.centroid();
    let sides = patch.half_planes();
    let widths = sides.iter().map(|h| h.b - h.n.dot(&c.coords));
    let half_width_m = widths.fold(f64::MAX, f64::min);
    margin_m.min(half_width_m - LEFT_M.min(LEFT_PART * half_width_m))
}

/// The points of a patch at which its forces act, in C, m: the polygon shrunk by [`patch_inset_m`].
/// A patch that is no polygon keeps its points.
///
/// These are the points of a plan's `force_points_W`, in that order.
pub fn force_points(polygon: &[Point2<f64>], margin_m: f64) -> Vec<Point2<f64>> {
    let inset_m = patch_inset_m(polygon, margin_m);
    let patch = ConvexPolygon::new(polygon.to_vec()).ok();
    let inside = patch.and_then(|patch| patch.inset(inset_m));
    inside.map_or_else(|| polygon.to_vec(), |p| p.vertices().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sole_gives_the_margin_that_is_asked_for_and_a_finger_keeps_some_width() {
        let inset_mm = |half_mm: f64, margin_mm: f64| {
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let square = corners.map(|[x, y]| Point2::new(x, y) * (half_mm / 1e3));
            (patch_inset_m(&square, margin_mm / 1e3) * 1e3).round()
        };
        assert_eq!(inset_mm(63.0, 40.0), 40.0);
        assert_eq!(inset_mm(63.0, 50.0), 50.0);
        assert_eq!(inset_mm(63.0, 60.0), 53.0);
        assert_eq!(inset_mm(20.0, 60.0), 12.0);
    }
}
