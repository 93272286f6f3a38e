//! When what of a plan happens: stances have no times, a controller needs some.

use planner::plan::{Change, Plan};

use super::Config;

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

/// The phases in order, one after the other.
///
/// Before a contact leaves, the weight shifts with it still touching; a contact that leaves and
/// is made in the next stance swings there, any other is taken away. A contact that is made needs
/// no shift: the stance before already bears without it.
pub fn phases(plan: &Plan, config: &Config) -> Vec<Phase> {
    let mut phases: Vec<Phase> = Vec::new();
    let mut now = config.start_s;
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
                    push(index, Move::Release, config.release_s);
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
