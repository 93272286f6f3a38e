//! Walls and things around a ramp: all that stands there is covered by bodies, and nothing else is.
use crate::ramps::{calibration, cloud, mount, take, usual_mount};
use nalgebra::{Isometry3, Point3, Vector3};
use perception::lidar::{LidarConfig, SegmentedCloud, segment_cloud};
use scenes::worlds::slope::{PAPER, POLE_M, POLES_M, Ramp, room};
use scenes::{OrientedBox, Truth};
use surfaces::{ConvexPolygon, Obstacle};

fn looked(truth: &Truth, X_WV: &Isometry3<f64>, seed: u64) -> SegmentedCloud {
    let sweep = take(truth, X_WV, seed);
    let known = calibration(X_WV, None);
    segment_cloud(&cloud(&sweep), Some(&known), &LidarConfig::default()).unwrap()
}

/// Whether a place is in an upright body, grown by a border.
fn holds(body: &Obstacle, p: &Point3<f64>, border_m: f64) -> bool {
    let plan: Vec<_> = body.points_W.iter().map(|p| p.xy()).collect();
    let heights = body.points_W.iter().map(|p| p.z);
    let low = heights.clone().fold(f64::INFINITY, f64::min);
    let high = heights.fold(f64::NEG_INFINITY, f64::max);
    (low - border_m..=high + border_m).contains(&p.z)
        && ConvexPolygon::hull(&plan)
            .unwrap()
            .contains(&p.xy(), border_m)
}

fn bodies(seen: &SegmentedCloud) -> Vec<&Obstacle> {
    seen.around.obstacles().collect()
}

/// Places on an upright box's corners and edges up to a height.
fn upright_edges(x: f64, y: f64, half: f64, to_m: f64) -> Vec<Point3<f64>> {
    let heights = (0..)
        .map(|k| 0.05 * f64::from(k))
        .take_while(|z| *z <= to_m);
    heights
        .flat_map(|z| {
            [(-half, -half), (half, -half), (half, half), (-half, half)]
                .map(|(dx, dy)| Point3::new(x + dx, y + dy, z))
        })
        .collect()
}

#[test]
fn walls_and_poles_are_covered_and_the_ramp_is_free() {
    for (seed, row) in PAPER.iter().enumerate() {
        let ramp = row.ramp();
        let truth = room("room", &[ramp]);
        for X_WV in [usual_mount(), mount(0.0, 0.0, 0.0, 0.75)] {
            let seen = looked(&truth, &X_WV, seed as u64);
            let all = bodies(&seen);
            // 1. The two walls, in their places: x = 6 and y = 4.5.
            for (axis, at) in [(0, 6.0), (1, 4.5)] {
                let mut found = seen.around.walls.iter().filter(|wall| {
                    let n = wall.face.normal_W();
                    let p = wall.face.X_WF.translation.vector;
                    n[axis] < -0.999 && (p[axis] - at).abs() < 0.03
                });
                assert!(found.any(|wall| wall.width_m > 1.0), "axis {axis}");
            }
            // 2. Each pole from the ground on, as high as a robot is.
            for [x, y] in POLES_M {
                for p in upright_edges(x, y, POLE_M / 2.0, 1.2) {
                    let inside = all.iter().any(|body| holds(body, &p, 0.015));
                    assert!(inside, "{}: pole at {x}, {y}: {p}", row.angle_deg);
                }
            }
            // 3. Nothing where nothing stands: on the way to the ramp, and over it.
            for p in free_places(&ramp) {
                let taken = all.iter().find(|body| holds(body, &p, 0.0));
                assert!(taken.is_none(), "{}: {p}: {taken:?}", row.angle_deg);
            }
            // 4. Not more than there is: bodies lie at walls and poles.
            for thing in &seen.around.things {
                let near = truth.boxes.iter().skip(2);
                let near = near.map(|b| distance_m(b, &thing.centre_W));
                let near = near.fold(f64::INFINITY, f64::min);
                assert!(near < 0.25, "{}: {near} m: {thing:?}", row.angle_deg);
            }
        }
    }
}

/// Places on the way of a robot to the ramp and up it: 0.45 m to either side, up to 1 m high.
fn free_places(ramp: &Ramp) -> Vec<Point3<f64>> {
    let (sin, cos) = ramp.angle_deg.to_radians().sin_cos();
    let turn = ramp.ascent_deg.to_radians();
    let [x0, y0] = ramp.start_m;
    let mut places = Vec::new();
    for along in (-15..23).map(|k| 0.1 * f64::from(k)) {
        for side in (-3..=3).map(|k| 0.15 * f64::from(k)) {
            for high in [0.02, 0.1, 0.3, 0.6, 1.0] {
                let (run, rise) = if along > 0.0 {
                    (along * cos, along * sin)
                } else {
                    (along, 0.0)
                };
                places.push(Point3::new(
                    x0 + run * turn.cos() - side * turn.sin(),
                    y0 + run * turn.sin() + side * turn.cos(),
                    rise + high,
                ));
            }
        }
    }
    places
}

/// Distance of a place from a box, m.
fn distance_m(body: &OrientedBox, p: &Point3<f64>) -> f64 {
    let local = body.X_WO().inverse_transform_point(p).coords.abs();
    (local - Vector3::from(body.size_m) / 2.0)
        .map(|x| x.max(0.0))
        .norm()
}

/// A wall with a door in it is two parts of a wall, and the door is free.
#[test]
fn a_door_is_free() {
    let mut truth = room("flat", &[]);
    let wall = |name: &str, y: f64| {
        let centre = Vector3::new(2.55, y, 1.25);
        OrientedBox::new(
            name,
            centre,
            [0.1, 1.6, 2.5],
            nalgebra::Rotation3::identity(),
        )
    };
    // Nothing else ahead of the door.
    truth.boxes.truncate(1);
    truth
        .boxes
        .extend([wall("left", 1.25), wall("right", -1.25)]);
    let seen = looked(&truth, &usual_mount(), 1);
    assert_eq!(seen.around.walls.len(), 2, "{:?}", seen.around.walls);
    for y in (-7..=7).map(|k| 0.05 * f64::from(k)) {
        for z in [0.05, 0.5, 1.0] {
            let p = Point3::new(2.5, y, z);
            let taken = bodies(&seen).into_iter().find(|body| holds(body, &p, 0.0));
            assert!(taken.is_none(), "{p}: {taken:?}");
        }
    }
}

/// A bar over the way is a thing that hangs: what is under it is free.
#[test]
fn what_hangs_leaves_the_ground_below_it_free() {
    let mut truth = room("flat", &[]);
    truth.boxes.truncate(1);
    truth.boxes.push(OrientedBox::new(
        "bar",
        Vector3::new(2.5, 0.0, 0.8),
        [0.08, 1.2, 0.2],
        nalgebra::Rotation3::identity(),
    ));
    let seen = looked(&truth, &usual_mount(), 2);
    let at = |z: f64| {
        let p = Point3::new(2.5, 0.0, z);
        bodies(&seen).into_iter().any(|body| holds(body, &p, 0.0))
    };
    assert!(at(0.8) && !at(0.3), "{:?}", seen.around);
}
