//! What follows from a request once for the whole search.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use nalgebra::Vector3;
use posture::{Contact, FaceIndex, Problem, Upright};
use robot_model::{Configuration, Kinematics, PatchId};

use crate::footing::Footing;
use crate::goal_stance::{GoalStance, is_at};
use crate::landing::{Footprint, Landing};
use crate::reach::Reach;
use crate::request::Request;
use crate::route::{Route, heading};
use crate::{Config, Error};

/// Fewer feet than these keep a robot upright.
pub(crate) const LEANING_MIN: usize = 3;
/// A stride is at most this part of the length of the legs, as of HRP-2's 0.70 m the 0.40 m that are set:
/// short legs step as much less far.
const STRIDE_OF_LEG: f64 = 0.57;
/// Nothing steps less far than settings allow, m.
const STRIDE_MIN_M: f64 = 0.01;
/// The search looks as finely as suits strides of this and more, m, as of Solo12; for shorter ones as much more finely.
const COARSE_STRIDE_M: f64 = 0.18;
/// Angle by which a foot turns in one stride, rad.
const TURN_RAD: f64 = 0.5;
/// A foot may be over or under the route by this part of the legs' height; a metre more counts as so many
/// beside it: from a floor beside a bridge no foot steps onto it.
pub(crate) const LEVEL_LEGS: f64 = 0.25;
const OFF_LEVEL: f64 = 4.0;
/// Strides of the way that the budgets are meant for; longer ways get more in proportion.
const BUDGET_STRIDES: f64 = 10.0;

/// What follows from a request once for the whole search.
#[derive(Clone)]
pub(crate) struct SearchContext<'a> {
    pub request: &'a Request<'a>,
    pub config: &'a Config,
    /// What the estimated number of contacts to the goal weighs against those made.
    pub weight: f64,
    /// The nominal posture with its base upright in W's origin.
    pub upright: Configuration,
    /// Where the feet stand under the posture that is wanted at the goal.
    pub goal_stance: Option<GoalStance>,
    /// For each patch, its place relative to the base.
    offset: Vec<Vector3<f64>>,
    /// How far patches reach.
    pub reach: Reach,
    /// Patches whose progress counts: those that the robot stands on at the start.
    pub feet: Vec<PatchId>,
    /// How far a foot is put ahead of the others on level ground, m.
    pub stride_m: f64,
    /// How coarsely the search looks, as a part of what suits long strides.
    grain: f64,
    /// The way of the base.
    pub route: Route,
    /// Whether the route follows the ground.
    pub is_founded: bool,
    /// Where no way over the terrain was found: what is too wide, too high or too narrow.
    pub gap: Option<String>,
    /// Length that a turn by one radian counts for on the route, m.
    pub turn_m: f64,
    /// Smallest distance between two parts of the robot, m.
    pub self_clearance_m: f64,
    /// How far patches keep inside the area that they may touch, m.
    pub patch_margin_m: f64,
    /// Part of the friction that postures use.
    pub friction_use: f64,
    /// What each patch needs about the place where it lands.
    footprint: Vec<Footprint>,
    /// Patches that are used at all.
    used: Vec<bool>,
    /// For each patch and face, where on the face it and others with its footprint may land.
    landing: Arc<Vec<BTreeMap<FaceIndex, OnceLock<Landing>>>>,
}

impl<'a> SearchContext<'a> {
    pub fn new(
        request: &'a Request<'a>,
        config: &'a Config,
        posture: &posture::Config,
    ) -> Result<Self, Error> {
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
        let used = robot
            .patches
            .iter()
            .map(|patch| !config.excludes(patch))
            .collect();
        let feet = request.start.feet.clone();
        let reach = Reach::new(robot, &kinematics);
        let legs_m = feet.iter().map(|&foot| reach.leg(foot).length_m);
        let shortest_m = legs_m.fold(f64::INFINITY, f64::min);
        let stride_m = config.stride_m.min(0.5 * following_m(&offset, &feet));
        let stride_m = stride_m.min(STRIDE_OF_LEG * shortest_m).max(STRIDE_MIN_M);
        let apart_m = feet.iter().map(|foot| offset[foot.index()].xy().norm());
        let turn_m = apart_m.fold(stride_m / TURN_RAD, f64::max);
        let from = heading(&(request.start.configuration.R_WB * Vector3::x()));
        let route = Route::new(&request.guide, from, request.goal.base.yaw_rad, turn_m);
        let (clearance_m, margin_m) = (posture.clearance_m, posture.patch_margin_m);
        let footprint = |id| Footprint::new(robot, id, clearance_m, margin_m);
        let unknown = |faces: &Vec<FaceIndex>| {
            let faces = faces.iter();
            faces.map(|&face| (face, OnceLock::new())).collect()
        };
        let context = Self {
            request,
            config,
            weight: config.heuristic_weight,
            reach,
            upright,
            goal_stance: GoalStance::new(request, &feet),
            offset,
            route,
            is_founded: false,
            gap: None,
            turn_m,
            self_clearance_m: posture.self_clearance_m,
            patch_margin_m: margin_m,
            friction_use: posture.friction_use,
            footprint: robot.patch_ids().map(footprint).collect(),
            stride_m,
            grain: (stride_m / COARSE_STRIDE_M).min(1.0),
            feet,
            used,
            landing: Arc::new(request.usable.iter().map(unknown).collect()),
        };
        Ok(context)
    }

