//! Arrays that numpy saved together (`.npz`): a ZIP of `.npy` files, one of which is the scan.

use std::io::{Cursor, Read};
use std::path::Path;

use zip::ZipArchive;

use super::depth_png::PIXELS_MAX;
use super::npy::{self, Array};
use crate::Error;

pub(super) const MAGIC: &[u8] = b"PK\x03\x04";
/// No array is unpacked beyond this, bytes.
const BYTES_MAX: u64 = 8 * PIXELS_MAX as u64;
/// Arrays of fewer numbers are no scan: a camera's matrix, a pose.
const NUMBERS_MIN: usize = 64;

/// The array of that name, else the only one that is a depth image or points.
///
/// # Errors
/// [`Error::File`] with the names of the arrays, where none or several may be the scan; as [`npy::decode`].
pub(super) fn decode(
    path: &Path,
    bytes: &[u8],
    name: Option<&str>,
    notes: &mut Vec<String>,
) -> Result<Array, Error> {
    let fail = |cause: zip::result::ZipError| Error::parse(path, "NPZ", cause);
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(fail)?;
    let files = archive
        .file_names()
        .map(|name| Ok(name.map_err(fail)?.into_owned()));
    let files: Vec<String> = files.collect::<Result<_, Error>>()?;
    let mut read = |file: &str| {
        let mut array = Vec::new();
        let packed = archive.by_name(file).map_err(fail)?;
        let unpacked = packed.take(BYTES_MAX).read_to_end(&mut array);
        unpacked.map_err(|cause| Error::parse(path, "NPZ", cause))?;
        npy::decode(path, &array)
    };
    if let Some(name) = name {
        return read(&format!("{name}.npy"));
    }
    let is_scan = |array: &Array| {
        NUMBERS_MIN
            <= match array {
                Array::Depths(depths) => depths.units.len(),
                Array::Points(cloud) => cloud.points.len(),
            }
    };
    let found = files
        .iter()
        .filter_map(|file| Some((file, read(file).ok().filter(is_scan)?)));
    // A second one is enough to ask which: no more are held at once.
    let mut found: Vec<(&String, Array)> = found.take(2).collect();
    let shown = |file: &String| file.trim_end_matches(".npy").to_owned();
    match (found.len(), found.pop()) {
        (1, Some((file, array))) => {
            if files.len() > 1 {
                notes.push(format!("{}: array {}", path.display(), shown(file)));
            }
            Ok(array)
        }
        (count, _) => {
            let names: Vec<String> = files.iter().map(shown).collect();
            let several = if count == 0 { "none" } else { "several" };
            let cause = format!(
                "{several} of its arrays ({}) may be the scan: name it by --topic (topic in a scene)",
                names.join(", ")
            );
            Err(Error::file(path, cause))
        }
    }
}
