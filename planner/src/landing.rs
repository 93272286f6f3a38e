//! Where on a face a patch may land: what the face's insets leave, less what stands there.
//!
//! What stands there is every body of the world that rises over the face's plane, in the slab over
//! the plane that the patch's own link fills. Its outline in the plane is grown by what the link
//! must keep from it. Ground that rises gently beside a ball is in its way only where the ball would be in it.

use nalgebra::{Isometry3, Point2, Point3, Vector2};
use posture::{Environment, FaceIndex, ball_inset_m};
use robot_model::collision::{Obstacle, ShapeGeometry};
use robot_model::{ContactPatch, PatchId, Robot};
use surfaces::outline::Outline;
use surfaces::{ConvexPolygon, HalfPlane, Region};

/// The slab over a face in which things are in the way of a patch itself is at most so high, m; of
/// what is higher the posture keeps the rest of the limb away.
const SLAB_MAX_M: f64 = 0.12;
/// Planes whose normals differ by less than this do not meet.
const LEVEL: f64 = 1e-6;
/// An outline of no area is taken to be so wide, m.
const THIN_M: f64 = 1e-3;

/// What a patch needs about the place where it lands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    /// Radius of the largest circle about the patch's middle that it contains, of a ball its own, m.
    pub half_width_m: f64,
    /// How far things must be from the patch, m.
    beside_m: f64,
    /// How high over the plane things are in its way, m.
    height_m: f64,
    /// Radius of a ball, m.
    ball: Option<f64>,
}

impl Footprint {
    /// Of a patch that keeps `clearance_m` from things and `margin_m` inside its area.
    pub fn new(robot: &Robot, id: PatchId, clearance_m: f64, margin_m: f64) -> Self {
        let patch = &robot.patches[id];
        let half_width_m = half_width_m(patch);
        let (over_m, height_m) = match patch.point_radius_m() {
            Some(radius_m) => (0.0, 2.0 * radius_m),
            None => overhang(robot, patch),
        };
        Self {
            half_width_m,
            beside_m: (clearance_m + over_m - margin_m).max(0.0),
            height_m: (height_m + clearance_m).min(SLAB_MAX_M),
            ball: patch.point_radius_m(),
        }
    }
}

/// How far the shapes of a patch's link reach beyond the patch, within the slab, and how high over
/// its plane, m.
fn overhang(robot: &Robot, patch: &ContactPatch) -> (f64, f64) {
    let polygon = ConvexPolygon::new(patch.polygon.clone()).ok();
    let shapes = robot.collision.shapes().iter();
    let (mut beyond_m, mut height_m) = (0.0_f64, 0.0_f64);
    for shape in shapes.filter(|s| s.body == patch.body) {
        let X_CG = patch.X_BC.inverse() * shape.X_BG;
        for p in shape.geometry.vertices() {
            let p_C = X_CG * p;
            height_m = height_m.max(p_C.z);
            if let Some(polygon) = polygon.as_ref().filter(|_| p_C.z < SLAB_MAX_M) {
                beyond_m = beyond_m.max(polygon.signed_distance(&p_C.xy()));
            }
        }
    }
    (beyond_m, height_m)
}

/// Where on a face a patch may be, in the face's frame.
#[derive(Debug)]
pub(crate) struct Landing {
    /// Where any of it may be.
    outline: Outline,
    /// Where its middle may be: the parts in which there is room for its half width.
    middle: Vec<Region>,
}

impl Landing {
    pub fn new(environment: &Environment, face: FaceIndex, footprint: &Footprint) -> Self {
        let things = standing_on(environment, face, footprint);
        let left = |inside_m: f64, beside_m: f64| {
            let outline = environment.outline(face, inside_m);
            let grown = things
                .iter()
                .filter_map(|t| t.grown(footprint.beside_m + beside_m));
            // One after the other: hundreds of pieces of bodies that overlap take an overlay of all
            // of them minutes.
            grown.fold(outline, |left, thing| match is_near(&left, &thing) {
                true => left.minus(&Outline::from_polygon(&thing)),
                false => left,
            })
        };
        let half_width_m = footprint.half_width_m;
        let leaves = |inset_m: f64| !environment.outline(face, inset_m).is_empty();
        let inside_m = match footprint.ball {
            Some(radius_m) => ball_inset_m(radius_m, leaves),
            None => half_width_m,
        };
        Self {
            outline: left(0.0, 0.0),
            middle: left(inside_m, half_width_m).regions(),
        }
    }

    /// The place nearest to a point where the patch's middle may be; nothing where there is no room.
    pub fn nearest(&self, p_F: &Point2<f64>) -> Option<Point2<f64>> {
        let places = self.middle.iter().map(|region| region.nearest(p_F));
        places.min_by(|a, b| (a - p_F).norm().total_cmp(&(b - p_F).norm()))
    }

