//! A depth image as numpy saves it (`.npy`): one array of rows × columns, whole numbers in the sensor's unit or
//! floating ones in m; or a cloud of floating ones, points × columns or rows × columns × channels, x, y and z first
//! and of no more than four others (colours, normals, an intensity).
//!
//! The header is a Python literal of three known keys, which are looked for by name: nothing in it nests.

use std::ops::RangeInclusive;
use std::path::Path;

use super::depth_png::PIXELS_MAX;
use super::tidy;
use crate::Error;
use crate::scan::PointCloud;

pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// What one point's numbers may be. No image is so narrow.
const CHANNELS: RangeInclusive<usize> = 3..=7;

/// What an array is.
#[derive(Debug)]
pub(super) enum Array {
    /// An image.
    Depths(Depths),
    /// Points, m.
    Points(PointCloud),
}

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

/// The depths or the points of the array.
///
/// # Errors
/// [`Error::File`] naming the part of the header that is none of these or contradicts the file's length.
pub(super) fn decode(path: &Path, bytes: &[u8]) -> Result<Array, Error> {
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

    // Its elements.
    let kind = value("descr")?.trim_start_matches(['\'', '"']);
    let kind = kind.split(['\'', '"']).next().unwrap_or_default();
    let (order, kind) = kind.split_at_checked(1).unwrap_or_default();
    let size = match kind {
        "u2" | "i2" => 2,
        "f4" | "i4" | "u4" => 4,
        "f8" | "i8" | "u8" => 8,
        _ => {
            let cause = format!(
                "{order}{kind:?} is none of float32, float64 and whole numbers of 16, 32 or 64 bit"
            );
            return Err(fail("descr", cause));
        }
    };
    let metres = kind.starts_with('f');
    let (height, width, channels) = match long[..] {
        [points, channels] if metres && CHANNELS.contains(&channels) => (1, points, channels),
        [height, width] => (height, width, 1),
        [height, width, channels] if metres && CHANNELS.contains(&channels) => {
            (height, width, channels)
        }
        _ => {
            let cause = format!(
                "{axes:?} is neither a depth image's (rows, columns) nor that of points in m (points, 3 to 7 columns)"
            );
            return Err(fail("shape", cause));
        }
    };
    let pixels = width.checked_mul(height).filter(|&n| n <= PIXELS_MAX);
    let elements = pixels.map(|n| n * channels);
    let there = bytes.len() - data;
    let Some(elements) = elements.filter(|&n| n > 0 && n * size <= there) else {
        let cause = format!("{long:?} of {kind} cannot be in {there} bytes");
        return Err(fail("shape", cause));
    };
    let element = |raw: &[u8]| {
        let mut le = [0; 8];
        le[..size].copy_from_slice(raw);
        if order == ">" {
            le[..size].reverse();
        }
        let [a, b, c, d, ..] = le;
        let (whole, unused) = (u64::from_le_bytes(le), 64 - 8 * size);
        match kind {
            "f4" => f32::from_le_bytes([a, b, c, d]),
            "f8" => f64::from_le_bytes(le) as f32,
            signed if signed.starts_with('i') => ((whole << unused) as i64 >> unused) as f32,
            _ => whole as f32,
        }
    };
    let raw = bytes[data..].chunks_exact(size).take(elements);
    let mut units: Vec<f32> = raw.map(element).collect();
    if value("fortran_order")?.starts_with("True") {
        // The first axis is the fastest: rows, columns, channels.
        let by_rows = (0..elements).map(|i| {
            let (pixel, channel) = (i / channels, i % channels);
            units[pixel / width + height * (pixel % width + width * channel)]
        });
        units = by_rows.collect();
    }
    if channels == 1 {
        return Ok(Array::Depths(Depths {
            size: (width, height),
            units,
            metres,
        }));
    }
    let points = units.chunks_exact(channels).map(|p| [p[0], p[1], p[2]]);
    let grid = (height > 1).then_some((width, height));
    Ok(Array::Points(tidy(points.collect(), grid)))
}
