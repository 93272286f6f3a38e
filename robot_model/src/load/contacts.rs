//! The contacts file: where a robot may touch the world.
//!
//! ```toml
//! [[patch]]
//! name = "left_foot"
//! link = "LLEG_LINK5"
//! position_m = [0.015, 0.0095, -0.105]
//! rpy_rad = [0.0, 0.0, 0.0]     # frame C in the link's, z_C outward from the environment
//! polygon_m = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]]  # counter-clockwise
//! roles = ["foot"]
//! friction = 0.6
//!
//! [[patch]]
//! name = "front_left"
//! link = "FL_foot"
//! kind = "point"                # "area" where it is left out
//! position_m = [0.0, 0.0, 0.0]  # the ball's centre
//! radius_m = 0.02               # instead of a polygon
//! roles = ["foot"]
//! friction = 0.6
//!
//! [held]                        # joints that stay where they are, as if they were fixed, rad or m
//! left_finger_joint = 1.2
//! ```

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point2, Translation3, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{ContactPatch, Error, GREATEST_M, PatchKind, Robot};

#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Contacts")]
struct File {
    /// The patches.
    #[serde(default)]
    patch: Vec<Patch>,
    /// Joints that are held where they are, as if they were fixed, rad or m, such as fingers.
    #[serde(default)]
    held: BTreeMap<String, f64>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Patch {
    /// Name, of its own.
    name: String,
    /// The link that carries it.
    link: String,
    /// Origin of the patch frame C in the link's, m; of a point the ball's centre.
    #[serde(default)]
    position_m: [f64; 3],
    /// Roll, pitch and yaw of C in the link's frame, rad; z points out of the environment.
    #[serde(default)]
    rpy_rad: [f64; 3],
    /// With what it touches.
    #[serde(default)]
    kind: Kind,
    /// Of an area the vertices in C, strictly convex and counter-clockwise, m.
    polygon_m: Option<Vec<[f64; 2]>>,
    /// Of a point the ball's radius, m.
    radius_m: Option<f64>,
    /// What it may do: `foot`, `hand` or any role that the settings have.
    #[serde(default)]
    roles: Vec<String>,
    /// Coefficient of friction.
    friction: f64,
}

#[derive(Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Kind {
    #[default]
    Area,
    Point,
}

/// The JSON Schema of the file.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(File)
}

/// The joints that a contacts file holds, and where, rad or m; none of a file that [`read`] refuses.
pub(super) fn held(text: &str) -> BTreeMap<String, f64> {
    crate::toml_file::parse::<File>(text).map_or_else(|_| BTreeMap::new(), |file| file.held)
}

/// The patches of a contacts file on a robot.
///
/// # Errors
/// All of: [`Error::File`] with the line; [`Error::Part`] for a polygon that is not strictly convex
/// and counter-clockwise, a radius or a friction that is not positive, an area without a polygon or
/// a point without a radius, a name given twice;
/// [`Error::Unknown`] for a link that is not there.
pub(super) fn read(file: &str, text: &str, robot: &Robot) -> Result<Vec<ContactPatch>, Error> {
    let mut refused = Vec::new();
    let parsed = crate::toml_file::parse::<File>(text);
    let parsed = parsed.unwrap_or_else(|mistakes| {
        refused.extend(
            mistakes
                .into_iter()
                .map(|mistake| Error::file(file, mistake)),
        );
        File::default()
    });
    let mut patches: Vec<ContactPatch> = Vec::new();
    for (number, patch) in parsed.patch.iter().enumerate() {
        let mut refuse =
            |cause: String| refused.push(Error::part(file, "patch", &patch.name, cause));
        if parsed.patch[..number]
            .iter()
            .any(|other| other.name == patch.name)
        {
            refuse("its name is given twice".to_owned());
        }
        let numbers = patch.position_m.iter().chain(&patch.rpy_rad);
        let mut numbers = numbers.chain(patch.polygon_m.iter().flatten().flatten());
        if let Some(number) = numbers.find(|v| v.is_nan() || v.abs() > GREATEST_M) {
            refuse(format!(
                "it holds {number}, which is not within {GREATEST_M}"
            ));
        }
        let friction = patch.friction;
        if !(friction.is_finite() && friction > 0.0) {
            refuse(format!("its friction {friction} is not positive"));
        }
        let shape = shape(patch).map_err(refuse);
        let frame = robot.frames.iter().find(|f| f.name == patch.link);
        if frame.is_none() {
            let place = format!("{file}: patch \"{}\"", patch.name);
            let links = robot.frames.iter().map(|f| f.name.as_str());
            refused.push(Error::unknown(Some(&place), "link", &patch.link, links));
        }
        let (Ok((kind, polygon)), Some(frame)) = (shape, frame) else {
            continue;
        };
        let [roll, pitch, yaw] = patch.rpy_rad;
        let X_LC = Isometry3::from_parts(
            Translation3::from(Vector3::from(patch.position_m)),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        );
        patches.push(ContactPatch {
            name: patch.name.clone(),
            link: patch.link.clone(),
            body: frame.body,
            X_BC: frame.X_BL * X_LC,
            kind,
            polygon,
            roles: patch.roles.clone(),
            friction,
        });
    }
    Error::all(refused).map(|()| patches)
}

