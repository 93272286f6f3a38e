//! 16-bit grey PNG → [`DepthImage`].

use std::io::Cursor;
use std::path::Path;

use png::{BitDepth, ColorType, Decoder, Limits};

use super::SensorOptions;
use crate::Error;
use crate::error::within;
use crate::scan::DepthImage;
use crate::sensor::{SENSORS, Sensor};

const FORMAT: &str = "PNG";
/// Deflate expands by at most this factor, so a smaller file cannot hold the image it promises.
pub(super) const DEFLATE_RATIO_MAX: usize = 1032;
/// No depth camera has more pixels.
pub(super) const PIXELS_MAX: usize = 64 << 20;

/// Less than this part of the pixels measured in the sensor's range is no range but another unit.
const IN_RANGE_MIN: f64 = 0.1;

/// That depths in the unit given are such that the sensor measures.
fn check_unit(path: &Path, z_m: &[f32], sensor: &Sensor, scale: f64) -> Result<(), Error> {
    let (near, far) = (sensor.range_m.0 as f32, sensor.range_m.1 as f32);
    let mut measured: Vec<f32> = z_m.iter().copied().filter(|z| *z > 0.0).collect();
    let inside = measured
        .iter()
        .filter(|z| (near..=far).contains(*z))
        .count();
    if measured.is_empty() || inside as f64 >= IN_RANGE_MIN * measured.len() as f64 {
        return Ok(());
    }
    let middle = measured.len() / 2;
    let (_, median, _) = measured.select_nth_unstable_by(middle, f32::total_cmp);
    let cause = format!(
        "{median:.3} m in the median, and {} measures from {near} to {far} m: is a unit {scale} m? Another is the \
         last number of --sensor NAME:fx,fy,cx,cy,METRES (depth_scale_m in a scene): 0.001 for mm",
        sensor.name
    );
    Err(Error::field(path, "depths", cause))
}

/// Width and height, and the pixels row by row.
///
/// # Errors
/// [`Error::File`] for another pixel type, absurd sizes or a file too short for them, and from
/// the decoder.
pub(super) fn decode(path: &Path, bytes: &[u8]) -> Result<((usize, usize), Vec<u16>), Error> {
    // Check the promised size against the bytes that are there.
    let mut decoder = Decoder::new(Cursor::new(bytes));
    let info = decoder
        .read_header_info()
        .map_err(|e| Error::parse(path, FORMAT, e))?;
    let (width, height) = (info.width as usize, info.height as usize);
    let (color, bits) = (info.color_type, info.bit_depth);
    if (color, bits) != (ColorType::Grayscale, BitDepth::Sixteen) {
        let cause = format!("a depth image is 16-bit grey, this is {bits:?}-bit {color:?}");
        return Err(Error::field(path, "IHDR", cause));
    }
    let pixels = width
        .checked_mul(height)
        .filter(|&n| n > 0 && n <= PIXELS_MAX);
    let Some(pixels) = pixels.filter(|&n| n * 2 <= bytes.len().saturating_mul(DEFLATE_RATIO_MAX))
    else {
        let cause = format!("{width}x{height} pixels cannot be in {} bytes", bytes.len());
        return Err(Error::field(path, "IHDR", cause));
    };

    // Decode; samples are big-endian.
    decoder.set_limits(Limits {
        bytes: 4 * pixels + (1 << 20),
    });
    let mut reader = decoder
        .read_info()
        .map_err(|e| Error::parse(path, FORMAT, e))?;
    let size = reader.output_buffer_size().unwrap_or(0);
    if size != 2 * pixels {
        return Err(Error::field(
            path,
            "IHDR",
            format!("a frame of {size} bytes is not 16-bit"),
        ));
    }
    let mut raw = vec![0_u8; size];
    reader
        .next_frame(&mut raw)
        .map_err(|e| Error::parse(path, FORMAT, e))?;
    let units = raw.chunks_exact(2);
    let units = units.map(|b| u16::from_be_bytes([b[0], b[1]]));
    Ok(((width, height), units.collect()))
}

/// The depth image, in metres, of rows of pixels; `unit_m` is a unit of theirs where the options give none, and
/// `path` is for the messages.
///
/// Depths outside the sensor's range count as not measured.
///
/// # Errors
/// [`Error::File`] for depths in another unit or without intrinsics; [`Error::Config`].
pub(super) fn metric(
    path: &Path,
    (width, height): (usize, usize),
    units: impl Iterator<Item = f32>,
    unit_m: f64,
    sensor: &Sensor,
    options: &SensorOptions,
) -> Result<DepthImage, Error> {
    let scale = options.depth_scale_m.unwrap_or(unit_m);
    within(
        "depth_scale_m",
        scale,
        1e-9,
        1.0,
        "must be in (0, 1] metres per unit",
    )?;
    let (near, far) = (sensor.range_m.0 as f32, sensor.range_m.1 as f32);
    let mut z_m: Vec<f32> = units.map(|unit| unit * scale as f32).collect();
    check_unit(path, &z_m, sensor, scale)?;
    for z in z_m.iter_mut().filter(|z| !(near..=far).contains(*z)) {
        *z = 0.0;
    }

    // The pinhole: the caller's, else the sensor's for this size.
    let intrinsics = options
        .intrinsics
        .or_else(|| sensor.intrinsics_for(width, height))
        .ok_or_else(|| {
            let what = format!("no intrinsics for {width}x{height} pixels");
            let of_size = SENSORS
                .iter()
                .filter(|s| s.intrinsics_for(width, height).is_some());
            let names: Vec<&str> = of_size.map(|sensor| sensor.name).collect();
            let other = match names[..] {
                [] => String::new(),
                _ => format!(" (those of {} are of this size)", names.join(", ")),
            };
            let cause = format!(
                "sensor {:?} has {what}; name the sensor{other}, or give fx, fy, cx, cy",
                sensor.name
            );
            Error::file(path, cause)
        })?;
    let k = intrinsics;
    for (key, focal) in [("fx", k.fx), ("fy", k.fy)] {
        within(key, focal, 1.0, 1e6, "must be a focal length in pixels")?;
    }
    within("cx", k.cx, -1e6, 1e6, "must be a pixel column")?;
    within("cy", k.cy, -1e6, 1e6, "must be a pixel row")?;
    Ok(DepthImage {
        width,
        height,
        z_m,
        intrinsics,
    })
}
