//! Depth images as ROS sends them: bare, or packed by `compressed_depth_image_transport`.

use std::path::Path;

use super::messages::{CameraInfo, CompressedImage, Image};
use crate::Error;
use crate::readers::depth_png;
use crate::scan::DepthImage;
use crate::sensor::Intrinsics;

/// Bytes before the PNG of a compressedDepth: the format's number and the two of the quantisation.
const CONFIG_BYTES: usize = 12;
/// Depths of images of whole numbers, m (REP 118).
const MILLIMETRE: f64 = 0.001;

/// Pixels row by row, and metres a unit.
pub(super) struct Depths {
    pub size: (usize, usize),
    pub units: Vec<f32>,
    pub scale_m: f64,
}

/// The depths of a bare image.
pub(super) fn bare(path: &Path, image: &Image<'_>) -> Result<Depths, Error> {
    let (width, height, step) = (
        image.width as usize,
        image.height as usize,
        image.step as usize,
    );
    let (bytes, scale_m) = match image.encoding.as_str() {
        "16UC1" | "mono16" => (2, MILLIMETRE),
        "32FC1" => (4, 1.0),
        other => {
            let cause = format!("{other:?} is none of depths: 16UC1, mono16 and 32FC1 are");
            return Err(Error::field(path, "encoding", cause));
        }
    };
    let row = width
        .checked_mul(bytes)
        .filter(|row| *row > 0 && *row <= step);
    let total = step
        .checked_mul(height)
        .filter(|total| *total > 0 && *total <= image.data.len());
    let (Some(row), Some(total)) = (row, total) else {
        let there = image.data.len();
        let cause =
            format!("{width}x{height} pixels in rows of {step} bytes are not {there} bytes");
        return Err(Error::field(path, "data", cause));
    };
    let big = image.is_bigendian != 0;
    let unit = |b: &[u8]| match *b {
        [a, b] if big => f32::from(u16::from_be_bytes([a, b])),
        [a, b] => f32::from(u16::from_le_bytes([a, b])),
        [a, b, c, d] if big => f32::from_be_bytes([a, b, c, d]),
        [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
        _ => 0.0,
    };
    let rows = image.data[..total].chunks_exact(step);
    let units = rows.flat_map(|bytes_of| bytes_of[..row].chunks_exact(bytes).map(unit));
    Ok(Depths {
        size: (width, height),
        units: units.collect(),
        scale_m,
    })
}

/// The depths of a packed image: a PNG of depths, or where they were fractions of quantised inverse depths q,
/// z = a/(q − b).
pub(super) fn packed(path: &Path, image: &CompressedImage<'_>) -> Result<Depths, Error> {
    let fail = |cause: String| Err(Error::field(path, "format", cause));
    let format = image.format.as_str();
    if !format.contains("compressedDepth") || format.contains("rvl") {
        return fail(format!(
            "{format:?} is not read: a compressedDepth of PNG is"
        ));
    }
    let Some((config, png)) = image.data.split_at_checked(CONFIG_BYTES) else {
        return fail(format!("{} bytes are no compressedDepth", image.data.len()));
    };
    let (size, units) = depth_png::decode(path, png)?;
    let units = units.into_iter().map(f32::from);
    if !format.starts_with("32FC1") {
        return Ok(Depths {
            size,
            units: units.collect(),
            scale_m: MILLIMETRE,
        });
    }
    let number = |at: usize| {
        config[at..]
            .first_chunk()
            .map_or(f32::NAN, |b| f32::from_le_bytes(*b))
    };
    let (a, b) = (number(4), number(8));
    if !a.is_finite() || !b.is_finite() || a <= 0.0 {
        return fail(format!("inverse depths cannot be quantised by {a} and {b}"));
    }
    let metres = units.map(|q| if q > 0.0 { a / (q - b) } else { 0.0 });
    Ok(Depths {
        size,
        units: metres.collect(),
        scale_m: 1.0,
    })
}

/// The pinhole of an image of this topic, and the distortion that its pixels still have.
///
/// Images called rectified have the projection P; all others K and the lens.
///
/// # Errors
/// [`Error::File`] of a CameraInfo of another size, not calibrated, or of a lens that is not known.
pub(super) fn pinhole(
    path: &Path,
    topic: &str,
    info: &CameraInfo,
    size: (usize, usize),
) -> Result<(Intrinsics, Option<Lens>), Error> {
    let fail = |cause: String| Err(Error::field(path, "CameraInfo", cause));
    if (info.width as usize, info.height as usize) != size {
        let cause = format!(
            "is of {}x{} pixels, the image of {}x{}",
            info.width, info.height, size.0, size.1
        );
        return fail(cause);
    }
    let rectified = topic.contains("rect") && info.p[0] > 0.0;
    let [fx, cx, fy, cy] = match rectified {
        true => [info.p[0], info.p[2], info.p[5], info.p[6]],
        false => [info.k[0], info.k[2], info.k[4], info.k[5]],
    };
    let lengths = [fx, fy].iter().all(|f| (1.0..=1e6).contains(f));
    if !lengths || ![cx, cy].iter().all(|c| (-1e6..=1e6).contains(c)) {
        return fail(format!(
            "fx {fx}, fy {fy}, cx {cx}, cy {cy} are of no calibrated camera"
        ));
    }
    let k = Intrinsics { fx, fy, cx, cy };
    if rectified || info.d.iter().all(|d| *d == 0.0) {
        return Ok((k, None));
    }
    let mut d = [0.0; 8];
    let lens = match (info.distortion_model.as_str(), info.d.len()) {
        ("plumb_bob" | "rational_polynomial", 4 | 5 | 8) => {
            d[..info.d.len()].copy_from_slice(&info.d);
            Lens::Polynomial(d)
        }
        ("equidistant", 4) => {
            d[..4].copy_from_slice(&info.d);
            Lens::Equidistant(d)
        }
        (model, n) => {
            return fail(format!(
                "the lens {model:?} of {n} numbers is not known; rectify the images, or give the intrinsics"
            ));
        }
    };
    Ok((k, Some(lens)))
}

/// Where a lens puts what a pinhole would see, as OpenCV has it.
pub(super) enum Lens {
    /// k₁, k₂, p₁, p₂, k₃, k₄, k₅, k₆.
    Polynomial([f64; 8]),
    /// k₁…k₄ of the angle to the axis.
    Equidistant([f64; 8]),
}

impl Lens {
    /// The place in the image plane at z = 1.
    fn bent(&self, x: f64, y: f64) -> (f64, f64) {
        let r2 = x * x + y * y;
        match self {
            Self::Polynomial([k1, k2, p1, p2, k3, k4, k5, k6]) => {
                let radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)))
                    / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
                (
                    x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                    y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
                )
            }
            Self::Equidistant([k1, k2, k3, k4, ..]) => {
                let r = r2.sqrt();
                let t = r.atan();
                let t2 = t * t;
                let bent = t * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
                let by = if r > 1e-9 { bent / r } else { 1.0 };
                (x * by, y * by)
            }
        }
    }

    /// The image that a pinhole would have seen, each pixel the nearest of the lens's: a depth is not the mean
    /// of those beside it where one thing ends before another.
    pub fn straighten(&self, image: &mut DepthImage) {
        let k = image.intrinsics;
        let (width, height) = (image.width, image.height);
        let source = |pixel: usize| {
            let (u, v) = ((pixel % width) as f64, (pixel / width) as f64);
            let (x, y) = self.bent((u - k.cx) / k.fx, (v - k.cy) / k.fy);
            let (u, v) = ((k.fx * x + k.cx).round(), (k.fy * y + k.cy).round());
            let inside = (0.0..width as f64).contains(&u) && (0.0..height as f64).contains(&v);
            match inside {
                true => image.z_m[v as usize * width + u as usize],
                false => 0.0,
            }
        };
        image.z_m = (0..width * height).map(source).collect();
    }
}
