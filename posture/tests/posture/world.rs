//! Robots, faces, problems, and what every posture must fulfil.

use nalgebra::{DMatrix, DVector, Isometry3, Translation3, UnitQuaternion, Vector3};
use posture::{BaseGoal, Config, Contact, Environment, Outcome, Posture, Problem, stand};
use robot_model::collision::BodyShape;
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, Robot};
use surfaces::{Face, Terrain};

/// A robot that ships, standing in one of its postures on z = 0.
pub fn standing(robot: &str, posture: &str, foot: &str) -> (Robot, Configuration) {
    let robot = scenes::robot(robot).unwrap();
    let feet = [robot.patch_id(foot).unwrap()];
    let q = stand::on_level_ground(&robot, &robot.posture(posture).unwrap(), &feet);
    (robot, q)
}

/// A square of half width `half`, turned by `tilt_rad` about y.
pub fn square(id: &str, p: [f64; 3], tilt_rad: f64, half: f64) -> Face {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), tilt_rad);
    let pose = Isometry3::from_parts(Translation3::from(p), turn);
    Face::rectangle(id, pose, [2.0 * half; 2]).unwrap()
}

pub fn world(faces: Vec<Face>) -> Environment {
    let terrain = Terrain::new(faces, Vec::new()).unwrap();
    Environment::new(terrain, 0.05, 2.0).unwrap()
}

/// A contact anywhere on a face.
pub fn on(world: &Environment, robot: &Robot, patch: &str, face: &str, friction: f64) -> Contact {
    let (face, patch) = (world.face(face).unwrap(), robot.patch_id(patch).unwrap());
    Contact {
        friction,
        ..Contact::anywhere_on(world, face, robot, patch).unwrap()
    }
}

/// What comes of a problem whose reference is also its guess.
pub fn solve(
    robot: &Robot,
    world: &Environment,
    contacts: &[Contact],
    base_goal: Option<BaseGoal>,
    q: &Configuration,
    config: &Config,
) -> Outcome {
    let problem = Problem {
        robot,
        environment: world,
        contacts: contacts.to_vec(),
        base_goal,
        joint_goal: None,
        reference: q,
        guess: q,
    };
    let outcome = posture::solve(&problem, config).unwrap();
    if let Some(posture) = outcome.posture() {
        assert_sound(robot, contacts, posture, config);
        assert_on_ground(robot, world, contacts, posture);
    }
    outcome
}

/// Balance, friction, torques and limits, from the posture alone; balls touch below their centres.
fn assert_sound(robot: &Robot, contacts: &[Contact], posture: &Posture, config: &Config) {
    let weight = robot.mass_kg * GRAVITY_M_S2;
    let mut force = Vector3::new(0.0, 0.0, -weight);
    let mut moment = Vector3::zeros();
    let kinematics = Kinematics::new(robot, &posture.q);
    let mut torques = DVector::zeros(robot.nv());
    kinematics.gravity_torques(robot, &mut torques);
    for (state, contact) in posture.contacts.iter().zip(contacts) {
        let patch = &robot.patches[contact.patch];
        let normal = contact.normal_W();
        if let Some(radius) = patch.point_radius_m() {
            let centre = kinematics.X_WC(patch).translation.vector;
            let touched = centre - radius * normal;
            let over = patch.touched_W(&contact.X_WC);
            assert!(normal.dot(&(touched - over)).abs() < 1e-4, "{}", patch.name);
            assert!((state.X_WC.translation.vector - centre).norm() < 1e-9);
            assert!((state.X_WC.rotation * Vector3::z()).angle(&normal) < 1e-6);
            assert_eq!(state.vertices_W, state.force_points_W);
            assert_eq!(state.force_points_W.len(), 1);
            assert!((state.force_points_W[0] - touched).norm() < 1e-9);
        }
        for (p, f) in state.force_points_W.iter().zip(&state.forces_W) {
            force += f;
            moment += (p - kinematics.com_W).cross(f);
            let pressed = f.dot(&normal);
            let slid = (f - pressed * normal).norm();
            assert!(pressed >= -1e-6 * weight, "pulls with {pressed} N");
            let bound = contact.friction * config.friction_use * pressed;
            assert!(slid <= bound + 1e-5 * weight, "slides with {slid} N");
            assert!(contact.loaded || f.norm() == 0.0, "bears {f}");
            let mut jacobian = DMatrix::zeros(3, robot.nv());
            kinematics.point_jacobian(robot, patch.body, p, &mut jacobian);
            torques -= jacobian.transpose() * f;
        }
    }
    assert!(force.norm() < 1e-4 * weight, "unbalanced force {force}");
    assert!(moment.norm() < 1e-4 * weight, "unbalanced moment {moment}");
    for (j, body) in robot.joint_bodies().iter().enumerate() {
        let (torque, q, joint) = (torques[6 + j], posture.q.joints[j], &body.joint);
        let off = (torque - posture.torques[j]).abs();
        assert!(off < 1e-6 * weight, "{joint}");
        let most = body.effort * (config.torque_use + 1e-4);
        assert!(torque.abs() <= most, "{joint}");
        assert!(q >= body.lower && q <= body.upper, "{joint}");
    }
}

/// No link that stands on a ball is deeper in what it stands on than 4 mm.
fn assert_on_ground(robot: &Robot, world: &Environment, contacts: &[Contact], posture: &Posture) {
    let kinematics = Kinematics::new(robot, &posture.q);
    let on_ball = |body: usize| {
        let patches = contacts.iter().map(|c| &robot.patches[c.patch]);
        let mut own = patches.filter(|patch| patch.body == body);
        own.any(|patch| patch.point_radius_m().is_some())
    };
    let others = |shape: BodyShape, _| !on_ball(shape.body);
    let mut near = Vec::new();
    let collision = &robot.collision;
    collision.world_proximities(&kinematics, world.world(), 0.0, &others, &mut near);
    for pair in near {
        let shape = &collision.shapes()[pair.a.shape];
        let deepest = if shape.is_pad { -4.1e-3 } else { 0.0 };
        assert!(pair.distance > deepest, "{}: {}", shape.link, pair.distance);
    }
}
