//! What is asked of the planner.

use nalgebra::Vector3;
use posture::{BaseGoal, Environment};
use robot_model::{Configuration, ContactPatch, Kinematics, Robot};
use surfaces::Surface;

use crate::comfort::LEANING_MIN;
use crate::guide::Guide;
use crate::{Config, Error};

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
    /// For each patch of the robot the surfaces it may touch.
    pub usable: Vec<Vec<usize>>,
    /// The comfortable posture; its base is not used.
    pub reference: Configuration,
}

/// The first stance.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Base pose and joints.
    pub configuration: Configuration,
    /// Pairs of patch and surface that are in contact.
    pub contacts: Vec<(usize, usize)>,
}

/// What the last stance must be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Goal {
    /// Where the base must be.
    pub base: BaseGoal,
    /// Patches that must be in contact, anywhere.
    pub patches: Vec<usize>,
    /// Pairs of patch and surface that must be in contact.
    pub contacts: Vec<(usize, usize)>,
}

/// What follows from a request once for the whole search.
pub(crate) struct Prepared<'a> {
    pub request: &'a Request<'a>,
    pub config: &'a Config,
    /// For each patch, its place (of a ball that of its lowest point) relative to the base in the reference posture, looking ahead.
    pub offset: Vec<Vector3<f64>>,
    /// For each patch, an upper bound of its distance from the base, m.
    pub reach_m: Vec<f64>,
    /// Patches whose progress counts: those in contact at the start.
    pub feet: Vec<usize>,
    /// How far a foot is put ahead of the others on level ground, m.
    pub stride_m: f64,
    /// For each patch, the leg that carries it.
    leg: Vec<Leg>,
    /// Patches that are used at all.
    pub used: Vec<bool>,
    /// For each surface, the first that is a piece of the same face.
    pub face: Vec<usize>,
}

impl<'a> Prepared<'a> {
    pub fn new(request: &'a Request<'a>, config: &'a Config) -> Result<Self, Error> {
        config.validate()?;
        let robot = request.robot;
        for name in &config.exclude {
            if !robot
                .patches
                .iter()
                .any(|p| &p.name == name || p.has_role(name))
            {
                let known: Vec<&str> = robot
                    .patches
                    .iter()
                    .flat_map(|p| std::iter::once(&p.name).chain(&p.roles))
                    .map(String::as_str)
                    .collect();
                return Err(Error::Exclude {
                    name: name.clone(),
                    known: known.join(", "),
                });
            }
        }
        if request.start.contacts.is_empty() {
            return Err(Error::Start {
                reason: "no contact is named".to_owned(),
            });
        }
        let mut upright = Configuration::zero(robot.nj());
        upright.joints.copy_from(&request.reference.joints);
        let kinematics = Kinematics::new(robot, &upright);
        let offset: Vec<Vector3<f64>> = robot
            .patches
            .iter()
            .map(|patch| {
                // A ball stands on its lowest point.
                let radius = patch.point_radius_m().unwrap_or(0.0);
                kinematics.X_WC(patch).translation.vector - radius * Vector3::z()
            })
            .collect();
        let reach_m = robot
            .patches
            .iter()
            .map(|patch| {
                let mut reach = patch.X_BC.translation.vector.norm();
                let mut body = patch.body;
                while let Some(parent) = robot.bodies[body].parent {
                    let b = &robot.bodies[body];
                    reach += b.X_PJ.translation.vector.norm();
                    if b.kind == robot_model::JointKind::Prismatic {
                        reach += b.lower.abs().max(b.upper.abs());
                    }
                    body = parent;
                }
                reach
            })
            .collect();
        let used = robot
            .patches
            .iter()
            .map(|p| !config.exclude.iter().any(|e| &p.name == e || p.has_role(e)))
            .collect();
        let mut feet: Vec<usize> = request.start.contacts.iter().map(|c| c.0).collect();
        feet.sort_unstable();
        feet.dedup();
        let stride_m = config.stride_m.min(0.5 * following_m(&offset, &feet));
        let leg = robot
            .patches
            .iter()
            .map(|p| Leg::new(robot, &kinematics, p));
        let leg = leg.collect();
        let surfaces = &request.environment.surfaces;
        let face = surfaces.iter().enumerate().map(|(i, surface)| {
            let same = |other: &Surface| other.face.is_some() && other.face == surface.face;
            surfaces.iter().position(same).unwrap_or(i)
        });
        Ok(Self {
            face: face.collect(),
            request,
            config,
            leg,
            offset,
            reach_m,
            stride_m,
            feet,
            used,
        })
    }

