//! A motion for tests: the weight goes onto the right foot, the left one steps in place.

use motion::time_scaling::quintic;
use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};
use plan::{Contact, Limits, MOTION_FORMAT, Motion, Phase, PhaseKind, Sample};
use robot_model::{Configuration, Kinematics, Robot};

use crate::robot::{balanced, half_sitting};

const DT_S: f64 = 0.01;
pub const SHIFT_S: f64 = 2.0;
const SWING_S: f64 = 2.5;
const LIFT_M: f64 = 0.05;
const FEET: [&str; 2] = ["left_foot", "right_foot"];

/// Shift onto the right foot, lift and lower the left one, onto a place so much higher, shift back; the forces
/// act at the patches' own corners.
pub fn step_in_place(robot: &Robot, higher_m: f64) -> Motion {
    let start = half_sitting(robot);
    let kinematics = Kinematics::new(robot, &start);
    let com = kinematics.com_W;
    let feet = FEET.map(|name| kinematics.X_WC(robot.patch(name).expect("a patch")));
    let over = feet[1].translation.vector.xy().push(com.z);
    let contact = |k: usize| Contact {
        patch: FEET[k].to_owned(),
        link: robot.patch(FEET[k]).expect("a patch").link.clone(),
        face: "floor".into(),
        X_WC: (&feet[k]).into(),
        rolls_from: None,
        friction: robot.patch(FEET[k]).expect("a patch").friction,
        loaded: true,
        vertices_W: Vec::new(),
        force_points_W: {
            let polygon = robot.patch(FEET[k]).expect("a patch").polygon.iter();
            let corners = polygon.map(|p| feet[k] * Point3::from(p.coords.push(0.0)));
            corners.map(|p: Point3<f64>| p.coords.into()).collect()
        },
        forces_W: Vec::new(),
    };
    let phase = |kind, t_start_s: f64, duration_s: f64, contacts, swing: Option<&str>| Phase {
        kind,
        t_start_s,
        t_end_s: t_start_s + duration_s,
        from_stance: 0,
        to_stance: 0,
        contacts,
        swing: swing.map(str::to_owned),
    };
    let both = || vec![contact(0), contact(1)];
    let (right, left) = (vec![contact(1)], Some(FEET[0]));
    let lowered = SHIFT_S + SWING_S;
    let landed = || {
        let mut landed = contact(0);
        landed.X_WC.p[2] += higher_m;
        let points = landed.force_points_W.iter_mut();
        points.for_each(|p| p[2] += higher_m);
        vec![landed, contact(1)]
    };
    let phases = vec![
        phase(PhaseKind::Shift, 0.0, SHIFT_S, both(), None),
        phase(PhaseKind::Swing, SHIFT_S, SWING_S, right, left),
        phase(PhaseKind::Shift, lowered, SHIFT_S, landed(), None),
    ];
    let mut configuration = start.clone();
    let sample = |k: usize| {
        let t = k as f64 * DT_S;
        // Onto the right foot and back; the left one up and down, at rest at both ends and at the top.
        let onto = quintic(t / SHIFT_S).min(1.0 - quintic((t - lowered) / SHIFT_S));
        let s = (t - SHIFT_S) / SWING_S * 2.0;
        let mut left = feet[0];
        left.translation.vector.z += LIFT_M * quintic(s).min(quintic(2.0 - s));
        left.translation.vector.z += higher_m * quintic(s - 1.0);
        let target = com + (over - com) * onto;
        reach(robot, &mut configuration, &start, &[left, feet[1]], &target);
        let swings = (SHIFT_S - 1e-9..lowered - 1e-9).contains(&t);
        Sample {
            t_s: t,
            q: configuration.to_q(),
            v: vec![0.0; robot.nv()],
            a: vec![0.0; robot.nv()],
            tau: vec![0.0; robot.nj()],
            com_W: target.into(),
            forces_W: forces(robot, &configuration, onto, swings),
        }
    };
    let steps = ((lowered + SHIFT_S) / DT_S).round() as usize;
    Motion {
        format: MOTION_FORMAT.to_owned(),
        robot: robot.name.clone(),
        dt_s: DT_S,
        limits: Limits {
            joint_speed_use: 1.0,
            joint_acceleration_rad_s2: 50.0,
            torque_use: 1.0,
            friction_use: 1.0,
            margin_use: 0.0,
        },
        phases,
        samples: (0..=steps).map(sample).collect(),
    }
}

