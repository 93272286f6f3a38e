//! Which patch of the robot may touch which face, and why not the others.

use posture::{Environment, FaceIndex};
use robot_model::{PatchId, Robot};
use surfaces::Face;
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
/// A role without a filter asks for nothing. What a patch touches `at_start` it may touch again; of what is `wanted` at the goal
/// the notes tell first.
pub fn usable(
    robot: &Robot,
    environment: &Environment,
    [at_start, wanted]: [&[(PatchId, FaceIndex)]; 2],
    config: &Config,
    edge_sigmas: f64,
) -> Usable {
    let mut notes = Vec::new();
    let faces = environment.faces().map(|face| &environment[face]);
    let ground_m = config.ground_m(faces, edge_sigmas);
    let mut of_patch = |patch: PatchId| -> Vec<FaceIndex> {
        let shape = &robot.patches[patch];
        let serves = |face: &FaceIndex| {
            let known = at_start.contains(&(patch, *face));
            let is_wanted = wanted.contains(&(patch, *face));
            let mut reasons = Vec::new();
            let fits = shape.roles.iter().any(|role| {
                let fault = why_not(role, &environment[*face], config, edge_sigmas, ground_m);
                reasons.extend(fault.iter().map(|why| format!("as {role}: {why}")));
                fault.is_none()
            });
            if !known && !fits && !reasons.is_empty() {
                let (id, patch) = (&environment[*face].id, &shape.name);
                let reasons = reasons.join("; ");
                let why = format!("{id} is not for {patch}: {reasons}");
                // What the goal asks for comes first.
                let at = if is_wanted { 0 } else { notes.len() };
                notes.insert(at, why);
            }
            known || fits
        };
        environment.faces().filter(serves).collect()
    };
    let faces = robot.patch_ids().map(&mut of_patch).collect();
    Usable { faces, notes }
}

/// Why patches of a role may not touch a face; nothing where they may. `ground_m`: [`Config::ground_m`] of all faces.
pub fn why_not(
    role: &str,
    face: &Face,
    config: &Config,
    edge_sigmas: f64,
    ground_m: [f64; 2],
) -> Option<String> {
    match &face.roles {
        Some(roles) if roles.iter().any(|given| given == role) => None,
        Some(roles) if roles.is_empty() => Some("nothing may touch it, its file says".to_owned()),
        Some(roles) => Some(format!("its file gives it to {}", roles.join(", "))),
        None => {
            let open = Filter::default();
            let filter = config.filter(role).unwrap_or(&open);
            let verdict = filter.serves(face, edge_sigmas, ground_m);
            verdict.err().map(|why| why.to_string())
        }
    }
}
