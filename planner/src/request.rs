//! What is asked of the planner.

use nalgebra::Vector3;
use posture::{BaseGoal, Contact, Environment, FaceIndex, JointGoal};
use robot_model::{Configuration, Kinematics, PatchId, Robot};

use crate::guide::Guide;

/// Cosine of the slope up to which [`Request::walk`] lets feet touch a face.
const WALKABLE: f64 = 0.8;

/// A robot, its surroundings, where it is and where it shall go.
pub struct Request<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What it may touch and must not hit.
    pub environment: &'a Environment,
    /// Where it is.
    pub start: Start,
    /// Where it shall go.
    pub goal: Goal,
    /// The path that its base should roughly follow.
    pub guide: Guide,
    /// For each patch of the robot, in its order, the faces it may touch.
    pub usable: Vec<Vec<FaceIndex>>,
    /// The nominal posture; its base is not used.
    pub reference: Configuration,
}

impl<'a> Request<'a> {
    /// A robot that stands on a face with those feet, and shall go `by` so far in W, m, to within 0.15 m:
    /// its feet may touch every face that is level enough to stand on, other patches none.
    ///
    /// # Errors
    /// [`crate::Error::Guide`] where a number is not finite.
    pub fn walk(
        robot: &'a Robot,
        environment: &'a Environment,
        stands: Configuration,
        (feet, floor): (&[PatchId], FaceIndex),
        by: Vector3<f64>,
    ) -> Result<Self, crate::Error> {
        let is_walkable = |face: &FaceIndex| environment[*face].normal_W().z > WALKABLE;
        let walkable: Vec<FaceIndex> = environment.faces().filter(is_walkable).collect();
        let usable = |id| match feet.contains(&id) {
            true => walkable.clone(),
            false => Vec::new(),
        };
        let to = stands.p_WB + by;
        let goal = BaseGoal {
            position_m: [Some(to.x), Some(to.y), None],
            tolerance_m: 0.15,
            yaw_rad: None,
            yaw_tolerance_rad: 0.2,
        };
        Ok(Self {
            robot,
            environment,
            start: Start {
                configuration: stands.clone(),
                contacts: feet.iter().map(|&foot| (foot, floor)).collect(),
                feet: feet.to_vec(),
            },
            goal: Goal {
                beside_m: goal.tolerance_m,
                base: goal,
                joints: None,
                patches: feet.to_vec(),
                contacts: Vec::new(),
            },
            guide: Guide::new(vec![stands.p_WB, to])?,
            usable: robot.patch_ids().map(usable).collect(),
            reference: stands,
        })
    }
}

/// The first stance.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Base pose and joints.
    pub configuration: Configuration,
    /// Pairs of patch and face that are in contact.
    pub contacts: Vec<(PatchId, FaceIndex)>,
    /// The patches that it walks on, in order: its feet by role, those that touch nothing yet among them, and what
    /// touches a face that a foot touches, as hands on the floor do; all that are in contact where none has the role.
    pub feet: Vec<PatchId>,
}

/// The role of what a robot stands on.
const FOOT: &str = "foot";

impl Start {
    /// The start of a robot with its feet. One on some of its feet, as a plan has it between two steps, lands the others
    /// first, but for those that `excluded` keeps out of use: these leave and stay in the air. A hand on a table, or a
    /// knee in the place of its foot, holds on only: it goes its own way and need not touch at the goal.
    pub fn new(
        robot: &Robot,
        configuration: Configuration,
        contacts: Vec<(PatchId, FaceIndex)>,
        excluded: impl Fn(PatchId) -> bool,
    ) -> Self {
        let is_foot = |patch: PatchId| robot.patches[patch].has_role(FOOT) && !excluded(patch);
        let touched = |patch: PatchId| contacts.iter().find(|c| c.0 == patch).map(|c| c.1);
        let feet = || robot.patch_ids().filter(|&patch| is_foot(patch));
        let under: Vec<FaceIndex> = feet().filter_map(touched).collect();
        let in_place_of_foot = |patch: PatchId| {
            let mut in_air = feet().filter(|&foot| touched(foot).is_none());
            in_air.any(|foot| robot.carries(patch, foot))
        };
        let bears = |patch: PatchId| match touched(patch) {
            Some(_) if under.is_empty() => true,
            None if under.is_empty() => false,
            _ if is_foot(patch) => true,
            Some(face) => under.contains(&face) && !in_place_of_foot(patch) && !excluded(patch),
            None => false,
        };
        Self {
            feet: robot.patch_ids().filter(|&patch| bears(patch)).collect(),
            configuration,
            contacts,
        }
    }

    /// The feet that touch nothing yet: they land first.
    pub fn in_air(&self) -> impl Iterator<Item = PatchId> {
        let touches = |patch: PatchId| self.contacts.iter().any(|c| c.0 == patch);
        self.feet
            .iter()
            .copied()
            .filter(move |&patch| !touches(patch))
    }

    /// Its contacts where the robot's own kinematics has them, in the order of the patches.
    pub fn touching(&self, robot: &Robot, environment: &Environment) -> Vec<Contact> {
        let kinematics = Kinematics::new(robot, &self.configuration);
        let touching = self.contacts.iter().map(|&(patch, face)| {
            let mut X_WC = kinematics.X_WC(&robot.patches[patch]);
            // How a ball is turned does not matter: it takes the axes of what it touches.
            if robot.patches[patch].point_radius_m().is_some() {
                X_WC.rotation = environment[face].X_WF.rotation;
            }
            Contact::at(robot, patch, X_WC).on(face, environment)
        });
        let mut touching: Vec<Contact> = touching.collect();
        touching.sort_by_key(|c| c.patch);
        touching
    }
}

/// What the last stance must be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Goal {
    /// Where the base must be.
    pub base: BaseGoal,
    /// Where joints must be, if it matters.
    pub joints: Option<JointGoal>,
    /// How far beside the end of the guide the way of the base may end, m.
    pub beside_m: f64,
    /// Patches that must be in contact, anywhere.
    pub patches: Vec<PatchId>,
    /// Pairs of patch and face that must be in contact.
    pub contacts: Vec<(PatchId, FaceIndex)>,
}
