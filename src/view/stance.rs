//! A stance in the page: bodies, contacts with what their forces amount to, support region.

use std::f64::consts::TAU;

use anyhow::{Result, ensure};
use nalgebra::{Point2, Point3, UnitQuaternion, Vector3};
use plan::{Change, Contact, RequiredMargins, Stance};
use robot_model::Robot;
use serde_json::{Value, json};
use surfaces::ConvexPolygon;

use super::number::{metres, newtons, plane_points, position, unit};
use super::robot::poses;
use super::support::{LoadedContact, support_region};
use crate::export::frames::isometry;

/// Contacts whose heights and normals differ by no more than this are called level: 2 mm, 1°.
const LEVEL_HEIGHT_M: f64 = 0.002;
const LEVEL_TILT_RAD: f64 = 0.0175;
/// Radius and corners of the disc that is drawn where a ball touches, m.
const DISC_M: f64 = 0.025;
const DISC_CORNERS: usize = 12;

/// The stance with everything that the page would have to compute from it.
///
/// # Errors
/// When q is not the robot's or a contact has not one force for each force point.
pub(super) fn record(stance: &Stance, required: &RequiredMargins, robot: &Robot) -> Result<Value> {
    for contact in &stance.contacts {
        let (forces, points) = (contact.forces_W.len(), contact.force_points_W.len());
        ensure!(
            forces == points,
            "contact {:?} has {forces} forces at {points} points",
            contact.patch
        );
    }
    let contacts = stance.contacts.iter();
    let contacts: Vec<_> = contacts.map(|c| contact(c, &stance.change)).collect();
    Ok(json!({
        "index": stance.index,
        "change": stance.change,
        "poses": poses(robot, &stance.q)?,
        "com_W": stance.com_W.map(metres),
        "contacts": contacts,
        "support_level_m": metres(support_level(stance)),
        "support": support(stance, required),
        "margins": stance.margins,
    }))
}

fn contact(contact: &Contact, change: &Change) -> Value {
    let normal = normal(contact);
    let (points, forces) = (triples(&contact.force_points_W), triples(&contact.forces_W));
    let force: Vector3<f64> = forces.iter().sum();
    let normal_force = force.dot(&normal);
    let pushes = contact.loaded && normal_force > 0.0;

    // Where the normal parts of the forces act together.
    let pressure = || {
        let weighted = points.iter().zip(&forces).map(|(p, f)| *p * f.dot(&normal));
        position(&(weighted.sum::<Vector3<f64>>() / normal_force))
    };
    let tangential = (force - normal * normal_force).norm();
    json!({
        "patch": contact.patch,
        "link": contact.link,
        "face": contact.face,
        "loaded": contact.loaded,
        "state": state(contact, change),
        "friction": contact.friction,
        "normal_W": components(&normal, unit),
        "vertices_W": outline(contact).iter().map(|p| p.map(metres)).collect::<Vec<_>>(),
        "force_points_W": contact.force_points_W.iter().map(|p| p.map(metres)).collect::<Vec<_>>(),
        "forces_W": contact.forces_W.iter().map(|f| f.map(newtons)).collect::<Vec<_>>(),
        "force_W": components(&force, newtons),
        "normal_N": newtons(normal_force),
        "centre_of_pressure_W": pushes.then(pressure),
        "friction_use": pushes.then(|| tangential / (contact.friction * normal_force)),
    })
}

/// The patch as it is drawn: its vertices, or a small disc where a ball touches.
fn outline(contact: &Contact) -> Vec<[f64; 3]> {
    let [touched] = contact.vertices_W[..] else {
        return contact.vertices_W.clone();
    };
    let turn = rotation(contact);
    (0..DISC_CORNERS)
        .map(|k| {
            let (sin, cos) = (TAU * k as f64 / DISC_CORNERS as f64).sin_cos();
            (Vector3::from(touched) + turn * Vector3::new(DISC_M * cos, DISC_M * sin, 0.0)).into()
        })
        .collect()
}

