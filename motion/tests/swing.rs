//! Motions of the humanoid that ships between stances on a floor and a step.
#![allow(clippy::unwrap_used)]

use motion::{Config, Failure, Interpolation, MotionContext, Reason, Segment, StanceRef};
use motion::{assemble, segment};
use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use plan::{Motion, PhaseKind};
use posture::{Contact, Environment, Freedom, Outcome, Posture, Problem};
use robot_model::collision::closest;
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, PatchId, Robot};
use surfaces::{Face, Obstacle, Terrain};

/// Height and front of the step, m.
const STEP: (f64, f64) = (0.20, 0.22);

fn face(id: &str, p: [f64; 3], x: Vector3<f64>, y: Vector3<f64>, size: [f64; 2]) -> Face {
    let rotation = Rotation3::from_basis_unchecked(&[x, y, x.cross(&y)]);
    let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
    let pose = Isometry3::from_parts(Translation3::from(p), rotation);
    Face::rectangle(id, pose, size).unwrap()
}

/// A floor, and a step across it with a front.
fn step() -> Terrain {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let (height, front) = STEP;
    Terrain {
        faces: vec![
            face("floor", [-0.3, 0.0, 0.0], x, y, [1.04, 1.2]),
            face("step", [front + 0.25, 0.0, height], x, y, [0.5, 1.2]),
            face("riser", [front, 0.0, 0.5 * height], -y, z, [1.2, height]),
        ],
        obstacles: Vec::new(),
    }
}

/// Stances: the left foot about to leave the floor, touching the step, and bearing all.
struct Pair {
    contacts: [Vec<Contact>; 3],
    posture: [Posture; 3],
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
                .on(floor, environment)
                .loaded(loaded)
        };
        let placed = Contact::anywhere_on(environment, step, robot, left).unwrap();
        let mut placed = Contact {
            friction: 0.6,
            ..placed.loaded(false)
        };
        if let Freedom::Within(area) = &mut placed.freedom {
            area.toward = Some(Point3::new(STEP.1 + 0.16, 0.10, STEP.0));
            area.yaw_rad = Some(0.0);
        }
        let solve = |contacts: &[Contact], guess: &Configuration| {
            let problem = Problem {
                robot,
                environment,
                contacts: contacts.to_vec(),
                base_goal: None,
                joint_goal: None,
                reference: &start,
                guess,
            };
            match posture::solve(&problem, &posture::Config::default()).unwrap() {
                Outcome::Feasible(posture) => *posture,
                other => panic!("{}", other.violation().unwrap().describe(&problem)),
            }
        };
        let off = vec![fixed(left, false), fixed(right, true)];
        let onto = vec![fixed(right, true), placed];
        let before = solve(&off, &start);
        let after = solve(&onto, &before.q);
        let landed = Contact {
            freedom: Freedom::Fixed,
            X_WC: after.contacts[1].X_WC,
            ..onto[1].clone().loaded(true)
        };
        let leaving = vec![fixed(right, false), landed];
        let shifted = solve(&leaving, &after.q);
        Self {
            contacts: [off, onto, leaving],
            posture: [before, after, shifted],
        }
    }

    fn end(&self, i: usize) -> StanceRef<'_> {
        StanceRef {
            contacts: &self.contacts[i],
            posture: &self.posture[i],
        }
    }
}

/// The humanoid, the two stances, and what a motion between them is asked for.
struct Step {
    robot: Robot,
    environment: Environment,
    pair: Pair,
    posture: posture::Config,
    config: Config,
}

impl Step {
    fn new() -> Self {
        Self::beside(Vec::new())
    }

    /// With bodies beside the step.
    fn beside(obstacles: Vec<Obstacle>) -> Self {
        let builtin = scenes::builtin_robot("hrp2").unwrap();
        let robot = builtin.load(&robot_model::Config::default()).unwrap();
        let world = Terrain {
            obstacles,
            ..step()
        };
        let environment = Environment::new(world, 0.03, 2.0).unwrap();
        Self {
            pair: Pair::new(&robot, &environment),
            robot,
            environment,
            posture: posture::Config::default(),
            config: Config::default(),
        }
    }

