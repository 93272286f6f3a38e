//! Walks of robots on balls over exactly known surfaces: planned, verified, executed.
#![allow(dead_code, non_snake_case, clippy::unwrap_used)]

use std::sync::atomic::AtomicBool;

use motion::Motion;
use nalgebra::{Isometry3, Point2, Rotation3, UnitQuaternion, Vector3};
use planner::plan::{
    GoalContact, GoalRecord, PLAN_FORMAT, Plan, Program, RequiredMargins, RobotSummary,
};
use planner::{Answer, Goal, Guide, Request, Start};
use posture::{BaseGoal, Environment};
use robot_model::{Configuration, Kinematics, Robot};
use surfaces::{ConvexPolygon, Surface, SurfaceSet};

/// Thickness of the bodies behind the surfaces, m.
const BODY_M: f64 = 0.05;

/// A robot that ships.
pub fn robot(name: &str) -> Robot {
    scenes::builtin_robot(name)
        .unwrap()
        .load(&robot_model::Config::default())
        .unwrap()
}

/// The rectangle with that middle, axes and half sizes.
pub fn face(
    id: &str,
    p: Vector3<f64>,
    x: Vector3<f64>,
    y: Vector3<f64>,
    half: [f64; 2],
) -> Surface {
    let rotation = Rotation3::from_basis_unchecked(&[x, y, x.cross(&y)]);
    let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
    let [a, b] = half;
    let corners = [(-a, -b), (a, -b), (a, b), (-a, b)].map(|(u, v)| Point2::new(u, v));
    let polygon = ConvexPolygon::new(corners.to_vec()).unwrap();
    Surface::new(id, Isometry3::from_parts(p.into(), rotation), polygon)
}

/// A walk of a robot that stands on the first surface of a set.
pub struct Walk {
    pub robot: Robot,
    pub set: SurfaceSet,
    /// Where the base goes, from where it stands at the origin of W with heading 0, m.
    pub way: Vec<Vector3<f64>>,
    /// Height of the base at the end.
    pub tolerance_m: f64,
    /// The surface that all feet have to stand on at the end.
    pub goal_surface: Option<usize>,
    /// Surfaces that the feet may touch.
    pub usable: Vec<usize>,
    pub planner: planner::Config,
    pub posture: posture::Config,
}

/// What came of it.
pub struct Walked {
    pub answer: Answer,
    pub plan: Plan,
    pub robot: Robot,
}

impl Walk {
    /// The standing posture with its balls on z = 0.
    pub fn standing(&self) -> Configuration {
        let mut configuration = self.robot.posture("standing").unwrap();
        let kinematics = Kinematics::new(&self.robot, &configuration);
        let patches = self.robot.patches.iter();
        let lowest = patches
            .map(|p| kinematics.X_WC(p).translation.vector.z - p.point_radius_m().unwrap())
            .fold(f64::INFINITY, f64::min);
        configuration.p_WB.z -= lowest;
        configuration
    }

