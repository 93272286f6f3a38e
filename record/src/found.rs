//! The faces that a program wrote into a `surfaces.json`, of any version of the format.

use anyhow::{Result, bail};
use nalgebra::{Isometry3, Vector3};
use serde::Deserialize;
use serde_json::Value;
use surfaces::outline::Outline;
use surfaces::{ConvexPolygon, Face, TERRAIN_FORMAT, Terrain};

/// Parts whose planes are as near as this are of one plane: normals, rad, and offsets, m.
const SAME_PLANE: f64 = 2e-3;

/// Standard deviations that are kept off the edges of a face, as the program's settings have it.
const EDGE_SIGMAS: f64 = 2.0;

/// What was found of one plane of the world; parts of it that are apart are one `Found`.
#[allow(non_snake_case)]
pub struct Found {
    /// Frame of the plane, z outward.
    pub X_WF: Isometry3<f64>,
    /// Everything that lies in it, in F.
    pub outline: Outline,
    /// What is left after the insets, in F.
    pub touchable: Outline,
    /// RMS distance of the points from the plane, m; 0 where unknown.
    pub rms_m: f64,
    name: Option<String>,
}

/// A convex piece of a face, as version 1 has it.
#[derive(Deserialize)]
#[allow(non_snake_case)]
struct Piece {
    #[serde(with = "surfaces::pose")]
    X_WS: Isometry3<f64>,
    polygon: ConvexPolygon,
    #[serde(default)]
    outline: Vec<Vec<[f64; 2]>>,
    #[serde(default)]
    inset_m: f64,
    #[serde(default)]
    edge_insets_m: Vec<f64>,
    #[serde(default)]
    rms_m: f64,
    #[serde(default)]
    face: Option<String>,
}

/// The faces of a `surfaces.json`.
pub fn read(file: &Value) -> Result<Vec<Found>> {
    let mut all: Vec<Found> = Vec::new();
    match file["format"].as_str() {
        Some("scandent-surfaces/1") => {
            for piece in Vec::<Piece>::deserialize(&file["surfaces"])? {
                add(&mut all, piece.into());
            }
        }
        Some(TERRAIN_FORMAT) => {
            let terrain = Terrain::from_json(&file.to_string())?;
            terrain
                .faces
                .iter()
                .for_each(|face| add(&mut all, face.into()));
        }
        format => bail!("surfaces of the format {format:?} cannot be read"),
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
            name: None,
        }
    }
}

impl From<Piece> for Found {
    fn from(piece: Piece) -> Self {
        let left = match piece.edge_insets_m.is_empty() {
            true => piece.polygon.inset(piece.inset_m),
            false => piece.polygon.inset_edges(&piece.edge_insets_m),
        };
        Self {
            X_WF: piece.X_WS,
            outline: match piece.outline.is_empty() {
                true => Outline::from_polygon(&piece.polygon),
                false => Outline::from_rings(&piece.outline),
            },
            touchable: left
                .as_ref()
                .map_or_else(Outline::default, Outline::from_polygon),
            rms_m: piece.rms_m,
            name: piece.face,
        }
    }
}

/// Adds a part to the plane that it lies in.
#[allow(non_snake_case)]
fn add(all: &mut Vec<Found>, part: Found) {
    let same = |known: &&mut Found| {
        let named = part.name.is_some() && known.name == part.name;
        named || known.plane_of(&part) && part.plane_of(known)
    };
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
        assert!((found[0].touchable.area() - (0.9 * 0.8 + 1.0)).abs() < 1e-6);
        assert!(read(&json!({ "format": "scandent-surfaces/9" })).is_err());

        // The same face as version 2 has it, with edges that are exactly known.
        let whole = Terrain::from_json(&file.to_string()).unwrap();
        let file = serde_json::from_str(&whole.to_json().unwrap()).unwrap();
        let found = read(&file).unwrap();
        assert_eq!(found.len(), 1);
        assert!((found[0].outline.area() - 2.0).abs() < 1e-6);
    }
}
