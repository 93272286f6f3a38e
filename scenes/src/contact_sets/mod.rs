//! Sets of posture problems drawn from a seed, for any robot with feet: to measure a posture
//! generator with, and to compare it with others.
//!
//! | file | family | what is known of its problems |
//! |---|---|---|
//! | `easy` | feet and up to two hands on surfaces tilted by at most 20° | solvable: a witness is recorded |
//! | `free` | the same with contacts anywhere on polygons, thin bodies behind them | solvable: a witness |
//! | `steep` | feet tilted by 20° to 40°, and a hand | nothing |
//! | `one_foot` | one foot and two hands | nothing |
//! | `chimney` | feet, and hands, on opposed walls | nothing |
//! | `spread` | feet far apart, little friction | nothing |
//! | `infeasible` | out of reach, no equilibrium, too little friction | infeasible, with the reason |
//!
//! Every problem comes from a configuration that is drawn within the joint limits: where its
//! patches are, surfaces are placed. A **witness** is such a configuration that also holds: forces
//! that balance it within the torque limits are found by linear programming, and no parts are near
//! each other, all with margins above those of a planner. The problems of which nothing is known
//! are moved a little away from the configuration; they are kept where friction can carry the
//! robot with its centre of mass somewhere, so that they are plausible and no more.
//!
//! The problem of a number depends on the robot, the family, the seed and the number alone.

mod draw;
mod easy;
mod forces;
mod free;
mod hard;
mod infeasible;
mod limbs;
mod place;
mod plausible;
mod record;
mod witness;

use robot_model::{Configuration, ContactPatch, PatchKind, Robot};

pub use record::{
    BODY_M, ContactRecord, Expected, FORMAT, FORMAT_BEGINS, ProblemRecord, ProblemSet,
    SurfaceRecord,
};
pub use witness::Margins;

use crate::Error;
use draw::Draws;
use limbs::Limbs;

/// A kind of problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// Feet and up to two hands on surfaces tilted by at most 20°.
    Easy,
    /// As easy, with contacts anywhere on polygons and bodies behind them.
    Free,
    /// Steep feet and a hand.
    Steep,
    /// One foot and two hands.
    OneFoot,
    /// Opposed walls.
    Chimney,
    /// Feet far apart and little friction.
    Spread,
    /// Infeasible by construction.
    Infeasible,
}

impl Family {
    /// Every family.
    pub const ALL: [Family; 7] = [
        Family::Easy,
        Family::Free,
        Family::Steep,
        Family::OneFoot,
        Family::Chimney,
        Family::Spread,
        Family::Infeasible,
    ];

    /// The families of which nothing is known beforehand.
    pub const HARD: [Family; 4] = [
        Family::Steep,
        Family::OneFoot,
        Family::Chimney,
        Family::Spread,
    ];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Family::Easy => "easy",
            Family::Free => "free",
            Family::Steep => "steep",
            Family::OneFoot => "one-foot",
            Family::Chimney => "chimney",
            Family::Spread => "spread",
            Family::Infeasible => "infeasible",
        }
    }

    /// The families of a name: `hard` are four.
    pub fn named(name: &str) -> Option<Vec<Family>> {
        if name == "hard" {
            return Some(Self::HARD.to_vec());
        }
        let one = Self::ALL.into_iter().find(|family| family.name() == name);
        one.map(|family| vec![family])
    }

    /// Whether the robot has the limbs that the family is about.
    pub fn suits(self, robot: &Robot) -> bool {
        let having = |role| robot.patches.iter().filter(|p| p.has_role(role)).count();
        let sole = |p: &ContactPatch| p.has_role("foot") && p.kind == PatchKind::Area;
        match self {
            Family::OneFoot => having("foot") >= 1 && having("hand") >= 2,
            // Two balls hold nothing.
            _ => having("foot") > 2 || having("foot") == 2 && robot.patches.iter().any(sole),
        }
    }
}

/// How often a resting posture is drawn, ever farther from the robot's, until it is clear of itself.
const RESTS_MAX: u32 = 4000;
/// How often a problem is drawn anew before the family is given up for the robot.
const DRAWS_MAX: usize = 20_000;

