//! Motions of the humanoid that ships between stances on a floor and a step.
#![allow(clippy::unwrap_used, non_snake_case)]

use motion::{Config, Interpolation, MotionContext, Reason, Segment, StanceRef, assemble, segment};
use nalgebra::{Isometry3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use plan::{Motion, PhaseKind};
use posture::{Contact, Environment, Freedom, Outcome, Posture, Problem};
use robot_model::collision::closest;
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, PatchId, Robot};
use surfaces::{Face, Obstacle, Region, Terrain};

/// Height and front of the step, m.
const STEP: (f64, f64) = (0.20, 0.22);

fn humanoid() -> Robot {
    scenes::builtin_robot("hrp2")
        .unwrap()
        .load(&robot_model::Config::default())
        .unwrap()
}

fn face(id: &str, p: Vector3<f64>, x: Vector3<f64>, y: Vector3<f64>, half: [f64; 2]) -> Face {
    let rotation = Rotation3::from_basis_unchecked(&[x, y, x.cross(&y)]);
    let pose = Isometry3::from_parts(
        Translation3::from(p),
        UnitQuaternion::from_rotation_matrix(&rotation),
    );
    let [a, b] = half;
    let corners = [(-a, -b), (a, -b), (a, b), (-a, b)].map(|(u, v)| Point2::new(u, v));
    Face::new(id, pose, Region::new([corners.to_vec()]).unwrap())
}

/// A floor, and a step across it with a front.
fn step() -> Terrain {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let (height, front) = STEP;
    Terrain {
        faces: vec![
            face("floor", Vector3::new(-0.3, 0.0, 0.0), x, y, [0.52, 0.6]),
            face(
                "step",
                Vector3::new(front + 0.25, 0.0, height),
                x,
                y,
                [0.25, 0.6],
            ),
            face(
                "riser",
                Vector3::new(front, 0.0, 0.5 * height),
                -y,
                z,
                [0.6, 0.5 * height],
            ),
        ],
        obstacles: Vec::new(),
    }
}

/// Two stances: the left foot about to leave the floor, and touching the step.
struct Pair {
    contacts: [Vec<Contact>; 2],
    posture: [Posture; 2],
}

impl Pair {
    fn new(robot: &Robot, environment: &Environment) -> Self {
        let mut start: Configuration = robot.posture("half_sitting").unwrap();
        let sole = |q: &Configuration, name: &str| {
            Kinematics::new(robot, q).X_WC(robot.patch(name).unwrap())
        };
        start.p_WB.z -= sole(&start, "left_foot").translation.vector.z;
        let [left, right] = ["left_foot", "right_foot"].map(|n| robot.patch_id(n).unwrap());
        let [floor, step] = ["floor", "step"].map(|n| environment.face(n).unwrap());
        let fixed = |patch: PatchId, loaded: bool| Contact {
            friction: 0.6,
            ..Contact::at(robot, patch, sole(&start, &robot.patches[patch].name))
                .on(floor)
                .loaded(loaded)
        };
        let mut placed = Contact::anywhere_on(environment, step, robot, left).unwrap();
        placed = Contact {
            friction: 0.6,
            ..placed.loaded(false)
        };
        if let Freedom::Within(area) = &mut placed.freedom {
            area.toward = Some(Point3::new(STEP.1 + 0.16, 0.10, STEP.0));
            area.yaw_rad = Some(0.0);
        }
        let solve = |contacts: Vec<Contact>, guess: &Configuration| {
            let problem = Problem {
                robot,
                environment,
                contacts,
                base_goal: None,
                reference: &start,
                guess,
            };
            match posture::solve(&problem, &posture::Config::default()).unwrap() {
                Outcome::Feasible(posture) => *posture,
                other => panic!("{}", other.violation().unwrap().describe(&problem)),
            }
        };
        let contacts = [
            vec![fixed(left, false), fixed(right, true)],
            vec![fixed(right, true), placed],
        ];
        let before = solve(contacts[0].clone(), &start);
        let after = solve(contacts[1].clone(), &before.q);
        Self {
            contacts,
            posture: [before, after],
        }
    }