    /// Corners of where the patch's middle may be.
    pub fn middles(&self) -> impl Iterator<Item = &Point2<f64>> {
        let rings = self.middle.iter().flat_map(Region::rings);
        rings.flat_map(|ring| &ring.vertices)
    }

    /// Whether the patch's middle may be at a place.
    pub fn contains(&self, p_F: &Point2<f64>) -> bool {
        self.middle.iter().any(|region| region.contains(p_F))
    }

    /// A place in each part where the patch's middle may be.
    pub fn inside(&self) -> impl Iterator<Item = Point2<f64>> {
        self.middle
            .iter()
            .map(|region| region.nearest(&region.centroid()))
    }

    /// A large convex part about a place, long along a direction where it can be.
    pub fn area(&self, p_F: &Point2<f64>, along_F: &Vector2<f64>) -> Option<ConvexPolygon> {
        self.outline.convex_around(p_F, along_F)
    }
}

/// Whether the boxes around an outline and a polygon meet.
fn is_near(outline: &Outline, polygon: &ConvexPolygon) -> bool {
    outline.bounds().is_some_and(|(low, high)| {
        let beyond = |axis: usize| {
            let of = |p: &Point2<f64>| p[axis];
            polygon.vertices().iter().all(|p| of(p) < low[axis])
                || polygon.vertices().iter().all(|p| of(p) > high[axis])
        };
        !beyond(0) && !beyond(1)
    })
}

/// What rises over a face's plane.
struct Thing {
    /// The outline in the plane of what it has from there up to the height of what is looked at.
    section: ConvexPolygon,
    /// Where it is in the way of a ball: over these planes through the ground that rises gently it is not.
    under: Vec<HalfPlane>,
}

impl Thing {
    /// Where its section widened is in the way; nothing where it is nowhere.
    fn grown(&self, beside_m: f64) -> Option<ConvexPolygon> {
        self.section.grown(beside_m).clip_all(&self.under)
    }
}

/// The bodies that rise over a face's plane, as far as they are in the way of a patch there.
fn standing_on(environment: &Environment, face: FaceIndex, footprint: &Footprint) -> Vec<Thing> {
    let on = &environment[face];
    let corners = on.vertices_W();
    let first = corners.first().copied().unwrap_or_default();
    let (low, high) = (corners.iter()).fold((first, first), |b, p| (b.0.inf(p), b.1.sup(p)));
    let (X_FW, height_m) = (on.X_WF.inverse(), footprint.height_m);
    let near = environment.world().near(&low, &high, height_m).into_iter();
    near.filter(|&k| !environment.is_behind(face, k))
        .filter_map(|k| {
            let body = &environment.world().obstacles()[k];
            Some(Thing {
                section: section(body, &X_FW, height_m)?,
                under: under(environment, face, body, footprint),
            })
        })
        .collect()
}

/// Where on a face a ball would be in the ground of a body that rises gently.
fn under(
    environment: &Environment,
    face: FaceIndex,
    body: &Obstacle,
    footprint: &Footprint,
) -> Vec<HalfPlane> {
    let (Some(radius_m), ShapeGeometry::ConvexHull(hull)) = (footprint.ball, body.geometry())
    else {
        return Vec::new();
    };
    let X_FO = environment[face].X_WF.inverse() * body.pose();
    let facets = hull.face_normals().zip(hull.triangles());
    let of_facet = facets.filter_map(|(normal_O, [corner, ..])| {
        let is_gentle = environment.is_gentle(face, &(body.pose() * normal_O));
        let (normal, at) = (X_FO * normal_O, X_FO * hull.vertices()[*corner as usize]);
        // A ball that touches the face and this plane has its centre over both by its radius.
        let along = normal.xy().norm();
        let b = normal.dot(&at.coords) + radius_m * (1.0 - normal.z);
        (is_gentle && along > LEVEL).then(|| HalfPlane {
            n: normal.xy() / along,
            b: b / along,
        })
    });
    of_facet.collect()
}