/// `count` problems for a generator with these margins, the families taking turns; those that do not suit the robot are left out.
///
/// # Errors
/// [`Error::ContactSet`] where no family suits the robot, or none of very many draws of a problem
/// is one.
pub fn generate(
    robot: &Robot,
    families: &[Family],
    margins: &Margins,
    count: usize,
    seed: u64,
) -> Result<ProblemSet, Error> {
    let refuse = |reason: String| Error::ContactSet {
        robot: robot.name.clone(),
        reason,
    };
    let names = |families: &[Family], between: &str| {
        let names: Vec<&str> = families.iter().map(|f| f.name()).collect();
        names.join(between)
    };
    let mut suitable = families.to_vec();
    suitable.retain(|family| family.suits(robot));
    if suitable.is_empty() {
        let names = names(families, ", ");
        return Err(refuse(format!(
            "it has no limbs for the family {names}: patches of the role foot, a sole or three balls, \
             and hands where it has any"
        )));
    }
    let maker = Maker::new(robot, margins);
    let mut problems = Vec::with_capacity(count);
    for k in 0..count {
        let family = suitable[k % suitable.len()];
        let number = k / suitable.len();
        problems.push(maker.problem(family, number, seed).ok_or_else(|| {
            let name = family.name();
            let overlapping = match robot.meeting_at_rest.is_empty() {
                true => "",
                false => {
                    "; its links meet at rest: try robot_model.disable_colliding_at_rest = true"
                }
            };
            refuse(format!(
                "none of {DRAWS_MAX} draws is of the family {name}{overlapping}"
            ))
        })?);
    }
    Ok(ProblemSet {
        format: FORMAT.to_owned(),
        robot: robot.name.clone(),
        joint_names: robot.joint_names().map(str::to_owned).collect(),
        family: names(&suitable, " "),
        seed,
        body_m: BODY_M,
        problems,
    })
}

/// The robot with what all draws share.
struct Maker<'a> {
    robot: &'a Robot,
    /// The resting posture: where the joints are that no contact needs.
    rest: Configuration,
    limbs: Limbs,
    /// What a witness keeps.
    margins: Margins,
}

impl<'a> Maker<'a> {
    fn new(robot: &'a Robot, margins: &Margins) -> Self {
        let mut rest = Configuration {
            joints: robot.resting().joints,
            ..Configuration::zero(robot.nj())
        };
        for (q, body) in rest.joints.iter_mut().zip(robot.joint_bodies()) {
            *q = q.clamp(body.lower, body.upper);
        }
        let limbs = Limbs::new(robot);
        let mut maker = Self {
            robot,
            rest,
            limbs,
            margins: margins.of_a_witness(),
        };
        maker.rest_clear();
        maker
    }

    /// Moves the joints no farther from rest than it takes for no parts to be near each other.
    fn rest_clear(&mut self) {
        let keeps = self.margins.self_clearance_m;
        let mut draws = Draws::new(0, 0, 0);
        let mut tried = self.rest.clone();
        for k in 0..RESTS_MAX {
            if self.is_clear_of_itself(&tried, keeps) {
                self.rest = tried;
                return;
            }
            let part = f64::from(k) / f64::from(RESTS_MAX);
            let joints = self.rest.joints.iter().zip(self.robot.joint_bodies());
            for (q, (rest, body)) in tried.joints.iter_mut().zip(joints) {
                let reach = part * (body.upper - body.lower) * draws.between(-1.0, 1.0);
                *q = (rest + reach).clamp(body.lower, body.upper);
            }
        }
    }

    /// The problem of a number: the first draw of its stream that is one.
    fn problem(&self, family: Family, number: usize, seed: u64) -> Option<ProblemRecord> {
        let mut draws = Draws::new(seed, family as u64, number as u64);
        let id = format!("{}-{}-{number:04}", self.robot.name, family.name());
        (0..DRAWS_MAX).find_map(|_| {
            let mut problem = match family {
                Family::Easy => easy::draw(self, &mut draws),
                Family::Free => free::draw(self, &mut draws),
                Family::Infeasible => infeasible::draw(self, &mut draws, number),
                hard => hard::draw(self, hard, &mut draws),
            }?;
            problem.id = id.clone().into();
            Some(problem)
        })
    }
}
