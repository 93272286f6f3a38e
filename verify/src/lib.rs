//! Recomputes everything that a plan claims, from the plan and the robot alone.
//!
//! The code here shares nothing with the solvers: it has kinematics of its own (4×4 matrices),
//! moments summed link by link, polygons by their edges, equilibrium by linear programming from
//! nothing but the contacts, and distances that a separating direction vouches for. What it takes
//! from elsewhere is data: the robot's bodies, shapes and patches, the plan's faces.
//!
//! | file | what it checks |
//! |---|---|
//! | `structure` | format, robot, the promised margins, the environment |
//! | `world` | world and task are those of the plan's files, as far as these were found |
//! | `sequence` | one contact a stance, kept contacts, the goal |
//! | `roles` | which patches may touch which faces |
//! | `well_formed` | lengths, numbers and names |
//! | `stance` | joint limits, centre of mass, contacts on their faces |
//! | `forces` | friction cones, balance, torques; equilibrium and support region by LP |
//! | `motion` | the motion between the stances, where there is one |
//! | `refutation` | proofs that contacts have no posture |
//! | `clearance`, `watch`, `step` | distances to the environment, between parts, and how deep contacts sink |
//!
//! A plan that fails is told where: stance, contact or joint or pair, check, and by how much.
//!
//! ```
//! let robot = scenes::robot("quadruped").expect("it ships");
//! let plan: plan::Plan = serde_json::from_value(serde_json::json!({
//!     "format": plan::PLAN_FORMAT, "program": {"name": "by hand", "version": "1"}, "scene": "none",
//!     "seed": 0, "config": null, "inputs": [], "faces": [], "obstacles": [], "thin_body_m": 0.03,
//!     "robot": {"name": "quadruped", "joint_names": robot.joint_names().collect::<Vec<_>>(),
//!         "mass_kg": robot.mass_kg},
//!     "required": {"friction_use": 0.8, "torque_use": 0.8, "joint_rad": 0.03, "clearance_m": 0.01,
//!         "self_clearance_m": 0.005, "com_m": 0.03, "edge_sigmas": 2.0},
//!     "goal": {"base_position_m": null, "tolerance_m": 0.1, "yaw_rad": null, "contacts": []},
//!     "stances": [], "motion": null, "search": {"nodes_generated": 0, "nodes_expanded": 0,
//!         "candidates_solved": 0, "path_stances": 0},
//! }))?;
//! let certificate = verify::verify(&plan, None, &robot);
//! let failures: Vec<String> = certificate.failures().map(|row| row.sentence()).collect();
//! assert_eq!(failures, ["plan: sequence does not hold: there are no stances"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod balance;
pub mod certificate;
mod check;
mod clearance;
mod convex_parts;
mod distance;
mod extremes;
mod findings;
mod forces;
mod motion;
mod nearest;
mod options;
mod polygon;
mod posture;
mod refutation;
mod region;
mod roles;
mod rolling;
mod scene;
mod sequence;
mod shapes;
mod simplex;
mod solid;
mod stance;
mod step;
mod structure;
mod surroundings;
mod watch;
mod well_formed;
mod world;

pub use certificate::{Certificate, Row, Summary};
pub use check::{Check, Sense};
pub use options::{Options, TOLERANCES};
pub use refutation::refuted;
pub use world::World;

use plan::{Motion, Plan};
use rayon::prelude::*;
use robot_model::Robot;

use findings::Findings;
use scene::Scene;
use surroundings::Surroundings;

/// Checks a plan, and the motion between its stances where there is one, against a robot; never fails, and
/// passes only what holds.
///
/// Bounds are the plan's own `required` margins, which must themselves make sense; slacks are
/// those of [`TOLERANCES`].
pub fn verify(plan: &Plan, motion: Option<&Motion>, robot: &Robot) -> Certificate {
    let mut world = World::default();
    world
        .leaves_open("if faces, obstacles, margins, start and goal are right: the plan's own word");
    verify_in(plan, motion, robot, &world)
}

/// [`verify`], and that the plan's world is the one that was found again from its files.
pub fn verify_in(
    plan: &Plan,
    motion: Option<&Motion>,
    robot: &Robot,
    world: &World,
) -> Certificate {
    let mut findings = Findings::default();
    let drawable = structure::check(plan, robot, &mut findings);
    sequence::check(plan, &mut findings);
    roles::check(plan, robot, &mut findings);
    world::check(plan, motion, world, &mut findings);
    if drawable {
        let scene = scene(plan, robot);
        each_stance(&scene, &mut findings);
        // Samples are gone through on what the stances say.
        let whole = (0..plan.stances.len()).all(|k| {
            !findings.flawed(Some(k), Check::Numbers) && !findings.flawed(Some(k), Check::Names)
        });
        match motion {
            Some(motion) if whole => self::motion::check(&scene, motion, &mut findings),
            Some(_) => {}
            None => {
                findings.condition("if the way from stance to stance is free: no motion".into())
            }
        }
    }
    findings.certify(&plan.scene, &robot.name, plan.stances.len())
}

/// Checks every stance of a plan by itself: postures that do not follow from one another, and lead
/// to no goal, can be checked as the stances of one plan.
pub fn verify_stances(plan: &Plan, robot: &Robot) -> Certificate {
    let mut findings = Findings::default();
    if structure::check(plan, robot, &mut findings) {
        each_stance(&scene(plan, robot), &mut findings);
    }
    findings.certify(&plan.scene, &robot.name, plan.stances.len())
}

fn scene<'a>(plan: &'a Plan, robot: &'a Robot) -> Scene<'a> {
    let (shapes, shanks) = shapes::with_shanks(robot);
    Scene {
        plan,
        robot,
        surroundings: Surroundings::new(plan),
        shapes,
        shanks,
    }
}

/// Each stance by itself, side by side.
fn each_stance(scene: &Scene, findings: &mut Findings) {
    let stances = scene.plan.stances.par_iter().enumerate();
    let found: Vec<Findings> = stances
        .map(|(index, stance)| {
            let mut findings = Findings::default();
            stance::check(scene, index, stance, &mut findings);
            findings
        })
        .collect();
    found.into_iter().for_each(|found| findings.append(found));
}