    fn end(&self, i: usize) -> StanceRef<'_> {
        StanceRef {
            contacts: &self.contacts[i],
            posture: &self.posture[i],
        }
    }
}

fn context<'a>(
    robot: &'a Robot,
    environment: &'a Environment,
    posture: &'a posture::Config,
    config: &'a Config,
) -> MotionContext<'a> {
    MotionContext {
        robot,
        environment,
        posture,
        config,
    }
}

fn moved(context: &MotionContext, pair: &Pair) -> (Segment, Motion) {
    let segment = segment(context, pair.end(0), pair.end(1)).unwrap();
    let segment = segment.unwrap_or_else(|failure| panic!("{}", failure.describe()));
    let motion = assemble(context, &[&segment]);
    motion.validate().unwrap();
    (segment, motion)
}

#[test]
fn a_swing_over_a_step_clears_it() {
    let robot = humanoid();
    let environment = Environment::new(step(), 0.03, 2.0).unwrap();
    let pair = Pair::new(&robot, &environment);
    let (posture, config) = (posture::Config::default(), Config::default());
    let (_, motion) = moved(&context(&robot, &environment, &posture, &config), &pair);

    let left = robot.patch("left_foot").unwrap();
    let right = robot.patch("right_foot").unwrap();
    let stands = pair.posture[0].contacts[1].X_WC;
    let mut rose: f64 = 0.0;
    for sample in &motion.samples {
        let q = Configuration::from_q(&sample.q).unwrap();
        let kinematics = Kinematics::new(&robot, &q);
        // The right foot stays where it stands.
        let off = kinematics.X_WC(right).translation.vector - stands.translation.vector;
        assert!(off.norm() < 5e-5, "{off} at {} s", sample.t_s);
        // Nothing of either leg comes near the riser; the foot lands on the step's own body.
        for (i, shape) in robot.collision.shapes().iter().enumerate() {
            let X_WG = robot.collision.X_WG(&kinematics, i);
            let riser = &environment.world().obstacles()[2];
            let near = closest(
                &shape.geometry,
                &X_WG,
                riser.geometry(),
                riser.pose(),
                posture.clearance_m,
            );
            let lands =
                shape.body == left.body && kinematics.X_WC(left).translation.vector.z > STEP.0;
            if let Some(near) = near.filter(|_| !lands) {
                let distance = near.distance;
                // 5 % of the margin is what a smooth curve may stray.
                assert!(
                    distance > 0.95 * posture.clearance_m,
                    "{}: {distance} at {} s",
                    shape.link,
                    sample.t_s
                );
            }
        }
        // Over the step's edge the whole sole is above the step.
        let X_WC = kinematics.X_WC(left);
        for v in &left.polygon {
            let p = X_WC * Point3::new(v.x, v.y, 0.0);
            rose = rose.max(p.z);
            if p.x > STEP.1 {
                assert!(p.z > STEP.0 - 1e-4, "{p} at {} s", sample.t_s);
            }
        }
    }
    assert!(rose > STEP.0 + config.swing_clearance_m, "{rose}");
}

