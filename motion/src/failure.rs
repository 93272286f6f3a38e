//! Why there is no motion.

/// What a motion violates most.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// A patch cannot be where it should be.
    Closure {
        /// The patch, or the centre of mass where there is none.
        patch: Option<String>,
    },
    /// A joint is beyond its limit, or too near to it.
    JointLimit {
        /// The joint.
        joint: String,
    },
    /// A joint needs more than its share of the torque.
    Torque {
        /// The joint.
        joint: String,
    },
    /// A joint jumps: however slow the motion, it is faster than it can be.
    Discontinuity {
        /// The joint, or the base.
        joint: String,
    },
    /// The base tilts farther than the postures at both ends may.
    Tilt,
    /// The forces do not balance the weight.
    Equilibrium,
    /// A contact slips.
    Friction {
        /// The patch.
        patch: String,
    },
    /// Two links of the robot are too near to each other.
    SelfClearance {
        /// The one link.
        link: String,
        /// The other.
        other: String,
    },
    /// A link is too near to a body of the environment.
    Clearance {
        /// The link.
        link: String,
        /// The body of the environment.
        body: String,
    },
}

/// The worst violation on a path, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// What is violated.
    pub reason: Reason,
    /// By how much: m, rad, part of the limit.
    pub amount: f64,
    /// Where on the path, 0…1.
    pub at: f64,
    /// What the phase does: the patch in the air, if one is.
    pub swing: Option<String>,
}

impl Failure {
    /// What makes one failure comparable with another: angles count times 0.1 m, parts of limits
    /// as 0.1 m.
    pub(crate) fn severity(&self) -> f64 {
        match self.reason {
            Reason::JointLimit { .. }
            | Reason::Discontinuity { .. }
            | Reason::Tilt
            | Reason::Torque { .. }
            | Reason::Friction { .. }
            | Reason::Equilibrium => 0.1 * self.amount,
            _ => self.amount,
        }
    }

    /// The failure in words: what, by how much, when.
    pub fn describe(&self) -> String {
        use Reason as R;
        let (mm, percent) = (1e3 * self.amount, 1e2 * self.amount);
        let degrees = self.amount.to_degrees();
        let what = match &self.reason {
            R::Closure { patch: Some(patch) } => format!("{patch} misses its place by {mm:.2} mm"),
            R::Closure { patch: None } => format!("the CoM misses its place by {mm:.1} mm"),
            R::JointLimit { joint } => format!("{joint} beyond its limit by {degrees:.2}°"),
            R::Torque { joint } => format!("torque of {joint} over its limit by {percent:.1} %"),
            R::Discontinuity { joint } => format!("{joint} jumps by {degrees:.1}°"),
            R::Tilt => format!("the base tilts too far by {degrees:.2}°"),
            R::Equilibrium => format!("no equilibrium: {percent:.3} % of the weight"),
            R::Friction { patch } => format!("{patch} slips: {percent:.1} % over the friction"),
            R::SelfClearance { link, other: near } | R::Clearance { link, body: near } => {
                format!("{link} is too near to {near} by {mm:.1} mm")
            }
        };
        let during = match &self.swing {
            Some(patch) => format!("the swing of {patch}"),
            None => "the shift".to_owned(),
        };
        format!("{what}, {:.0} % into {during}", 1e2 * self.at)
    }
}

/// The worse of two.
pub(crate) fn keep_worst(worst: &mut Option<Failure>, failure: Failure) {
    let before = worst.as_ref().map(Failure::severity);
    if before.is_none_or(|before| failure.severity() > before) {
        *worst = Some(failure);
    }
}
