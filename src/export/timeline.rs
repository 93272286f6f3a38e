//! When what of a plan happens: stances have no times, a controller needs some.

use plan::{Change, Motion, PhaseKind, Plan};

use super::Config;

/// From the start of the motion to its first movement, s.
pub(super) const START_S: f64 = 1.0;
/// To take a limb away that touches nothing next, s: without a motion.
const RELEASE_S: f64 = 1.5;

/// What a contact does between two times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Move {
    /// All contacts hold while the weight shifts.
    Shift,
    /// The patch goes from one place to the next (stance that leaves), through the air.
    Step {
        /// The stance in which the patch was about to leave.
        from: usize,
    },
    /// The patch comes from the air.
    Make,
    /// The patch goes into the air.
    Release,
}

/// A stretch of time that ends in a stance's posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// The stance whose posture is reached at the end.
    pub stance: usize,
    /// What happens.
    pub kind: Move,
    /// From here on the stance's posture is the one to go to, s.
    pub start_s: f64,
    /// Here it is reached, s.
    pub end_s: f64,
}

/// The phases in order, one after the other: as the motion has them, after the export's time before
/// the first movement; without a motion they last as long as the settings say.
pub fn phases(plan: &Plan, motion: Option<&Motion>, config: &Config) -> Vec<Phase> {
    match motion {
        Some(motion) => moved(plan, motion),
        None => assumed(plan, config),
    }
}

/// The phases of the motion; those without movement belong to what comes after them, as a contact is
/// made when its swing ends.
fn moved(plan: &Plan, motion: &Motion) -> Vec<Phase> {
    let mut phases: Vec<Phase> = Vec::new();
    let mut start_s = START_S;
    for phase in &motion.phases {
        let change = |stance: usize| plan.stances.get(stance).map(|s| &s.change);
        let lands = matches!(change(phase.to_stance), Some(Change::Add { patch, .. }) if Some(patch) == phase.swing.as_ref());
        let left = matches!(change(phase.from_stance), Some(Change::Remove { patch, .. }) if Some(patch) == phase.swing.as_ref());
        let (stance, kind) = match (phase.kind, lands, left) {
            (PhaseKind::Hold, ..) => continue,
            (PhaseKind::Shift, ..) => (phase.to_stance, Move::Shift),
            (PhaseKind::Swing, true, true) => {
                let from = phase.from_stance;
                (phase.to_stance, Move::Step { from })
            }
            (PhaseKind::Swing, true, false) => (phase.to_stance, Move::Make),
            (PhaseKind::Swing, false, _) => (phase.from_stance, Move::Release),
        };
        let end_s = START_S + phase.t_end_s;
        phases.push(Phase {
            stance,
            kind,
            start_s,
            end_s,
        });
        start_s = end_s;
    }
    phases
}

/// The phases as they follow from the contacts alone.
///
/// Before a contact leaves, the weight shifts with it still touching; a contact that leaves and
/// is made in the next stance swings there, any other is taken away. A contact that is made needs
/// no shift: the stance before already bears without it.
fn assumed(plan: &Plan, config: &Config) -> Vec<Phase> {
    let mut phases: Vec<Phase> = Vec::new();
    let mut now = START_S;
    let mut push = |stance, kind, duration: f64| {
        phases.push(Phase {
            stance,
            kind,
            start_s: now,
            end_s: now + duration,
        });
        now += duration;
    };
    for (index, stance) in plan.stances.iter().enumerate() {
        match &stance.change {
            Change::Start => {}
            Change::Goal => push(index, Move::Shift, config.shift_s),
            Change::Remove { patch, .. } => {
                push(index, Move::Shift, config.shift_s);
                let next = plan.stances.get(index + 1).map(|s| &s.change);
                if !matches!(next, Some(Change::Add { patch: made, .. }) if made == patch) {
                    push(index, Move::Release, RELEASE_S);
                }
            }
            Change::Add { patch, .. } => {
                let left = index.checked_sub(1).filter(|before| {
                    let change = plan.stances.get(*before).map(|s| &s.change);
                    matches!(change, Some(Change::Remove { patch: left, .. }) if left == patch)
                });
                let kind = left.map_or(Move::Make, |from| Move::Step { from });
                push(index, kind, config.swing_s);
            }
        }
    }
    phases
}
