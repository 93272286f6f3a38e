//! Ways of robots over exactly known surfaces: planned, verified, executed.

use std::sync::atomic::AtomicBool;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use plan::{GoalContact, GoalRecord, Motion, Plan, RequiredMargins};
use planner::{Goal, Guide, Request, SearchResult, Status};
use posture::{BaseGoal, Environment, FaceIndex, stand};
use robot_model::{PatchId, Robot};
use surfaces::{Face, Terrain};

use super::record::record;

/// Thickness of the bodies behind the surfaces, m.
const BODY_M: f64 = 0.05;

/// The rectangle with that middle, axes and half sizes.
pub fn face(id: &str, p: Vector3<f64>, x: Vector3<f64>, y: Vector3<f64>, half: [f64; 2]) -> Face {
    let rotation = UnitQuaternion::from_basis_unchecked(&[x, y, x.cross(&y)]);
    let pose = Isometry3::from_parts(p.into(), rotation);
    Face::rectangle(id, pose, half.map(|half| 2.0 * half)).unwrap()
}

/// A walk of a robot that stands on the first face of a terrain.
pub struct Walk {
    pub robot: Robot,
    pub terrain: Terrain,
    /// Where the base goes, from where it stands at the origin of W with heading 0, m.
    pub way: Vec<Vector3<f64>>,
    /// Height of the base at the end.
    pub tolerance_m: f64,
    /// The face that all feet have to stand on at the end.
    pub goal_face: Option<&'static str>,
    /// Faces that the feet may touch, by their names.
    pub usable: Vec<String>,
    pub posture: posture::Config,
}

/// What came of it.
pub struct Walked {
    pub answer: SearchResult,
    pub plan: Plan,
    pub robot: Robot,
}

impl Walk {
    pub fn plan(self) -> Walked {
        let Self { robot, terrain, .. } = &self;
        let environment = Environment::new(terrain.clone(), BODY_M, 2.0).unwrap();
        let face = |name: &str| environment.face(name).unwrap();
        let is_foot = |id: &PatchId| robot.patches[*id].has_role("foot");
        let feet: Vec<PatchId> = robot.patch_ids().filter(is_foot).collect();
        let stands = stand::on_level_ground(robot, &robot.resting(), &feet);
        let (from, by) = (stands.p_WB, *self.way.last().unwrap());
        let to = from + by;
        let floor = face(terrain.faces[0].id.as_str());
        let walk = Request::walk(robot, &environment, stands, (&feet, floor), by).unwrap();
        let on_goal = |foot: &PatchId| self.goal_face.map(|name| (*foot, face(name)));
        let way = std::iter::once(from).chain(self.way.iter().map(|p| from + p));
        let usable: Vec<FaceIndex> = self.usable.iter().map(|name| face(name)).collect();
        let request = Request {
            goal: Goal {
                beside_m: 0.0,
                base: BaseGoal {
                    tolerance_m: self.tolerance_m,
                    yaw_tolerance_rad: 0.1,
                    ..walk.goal.base
                },
                contacts: feet.iter().filter_map(on_goal).collect(),
                ..walk.goal
            },
            guide: Guide::new(way.collect()).unwrap(),
            usable: (robot.patch_ids())
                .map(|id| {
                    usable
                        .clone()
                        .into_iter()
                        .filter(|_| is_foot(&id))
                        .collect()
                })
                .collect(),
            ..walk
        };
        let answer = planner::search(
            &request,
            &planner::Config::default(),
            &self.posture,
            &motion::Config::default(),
            &|_| {},
            &AtomicBool::new(false),
        )
        .unwrap();
        let goal_contact = |patch: &PatchId| {
            self.goal_face.map(|name| GoalContact {
                patch: robot.patches[*patch].name.clone(),
                face: name.into(),
            })
        };
        let stances = planner::record::stances(robot, &environment, &answer.path);
        let plan = Plan {
            required: RequiredMargins::from(&self.posture),
            goal: GoalRecord {
                base_position_m: Some([Some(to.x), Some(to.y), None]),
                tolerance_m: self.tolerance_m,
                yaw_rad: None,
                contacts: feet.iter().filter_map(goal_contact).collect(),
                joints: None,
            },
            search: answer.summary.clone(),
            ..record(robot, terrain.clone(), BODY_M, stances)
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

    #[track_caller]
    pub fn assert_found(&self) {
        let (status, blocked) = (&self.answer.status, &self.answer.blocked);
        assert_eq!(*status, Status::Found, "{blocked:?}");
    }

    /// A way was found, and the verifier passes its stances and every sample of its motion.
    #[track_caller]
    pub fn assert_certified(&self) {
        self.assert_found();
        let motion = Some(self.motion());
        let certificate = verify::verify(&self.plan, motion, &self.robot);
        assert!(certificate.pass, "{}", certificate.table());
    }

    /// Writes plan, motion and page where the variable names a folder, to be looked at.
    pub fn show(&self, name: &str) {
        let Some(folder) = std::env::var_os("SCANDENT_WALKS") else {
            return;
        };
        let folder = std::path::PathBuf::from(folder).join(name);
        std::fs::create_dir_all(&folder).unwrap();
        let page = scandent::view::page(&scandent::view::ViewInput {
            motion: self.answer.motion.as_ref(),
            trace: Some(&self.answer.trace),
            ..scandent::view::ViewInput::new(&self.plan, &self.robot)
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
        use simulation::perturbation::Perturbation;
        use simulation::playback::Playback;
        use simulation::world::{WorldBody, WorldShape};

        let bodies = self.plan.faces.iter().flat_map(|face| {
            let bodies = face.bodies_W(self.plan.thin_body_m).into_iter().enumerate();
            bodies.map(|(number, points_W)| WorldBody {
                name: format!("{}/{number}", face.id),
                part_of: face.id.to_string(),
                shape: WorldShape::Hull(points_W),
                friction: face.friction,
            })
        });
        let world: Vec<WorldBody> = bodies.collect();
        let playback = Playback::new(&self.robot, self.motion().clone()).unwrap();
        let (config, push) = (simulation::Config::default(), Perturbation::default());
        let executed = execute(
            &self.robot,
            &world,
            &playback,
            &config,
            &push,
            &mut Unobserved,
        );
        let executed = executed.unwrap();
        assert!(
            executed.pass,
            "{:?}: {:?}",
            executed.cause, executed.criteria
        );
    }
}
