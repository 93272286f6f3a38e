//! TIFF of one grey channel → depths: whole numbers in the sensor's unit, floating ones in m.

use std::io::Cursor;
use std::path::Path;

use tiff::decoder::{Decoder, DecodingResult, Limits};

use super::depth_png::{DEFLATE_RATIO_MAX, PIXELS_MAX};
use super::npy::{Array, Depths};
use crate::Error;

/// Little and big endian.
pub(super) const MAGIC: [&[u8]; 2] = [b"II*\0", b"MM\0*"];

/// The depths of the first page.
///
/// # Errors
/// [`Error::File`] of pixels that are neither of 16 or 32 bit nor floating, of several channels, and from the decoder.
pub(super) fn decode(path: &Path, bytes: &[u8]) -> Result<Array, Error> {
    let fail = |cause| Error::parse(path, "TIFF", cause);
    let mut limits = Limits::default();
    limits.decoding_buffer_size = 4 * PIXELS_MAX;
    let mut decoder = Decoder::new(Cursor::new(bytes))
        .map_err(fail)?
        .with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(fail)?;
    let size = (width as usize, height as usize);
    let pixels = size.0.checked_mul(size.1);
    if pixels.is_none_or(|n| n > PIXELS_MAX || n > bytes.len().saturating_mul(DEFLATE_RATIO_MAX)) {
        let cause = format!("{width}x{height} pixels cannot be in {} bytes", bytes.len());
        return Err(Error::field(path, "size", cause));
    }
    let color = decoder.colortype().map_err(fail)?;
    let (units, metres): (Vec<f32>, bool) = match decoder.read_image().map_err(fail)? {
        DecodingResult::U16(units) => (units.into_iter().map(f32::from).collect(), false),
        DecodingResult::I16(units) => (units.into_iter().map(f32::from).collect(), false),
        DecodingResult::U32(units) => (units.into_iter().map(|z| z as f32).collect(), false),
        DecodingResult::F32(units) => (units, true),
        DecodingResult::F64(units) => (units.into_iter().map(|z| z as f32).collect(), true),
        _ => (Vec::new(), false),
    };
    if pixels != Some(units.len()) || units.is_empty() {
        let cause = format!(
            "a depth image is one channel of 16 or 32 bit or floating numbers, this is {color:?}"
        );
        return Err(Error::field(path, "pixels", cause));
    }
    Ok(Array::Depths(Depths {
        size,
        units,
        metres,
    }))
}