/// What the patch touches with: its kind and its vertices in C, or what is wrong.
fn shape(patch: &Patch) -> Result<(PatchKind, Vec<Point2<f64>>), String> {
    match (patch.kind, &patch.polygon_m, patch.radius_m) {
        (Kind::Area, Some(vertices), None) => {
            let polygon: Vec<Point2<f64>> = vertices.iter().map(|&p| p.into()).collect();
            flaw(&polygon).map_or(Ok((PatchKind::Area, polygon)), Err)
        }
        (Kind::Point, None, Some(radius_m)) => {
            if !(radius_m > 0.0 && radius_m <= GREATEST_M) {
                return Err(format!("its radius_m {radius_m} is not positive"));
            }
            Ok((PatchKind::Point { radius_m }, vec![Point2::origin()]))
        }
        (Kind::Area, None, _) => Err("an area needs polygon_m".to_owned()),
        (Kind::Area, _, Some(_)) => Err("an area has no radius_m".to_owned()),
        (Kind::Point, _, None) => Err("a point needs radius_m".to_owned()),
        (Kind::Point, Some(_), _) => Err("a point has no polygon_m".to_owned()),
    }
}

/// Vertices nearer than this are one, corners flatter than this (as a height) are none; m.
const SMALLEST_M: f64 = 1e-6;

/// Why the vertices are no strictly convex polygon in counter-clockwise order, if so.
fn flaw(polygon: &[Point2<f64>]) -> Option<String> {
    let n = polygon.len();
    if n < 3 {
        let cause = format!("its polygon has {n} vertices, at least 3 are wanted");
        return Some(cause);
    }
    for i in 0..n {
        for j in 0..i {
            if (polygon[i] - polygon[j]).norm() < SMALLEST_M {
                return Some(format!("vertices {j} and {i} of its polygon are the same"));
            }
        }
    }
    let doubled = |i: usize| polygon[i].coords.perp(&polygon[(i + 1) % n].coords);
    let area: f64 = (0..n).map(doubled).sum();
    if area <= 0.0 {
        return Some("its polygon runs clockwise, counter-clockwise is wanted".to_owned());
    }
    // Left turns all along, and one turn in total: a star turns left, too.
    let mut turning = 0.0;
    for i in 0..n {
        let (a, b, c) = (polygon[i], polygon[(i + 1) % n], polygon[(i + 2) % n]);
        let (into, out) = (b - a, c - b);
        let turn = into.perp(&out);
        if turn < SMALLEST_M * (c - a).norm() {
            let at = (i + 1) % n;
            return Some(format!("its polygon is not strictly convex at vertex {at}"));
        }
        turning += turn.atan2(into.dot(&out));
    }
    (turning > 1.5 * std::f64::consts::TAU).then(|| "its polygon crosses itself".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flaw_of(points: &[[f64; 2]]) -> String {
        let polygon: Vec<Point2<f64>> = points.iter().map(|&p| p.into()).collect();
        flaw(&polygon).unwrap_or_default()
    }

    #[test]
    fn polygons_are_checked() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(flaw_of(&square), "");
        let mut clockwise = square;
        clockwise.reverse();
        assert!(flaw_of(&clockwise).contains("clockwise"));
        assert!(flaw_of(&square[..2]).contains("2 vertices"));
        let repeated = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        assert!(flaw_of(&repeated).contains("the same"));
        let dented = [[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]];
        assert!(flaw_of(&dented).contains("convex"));
        let star = [0.0, 0.4, 0.8, 1.2, 1.6].map(|turns| {
            let (y, x) = f64::sin_cos(turns * std::f64::consts::TAU);
            [x, y]
        });
        assert!(flaw_of(&star).contains("crosses"));
    }
}