    pub fn plan(self) -> Walked {
        let Self { robot, set, .. } = &self;
        let environment = Environment::new(set, BODY_M).unwrap();
        let configuration = self.standing();
        let from = configuration.p_WB;
        let to = from + self.way.last().unwrap();
        let feet: Vec<usize> = (0..robot.patches.len()).collect();
        let on_goal = |foot: &usize| self.goal_surface.map(|surface| (*foot, surface));
        let base = BaseGoal {
            position_m: [Some(to.x), Some(to.y), None],
            tolerance_m: self.tolerance_m,
            yaw_rad: None,
            yaw_tolerance_rad: 0.1,
        };
        let way = std::iter::once(from).chain(self.way.iter().map(|p| from + p));
        let request = Request {
            robot,
            environment: &environment,
            start: Start {
                configuration: configuration.clone(),
                contacts: feet.iter().map(|&f| (f, 0)).collect(),
            },
            goal: Goal {
                base,
                patches: feet.clone(),
                contacts: feet.iter().filter_map(on_goal).collect(),
            },
            guide: Guide::new(way.collect()).unwrap(),
            usable: feet.iter().map(|_| self.usable.clone()).collect(),
            reference: configuration,
        };
        let answer = planner::search(
            &request,
            &self.planner,
            &self.posture,
            &motion::Config::default(),
            &|_| {},
            &AtomicBool::new(false),
        )
        .unwrap();
        let goal_contact = |patch: &usize| {
            self.goal_surface.map(|surface| GoalContact {
                patch: robot.patches[*patch].name.clone(),
                surface: set.surfaces[surface].id.clone(),
            })
        };
        let plan = Plan {
            format: PLAN_FORMAT.to_owned(),
            program: Program {
                name: "scandent".to_owned(),
                version: "test".to_owned(),
            },
            scene: "exact".to_owned(),
            seed: 0,
            config: serde_json::Value::Null,
            inputs: Vec::new(),
            robot: RobotSummary {
                name: robot.name.clone(),
                joint_names: robot.joint_names().map(str::to_owned).collect(),
                mass_kg: robot.mass_kg,
            },
            motion: None,
            stances: planner::record::stances(robot, &environment, &answer.path),
            surfaces: set.surfaces.clone(),
            obstacles: set.obstacles.clone(),
            thin_body_m: BODY_M,
            required: RequiredMargins::from(&self.posture),
            goal: GoalRecord {
                base_position_m: Some([Some(to.x), Some(to.y), None]),
                tolerance_m: self.tolerance_m,
                yaw_rad: None,
                contacts: feet.iter().filter_map(goal_contact).collect(),
            },
            search: answer.summary.clone(),
        };
        Walked {
            answer,
            plan,
            robot: self.robot,
        }
    }
}

impl Walked {
    pub fn motion(&self) -> &Motion {
        self.answer.motion.as_ref().expect("a motion")
    }

    /// The verdict on stances and motion, on every sample.
    pub fn certify(&self) -> scandent::verify::Certificate {
        let options = scandent::verify::Options {
            motion_stride: 1,
            ..scandent::verify::Options::default()
        };
        scandent::verify::verify_with(&self.plan, Some(self.motion()), &self.robot, &options)
    }

    /// Writes plan, motion and page where the variable names a folder, to be looked at.
    pub fn show(&self, name: &str) {
        let Some(folder) = std::env::var_os("SCANDENT_WALKS") else {
            return;
        };
        let folder = std::path::PathBuf::from(folder).join(name);
        std::fs::create_dir_all(&folder).unwrap();
        let page = scandent::view::page(&scandent::view::ViewInput {
            plan: &self.plan,
            motion: self.answer.motion.as_ref(),
            robot: &self.robot,
            cloud_W: &[],
        });
        std::fs::write(folder.join("view.html"), page.unwrap()).unwrap();
        let plan = serde_json::to_vec(&self.plan).unwrap();
        std::fs::write(folder.join("plan.json"), plan).unwrap();
        let motion = serde_json::to_vec(&self.answer.motion).unwrap();
        std::fs::write(folder.join("motion.json"), motion).unwrap();
    }

    /// Executes the motion in MuJoCo on the plan's own surfaces; every criterion must hold.
    #[cfg(feature = "mujoco")]
    pub fn assert_executed(&self) {
        use simulation::execution::{Unobserved, execute};
        use simulation::world::{WorldBody, WorldShape};

        let bodies = self.plan.surfaces.iter().map(|surface| WorldBody {
            name: surface.id.clone(),
            shape: WorldShape::Hull(surface.thin_body(self.plan.thin_body_m).points_W),
        });
        let world: Vec<WorldBody> = bodies.collect();
        let (motion, com_m) = (self.motion().clone(), self.plan.required.com_m);
        let playback = simulation::playback::Playback::new(&self.robot, motion, com_m).unwrap();
        let executed = execute(
            &self.robot,
            &world,
            &playback,
            &simulation::Config::default(),
            &simulation::perturbation::Perturbation::default(),
            &mut Unobserved,
        )
        .unwrap();
        for c in &executed.criteria {
            println!(
                "{}: {:.3} of {:.3} {} {:?}",
                c.name, c.value, c.bound, c.unit, c.detail
            );
        }
        assert!(executed.pass, "{:?}", executed.cause);
    }
}