    /// Contacts of one patch on one face nearer than this count as the same, m; alternatives to one
    /// are this far from it.
    pub fn same_place_m(&self) -> f64 {
        0.06 * self.grain
    }

    /// Distance of neighbouring places of the base on its way, m.
    pub fn places_m(&self) -> f64 {
        0.1 * self.grain
    }

    /// Levels nearer than this are one for the way of the base, m.
    pub fn levels_m(&self) -> f64 {
        0.15 * self.grain
    }

    /// Where on a face a patch may land; nothing on faces that it may not touch.
    pub fn landing(&self, patch: PatchId, face: FaceIndex) -> Option<&Landing> {
        let footprint = self.footprint.get(patch.index())?;
        if !self.may_touch(patch, face) {
            return None;
        }
        // A left and a right foot share theirs.
        let alike = self.footprint.iter().zip(self.landing.iter());
        let mut alike = alike.filter(|(other, _)| *other == footprint);
        let landing = alike.find_map(|(_, landing)| landing.get(&face))?;
        let environment = self.request.environment;
        Some(landing.get_or_init(|| Landing::new(environment, face, footprint)))
    }

    /// Whether two patches may land in the same places.
    pub fn land_alike(&self, a: PatchId, b: PatchId) -> bool {
        let usable = &self.request.usable;
        self.footprint[a.index()] == self.footprint[b.index()]
            && usable[a.index()] == usable[b.index()]
    }

    /// The heading of a sole that stands, rad.
    pub fn yaw(&self, contact: &Contact) -> Option<f64> {
        let sole = self.request.robot.patches[contact.patch]
            .point_radius_m()
            .is_none();
        let settled = contact.area().is_none();
        let foot = self.foot(contact.patch).is_some();
        (sole && settled && foot).then(|| heading(&(contact.X_WC.rotation * Vector3::x())))
    }

    /// Where on the route a foot has come to its end, m.
    pub fn end_m(&self) -> f64 {
        self.route.length_m() - 0.5 * self.request.goal.beside_m
    }

    /// Where a foot stands at the end of the way, and its heading, where a posture of the legs is wanted there.
    pub fn stand_at_goal(&self, foot: PatchId) -> Option<(Vector3<f64>, f64)> {
        self.foot(foot)?;
        let end = self.route.at(self.route.length_m());
        self.goal_stance.as_ref()?.foot_at(&end, foot)
    }

    /// Whether a contact is wanted at the goal.
    pub fn is_wanted(&self, patch: PatchId, face: FaceIndex) -> bool {
        self.request.goal.contacts.contains(&(patch, face))
    }

    /// Whether a patch is wanted on another face than that at the goal.
    pub fn is_elsewhere(&self, patch: PatchId, face: FaceIndex) -> bool {
        let mut wanted = self.request.goal.contacts.iter();
        !self.is_wanted(patch, face) && wanted.any(|wanted| wanted.0 == patch)
    }

    /// How many contacts of other limbs than feet that are wanted at the goal are not among those.
    pub fn missing(&self, held: &[(PatchId, FaceIndex)]) -> usize {
        let wanted = self.request.goal.contacts.iter();
        let wanted = wanted.filter(|(patch, _)| self.foot(*patch).is_none());
        wanted.filter(|contact| !held.contains(contact)).count()
    }

    /// How far along the route the search may go on in proportion: the budgets are for
    /// [`BUDGET_STRIDES`] strides, and for each that the way has more there is as much more.
    pub fn budget(&self, budget: usize) -> usize {
        let strides = self.route.length_m() / self.stride_m.max(1e-6);
        (budget as f64 * (strides / BUDGET_STRIDES).max(1.0)).ceil() as usize
    }

