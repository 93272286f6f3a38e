//! Feet that stand on what is there although nobody names them: they bear nothing, and touch all the same.

use robot_model::{Kinematics, PatchId, Robot};
use surfaces::{Face, Source, Terrain};

use super::settle::on;
use super::{FOOT, StartState};

/// A foot whose corners are all this near to what is under it touches it, m.
const TOUCHES_M: f64 = 1e-3;
/// Scanned faces are off by this, m.
const SCANNED_M: f64 = 5e-3;

/// Adds to the patches of a start the other feet that lie on a face, or, where the surroundings are scanned, in the plane
/// of a sole that stands, and says so. A foot in the air would have to keep off what it stands on.
pub fn add_touching(robot: &Robot, stand: &mut StartState, terrain: &Terrain) -> Option<String> {
    let kinematics = Kinematics::new(robot, &stand.configuration);
    let is_foot = |patch: &PatchId| robot.patches[*patch].has_role(FOOT);
    let stands = |patch: &PatchId| stand.patches.contains(patch);
    let is_scanned = terrain.faces.iter().all(|f| f.source == Source::Scan);
    let is_sole = |patch: &PatchId| robot.patches[*patch].point_radius_m().is_none();
    let soles = stand.patches.iter().filter(|p| is_foot(p) && is_sole(p));
    let soles = soles.filter(|_| is_scanned);
    let planes = soles.filter_map(|&patch| {
        let X_WC = kinematics.X_WC(&robot.patches[patch]);
        Face::rectangle("sole", X_WC, [1e3, 1e3]).ok()
    });
    let planes: Vec<Face> = planes.collect();
    let touches = |patch: &PatchId| {
        let X_WC = kinematics.X_WC(&robot.patches[*patch]);
        let mut under = terrain.faces.iter().chain(&planes);
        under.any(|face| {
            let most_m = match face.source {
                Source::Scan => SCANNED_M,
                _ => TOUCHES_M,
            };
            on(robot, *patch, &X_WC, face).is_some_and(|(_, off_m)| off_m < most_m)
        })
    };
    let others = robot
        .patch_ids()
        .filter(|p| is_foot(p) && !stands(p) && touches(p));
    let others: Vec<PatchId> = others.collect();
    stand.patches.extend(&others);
    let names = others
        .iter()
        .map(|&patch| robot.patches[patch].name.as_str());
    let names: Vec<&str> = names.collect();
    (!names.is_empty()).then(|| {
        let names = names.join(", ");
        format!("at the start {names} touches the ground, too, and counts among the contacts, although not named")
    })
}
