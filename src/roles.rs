//! Which patch of the robot may touch which face, and why not the others.

use posture::{Environment, FaceIndex};
use robot_model::{PatchId, Robot};
use surfaces::role::{Config, Filter};

/// What each patch may touch.
pub struct Usable {
    /// For each patch of the robot, in its order, the faces that it may touch.
    pub faces: Vec<Vec<FaceIndex>>,
    /// Why faces serve no patch that has a role with a filter, for the user.
    pub notes: Vec<String>,
}

/// For each patch of the robot the faces it may touch, by the filters of its roles.
///
/// A role without a filter asks for nothing. What a patch touches at the start it may touch again.
pub fn usable(
    robot: &Robot,
    environment: &Environment,
    at_start: &[(PatchId, FaceIndex)],
    config: &Config,
    edge_sigmas: f64,
) -> Usable {
    let open = Filter::default();
    let mut notes = Vec::new();
    let mut of_patch = |patch: PatchId| -> Vec<FaceIndex> {
        let shape = &robot.patches[patch];
        let serves = |face: &FaceIndex| {
            let known = at_start.contains(&(patch, *face));
            let mut reasons = Vec::new();
            let fits = shape.roles.iter().any(|role| {
                let filter = config.filter(role).unwrap_or(&open);
                let verdict = filter.serves(&environment[*face], edge_sigmas);
                let fault = verdict.as_ref().err();
                reasons.extend(fault.map(|why| format!("as {role}: {why}")));
                verdict.is_ok()
            });
            if !known && !fits && !reasons.is_empty() {
                let (id, patch) = (&environment[*face].id, &shape.name);
                let reasons = reasons.join("; ");
                notes.push(format!("{id} is not for {patch}: {reasons}"));
            }
            known || fits
        };
        environment.faces().filter(serves).collect()
    };
    let faces = robot.patch_ids().map(&mut of_patch).collect();
    Usable { faces, notes }
}