    /// Where a patch (of a ball its lowest point) is relative to the base in the nominal posture,
    /// looking ahead, m.
    pub fn offset(&self, patch: PatchId) -> &Vector3<f64> {
        &self.offset[patch.index()]
    }

    /// Whether a patch may touch a face.
    pub fn may_touch(&self, patch: PatchId, face: FaceIndex) -> bool {
        self.landing[patch.index()].contains_key(&face)
    }

    /// Whether a patch may be used at all.
    pub fn is_used(&self, patch: PatchId) -> bool {
        self.used[patch.index()]
    }

    /// Which of the feet a patch is, where it is one.
    pub fn foot(&self, patch: PatchId) -> Option<usize> {
        self.feet.iter().position(|&foot| foot == patch)
    }

    /// The place that a contact touches, in W: C's origin, or the point of a ball.
    pub fn place_W(&self, contact: &Contact) -> Vector3<f64> {
        self.request.robot.patches[contact.patch].touched_W(&contact.X_WC)
    }

    /// Where on the route a patch stands that touches at a place, with a heading where it has one;
    /// about `near_m` where that is known. Sideways counts what is beyond half its usual offset; height
    /// counts for feet on a route that follows the ground, beyond what the other foot makes up.
    pub fn footing(
        &self,
        patch: PatchId,
        place_W: &Vector3<f64>,
        yaw: Option<f64>,
        near_m: Option<f64>,
    ) -> Footing {
        let (route, offset) = (&self.route, self.offset(patch));
        let along_m = route.progress(offset, place_W, yaw, near_m);
        let usual = route.foot_at(along_m, offset);
        let mut lateral_m = ((place_W - usual).xy().norm() - 0.5 * offset.y.abs()).max(0.0);
        if self.is_founded && self.foot(patch).is_some() {
            let level_m = (place_W.z - usual.z).abs() + LEVEL_LEGS * offset.z;
            lateral_m += OFF_LEVEL * level_m.max(0.0);
        }
        let wanted = self.stand_at_goal(patch);
        let has_arrived = wanted.map(|wanted| is_at(wanted, place_W, yaw));
        Footing {
            along_m: match has_arrived {
                Some(true) => route.length_m(),
                _ => along_m,
            },
            lateral_m,
            in_air: false,
            astray: has_arrived == Some(false),
        }
    }

    /// The posture problem of a contact set from a guess, with the nominal posture over it.
    pub fn problem<'p>(
        &'p self,
        contacts: Vec<Contact>,
        reference: &'p Configuration,
        guess: &'p Configuration,
    ) -> Problem<'p> {
        Problem {
            robot: self.request.robot,
            environment: self.request.environment,
            contacts,
            base_goal: None,
            joint_goal: None,
            reference,
            guess,
        }
    }

    /// How far the base may tilt: from a nominal posture's up.
    pub fn upright(&self, nominal: &Configuration) -> Upright {
        Upright {
            z_W: nominal.R_WB * Vector3::z(),
            tilt_max_rad: self.config.tilt_max_rad,
        }
    }

    /// How far a foot is put ahead of the others on a face, m: where it leans along the way by δ, as
    /// much less as the legs that are left behind on it reach less far down,
    ///
    ///   s(δ) / s(0) = range(δ) / range(0),   tan δ = |n·h| / n_z   with the direction h of the route.
    ///
    /// Friction limits where one can stand, not how far one steps: forces are plumb. A robot on two
    /// feet strides as it is set to.
    pub fn stride_on(&self, patch: PatchId, normal: &Vector3<f64>, along_m: f64) -> f64 {
        let along = normal.dot(&self.route.direction(along_m));
        let level = self.reach.leg(patch).range_m(0.0);
        if self.feet.len() < LEANING_MIN || along.abs() < 1e-6 || normal.z <= 0.0 || level <= 0.0 {
            return self.stride_m;
        }
        let delta = (along.abs() / normal.z).atan();
        self.stride_m * self.reach.leg(patch).range_m(delta) / level
    }
}

/// The least distance along the way of feet that follow each other, m: of those that are farther
/// apart along it than across. Infinite where no foot follows another.
fn following_m(offset: &[Vector3<f64>], feet: &[PatchId]) -> f64 {
    let pairs = feet.iter().flat_map(|&a| {
        feet.iter()
            .map(move |&b| offset[b.index()] - offset[a.index()])
    });
    pairs
        .filter(|apart| apart.x > apart.y.abs())
        .map(|apart| apart.x)
        .fold(f64::INFINITY, f64::min)
}