/// What the page calls the contact.
fn state(contact: &Contact, change: &Change) -> &'static str {
    match change {
        _ if contact.loaded => "loaded",
        Change::Add { patch, .. } if *patch == contact.patch => "made",
        Change::Remove { patch, .. } if *patch == contact.patch => "leaving",
        _ => "touching",
    }
}

/// z_C in W.
fn normal(contact: &Contact) -> Vector3<f64> {
    rotation(contact) * Vector3::z()
}

fn rotation(contact: &Contact) -> UnitQuaternion<f64> {
    isometry(&contact.X_WC).rotation
}

fn components(v: &Vector3<f64>, rounded: fn(f64) -> f64) -> [f64; 3] {
    <[f64; 3]>::from(*v).map(rounded)
}

fn triples(rows: &[[f64; 3]]) -> Vec<Vector3<f64>> {
    rows.iter().map(|&row| row.into()).collect()
}

/// The height at which the support region is drawn: that of the lowest loaded contact.
fn support_level(stance: &Stance) -> f64 {
    let height = |contact: &Contact| contact.X_WC.p[2];
    let lowest =
        |contacts: &mut dyn Iterator<Item = &Contact>| contacts.map(height).reduce(f64::min);
    lowest(&mut stance.contacts.iter().filter(|c| c.loaded))
        .or_else(|| lowest(&mut stance.contacts.iter()))
        .unwrap_or(0.0)
}

/// The support region of the loaded contacts, and the smaller one that the plan keeps to: with
/// the forces at the shrunk patches and the share of the friction that may be used.
fn support(stance: &Stance, required: &RequiredMargins) -> Option<Value> {
    let loaded: Vec<_> = stance.contacts.iter().filter(|c| c.loaded).collect();
    let region_of = |points: fn(&Contact) -> &[[f64; 3]], friction_use: f64| {
        let contacts = loaded.iter().map(|&contact| LoadedContact {
            points_W: points(contact).iter().map(|&p| Point3::from(p)).collect(),
            normal_W: normal(contact),
            friction: friction_use * contact.friction,
        });
        support_region(&contacts.collect::<Vec<_>>())
    };
    let region = region_of(|c| &c.vertices_W, 1.0)?;
    let kept = region_of(|c| &c.force_points_W, required.friction_use);
    let [x, y, _] = stance.com_W;
    let hull = ConvexPolygon::hull(&region).ok();
    let inside = |p: &Point2<f64>| hull.as_ref().map(|hull| -hull.signed_distance(p));
    // Narrow patches are shrunk by less than the margin asked for. Balls cannot be shrunk: what each
    // of them spares gives the whole margin.
    let promised = if loaded.iter().all(|c| c.vertices_W.len() == 1) {
        Some(required.com_m)
    } else {
        kept.as_ref().and_then(|kept| {
            let inside = kept.iter().map(inside);
            inside.reduce(|a, b| Some(a?.min(b?))).flatten()
        })
    };
    Some(json!({
        "region": plane_points(&region),
        "kept": kept.as_ref().map(plane_points),
        "com_edge_m": inside(&Point2::new(x, y)).map(metres),
        "com_promised_m": promised.map(metres),
        "level": is_level(&loaded),
    }))
}

/// Whether the contacts lie in one horizontal plane.
fn is_level(contacts: &[&Contact]) -> bool {
    let heights = || contacts.iter().flat_map(|c| &c.vertices_W).map(|v| v[2]);
    let low = heights().fold(f64::MAX, f64::min);
    let high = heights().fold(f64::MIN, f64::max);
    let upright = |contact: &&Contact| normal(contact).angle(&Vector3::z()) < LEVEL_TILT_RAD;
    high - low < LEVEL_HEIGHT_M && contacts.iter().all(upright)
}

#[cfg(test)]
mod tests {
    use super::*;
    use plan::{Margins, Pose};