#[test]
fn configuration_forces_and_rates_are_continuous_and_carry_the_weight() {
    let robot = humanoid();
    let environment = Environment::new(step(), 0.03, 2.0).unwrap();
    let pair = Pair::new(&robot, &environment);
    let (posture, config) = (posture::Config::default(), Config::default());
    let (_, motion) = moved(&context(&robot, &environment, &posture, &config), &pair);
    let weight = robot.mass_kg * GRAVITY_M_S2;

    let kinds: Vec<PhaseKind> = motion.phases.iter().map(|p| p.kind).collect();
    assert_eq!(kinds, [PhaseKind::Swing, PhaseKind::Hold]);
    let (first, last) = (
        &motion.samples[0],
        &motion.samples[motion.samples.len() - 1],
    );
    for (sample, posture) in [(first, &pair.posture[0]), (last, &pair.posture[1])] {
        let q = Configuration::from_q(&sample.q).unwrap();
        assert!(q.difference(&posture.q).amax() < 1e-6);
    }
    for pair in motion.samples.windows(2) {
        let forces = |k: usize| pair[k].forces_W.iter().flatten().map(|f| Vector3::from(*f));
        let sum: Vector3<f64> = forces(0).sum();
        assert!((sum - Vector3::z() * weight).norm() < 1e-6 * weight);
        // Over the whole swing they change by less than the weight: a hundredth of it a step.
        for (a, b) in forces(0).zip(forces(1)) {
            assert!((a - b).norm() < 0.02 * weight, "at {} s", pair[0].t_s);
        }
    }
    // Accelerations change by steps of their own size over a hundredth of the swing.
    let curve = Interpolation::new(&motion).unwrap();
    let at = |i: usize| curve.at(i as f64 * motion.dt_s);
    let accelerations: Vec<_> = (0..motion.samples.len()).map(|i| at(i).a).collect();
    let peak = accelerations.iter().map(|a| a.amax()).fold(0.0, f64::max);
    for (i, pair) in accelerations.windows(2).enumerate() {
        let jump = (&pair[1] - &pair[0]).amax();
        assert!(jump < 0.35 * peak, "{jump} of {peak} at sample {i}");
    }
    assert!(at(0).v.amax() < 1e-9 && at(motion.samples.len() - 1).v.amax() < 1e-9);
    // Joints keep to the part of their speed that is asked for.
    for i in 0..motion.samples.len() {
        for (v, body) in at(i).v.iter().skip(6).zip(robot.joint_bodies()) {
            assert!(v.abs() < 1.1 * config.joint_speed_use * body.velocity);
        }
    }
}

#[test]
fn a_wall_in_the_way_is_the_reason() {
    let robot = humanoid();
    let free = Environment::new(step(), 0.03, 2.0).unwrap();
    let pair = Pair::new(&robot, &free);
    // A plate between the foot's places, from wall to wall and up to the chest, where neither
    // posture is.
    let mut set = step();
    let plate = |x: f64, y: [f64; 2], z: [f64; 2]| {
        let corners = [0, 1].into_iter().flat_map(move |i| {
            [0, 1]
                .into_iter()
                .flat_map(move |j| [0, 1].map(|k| (i, j, k)))
        });
        corners
            .map(|(i, j, k)| Point3::new(x + 0.005 * f64::from(i), y[j], z[k]))
            .collect::<Vec<_>>()
    };
    set.obstacles.push(Obstacle {
        id: "plate".to_owned(),
        points_W: plate(0.175, [0.0, 1.5], [0.02, 0.75]),
        surface: None,
        assumed: false,
    });
    let walled = Environment::new(set, 0.03, 2.0).unwrap();
    let (posture, config) = (posture::Config::default(), Config::default());
    let context = context(&robot, &walled, &posture, &config);
    let failure = segment(&context, pair.end(0), pair.end(1))
        .unwrap()
        .expect_err("the plate is in the path");
    let text = failure.describe();
    assert_eq!(failure.swing.as_deref(), Some("left_foot"), "{text}");
    assert!((0.0..=1.0).contains(&failure.at), "{text}");
    match &failure.reason {
        Reason::Clearance { link, body } => {
            assert_eq!(body, "plate");
            assert!(link.starts_with("LLEG"), "{text}");
        }
        other => panic!("{other:?}: {text}"),
    }
    assert!(
        text.contains("plate") && text.contains("swing of left_foot"),
        "{text}"
    );
}

#[test]
fn the_same_stances_give_the_same_motion() {
    let robot = humanoid();
    let environment = Environment::new(step(), 0.03, 2.0).unwrap();
    let pair = Pair::new(&robot, &environment);
    let (posture, config) = (posture::Config::default(), Config::default());
    let context = context(&robot, &environment, &posture, &config);
    assert_eq!(moved(&context, &pair).1, moved(&context, &pair).1);
}

#[test]
fn stances_that_do_not_follow_on_each_other_are_refused() {
    let robot = humanoid();
    let environment = Environment::new(step(), 0.03, 2.0).unwrap();
    let mut pair = Pair::new(&robot, &environment);
    let (posture, config) = (posture::Config::default(), Config::default());
    let context = context(&robot, &environment, &posture, &config);
    pair.contacts[0][0].loaded = true;
    let error = segment(&context, pair.end(0), pair.end(1)).unwrap_err();
    assert!(error.to_string().contains("left_foot"), "{error}");
}
