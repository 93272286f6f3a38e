//! A start over a place: every foot on the ground that is there.

use anyhow::{Context, Result};
use nalgebra::{Isometry3, Point3, Vector3};
use posture::{Area, Contact, Environment, FaceIndex, Freedom, stand};
use robot_model::{Configuration, Kinematics, PatchId, Robot};
use surfaces::Region;

use crate::mistakes;

/// Faces steeper than this are no ground: the cosine of 45°.
const LEVEL: f64 = 0.7;
/// Farthest that ground may be beside where the posture has a foot, m.
const ASIDE_M: f64 = 0.15;

/// The contacts of a robot that stands in `posture` with its base over x and y, turned by `yaw_rad`,
/// each free to find its place on its face: of the ground under a foot what is nearest in height to
/// the highest under the foot that has the lowest. With the posture over that ground.
///
/// # Errors
/// Feet with no ground under them, with their places.
pub fn contacts(
    robot: &Robot,
    environment: &Environment,
    posture: &Configuration,
    feet: &[PatchId],
    ([x, y], yaw_rad): ([f64; 2], f64),
) -> Result<(Vec<Contact>, Configuration)> {
    let level = stand::on_level_ground(robot, posture, feet);
    let over = |height: f64| {
        let p = Vector3::new(x, y, height + level.p_WB.z);
        let X_WB = Isometry3::new(p, Vector3::z() * yaw_rad);
        level.clone().with_base(&X_WB)
    };
    let kinematics = Kinematics::new(robot, &over(0.0));
    let grounds = feet.iter().map(|&foot| {
        let X_WC = kinematics.X_WC(&robot.patches[foot]);
        let faces = environment.faces();
        let grounds: Vec<Contact> = faces
            .filter_map(|face| ground(robot, environment, face, foot, &X_WC))
            .collect();
        let p = X_WC.translation.vector;
        let name = &robot.patches[foot].name;
        let none = || {
            format!(
                "the start: no ground under {name}, at ({:.2}, {:.2})",
                p.x, p.y
            )
        };
        let highest = grounds.iter().map(height_m).reduce(f64::max);
        Ok((highest.with_context(none)?, grounds))
    });
    let grounds: Vec<(f64, Vec<Contact>)> = mistakes::all(grounds)?;
    let height = grounds.iter().map(|g| g.0).fold(f64::INFINITY, f64::min);
    let off = |contact: &Contact| (height_m(contact) - height).abs();
    let nearest = grounds.into_iter().filter_map(|(_, grounds)| {
        let by_height = |a: &Contact, b: &Contact| off(a).total_cmp(&off(b));
        grounds.into_iter().min_by(by_height)
    });
    Ok((nearest.collect(), over(height)))
}

/// Height of where a contact begins, m.
fn height_m(contact: &Contact) -> f64 {
    contact.X_WC.translation.z
}

/// The contact of a foot with a face under it, or beside by little, that has room for it.
fn ground(
    robot: &Robot,
    environment: &Environment,
    face: FaceIndex,
    foot: PatchId,
    X_WC: &Isometry3<f64>,
) -> Option<Contact> {
    let (X_WF, patch) = (environment[face].X_WF, &robot.patches[foot]);
    let (n, p) = (X_WF.rotation * Vector3::z(), X_WC.translation.vector);
    if n.z < LEVEL {
        return None;
    }
    let down = n.dot(&(X_WF.translation.vector - p)) / n.z;
    let under = X_WF.inverse_transform_point(&Point3::from(p + Vector3::z() * down));
    let heading = X_WC.rotation * Vector3::x();
    let ahead = X_WF.inverse_transform_vector(&heading).xy();
    let polygon = environment
        .outline(face, 0.0)
        .convex_around(&under.xy(), &ahead)?;
    let (_, room_m) = polygon.inscribed_circle();
    let narrow = patch.polygon.iter().map(|v| v.x.abs().min(v.y.abs()));
    let at = Region::from(&polygon).nearest(&under.xy());
    if (at - under.xy()).norm() > ASIDE_M || room_m < narrow.fold(0.0, f64::max) {
        return None;
    }
    let place = X_WF * Point3::new(at.x, at.y, 0.0);
    let X_WS = Isometry3::from_parts(place.into(), X_WF.rotation);
    let area = Area {
        X_WF,
        polygon,
        toward: Some(place),
        yaw_rad: Some(heading.y.atan2(heading.x)),
    };
    Some(Contact {
        freedom: Freedom::Within(Box::new(area)),
        ..Contact::at(robot, foot, patch.touching(&X_WS)).on(face, environment)
    })
}

#[cfg(test)]
mod tests {
    use surfaces::{Face, Terrain};

    use crate::provenance::Inputs;
    use crate::robot_files::RobotFiles;
    use crate::scene::Start;

    use super::*;

    /// A level square of the half width.
    fn square(id: &str, at: [f64; 3], half: f64) -> Face {
        let X_WF = Isometry3::translation(at[0], at[1], at[2]);
        Face::rectangle(id, X_WF, [2.0 * half; 2]).unwrap()
    }

    #[test]
    fn feet_find_the_ground_of_the_place_and_keep_the_heading() {
        let robot = RobotFiles::named("builtin:hrp2");
        let robot = robot
            .load(&Default::default(), &mut Inputs::default())
            .unwrap();
        // A floor, a platform over it, and over the head a beam that has no room for a foot.
        let faces = vec![
            square("floor", [0.0, 0.0, 0.0], 4.0),
            square("platform", [2.0, 0.0, 0.3], 0.5),
            square("beam", [2.0, 0.1, 2.5], 0.04),
        ];
        let terrain = Terrain::new(faces, Vec::new()).unwrap();
        let environment = Environment::new(terrain, 0.03, 2.0).unwrap();
        let over = |at_m: [f64; 2]| {
            let start = Start::Over {
                name: None,
                joints: Default::default(),
                at_m,
                yaw_rad: 0.5,
                contacts: Vec::new(),
            };
            crate::start::stand(&robot, &start, &environment, &Default::default())
        };
        for (at_m, height) in [([2.0, 0.0], 0.3), ([-1.0, 0.5], 0.0)] {
            let stands = over(at_m).unwrap();
            let kinematics = Kinematics::new(&robot, &stands.configuration);
            for foot in &stands.patches {
                let X_WC = kinematics.X_WC(&robot.patches[*foot]);
                assert!((X_WC.translation.z - height).abs() < 5e-4, "{X_WC}");
                let x = X_WC.rotation * Vector3::x();
                assert!((x.y.atan2(x.x) - 0.5).abs() < 0.05, "{x}");
            }
            let p = stands.configuration.p_WB;
            assert!((p.x - at_m[0]).hypot(p.y - at_m[1]) < 0.05, "{p}");
        }
        let reason = over([9.0, 0.0]).unwrap_err().to_string();
        assert!(reason.contains("no ground under"), "{reason}");
    }
}
