//! Stances and motions in MuJoCo.

use nalgebra::{DVector, Matrix3, Point2, Vector3};
use robot_model::{GRAVITY_M_S2, Kinematics, Robot};

use simulation::Error;
use simulation::config::{Config, Controller};
use simulation::dynamics::Dynamics;
use simulation::execution::{Observer, TraceRow, Unobserved, execute};
use simulation::hold::hold;
use simulation::outcome::{Executed, Held};
use simulation::perturbation::{Kinds, Perturbation, Push};
use simulation::physics::{Physics, Scales, Servo};
use simulation::plant::{Plant, Side};
use simulation::playback::Playback;
use simulation::used_faces::Used;
use simulation::world::{WorldBody, WorldShape};

use crate::robot::{half_sitting, hrp2, standing};
use crate::stepping::{SHIFT_S, step_in_place};

const FEET: [&str; 2] = ["left_foot", "right_foot"];

/// A floor with its top at z = 0 that ends at x = `end_x_m`.
fn floor(end_x_m: f64) -> Vec<WorldBody> {
    let centre = Vector3::new(end_x_m - 10.0, 0.0, -0.25);
    vec![WorldBody {
        friction: None,
        name: "floor".to_owned(),
        part_of: "floor".to_owned(),
        shape: WorldShape::Box {
            X_WO: centre.into(),
            half_m: Vector3::new(10.0, 10.0, 0.25),
        },
    }]
}

/// The robot in a world with a floor, under these conditions.
fn plant(robot: &Robot, physics: &Physics, servo: Servo, scales: &Scales) -> Plant {
    Plant::new(robot, &floor(5.0), physics, servo, scales).expect("a model")
}

fn value(held: &Held, name: &str) -> f64 {
    let found = held.criteria.iter().find(|c| c.name == name);
    found.expect("a criterion of that name").value
}

#[test]
fn the_model_has_the_robots_mass_and_velocities() {
    // Plant::new refuses a model that has not; a scaled one has the scaled mass.
    let robot = hrp2();
    let physics = Physics::from(&Config::default());
    for mass in [1.0, 0.95] {
        let friction = 1.0;
        plant(&robot, &physics, Servo::STIFF, &Scales { mass, friction });
    }
}

#[test]
fn a_link_whose_moments_of_inertia_are_no_bodys_is_made_one() {
    let mut robot = hrp2();
    let physics = Physics::from(&Config::default());
    // None at all, and two that are less than the third, as Mini Cheetah's thighs in some descriptions.
    for moments in [[0.0; 3], [4.079e-4, 1.791e-3, 2.295e-3]] {
        for body in &mut robot.bodies {
            body.inertia_B = Matrix3::from_diagonal(&moments.into());
        }
        plant(&robot, &physics, Servo::STIFF, &Scales::default());
    }
}

/// M and h of this crate against MuJoCo's, by way of the acceleration of free fall with torques.
#[test]
fn accelerations_agree_with_mujoco() {
    let robot = hrp2();
    // Far above any floor, without what only MuJoCo's joints have.
    let physics = Physics {
        armature: 0.0,
        damping: 0.0,
        dt_s: 1e-6,
        ..Physics::from(&Config::default())
    };
    let servo = Servo { kp: 1.0, kv: 0.0 };
    let mut plant = plant(&robot, &physics, servo, &Scales::default());
    let mut configuration = half_sitting(&robot);
    configuration.p_WB.z += 2.0;
    let mut turn = vec![0.3; 6];
    // Towards the middle of the ranges: a limit that is touched pushes, too.
    for (q, body) in configuration.joints.iter().zip(robot.joint_bodies()) {
        turn.push(0.2 * ((body.lower + body.upper) / 2.0 - q));
    }
    configuration.integrate_in_place(&turn);
    plant.reset(&configuration);
    let mut touches = Vec::new();
    plant.touches(&mut touches);
    assert!(touches.is_empty(), "{touches:?}");
    let torques: Vec<f64> = (0..robot.nj()).map(|j| 0.5 * (j as f64).sin()).collect();
    let still = vec![0.0; robot.nj()];
    plant.command(configuration.joints.as_slice(), &still, &torques);
    let (mut after, mut v) = (configuration.clone(), DVector::zeros(robot.nv()));
    assert!(plant.step());
    plant.state(&mut after, &mut v);
    let measured = v / physics.dt_s;

    let dynamics = Dynamics::new(&robot, &configuration);
    let mut force = -&dynamics.h;
    for (j, torque) in torques.iter().enumerate() {
        force[6 + j] += torque;
    }
    let expected = dynamics.M.cholesky().expect("definite").solve(&force);
    let error = (&measured - &expected).norm() / expected.norm();
    assert!(error < 1e-5, "{error}");
}