    fn context(&self) -> MotionContext<'_> {
        MotionContext::new(&self.robot, &self.environment, &self.posture, &self.config)
    }

    fn segment(&self) -> Result<Result<Segment, Failure>, motion::Error> {
        segment(&self.context(), self.pair.end(0), self.pair.end(1))
    }

    fn motion(&self) -> Motion {
        self.motion_to(1)
    }

    /// The motion from the first stance to another.
    fn motion_to(&self, last: usize) -> Motion {
        let context = self.context();
        let segments = (0..last).map(|k| {
            let segment = segment(&context, self.pair.end(k), self.pair.end(k + 1)).unwrap();
            segment.unwrap_or_else(|failure| panic!("{}", failure.describe()))
        });
        let segments: Vec<Segment> = segments.collect();
        let motion = assemble(&context, &segments.iter().collect::<Vec<_>>());
        motion.validate().unwrap();
        motion
    }
}

#[test]
fn a_swing_over_a_step_clears_it() {
    let step = Step::new();
    let motion = step.motion();
    let Step {
        robot,
        environment,
        pair,
        posture,
        config,
    } = &step;

    let left = robot.patch("left_foot").unwrap();
    let right = robot.patch("right_foot").unwrap();
    let stands = pair.posture[0].contacts[1].X_WC;
    let mut rose: f64 = 0.0;
    for sample in &motion.samples {
        let q = Configuration::from_q(&sample.q).unwrap();
        let kinematics = Kinematics::new(robot, &q);
        // The right foot stays where it stands.
        let off = kinematics.X_WC(right).translation.vector - stands.translation.vector;
        assert!(off.norm() < 5e-5, "{off} at {} s", sample.t_s);
        // Nothing of either leg comes near the riser; the foot lands on the step's own body.
        for (i, shape) in robot.collision.shapes().iter().enumerate() {
            let X_WG = robot.collision.X_WG(&kinematics, i);
            let riser = &environment.world().obstacles()[2];
            let (geometry, pose, margin) = (riser.geometry(), riser.pose(), posture.clearance_m);
            let near = closest(&shape.geometry, &X_WG, geometry, pose, margin);
            let over = kinematics.X_WC(left).translation.vector.z > STEP.0;
            let distance = near.map_or(margin, |near| near.distance);
            // 5 % of the margin is what a smooth curve may stray.
            let clear = distance > 0.95 * margin || shape.body == left.body && over;
            assert!(clear, "{}: {distance} at {} s", shape.link, sample.t_s);
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
    let mut step = Step::new();
    step.config.settle_s = 0.05;
    let motion = step.motion();
    let Step {
        robot,
        pair,
        config,
        ..
    } = &step;
    let weight = robot.mass_kg * GRAVITY_M_S2;

    let kinds: Vec<PhaseKind> = motion.phases.iter().map(|p| p.kind).collect();
    assert_eq!(kinds, [PhaseKind::Swing, PhaseKind::Hold]);
    let ends = [motion.samples.first(), motion.samples.last()].map(Option::unwrap);
    for (sample, posture) in ends.into_iter().zip(&pair.posture) {
        let q = Configuration::from_q(&sample.q).unwrap();
        assert!(q.difference(&posture.q).amax() < 1e-6);
    }
    // Forces are what the centre of mass needs, by its own path; its height is the samples'.
    let up = Vector3::z() * GRAVITY_M_S2;
    for three in motion.samples.windows(3) {
        let [before, now, after] = [0, 1, 2].map(|k| Vector3::from(three[k].com_W));
        let acceleration = (after - now * 2.0 + before) / motion.dt_s.powi(2);
        let forces = |k: usize| {
            three[k]
                .forces_W
                .iter()
                .flatten()
                .map(|f| Vector3::from(*f))
        };
        let lands = forces(2).count() != forces(1).count();
        let sum: Vector3<f64> = forces(1).sum();
        // Differences over three samples see an acceleration that grows to its bound within five.
        let off = (sum / robot.mass_kg - up - acceleration).norm();
        assert!(off < 0.3, "{off} m/s² at {} s", three[1].t_s);
        // From bound to bound within five samples.
        if !lands {
            for (a, b) in forces(1).zip(forces(2)) {
                assert!((a - b).norm() < 0.25 * weight, "at {} s", three[1].t_s);
            }
        }
    }
    // Accelerations grow and fall over some samples.
    let curve = Interpolation::new(&motion).unwrap();
    let at = |i: usize| curve.at(i as f64 * motion.dt_s);
    let accelerations: Vec<_> = (0..motion.samples.len()).map(|i| at(i).a).collect();
    let peak = accelerations.iter().map(|a| a.amax()).fold(0.0, f64::max);
    for (i, pair) in accelerations.windows(2).enumerate() {
        let jump = (&pair[1] - &pair[0]).amax();
        assert!(jump < 0.6 * peak, "{jump} of {peak} at sample {i}");
    }
    assert!(at(0).v.amax() < 1e-9 && at(motion.samples.len() - 1).v.amax() < 1e-9);
    // Joints keep to the part of their speed that is asked for.
    for i in 0..motion.samples.len() {
        for (v, body) in at(i).v.iter().skip(6).zip(robot.joint_bodies()) {
            assert!(v.abs() < 1.02 * config.joint_speed_use * body.velocity);
        }
    }
}

#[test]
fn the_body_goes_on_while_the_foot_lands_at_rest() {
    let mut step = Step::new();
    let through = step.motion_to(2);
    step.config.settle_s = 0.05;
    let stops = step.motion_to(2);
    let kinds = |motion: &Motion| motion.phases.iter().map(|p| p.kind).collect::<Vec<_>>();
    assert_eq!(kinds(&through), [PhaseKind::Swing, PhaseKind::Shift]);
    let halted = [PhaseKind::Swing, PhaseKind::Hold, PhaseKind::Shift];
    assert_eq!(kinds(&stops), halted);
    let left = &step.robot.patches[step.robot.patch_id("left_foot").unwrap()];
    let lands = |motion: &Motion| (motion.phases[0].t_end_s / motion.dt_s).round() as usize;
    let border = lands(&through);
    let [before, at, after] = [border - 1, border, border + 1].map(|i| &through.samples[i]);
    let com = |sample: &plan::Sample| Vector3::from(sample.com_W);
    let speed = (com(after) - com(before)).norm() / (2.0 * through.dt_s);
    assert!(speed > 0.05, "{speed} m/s");
    let still = &stops.samples[lands(&stops)];
    assert!(still.v.iter().all(|v| v.abs() < 1e-6));
    // The foot stands still there, and the body is where the stance has it.
    let place = |sample: &plan::Sample| {
        let q = Configuration::from_q(&sample.q).unwrap();
        Kinematics::new(&step.robot, &q).X_WC(left)
    };
    let moved = place(before).translation.vector - place(at).translation.vector;
    assert!(moved.norm() < 1e-4, "{moved}");
    let q = Configuration::from_q(&at.q).unwrap();
    assert!(q.difference(&step.pair.posture[1].q).amax() < 1e-4);
    // No velocity jumps.
    let most = step.config.joint_acceleration_rad_s2 * through.dt_s;
    for pair in through.samples.windows(2) {
        for (a, b) in pair[0].v.iter().zip(&pair[1].v).skip(6) {
            assert!((a - b).abs() < 1.01 * most, "at {} s", pair[1].t_s);
        }
    }
}

/// Every limit, from nothing but the samples: rates by differences, loads from the forces as they are.
#[test]
fn the_fastest_motion_keeps_its_limits_and_one_of_them_binds() {
    let step = Step::new();
    let (motion, config, robot) = (step.motion(), &step.config, &step.robot);
    let mut most = [0.0_f64; 4];
    for phase in &motion.phases {
        let index = |t: f64| (t / motion.dt_s).round() as usize;
        let samples = &motion.samples[index(phase.t_start_s)..index(phase.t_end_s)];
        for pair in samples.windows(2) {
            for (j, body) in robot.joint_bodies().iter().enumerate() {
                let change = |x: &dyn Fn(usize) -> f64| (x(1) - x(0)).abs() / motion.dt_s;
                let speed = change(&|k| pair[k].q[7 + j]) / body.velocity;
                let acceleration = change(&|k| pair[k].v[6 + j]);
                most[0] = most[0].max(speed / config.joint_speed_use);
                most[1] = most[1].max(acceleration / config.joint_acceleration_rad_s2);
                let torque = pair[0].tau[j].abs() / body.effort;
                most[2] = most[2].max(torque / config.torque_use);
            }
            for (contact, forces) in phase.contacts.iter().zip(&pair[0].forces_W) {
                let X_WC = UnitQuaternion::new_normalize(contact.X_WC.quat_xyzw.into());
                for force in forces.iter().filter(|f| f[2].abs() > 1e-6) {
                    let f = X_WC.inverse_transform_vector(&Vector3::from(*force));
                    assert!(f.z > 0.0, "it pulls at {} s", pair[0].t_s);
                    let friction = f.xy().norm() / (f.z * contact.friction);
                    most[3] = most[3].max(friction / config.friction_use);
                }
            }
        }
    }
    // Differences of a curve over a sample are its mean rates: no more than the largest.
    assert!(most.iter().all(|part| *part < 1.01), "{most:?}");
    assert!(most.iter().any(|part| *part > 0.9), "{most:?}");
}

/// Two faces that are known to a centimetre: one of them rises over the foot that stands on the other.
#[test]
fn a_foot_leaves_what_rises_a_little_beside_its_floor() {
    for rise_m in [0.009, 0.0105, 0.012, 0.0135, 0.0148] {
        let plate = Obstacle::cuboid("plate", [-0.3, 0.05, -0.05], [0.15, 0.3, rise_m]);
        let step = Step::beside(vec![plate]);
        if let Err(failure) = step.segment().unwrap() {
            panic!("{rise_m} m: {}", failure.describe());
        }
    }
}

#[test]
fn a_wall_in_the_way_is_the_reason() {
    let mut between = Step::new();
    // A plate between the foot's places, from wall to wall and up to the chest, where neither
    // posture is.
    let mut set = step();
    let corner = |k: usize| {
        let side = |bit: usize, sides: [f64; 2]| sides[k >> bit & 1];
        Point3::new(
            side(0, [0.175, 0.18]),
            side(1, [0.0, 1.5]),
            side(2, [0.02, 0.75]),
        )
    };
    set.obstacles.push(Obstacle {
        id: "plate".to_owned(),
        points_W: (0..8).map(corner).collect(),
        surface: None,
        assumed: false,
    });
    between.environment = Environment::new(set, 0.03, 2.0).unwrap();
    let failure = between.segment().unwrap();
    let failure = failure.expect_err("the plate is in the path");
    let text = failure.describe();
    assert_eq!(failure.swing.as_deref(), Some("left_foot"), "{text}");
    assert!((0.0..=1.0).contains(&failure.at), "{text}");
    let Reason::Clearance { link, body } = &failure.reason else {
        panic!("{:?}: {text}", failure.reason);
    };
    assert!(body == "plate" && link.starts_with("LLEG"), "{text}");
    let said = text.contains("plate") && text.contains("swing of left_foot");
    assert!(said, "{text}");
}

#[test]
fn the_same_stances_give_the_same_motion() {
    let step = Step::new();
    assert_eq!(step.motion(), step.motion());
}

#[test]
fn stances_that_do_not_follow_on_each_other_are_refused() {
    let mut step = Step::new();
    step.pair.contacts[0][0].loaded = true;
    let error = step.segment().unwrap_err();
    assert!(error.to_string().contains("left_foot"), "{error}");
}
