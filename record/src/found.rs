//! The faces that a program wrote into a `surfaces.json`, of any version of the format.

use anyhow::Result;
use nalgebra::{Isometry3, Vector3};
use serde_json::Value;
use surfaces::outline::Outline;
use surfaces::{Face, Terrain};

/// Parts whose planes are as near as this are of one plane: normals, rad, and offsets, m.
const SAME_PLANE: f64 = 2e-3;

/// Standard deviations that are kept off the edges of a face, as the program's settings have it.
const EDGE_SIGMAS: f64 = 2.0;

/// What was found of one plane of the world; parts of it that are apart are one `Found`.
pub struct Found {
    /// Frame of the plane, z outward.
    pub X_WF: Isometry3<f64>,
    /// Everything that lies in it, in F.
    pub outline: Outline,
    /// What is left after the insets, in F.
    pub touchable: Outline,
    /// RMS distance of the points from the plane, m; 0 where unknown.
    pub rms_m: f64,
}

/// The faces of a `surfaces.json`.
pub fn read(file: &Value) -> Result<Vec<Found>> {
    let mut all: Vec<Found> = Vec::new();
    for face in &Terrain::from_json(&file.to_string())?.faces {
        add(&mut all, face.into());
    }
    Ok(all)
}

impl From<&Face> for Found {
    fn from(face: &Face) -> Self {
        Self {
            X_WF: face.X_WF,
            outline: Outline::from(&face.region),
            touchable: face.inset_region(EDGE_SIGMAS, 0.0),
            rms_m: face.fit.as_ref().map_or(0.0, |fit| fit.rms_m),
        }
    }
}

/// Adds a part to the plane that it lies in.
fn add(all: &mut Vec<Found>, part: Found) {
    let same = |known: &&mut Found| known.plane_of(&part) && part.plane_of(known);
    match all.iter_mut().find(same) {
        Some(known) => {
            let X_KP = known.X_WF.inv_mul(&part.X_WF);
            known.outline = known.outline.union(&part.outline.moved(&X_KP));
            known.touchable = known.touchable.union(&part.touchable.moved(&X_KP));
        }
        None => all.push(part),
    }
}

impl Found {
    pub fn normal(&self) -> Vector3<f64> {
        self.X_WF * Vector3::z()
    }

    /// Whether the other's frame lies in this plane.
    fn plane_of(&self, other: &Self) -> bool {
        let between = other.X_WF.translation.vector - self.X_WF.translation.vector;
        self.normal().angle(&other.normal()) < SAME_PLANE
            && self.normal().dot(&between).abs() < SAME_PLANE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn pieces_of_a_face_become_one_again_and_lose_their_insets() {
        let pose = json!({ "p": [0, 0, 1], "quat_xyzw": [0, 0, 0, 1] });
        let outline = json!([[[0, 0], [2, 0], [2, 1], [0, 1]]]);
        let piece = |from: f64, insets: [f64; 4]| {
            json!({
                "id": format!("s{from}"), "X_WS": pose, "outline": outline, "face": "f", "edge_insets_m": insets,
                "polygon": [[from, 0], [from + 1.0, 0], [from + 1.0, 1], [from, 1]],
            })
        };
        let pieces = [piece(0.0, [0.1, 0.0, 0.1, 0.1]), piece(1.0, [0.0; 4])];
        let file = json!({ "format": "scandent-surfaces/1", "surfaces": pieces });
        let found = read(&file).unwrap();
        assert_eq!(found.len(), 1);
        assert!((found[0].outline.area() - 2.0).abs() < 1e-6);
        // Along an edge of the face the most that a piece is taken back.
        assert!((found[0].touchable.area() - 1.9 * 0.8).abs() < 1e-6);
        assert!(read(&json!({ "format": "scandent-surfaces/9" })).is_err());

        // The same face as version 2 has it, with edges that are exactly known.
        let whole = Terrain::from_json(&file.to_string()).unwrap();
        let file = serde_json::from_str(&whole.to_json().unwrap()).unwrap();
        let found = read(&file).unwrap();
        assert_eq!(found.len(), 1);
        assert!((found[0].outline.area() - 2.0).abs() < 1e-6);
    }
}