    /// How far a foot is put ahead of the others on a face, m: where it leans along the way by δ, as
    /// much less as the legs that are left behind on it reach less far down,
    ///
    ///   s(δ) / s(0) = range(δ) / range(0),   tan δ = |n·h| / n_z   with the heading h.
    ///
    /// Friction limits where one can stand, not how far one steps: forces are plumb. A robot on two
    /// feet strides as it is set to.
    pub fn stride_on(&self, patch: usize, normal: &Vector3<f64>, heading: f64) -> f64 {
        let along = normal.x * heading.cos() + normal.y * heading.sin();
        let level = self.leg[patch].range_m(0.0);
        if self.feet.len() < LEANING_MIN || along.abs() < 1e-6 || normal.z <= 0.0 || level <= 0.0 {
            return self.stride_m;
        }
        let delta = (along.abs() / normal.z).atan();
        self.stride_m * self.leg[patch].range_m(delta) / level
    }

    /// Estimated number of contact changes to the goal, given each foot's last place and whether
    /// it is in the air.
    ///
    /// A foot in the air lands a stride ahead of the hindmost of the others. Of two feet each then
    /// passes the other, and one on the ground must leave and land once for every two strides that
    /// it is behind; more feet catch up with each other, once for every stride.
    pub fn estimate(&self, feet: &[FootState]) -> f64 {
        let end = self.request.guide.length_m();
        let stride = self.stride_m;
        let advance = if feet.len() > 2 { stride } else { 2.0 * stride };
        let tolerance = 0.5 * self.request.goal.base.tolerance_m;
        feet.iter()
            .enumerate()
            .map(|(i, foot)| {
                let (along, landing) = if foot.in_air {
                    (foot.along_m.max(hindmost(feet, i) + stride), 1.0)
                } else {
                    (foot.along_m, 0.0)
                };
                let behind = (end - tolerance - along).max(0.0);
                landing + 2.0 * behind / advance + self.config.aside_price_per_m * foot.aside_m
            })
            .sum()
    }
}

/// A leg, from its first joint to its patch.
#[derive(Clone, Copy, Debug)]
struct Leg {
    /// Length stretched out, m.
    length_m: f64,
    /// Height of the first joint over the patch in the reference posture, m.
    height_m: f64,
}

impl Leg {
    fn new(robot: &Robot, kinematics: &Kinematics, patch: &ContactPatch) -> Self {
        let mut length_m = patch.X_BC.translation.vector.norm();
        let mut body = patch.body;
        while let Some(parent) = robot.bodies[body].parent.filter(|&p| p != 0) {
            length_m += robot.bodies[body].X_PJ.translation.vector.norm();
            body = parent;
        }
        let foot = kinematics.X_WC(patch).translation.vector;
        Self {
            length_m,
            height_m: (kinematics.origin_W[body].z - foot.z).max(0.0),
        }
    }

    /// How far down a slope of `delta` the foot reaches from below the first joint, at the usual
    /// height over it, m.
    ///
    ///   ‖(s cos δ, h + s sin δ)‖ = L   ⇒   s = √(L² − h² cos² δ) − h sin δ
    fn range_m(&self, delta: f64) -> f64 {
        let (sin, cos) = delta.sin_cos();
        let (l, h) = (self.length_m, self.height_m);
        ((l * l - h * h * cos * cos).max(0.0).sqrt() - h * sin).max(0.0)
    }
}

/// The least distance along the way of feet that follow each other, m: of those that are farther
/// apart along it than across. Infinite where no foot follows another.
fn following_m(offset: &[Vector3<f64>], feet: &[usize]) -> f64 {
    let pairs = feet
        .iter()
        .flat_map(|&a| feet.iter().map(move |&b| offset[b] - offset[a]));
    pairs
        .filter(|apart| apart.x > apart.y.abs())
        .map(|apart| apart.x)
        .fold(f64::INFINITY, f64::min)
}

/// Progress of the hindmost foot beside the one of that index, m: of those in the air, too, which
/// would otherwise be left behind without a price.
pub(crate) fn hindmost(feet: &[FootState], but: usize) -> f64 {
    let others = feet.iter().enumerate().filter(|(i, _)| *i != but);
    others
        .map(|(_, foot)| foot.along_m)
        .min_by(f64::total_cmp)
        .unwrap_or(f64::NEG_INFINITY)
}

/// A foot as the estimate sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FootState {
    pub along_m: f64,
    pub aside_m: f64,
    pub in_air: bool,
}
