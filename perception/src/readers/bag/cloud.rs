//! `PointCloud2` → points.

use std::path::Path;

use super::messages::PointCloud2;
use crate::Error;
use crate::readers::tidy;
use crate::scan::PointCloud;

/// Datatypes of a point's numbers.
const FLOAT32: u8 = 7;
const FLOAT64: u8 = 8;

/// The points in the cloud's own frame.
///
/// # Errors
/// [`Error::File`] for x, y or z that are not there as floats, and sizes that contradict each other.
pub(super) fn points(path: &Path, cloud: &PointCloud2<'_>) -> Result<PointCloud, Error> {
    let (width, height) = (cloud.width as usize, cloud.height as usize);
    let (point, row) = (cloud.point_step as usize, cloud.row_step as usize);
    let mut places = [(0, 0); 3];
    for (name, place) in ["x", "y", "z"].into_iter().zip(&mut places) {
        let Some(field) = cloud.fields.iter().find(|field| field.name == name) else {
            return Err(Error::field(path, "fields", format!("has no {name}")));
        };
        let bytes = match field.datatype {
            FLOAT32 => 4,
            FLOAT64 => 8,
            other => {
                let cause = format!("{name} is of the datatype {other}, not of 7 or 8 (floats)");
                return Err(Error::field(path, "fields", cause));
            }
        };
        *place = (field.offset as usize, bytes);
        if place.0.saturating_add(bytes) > point {
            let cause = format!("{name} lies beyond the {point} bytes of a point");
            return Err(Error::field(path, "fields", cause));
        }
    }
    let fits = width.checked_mul(point).is_some_and(|used| used <= row)
        && row
            .checked_mul(height)
            .is_some_and(|all| all <= cloud.data.len());
    if !fits || row == 0 {
        let there = cloud.data.len();
        let cause = format!(
            "{width}x{height} points of {point} bytes in rows of {row} are not {there} bytes"
        );
        return Err(Error::field(path, "data", cause));
    }
    let big = cloud.is_bigendian;
    let number = |b: &[u8]| match *b {
        [a, b, c, d] if big => f32::from_be_bytes([a, b, c, d]),
        [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
        _ => {
            let eight = *b.first_chunk().unwrap_or(&[0; 8]);
            (if big {
                f64::from_be_bytes(eight)
            } else {
                f64::from_le_bytes(eight)
            }) as f32
        }
    };
    let rows = cloud.data.chunks_exact(row).take(height);
    let points = rows.flat_map(|bytes| bytes[..width * point].chunks_exact(point));
    let points = points.map(|bytes| places.map(|(at, n)| number(&bytes[at..at + n])));
    let organised = (height > 1 && width > 1).then_some((width, height));
    Ok(tidy(points.collect(), organised))
}
