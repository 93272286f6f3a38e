//! What holds a ball, near the ground that the ball is on.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use posture::{BaseGoal, Config, Contact, PlacedShape};
use robot_model::collision::{ShapeGeometry, closest};
use robot_model::{Kinematics, Robot};
use surfaces::Source;

use crate::world::{solve, square, standing, world};

/// A shank is thicker than its ball: where it lies flat it stands on its rim, and the ball on nothing.
#[test]
fn a_shank_stays_off_the_ground_that_its_ball_is_on() {
    let (robot, q) = standing("quadruped", "standing", "front_left");
    let world = world(vec![square("floor", [0.0; 3], 0.0, 2.0)]);
    let floor = world.face("floor").unwrap();
    let kinematics = Kinematics::new(&robot, &q);
    let feet = ["front_left", "front_right", "rear_left", "rear_right"];
    let far_ahead = feet.map(|foot| {
        let patch = robot.patch_id(foot).unwrap();
        let mut at = kinematics.X_WC(&robot.patches[patch]).translation.vector;
        at.x += if at.x > 0.0 { 0.4 } else { 0.0 };
        let at = Isometry3::from_parts(at.into(), UnitQuaternion::identity());
        Contact::at(&robot, patch, at).on(floor, &world)
    });
    let low = BaseGoal {
        position_m: [None, None, Some(0.25)],
        tolerance_m: 0.03,
        ..BaseGoal::default()
    };
    let outcome = solve(
        &robot,
        &world,
        &far_ahead,
        Some(low),
        &q,
        &Config::default(),
    );
    assert!(outcome.posture().is_some(), "{outcome:?}");
}

#[test]
fn what_holds_the_ball_may_touch_and_all_of_the_link_where_nothing_does() {
    let (mut robot, _) = standing("quadruped", "standing", "front_left");
    let mut patches = robot.patches.clone();
    let body = patches[0].body;
    let pads = |robot: &Robot| {
        let own = robot.collision.shapes().iter().filter(|s| s.body == body);
        own.map(|shape| shape.is_pad).collect::<Vec<bool>>()
    };
    let held = pads(&robot);
    assert!(held.contains(&true) && held.contains(&false), "{held:?}");
    patches[0].X_BC.translation.vector.z -= 1.0;
    robot.set_patches(patches);
    assert!(pads(&robot).iter().all(|is_pad| *is_pad));
}

/// A shank leans over the next step, and its hull ends as its ball does.
#[test]
fn a_shank_that_is_round_below_is_a_ball_near_the_ball_alone() {
    let (robot, _) = standing("quadruped", "standing", "front_left");
    let patch = robot.patch("front_left").unwrap();
    let radius_m = patch.point_radius_m().unwrap();
    let (half_length_m, lean_rad) = (8.0 * radius_m, 65.0_f64.to_radians());
    let shank = ShapeGeometry::Capsule {
        half_length_m,
        radius_m,
    };
    let X_BG = patch.X_BC * Isometry3::translation(0.0, 0.0, half_length_m);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), lean_rad);
    let along_W = turn * Vector3::z();
    // What is asked of the shank over the edge of a step, where the ball rests on the floor and the edge is so far from its
    // centre along the shank.
    let asked_m = |edge_m: f64, apart_m: f64| {
        let (step_m, centre_W) = (0.5, Vector3::z() * radius_m);
        let edge_W = centre_W + along_W * edge_m + turn * Vector3::x() * (radius_m + apart_m);
        let middle = [edge_W.x + step_m, 0.0, edge_W.z];
        let floor = square(
            "floor",
            [-1.0 - radius_m, 0.0, 0.0],
            0.0,
            1.0 + 2.0 * radius_m,
        );
        let world = world(vec![floor, square("step", middle, 0.0, step_m)]);
        let X_WG = Isometry3::from_parts((centre_W + along_W * half_length_m).into(), turn);
        let step = &world.world().obstacles()[1];
        let found = closest(&shank, &X_WG, step.geometry(), step.pose(), 0.1).unwrap();
        assert!((found.distance - apart_m).abs() < 1e-6, "{found:?}");
        let placed = PlacedShape {
            geometry: &shank,
            X_BG: &X_BG,
            X_WG: &X_WG,
            is_pad: true,
            nearest_W: found.p_a_W,
            normal_W: found.normal_W,
        };
        world.beside_contact_m((patch, world.face("floor").unwrap()), &placed, 1)
    };
    let at_ball = asked_m(0.0, 1e-3).unwrap();
    assert!(at_ball < 1e-6, "{at_ball} m");
    let further = [1.0, 2.0, 4.0, 12.0].map(|radii| asked_m(radii * radius_m, 1e-3).unwrap());
    assert!(
        further.is_sorted() && further[0] > 0.1 * radius_m,
        "{further:?}"
    );
    assert!((further[3] - 0.5 * radius_m).abs() < 1e-9, "{further:?}");
}

/// Two scanned planes of one floor differ by as much as the rib is high; a mesh has a floor and a rib.
#[test]
fn a_ball_stands_on_no_rib_of_a_mesh() {
    let (robot, _) = standing("quadruped", "standing", "front_left");
    let patch = robot.patch("front_left").unwrap();
    let least_m = |source: Source| {
        let mut floor = square("floor", [0.0; 3], 0.0, 2.0);
        floor.source = source;
        let rib = square("rib", [0.5, 0.0, 0.01], 0.0, 0.05);
        let world = world(vec![rib, floor]);
        let floor = world.face("floor").unwrap();
        let shape = robot
            .collision
            .shapes()
            .iter()
            .find(|s| s.body == patch.body && s.is_pad);
        world.contact_distance_m(&robot, (patch, floor), shape.unwrap(), 0, 0.0)
    };
    assert!(least_m(Source::Scan).is_some_and(|m| m < -0.01));
    assert_eq!(least_m(Source::Mesh), None);
}