#[test]
fn soles_touch_at_every_corner() {
    let four = hrp2();
    // More corners than MuJoCo gives two shapes points of contact.
    let mut eight = hrp2();
    for patch in &mut eight.patches {
        let clipped = |p: &Point2<f64>| [Point2::new(0.6 * p.x, p.y), Point2::new(p.x, 0.5 * p.y)];
        let corners: Vec<_> = patch.polygon.iter().flat_map(clipped).collect();
        patch.polygon = corners;
    }
    let mut wide = eight.clone();
    for patch in &mut wide.patches {
        patch.polygon.iter_mut().for_each(|p| *p *= 2.5);
    }
    let corners = |robot: &Robot| simulation::mjcf::corners(robot).count();
    assert_eq!([&four, &eight, &wide].map(corners), [0, 4 * 8, 0]);
    for robot in [four, eight] {
        let configuration = half_sitting(&robot);
        let physics = Physics::from(&Config::default());
        let mut plant = plant(&robot, &physics, Servo::STIFF, &Scales::default());
        // Half a millimetre deep, so that every corner touches.
        let mut pressed = configuration.clone();
        pressed.p_WB.z -= 0.0005;
        plant.reset(&pressed);
        let mut touches = Vec::new();
        plant.touches(&mut touches);
        let kinematics = Kinematics::new(&robot, &pressed);
        for name in FEET {
            let patch = robot.patch(name).expect("a patch");
            let X_WC = kinematics.X_WC(patch);
            for vertex in &patch.polygon {
                let p_W = X_WC * nalgebra::Point3::new(vertex.x, vertex.y, 0.0);
                let on_floor = touches.iter().filter(|t| t.other == Side::World(0));
                let away = on_floor.map(|t| (t.p_W - p_W.coords).norm());
                let near = away.fold(f64::INFINITY, f64::min);
                assert!(
                    near < 1.5e-3,
                    "{name}: nearest contact {near} m off a corner"
                );
            }
        }
        for touch in &touches {
            assert!((touch.depth_m - 0.0005).abs() < 1e-6, "{}", touch.depth_m);
            assert!(touch.normal_W.z > 0.999);
        }
    }
}

#[test]
fn standing_on_flat_ground_holds() {
    let robot = hrp2();
    let stance = standing(&robot, half_sitting(&robot), &FEET);
    let held = hold(&robot, &floor(5.0), &stance, &Config::default(), None).expect("a run");
    assert!(held.pass, "{:#?}", held.criteria);
    let sum: f64 = held.normal_n.iter().map(|(_, n)| n).sum();
    assert!((sum / (robot.mass_kg * GRAVITY_M_S2) - 1.0).abs() < 0.01);
    let push = Some(Vector3::x() * 20.0);
    let pushed = hold(&robot, &floor(5.0), &stance, &Config::default(), push).expect("a run");
    assert!(pushed.pass, "{:#?}", pushed.criteria);
    assert!(value(&pushed, "com drift") > value(&held, "com drift"));
}

/// The floor ends under the soles: the centre of mass lies inside or outside of what is left.
#[test]
fn the_edge_of_the_support_region_tells() {
    let robot = hrp2();
    let stance = standing(&robot, half_sitting(&robot), &FEET);
    let com_x = Kinematics::new(&robot, &half_sitting(&robot)).com_W.x;
    let config = Config::default();
    let at = |x: f64| hold(&robot, &floor(x), &stance, &config, None).expect("a run");
    let inside = at(com_x + 0.03);
    assert!(value(&inside, "com drift") < 3.0, "{:#?}", inside.criteria);
    let outside = at(com_x - 0.01);
    let drift = value(&outside, "com drift");
    assert!(!outside.pass && drift > 100.0, "{:#?}", outside.criteria);
}

/// On one foot over an edge that runs under the middle of the sole.
#[test]
fn a_foot_half_over_the_edge_falls() {
    let robot = hrp2();
    let stance = standing(&robot, half_sitting(&robot), &FEET);
    let patch = robot.patch("left_foot").expect("a patch");
    let X_WC = Kinematics::new(&robot, &half_sitting(&robot)).X_WC(patch);
    let edge = floor(X_WC.translation.x - 0.03);
    let held = hold(&robot, &edge, &stance, &Config::default(), None).expect("a run");
    assert!(!held.pass, "{:#?}", held.criteria);
}

