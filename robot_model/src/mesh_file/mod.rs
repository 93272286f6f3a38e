//! Triangles out of STL, OBJ, PLY, COLLADA and glTF files.
//!
//! Nothing that a file says about itself is believed before it is checked against
//! the bytes that are there, and vertices keep their double precision.

mod dae;
mod dae_primitive;
mod gltf;
mod obj;
mod ply;
mod stl;

use std::path::Path;

use nalgebra::{Point3, UnitQuaternion};

use crate::Error;

/// Vertices and the triangles over them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertices, in the file's own frame; m.
    pub vertices: Vec<Point3<f64>>,
    /// Indices into `vertices`, all of them valid.
    pub triangles: Vec<[u32; 3]>,
    /// Turns what the file calls up to z; nothing where it does not tell.
    pub R_up: UnitQuaternion<f64>,
}

impl TriangleMesh {
    /// Adds the fan of triangles over the corners of a face; none where it has no area.
    fn add_face(&mut self, corners: &[u32]) -> Result<(), String> {
        let [first, rest @ ..] = corners else {
            return Err("a face has no corners".to_owned());
        };
        if rest.len() >= CORNERS_MAX {
            let count = corners.len();
            return Err(format!(
                "a face has {count} corners, at most {CORNERS_MAX} are read"
            ));
        }
        // Lines among the faces, as some editors leave them, make none.
        self.triangles
            .extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        check_count("triangles", self.triangles.len())
    }
}

/// Most corners of a face: each makes a triangle with all others of a fan.
const CORNERS_MAX: usize = 1000;

/// What some editors begin a text with.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// Nodes of a scene that are nested deeper than this refer to themselves.
const GREATEST_DEPTH: usize = 64;
/// Nodes that share others twice over, time and again, make more than this.
const GREATEST_NODES: usize = 100_000;

/// More than this many vertices or triangles is no mesh of a robot or room.
const GREATEST_COUNT: usize = 20_000_000;

/// Reads a mesh out of the bytes of the file at `path`; the kind follows from its extension (`.stl`, `.obj`, `.ply`,
/// `.dae`, `.glb`, `.gltf`).
///
/// # Errors
/// [`Error::File`] with the line or byte: unknown kind, truncated, a header that lies, an index
/// out of range, a coordinate that is not finite, no triangle at all.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleMesh, Error> {
    let bytes = match bytes.strip_prefix(BYTE_ORDER_MARK) {
        Some(text) if !stl::is_binary(bytes) => text,
        _ => bytes,
    };
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase());
    let parsed = match extension.as_deref() {
        Some("stl") => stl::parse(bytes),
        Some("obj") => obj::parse(bytes),
        Some("ply") => ply::parse(bytes),
        Some("dae") => dae::parse(bytes),
        Some("glb" | "gltf") => gltf::parse(bytes),
        Some(other) => Err(format!(
            "meshes of kind \".{other}\" are not read; STL, OBJ, PLY, DAE, glTF are"
        )),
        None => Err("its name has no extension to tell its kind from".to_owned()),
    };
    let mesh = parsed.map_err(|cause| Error::file(path.display(), cause))?;
    if mesh.triangles.is_empty() {
        return Err(Error::file(path.display(), "it has no triangles"));
    }
    Ok(mesh)
}

/// Complains of a count that no honest file has.
fn check_count(what: &str, count: usize) -> Result<(), String> {
    if count > GREATEST_COUNT {
        return Err(format!(
            "{count} {what} are more than the {GREATEST_COUNT} that are read"
        ));
    }
    Ok(())
}
