//! A start posture is a wish: feet that are nearly on something are put onto it.

use anyhow::{Result, bail};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use posture::{Contact, Environment, Outcome, Problem};
use robot_model::{Kinematics, PatchId, Robot};
use surfaces::{Face, Source, Terrain};

use super::StartState;

/// Farthest that a foot's corners are moved, m: what rounded joint values and measured places err by.
pub const MOVED_MAX_M: f64 = 0.010;
/// A foot whose corners are this near to what is under it is there, m: a sole that leans by more is turned to
/// lie flat, since the part of the friction that it uses follows from where the face's normal points.
const THERE_M: f64 = 1e-5;
/// Below this nothing is said of it, and a posture that cannot do it stands as it is, m.
const STANDS_M: f64 = 3e-4;
/// Farthest that a sole is turned to lie flat, rad.
const TURNED_MAX_RAD: f64 = 0.03;

/// Puts the feet onto the start's ground, or onto the faces of a file or a mesh, that are under them within
/// [`MOVED_MAX_M`], by the posture nearest to the one that is wished for; says by how much joints
/// changed. Scanned faces are put under the feet instead, and nothing is done where feet stand already
/// or where nothing is so near.
///
/// # Errors
/// A posture that stands there is not found: what is in its way.
pub fn settle(
    robot: &Robot,
    stand: &mut StartState,
    terrain: &Terrain,
    on_ground: bool,
    config: &posture::Config,
) -> Result<Option<String>> {
    let kinematics = Kinematics::new(robot, &stand.configuration);
    let ground = Face::rectangle("level", stand.X_WG, [1e3, 1e3])?;
    let known = || terrain.faces.iter().filter(|f| f.source != Source::Scan);
    let mut moved_m: f64 = 0.0;
    let mut contacts = Vec::new();
    for &id in &stand.patches {
        let patch = &robot.patches[id];
        let X_WC = kinematics.X_WC(patch);
        let under = known().chain(on_ground.then_some(&ground));
        let mut near = under.filter_map(|face| on(robot, id, &X_WC, face));
        let Some((X_WS, off_m)) = near.next() else {
            return Ok(None);
        };
        moved_m = moved_m.max(off_m);
        contacts.push(Contact::at(robot, id, X_WS));
    }
    if moved_m <= THERE_M {
        return Ok(None);
    }
    let is_told = moved_m > STANDS_M;
    let nothing = Environment::default();
    let problem = Problem::new(robot, &nothing, contacts, &stand.configuration);
    match posture::solve(&problem, config)? {
        Outcome::Feasible(posture) => {
            let change = (&posture.q.joints - &stand.configuration.joints).amax();
            stand.configuration = posture.q;
            let words = format!(
                "the start posture was put onto what is under it: feet by up to {:.1} mm (at most {:.0} \
                 mm), joints by up to {:.1}°",
                1e3 * moved_m,
                1e3 * MOVED_MAX_M,
                change.to_degrees()
            );
            Ok(is_told.then_some(words))
        }
        _ if !is_told => Ok(None),
        other => {
            let why = other.violation().map(|v| v.describe(&problem));
            bail!(
                "the start is no stance: put onto what is under its feet ({:.1} mm away), {}",
                1e3 * moved_m,
                why.unwrap_or_default()
            )
        }
    }
}

/// Where a foot is on a face that is near it: its pose, and how far its corners are from there, m.
pub(super) fn on(
    robot: &Robot,
    id: PatchId,
    X_WC: &Isometry3<f64>,
    face: &Face,
) -> Option<(Isometry3<f64>, f64)> {
    let patch = &robot.patches[id];
    let n = face.normal_W();
    let radius = patch.point_radius_m().unwrap_or(0.0);
    let turn = match patch.point_radius_m() {
        Some(_) => UnitQuaternion::rotation_between(&Vector3::z(), &n)?,
        None => {
            let z = X_WC.rotation * Vector3::z();
            if z.angle(&n) > TURNED_MAX_RAD {
                return None;
            }
            UnitQuaternion::rotation_between(&z, &n)? * X_WC.rotation
        }
    };
    let p = Point3::from(X_WC.translation.vector);
    let height = face.height_of(&p) - radius;
    let X_WS = Isometry3::from_parts((p.coords - n * height).into(), turn);
    let foot = face.X_WF.inverse_transform_point(&p).xy();
    if (face.region.nearest(&foot) - foot).norm() > MOVED_MAX_M {
        return None;
    }
    let off = patch.polygon.iter().map(|v| {
        let v = Point3::new(v.x, v.y, 0.0);
        match patch.point_radius_m() {
            Some(_) => height.abs(),
            None => (X_WC * v - X_WS * v).norm(),
        }
    });
    let off_m = off.fold(0.0, f64::max);
    (off_m <= MOVED_MAX_M).then_some((X_WS, off_m))
}
