//! A depth image as numpy saves it (`.npy`): one array of rows × columns, whole numbers in the sensor's unit or
//! floating ones in m; or a cloud, points × 3 floating ones.
//!
//! The header is a Python literal of three known keys, which are looked for by name: nothing in it nests.

use std::path::Path;

use super::depth_png::PIXELS_MAX;
use crate::Error;

pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// Pixels row by row.
#[derive(Debug)]
pub(super) struct Depths {
    /// Width and height.
    pub size: (usize, usize),
    /// Depths in their unit.
    pub units: Vec<f32>,
    /// Whether the unit is 1 m.
    pub metres: bool,
}

/// The depths of the array.
///
/// # Errors
/// [`Error::File`] naming the part of the header that is not a depth image's or contradicts the file's length.
pub(super) fn decode(path: &Path, bytes: &[u8]) -> Result<Depths, Error> {
    let fail = |field: &str, cause: String| Error::field(path, field, cause);
    // Magic, version, the header's length (two bytes, later four), header.
    let short = || fail("header", "ends in the middle".to_owned());
    let wide = *bytes.get(6).ok_or_else(short)? > 1;
    let start = if wide { 12 } else { 10 };
    let length = bytes.get(8..start).ok_or_else(short)?;
    let length = length.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b));
    let data = start + length;
    let header = bytes.get(start..data).ok_or_else(short)?;
    let header = String::from_utf8_lossy(header);
    let value = |key: &str| {
        let quoted = [format!("'{key}':"), format!("\"{key}\":")];
        let mut at = quoted.iter();
        let rest = at.find_map(|q| Some(header.split_once(q.as_str())?.1.trim_start()));
        rest.ok_or_else(|| fail(key, "is missing".to_owned()))
    };

    // The array's shape, without axes of one element.
    let axes = value("shape")?;
    let axes = axes.strip_prefix('(').and_then(|s| s.split_once(')'));
    let axes = axes.map(|(axes, _)| axes.split(',').map(str::trim).filter(|s| !s.is_empty()));
    let axes = axes.and_then(|axes| axes.map(|n| n.parse().ok()).collect::<Option<Vec<usize>>>());
    let axes = axes.ok_or_else(|| fail("shape", "is no list of whole numbers".to_owned()))?;
    let long: Vec<usize> = axes.iter().copied().filter(|&n| n != 1).collect();
    let [height, width] = long[..] else {
        let cause = format!("{axes:?} is no depth image's, which has rows and columns");
        return Err(fail("shape", cause));
    };

    // Its elements.
    let kind = value("descr")?.trim_start_matches(['\'', '"']);
    let kind = kind.split(['\'', '"']).next().unwrap_or_default();
    let (order, kind) = kind.split_at_checked(1).unwrap_or_default();
    let size = match kind {
        "u2" => 2,
        "f4" | "i4" | "u4" => 4,
        "f8" => 8,
        _ => {
            let cause =
                format!("{order}{kind:?} is none of uint16, uint32, int32, float32 and float64");
            return Err(fail("descr", cause));
        }
    };
    let pixels = width.checked_mul(height).filter(|&n| n <= PIXELS_MAX);
    let there = bytes.len() - data;
    let Some(pixels) = pixels.filter(|&n| n > 0 && n * size <= there) else {
        let cause = format!("{width}x{height} of {kind} cannot be in {there} bytes");
        return Err(fail("shape", cause));
    };
    let element = |raw: &[u8]| {
        let mut le = [0; 8];
        le[..size].copy_from_slice(raw);
        if order == ">" {
            le[..size].reverse();
        }
        let [a, b, c, d, ..] = le;
        match kind {
            "f4" => f32::from_le_bytes([a, b, c, d]),
            "f8" => f64::from_le_bytes(le) as f32,
            "i4" => i32::from_le_bytes([a, b, c, d]) as f32,
            _ => u32::from_le_bytes([a, b, c, d]) as f32,
        }
    };
    let elements = bytes[data..].chunks_exact(size).take(pixels);
    let mut units: Vec<f32> = elements.map(element).collect();
    if value("fortran_order")?.starts_with("True") {
        let by_rows = (0..pixels).map(|i| units[i / width + i % width * height]);
        units = by_rows.collect();
    }
    Ok(Depths {
        size: (width, height),
        units,
        metres: kind.starts_with('f'),
    })
}