/// The outline in the plane z = 0 of what a body has between it and a height.
fn section(body: &Obstacle, X_FW: &Isometry3<f64>, height_m: f64) -> Option<ConvexPolygon> {
    let ShapeGeometry::ConvexHull(hull) = body.geometry() else {
        return None;
    };
    let X_FO = X_FW * body.pose();
    let corners: Vec<Point3<f64>> = hull.vertices().iter().map(|p| X_FO * p).collect();
    let inside = |p: &&Point3<f64>| p.z >= 0.0 && p.z <= height_m;
    let mut points: Vec<Point2<f64>> = corners.iter().filter(inside).map(Point3::xy).collect();
    for [i, j, k] in hull.triangles() {
        for (a, b) in [(i, j), (j, k), (k, i)] {
            let (a, b) = (corners[*a as usize], corners[*b as usize]);
            for z in [0.0, height_m] {
                if (a.z < z) != (b.z < z) {
                    points.push((a + (b - a) * ((z - a.z) / (b.z - a.z))).xy());
                }
            }
        }
    }
    if points.is_empty() {
        return None;
    }
    ConvexPolygon::hull(&points).ok().or_else(|| {
        let about = |p: &Point2<f64>| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| p + Vector2::new(x, y) * (0.5 * THIN_M))
        };
        ConvexPolygon::hull(&points.iter().flat_map(about).collect::<Vec<_>>()).ok()
    })
}

/// Radius of the largest circle about the middle of a patch that it contains, of a ball its own, m.
fn half_width_m(patch: &ContactPatch) -> f64 {
    let polygon = &patch.polygon;
    let middle =
        polygon.iter().map(|p| p.coords).sum::<Vector2<f64>>() / polygon.len().max(1) as f64;
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let to_edges = edges.map(|(a, b)| {
        let edge = b - a;
        edge.perp(&(middle - a.coords)).abs() / edge.norm().max(1e-12)
    });
    let radius_m = patch.point_radius_m();
    radius_m.unwrap_or_else(|| to_edges.fold(f64::INFINITY, f64::min))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use surfaces::{Face, Obstacle, Terrain};

    use super::*;

    #[test]
    fn what_stands_on_a_face_is_taken_off_and_what_hangs_over_it_is_not() {
        let floor = Face::rectangle("floor", Isometry3::identity(), [4.0, 4.0]).unwrap();
        let bodies = vec![
            Obstacle::cuboid("box", [0.5, -0.1, -0.2], [0.7, 0.1, 0.1]),
            Obstacle::cuboid("lamp", [-1.2, -0.2, 1.8], [-0.8, 0.2, 2.0]),
        ];
        let terrain = Terrain::new(vec![floor], bodies).unwrap();
        let environment = Environment::new(terrain, 0.03, 0.0).unwrap();
        let floor = environment.face("floor").unwrap();
        let footprint = Footprint {
            half_width_m: 0.05,
            beside_m: 0.02,
            height_m: 0.1,
            ball: None,
        };
        let landing = Landing::new(&environment, floor, &footprint);
        // 5 cm of the patch and 2 cm beside it.
        let p = landing.nearest(&Point2::new(0.52, 0.0)).unwrap();
        assert!((p.x - 0.43).abs() < 1e-6, "{p}");
        let area = landing.area(&p, &Vector2::x()).unwrap();
        assert!(
            area.vertices().iter().all(|v| v.x < 0.5 - 0.02 + 1e-6),
            "{area:?}"
        );
        let under = Point2::new(-1.0, 0.0);
        assert!((landing.nearest(&under).unwrap() - under).norm() < 1e-9);
    }

    #[test]
    fn ground_that_rises_gently_is_in_the_way_of_a_ball_only_where_the_ball_would_be_in_it() {
        let nearest = |tilt_rad: f64, ball: Option<f64>| {
            let floor = Face::rectangle("floor", Isometry3::identity(), [4.0, 4.0]).unwrap();
            let (sin, cos) = tilt_rad.sin_cos();
            let at = Isometry3::translation(0.5 + cos, 0.0, sin);
            let turn = Isometry3::rotation(Vector3::y() * -tilt_rad);
            let ramp = Face::rectangle("ramp", at * turn, [2.0, 4.0]).unwrap();
            let terrain = Terrain::new(vec![floor, ramp], vec![]).unwrap();
            let environment = Environment::new(terrain, 0.03, 0.0).unwrap();
            let footprint = Footprint {
                half_width_m: 0.02,
                beside_m: 0.02,
                height_m: 0.1,
                ball,
            };
            let floor = environment.face("floor").unwrap();
            let landing = Landing::new(&environment, floor, &footprint);
            landing.nearest(&Point2::new(0.5, 0.0)).unwrap().x
        };
        // The ball's own depth in the hollow, against the width of a sole and what it keeps beside it.
        let touches_both_m = 0.02 * (0.5 * 0.3_f64).tan();
        assert!((nearest(0.3, Some(0.02)) - (0.5 - touches_both_m)).abs() < 1e-6);
        assert!((nearest(0.3, None) - 0.46).abs() < 1e-6);
        assert!((nearest(0.9, Some(0.02)) - 0.46).abs() < 1e-6);
    }
}