/// Weight onto the right foot, the left one up and down, and back: a motion that the controllers
/// have to execute within the criteria of plans.
fn stepping(controller: Controller, perturbation: &Perturbation) -> Executed {
    let robot = hrp2();
    let playback = Playback::new(&robot, step_in_place(&robot, 0.0)).expect("a motion");
    let config = Config {
        controller,
        ..Config::default()
    };
    let (world, nobody) = (floor(5.0), &mut Unobserved);
    execute(&robot, &world, &playback, &config, perturbation, nobody).expect("a run")
}

#[test]
fn a_step_in_place_is_executed() {
    for controller in [Controller::WholeBody, Controller::Servo] {
        let run = stepping(controller, &Perturbation::default());
        assert!(run.pass, "{controller:?}: {:#?}", run.criteria);
    }
}

#[test]
fn a_step_in_place_survives_other_mass_friction_and_pushes() {
    for (mass, angle) in [(0.95_f64, 0.7_f64), (1.05, 3.9)] {
        let push = |t_s: f64| Push {
            t_s,
            duration_s: 0.2,
            force_W: [60.0 * angle.cos(), 60.0 * angle.sin(), 0.0],
        };
        let disturbed = Perturbation {
            friction_factor: Some(0.75),
            mass_factor: Some(mass),
            pushes: vec![push(1.0), push(3.2)],
            ..Perturbation::default()
        };
        let run = stepping(Controller::WholeBody, &disturbed);
        assert_eq!(run.fell_s, None, "{:#?}", run.criteria);
        assert!(run.pass, "{:#?}", run.criteria);
    }
}

/// Pushed back on its way over the right foot the robot is waited for; pushed on, or not at all, it is not.
#[test]
fn the_reference_waits_for_a_robot_that_is_held_up() {
    let pushed = |newton: f64| {
        let push = Push {
            t_s: 0.7 * SHIFT_S,
            duration_s: 0.2,
            force_W: [0.0, newton, 0.0],
        };
        let disturbed = Perturbation {
            pushes: vec![push],
            ..Perturbation::default()
        };
        stepping(Controller::WholeBody, &disturbed)
    };
    let [back, on, calm] = [120.0, -60.0, 0.0].map(pushed);
    assert!(back.pass && back.waited_s > 0.05, "{back:#?}");
    assert!(back.simulated_s - calm.simulated_s > 0.05);
    assert_eq!((on.waited_s, calm.waited_s), (0.0, 0.0));
}

/// When a foot presses for the first time after it should stand again.
struct Landing {
    patch: usize,
    due_s: f64,
    landed_s: Option<f64>,
}

impl Observer for Landing {
    fn see(&mut self, _: &mut Plant, row: &TraceRow) -> Result<(), Error> {
        if row.t_s >= self.due_s && row.normal_n[self.patch] > 0.0 {
            self.landed_s.get_or_insert(row.t_s);
        }
        Ok(())
    }
}

#[test]
fn a_foot_that_finds_nothing_goes_on_to_what_is_10_mm_lower() {
    let robot = hrp2();
    let motion = step_in_place(&robot, 0.010);
    let mut landing = Landing {
        patch: robot.patch_index("left_foot").expect("a patch"),
        due_s: motion.phases[2].t_start_s,
        landed_s: None,
    };
    let playback = Playback::new(&robot, motion).expect("a motion");
    let (config, calm) = (Config::default(), Perturbation::default());
    let world = floor(5.0);
    execute(&robot, &world, &playback, &config, &calm, &mut landing).expect("a run");
    let late_s = landing.landed_s.expect("a landing") - landing.due_s;
    // At 0.15 m/s.
    assert!(late_s < 0.13, "{late_s} s late");
}

#[test]
fn a_push_that_is_too_strong_fells_and_is_reported() {
    let push = Push {
        t_s: 3.0,
        duration_s: 0.4,
        force_W: [0.0, -400.0, 0.0],
    };
    let disturbed = Perturbation {
        pushes: vec![push],
        ..Perturbation::default()
    };
    let run = stepping(Controller::WholeBody, &disturbed);
    assert!(!run.pass);
    assert!(run.fell_s.is_some_and(|t| t > 3.0 && t < 5.0), "{run:#?}");
    assert!(run.cause.is_some_and(|cause| cause.contains("fell")));
}

#[test]
fn the_world_is_displaced_as_drawn() {
    let used = [Some(Used {
        first: 0,
        centre_W: Vector3::zeros(),
        reach_m: 0.0,
    })];
    let spread = Config::default().perturbation;
    let drawn = Perturbation::draw(3, 0, &spread, Kinds::ALL, &used, 6.5);
    let moved = drawn.applied(&floor(5.0));
    let [was, is] = [&floor(5.0), &moved].map(|world| world[0].corners_W()[7]);
    let wanted = drawn.moved[0].motion_W() * was;
    assert!((is - wanted).norm() < 1e-12 && (is - was).norm() > 1e-3);
}
