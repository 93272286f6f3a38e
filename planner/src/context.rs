//! What follows from a request once for the whole search.
#![allow(non_snake_case)]

use std::collections::BTreeMap;
use std::sync::OnceLock;

use nalgebra::{Vector2, Vector3};
use posture::{Contact, FaceIndex, Problem, Upright};
use robot_model::{Configuration, ContactPatch, Kinematics, PatchId, Robot};

use crate::landing::{Footprint, Landing};
use crate::request::Request;
use crate::result::Blocked;
use crate::route::Route;
use crate::{Config, Error};
use plan::Change;

/// Fewer feet than these keep a robot upright.
pub(crate) const LEANING_MIN: usize = 3;
/// Angle by which a foot turns in one stride, rad.
const TURN_RAD: f64 = 0.5;
/// Strides of the way that the budgets are meant for; longer ways get more in proportion.
const BUDGET_STRIDES: f64 = 10.0;

/// What follows from a request once for the whole search.
pub(crate) struct SearchContext<'a> {
    pub request: &'a Request<'a>,
    pub config: &'a Config,
    /// For each patch, its place relative to the base.
    offset: Vec<Vector3<f64>>,
    /// For each patch, an upper bound of its distance from the base, m.
    reach_m: Vec<f64>,
    /// Patches whose progress counts: those in contact at the start.
    pub feet: Vec<PatchId>,
    /// How far a foot is put ahead of the others on level ground, m.
    pub stride_m: f64,
    /// The way of the base.
    pub route: Route,
    /// Where no way over the terrain was found: the place that comes nearest to the point that the
    /// base should come to, and that point.
    pub gap: Option<[Vector2<f64>; 2]>,
    /// Length that a turn by one radian counts for on the route, m.
    pub turn_m: f64,
    /// Smallest distance between two parts of the robot, m.
    pub self_clearance_m: f64,
    /// What each patch needs about the place where it lands.
    footprint: Vec<Footprint>,
    /// For each patch, the leg that carries it.
    leg: Vec<Leg>,
    /// Patches that are used at all.
    used: Vec<bool>,
    /// For each patch and face, where on the face it may land.
    landing: Vec<BTreeMap<FaceIndex, OnceLock<Landing>>>,
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
        let mut feet: Vec<PatchId> = request.start.contacts.iter().map(|c| c.0).collect();
        feet.sort_unstable();
        feet.dedup();
        let stride_m = config.stride_m.min(0.5 * following_m(&offset, &feet));
        let leg = robot
            .patches
            .iter()
            .map(|p| Leg::new(robot, &kinematics, p));
        let leg = leg.collect();
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
            leg,
            offset,
            reach_m,
            route,
            gap: None,
            turn_m,
            self_clearance_m: posture.self_clearance_m,
            footprint: robot.patch_ids().map(footprint).collect(),
            stride_m,
            feet,
            used,
            landing: request.usable.iter().map(unknown).collect(),
        };
        Ok(context)
    }

    /// Where on a face a patch may land; nothing on faces that it may not touch.
    pub fn landing(&self, patch: PatchId, face: FaceIndex) -> Option<&Landing> {
        let landing = self.landing.get(patch.index())?.get(&face)?;
        let footprint = &self.footprint[patch.index()];
        let environment = self.request.environment;
        Some(landing.get_or_init(|| Landing::new(environment, face, footprint)))
    }

    /// Why the base has no way over the terrain, as far as the lattice can tell.
    pub fn no_way(&self) -> Option<Blocked> {
        let [nearest, to] = self.gap?;
        let reason = format!(
            "no way was found for the base over the terrain: from where it is it comes to \
             ({:.2}, {:.2}), {:.2} m from ({:.2}, {:.2}); what lies between is too wide, too high or too \
             narrow for steps of {:.2} m",
            nearest.x,
            nearest.y,
            (to - nearest).norm(),
            to.x,
            to.y,
            self.stride_m
        );
        Some(Blocked {
            change: Change::Goal,
            held: String::new(),
            reason,
            amount: None,
            distance_m: 0.0,
            proof: false,
        })
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

    /// An upper bound of a patch's distance from the base, m.
    pub fn reach_m(&self, patch: PatchId) -> f64 {
        self.reach_m[patch.index()]
    }

    /// An upper bound of the distance between two patches, m.
    pub fn span_m(&self, a: PatchId, b: PatchId) -> f64 {
        self.reach_m(a) + self.reach_m(b)
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
    /// about `near_m` where that is known. Sideways counts what is beyond half its usual offset, and
    /// height beside the route is the faces' business, not a detour.
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
        let lateral_m = ((place_W - usual).xy().norm() - 0.5 * offset.y.abs()).max(0.0);
        Footing {
            along_m,
            lateral_m,
            in_air: false,
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
        let level = self.leg[patch.index()].range_m(0.0);
        if self.feet.len() < LEANING_MIN || along.abs() < 1e-6 || normal.z <= 0.0 || level <= 0.0 {
            return self.stride_m;
        }
        let delta = (along.abs() / normal.z).atan();
        self.stride_m * self.leg[patch.index()].range_m(delta) / level
    }

    /// Estimated number of contact changes to the goal, given each foot's last place and whether
    /// it is in the air.
    ///
    /// A foot in the air lands a stride ahead of the hindmost of the others. Of two feet each then
    /// passes the other, and one on the ground must leave and land once for every two strides that
    /// it is behind; more feet catch up with each other, once for every stride.
    pub fn estimate(&self, feet: &[Footing]) -> f64 {
        let end = self.route.length_m();
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
                landing
                    + 2.0 * behind / advance
                    + self.config.lateral_deviation_price_per_m * foot.lateral_m
            })
            .sum()
    }
}

/// A leg, from its first joint to its patch.
#[derive(Clone, Copy, Debug)]
struct Leg {
    /// Length stretched out, m.
    length_m: f64,
    /// Height of the first joint over the patch in the nominal posture, m.
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

/// Progress of the hindmost foot beside the one of that index, m: of those in the air, too, which
/// would otherwise be left behind without a price.
pub(crate) fn hindmost(feet: &[Footing], but: usize) -> f64 {
    let others = feet.iter().enumerate().filter(|(i, _)| *i != but);
    others
        .map(|(_, foot)| foot.along_m)
        .min_by(f64::total_cmp)
        .unwrap_or(f64::NEG_INFINITY)
}

/// Where on the route a foot stands.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Footing {
    /// Progress along the route, m.
    pub along_m: f64,
    /// Distance beside it, m.
    pub lateral_m: f64,
    /// Whether it is in the air, and this is where it stood last.
    pub in_air: bool,
}

/// The heading of a direction, rad.
fn heading(direction: &Vector3<f64>) -> f64 {
    direction.y.atan2(direction.x)
}
