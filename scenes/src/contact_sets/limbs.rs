//! Limbs, and configurations drawn limb by limb.

use nalgebra::Isometry3;
use robot_model::{Configuration, Robot};

use super::Maker;
use super::draw::Draws;

/// How often a limb is drawn anew until its patch is as wanted.
const LIMB_DRAWS: usize = 60;

/// The joints between a patch and the first body that carries another.
pub(super) struct Limb {
    /// Index of the patch.
    pub patch: usize,
    /// Bodies from the one nearest to the trunk to the patch's own.
    pub bodies: Vec<usize>,
}

/// The limbs of a robot, feet and hands, and what is between them.
pub(super) struct Limbs {
    pub feet: Vec<Limb>,
    pub hands: Vec<Limb>,
    /// Bodies on the way from the base to several patches.
    pub trunk: Vec<usize>,
}

impl Limbs {
    pub fn new(robot: &Robot) -> Self {
        let carried = |body: usize| {
            let within = robot.subtree(body);
            robot
                .patches
                .iter()
                .filter(|p| within.contains(&p.body))
                .count()
        };
        let limb = |patch: usize| {
            let mut bodies = Vec::new();
            let mut body = robot.patches[patch].body;
            while let Some(parent) = robot.bodies[body].parent
                && carried(body) == 1
            {
                bodies.push(body);
                body = parent;
            }
            bodies.reverse();
            Limb { patch, bodies }
        };
        let of = |role: &str| {
            (0..robot.patches.len())
                .filter(|&p| robot.patches[p].has_role(role))
                .map(limb)
                .collect()
        };
        Self {
            feet: of("foot"),
            hands: of("hand"),
            trunk: (1..robot.bodies.len())
                .filter(|&b| carried(b) > 1)
                .collect(),
        }
    }
}

/// Which limbs touch, how far they are drawn, and where their patches may be.
pub(super) struct Wanted<'a> {
    /// The limbs that touch.
    pub limbs: Vec<&'a Limb>,
    /// Part of a joint's range by which a leg's and an arm's joints leave the resting posture.
    pub range: [f64; 2],
    /// Largest tilt of the base, rad.
    pub base_tilt: f64,
    /// Whether the patch of a limb may be at this pose, the base being over the origin.
    pub fits: &'a dyn Fn(&Limb, &Isometry3<f64>) -> bool,
}

impl Maker<'_> {
    /// A configuration within the joint limits with the wanted patches where they fit, its base
    /// over the origin and heading anywhere; `None` where a limb is never as wanted.
    pub fn configuration(&self, wanted: &Wanted, draws: &mut Draws) -> Option<Configuration> {
        let robot = self.robot;
        let mut q = self.rest.clone();
        q.R_WB = draws.tilt(0.0, wanted.base_tilt);
        let joint = |body: usize, range: f64, draws: &mut Draws| {
            let b = &robot.bodies[body];
            let margin = self.margins.joint_margin_rad;
            let (low, high) = (b.lower + margin, b.upper - margin);
            if low >= high {
                return None;
            }
            let rest = self.rest.joints[body - 1].clamp(low, high);
            let part = range * (high - low);
            Some(draws.between((rest - part).max(low), (rest + part).min(high)))
        };
        for &body in &self.limbs.trunk {
            if let Some(value) = joint(body, 0.3 * wanted.range[0], draws) {
                q.joints[body - 1] = value;
            }
        }
        let mut pose = vec![q.X_WB(); robot.bodies.len()];
        for &body in &self.limbs.trunk {
            let parent = robot.bodies[body].parent?;
            pose[body] = pose[parent] * robot.bodies[body].placed_at(q.joints[body - 1]);
        }
        for limb in &wanted.limbs {
            let foot = robot.patches[limb.patch].has_role("foot");
            let range = wanted.range[usize::from(!foot)];
            let root = robot.bodies[*limb.bodies.first()?].parent?;
            let fitting = (0..LIMB_DRAWS).find_map(|_| {
                let mut X = pose[root];
                let mut values = Vec::with_capacity(limb.bodies.len());
                for &body in &limb.bodies {
                    let value = joint(body, range, draws)?;
                    X *= robot.bodies[body].placed_at(value);
                    values.push(value);
                }
                (wanted.fits)(limb, &(X * robot.patches[limb.patch].X_BC)).then_some(values)
            })?;
            for (&body, value) in limb.bodies.iter().zip(fitting) {
                q.joints[body - 1] = value;
            }
        }
        Some(q)
    }

    /// The longest distance between a limb's patch and the trunk: the lengths of its links and
    /// strokes, laid in one line, m.
    pub fn reach_m(&self, limb: &Limb) -> f64 {
        let length = |&body: &usize| self.robot.bodies[body].apart_m();
        let patch = &self.robot.patches[limb.patch];
        let radius = patch.point_radius_m().unwrap_or(0.0);
        patch.X_BC.translation.vector.norm() + radius + limb.bodies.iter().map(length).sum::<f64>()
    }

    /// The longest distance between two points of the trunk at which limbs begin, m.
    pub fn trunk_m(&self) -> f64 {
        let length = |&b: &usize| self.robot.bodies[b].X_PJ.translation.vector.norm();
        self.limbs.trunk.iter().map(length).sum()
    }
}