    fn foot(patch: &str, loaded: bool) -> Contact {
        let corners = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]];
        Contact {
            patch: patch.into(),
            link: "sole".into(),
            face: "ground".into(),
            X_WC: Pose {
                p: [0.0, 0.0, 0.2],
                quat_xyzw: [0.0, 0.0, 0.0, 1.0],
            },
            rolls_from: None,
            friction: 0.5,
            loaded,
            vertices_W: corners.map(|[x, y]| [x, y, 0.2]).to_vec(),
            force_points_W: corners.map(|[x, y]| [0.8 * x, 0.8 * y, 0.2]).to_vec(),
            forces_W: [[30.0, 0.0, 200.0], [0.0, 0.0, 100.0]]
                .map(|force| if loaded { force } else { [0.0; 3] })
                .map(|force| [force; 2])
                .concat(),
        }
    }

    #[test]
    fn the_forces_of_a_contact_are_summed_up() {
        let record = contact(&foot("left", true), &Change::Start);
        assert_eq!(record["force_W"], json!([60.0, 0.0, 600.0]));
        assert_eq!(record["normal_N"], json!(600.0));
        // 400 N act at y = −0.04 m and 200 N at +0.04 m.
        assert_eq!(record["centre_of_pressure_W"], json!([0.0, -0.0133, 0.2]));
        // 60 N of the 0.5 · 600 N that friction can hold.
        assert!((record["friction_use"].as_f64().unwrap() - 0.2).abs() < 1e-12);
    }

    #[test]
    fn a_ball_is_drawn_as_a_disc_where_it_touches() {
        let mut ball = foot("toe", true);
        ball.vertices_W = vec![[0.3, 0.1, 0.2]];
        ball.force_points_W = ball.vertices_W.clone();
        ball.forces_W = vec![[0.0, 0.0, 100.0]];
        let record = contact(&ball, &Change::Start);
        let corners = record["vertices_W"].as_array().unwrap();
        assert_eq!(corners.len(), DISC_CORNERS);
        for corner in corners {
            let [x, y, z] = [0, 1, 2].map(|k| corner[k].as_f64().unwrap());
            assert!(((x - 0.3).hypot(y - 0.1) - DISC_M).abs() < 2e-4 && z == 0.2);
        }
        assert_eq!(record["centre_of_pressure_W"], json!([0.3, 0.1, 0.2]));
    }

    #[test]
    fn on_balls_alone_the_whole_margin_is_promised() {
        let ball = |x: f64, y: f64| {
            let at = vec![[x, y, 0.0]];
            Contact {
                vertices_W: at.clone(),
                force_points_W: at,
                forces_W: vec![[0.0, 0.0, 100.0]],
                ..foot("toe", true)
            }
        };
        let contacts = vec![ball(0.0, 0.0), ball(0.6, 0.0), ball(0.0, 0.6)];
        let stance = Stance {
            index: 0,
            change: Change::Start,
            contacts,
            q: Vec::new(),
            com_W: [0.2, 0.1, 0.5],
            margins: Margins::default(),
        };
        let required = RequiredMargins::from(&posture::Config::default());
        let support = support(&stance, &required).unwrap();
        assert_eq!(support["com_edge_m"], 0.1);
        assert_eq!(support["com_promised_m"], required.com_m);
    }

    #[test]
    fn a_contact_without_load_says_whether_it_comes_or_goes() {
        let (patch, face) = ("left".to_owned(), surfaces::FaceId::from("ground"));
        #[rustfmt::skip]
        let states = [
            (Change::Add { patch: patch.clone(), face: face.clone() }, "made"),
            (Change::Remove { patch, face }, "leaving"),
            (Change::Start, "touching"),
        ];
        for (change, expected) in states {
            let record = contact(&foot("left", false), &change);
            assert_eq!(record["state"], expected);
            assert_eq!(record["centre_of_pressure_W"], Value::Null);
        }
    }
}