/// Forces at the corners of the closed feet: the load goes to the right one as `onto` does.
fn forces(
    robot: &Robot,
    configuration: &Configuration,
    onto: f64,
    swings: bool,
) -> Vec<Vec<[f64; 3]>> {
    let right = balanced(robot, configuration, &FEET[1..]);
    let both = balanced(robot, configuration, &FEET);
    let corner_forces = |patch: usize, force: Vector3<f64>, moment: Vector3<f64>| {
        // Soles are level: the least-norm forces at the corners that make force and moment.
        let polygon = &robot.patches[patch].polygon;
        let mut grasp = DMatrix::zeros(6, 3 * polygon.len());
        for (k, p) in polygon.iter().enumerate() {
            grasp.view_mut((0, 3 * k), (3, 3)).fill_with_identity();
            let cross = p.coords.push(0.0).cross_matrix();
            grasp.view_mut((3, 3 * k), (3, 3)).copy_from(&cross);
        }
        let wrench = DVector::from_iterator(6, force.iter().chain(moment.iter()).copied());
        let x = grasp.pseudo_inverse(1e-9).expect("a pseudo-inverse") * wrench;
        let corner = |k: usize| [x[3 * k], x[3 * k + 1], x[3 * k + 2]];
        (0..polygon.len()).map(corner).collect::<Vec<_>>()
    };
    let on_right = |part: f64| {
        let (a, b) = (&both[1], &right[0]);
        let force = a.force_W.lerp(&b.force_W, part);
        corner_forces(a.patch, force, a.moment_W.lerp(&b.moment_W, part))
    };
    if swings {
        return vec![on_right(1.0)];
    }
    let left = &both[0];
    let less = 1.0 - onto;
    vec![
        corner_forces(left.patch, left.force_W * less, left.moment_W * less),
        on_right(onto),
    ]
}

/// Moves `configuration` so that the feet are at their poses and the centre of mass at its place,
/// near to `home` in what is left.
fn reach(
    robot: &Robot,
    configuration: &mut Configuration,
    home: &Configuration,
    feet: &[Isometry3<f64>; 2],
    com_W: &Vector3<f64>,
) {
    let nv = robot.nv();
    for _ in 0..20 {
        let kinematics = Kinematics::new(robot, configuration);
        let mut A = DMatrix::zeros(18, nv);
        let mut b = DVector::zeros(18);
        for (k, name) in FEET.iter().enumerate() {
            let patch = robot.patch(name).expect("a patch");
            let X_WC = kinematics.X_WC(patch);
            let at = X_WC.translation.vector;
            let mut rows = A.rows_mut(6 * k, 3);
            kinematics.point_jacobian(robot, patch.body, &at, &mut rows);
            let mut rows = A.rows_mut(6 * k + 3, 3);
            kinematics.angular_jacobian(robot, patch.body, &mut rows);
            let way = feet[k].translation.vector - at;
            b.rows_mut(6 * k, 3).copy_from(&way);
            let turn = (feet[k].rotation * X_WC.rotation.inverse()).scaled_axis();
            b.rows_mut(6 * k + 3, 3).copy_from(&turn);
        }
        kinematics.com_jacobian(robot, &mut A.rows_mut(12, 3));
        b.rows_mut(12, 3).copy_from(&(com_W - kinematics.com_W));
        for axis in 0..3 {
            A[(15 + axis, 3 + axis)] = 1.0;
        }
        let upright = (home.R_WB * configuration.R_WB.inverse()).scaled_axis();
        b.rows_mut(15, 3).copy_from(&upright);
        // Tasks first, then toward home as far as they allow.
        let inverse = A.clone().pseudo_inverse(1e-6).expect("a pseudo-inverse");
        let homeward = configuration.difference(home) * 0.5;
        let step = &inverse * &b + (&homeward - &inverse * (&A * &homeward));
        configuration.integrate_in_place(step.as_slice());
        if step.norm() < 1e-12 {
            break;
        }
    }
}
