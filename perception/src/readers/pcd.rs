//! PCD (ascii, binary, binary_compressed; organised or not) → points and viewpoint, and the ring,
//! azimuth and time of a LiDAR's points.

use std::io::BufRead;
use std::path::Path;

use nalgebra::Isometry3;
use pcd_rs::{DataKind, FieldDef, PcdDeserialize, PcdMeta, Reader, Schema, ValueKind};
use surfaces::WORLD_M;

use super::{stated_pose, tidy};
use crate::Error;
use crate::lidar::LidarCloud;
use crate::scan::PointCloud;

const FORMAT: &str = "PCD";
/// A longer record is a lie: real ones have some tens of bytes.
const RECORD_BYTES_MAX: u64 = 1 << 16;
/// LZF expands by at most this factor (264 bytes from 3).
const LZF_RATIO_MAX: u64 = 88;

/// The points in V and the pose X_WV that VIEWPOINT states.
///
/// # Errors
/// [`Error::File`] naming the header field that contradicts another one or the file's length,
/// and for anything else that is not PCD.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<(PointCloud, Isometry3<f64>), Error> {
    let (meta, organised, records) = records(path, bytes)?;
    let points = records.into_iter().map(|record| record.xyz).collect();
    Ok((tidy(points, organised), viewpoint(path, &meta)?))
}

/// The points of a LiDAR with the fields that drivers write: `ring` (or `channel`, `laser_id`),
/// `azimuth`, and `time` (or `t`, `timestamp`, `time_stamp`).
///
/// Azimuths are taken in degrees where one is beyond ±2π, else in radians, and clockwise where that
/// agrees better with the points; those that agree with neither are computed. Times stay in the
/// file's unit where it is seconds (a float) and are nanoseconds else.
///
/// # Errors
/// As [`parse`].
pub(super) fn parse_lidar(path: &Path, bytes: &[u8]) -> Result<LidarCloud, Error> {
    let (meta, _, mut records) = records(path, bytes)?;
    let has = |names: &[&str]| {
        let mut fields = meta.field_defs.iter();
        fields.find(|f| names.contains(&f.name.as_str()) && f.count == 1)
    };
    let time = has(&TIME);
    let unit = match time.map(|f| f.kind) {
        Some(ValueKind::F32 | ValueKind::F64) => 1.0,
        _ => 1e-9,
    };
    let first = records.iter().map(|r| r.time).fold(f64::INFINITY, f64::min);
    let azimuth = has(&[AZIMUTH]).and_then(|_| azimuth_unit(&records));
    let rings = has(&RING).is_some() && records.iter().all(|r| (0.0..256.0).contains(&r.ring));
    let mut cloud = LidarCloud::default();
    for record in records.drain(..) {
        let azimuth = azimuth
            .map(|unit| wrapped(unit * record.azimuth) as f32)
            .filter(|a| a.is_finite());
        cloud.push(
            record.xyz,
            rings.then_some(record.ring as u16),
            azimuth,
            time.map(|_| ((record.time - first) * unit) as f32),
        );
    }
    Ok(cloud)
}

/// Names of the fields.
const RING: [&str; 3] = ["ring", "channel", "laser_id"];
const AZIMUTH: &str = "azimuth";
const TIME: [&str; 4] = ["time", "t", "timestamp", "time_stamp"];

/// Radians, counter-clockwise, per unit of the azimuth field; `None` where it is no azimuth of the
/// points in their own frame.
fn azimuth_unit(records: &[Record]) -> Option<f64> {
    let largest = records
        .iter()
        .map(|r| r.azimuth.abs())
        .filter(|a| a.is_finite())
        .fold(0.0, f64::max);
    let scale = if largest > std::f64::consts::TAU + 1e-3 {
        std::f64::consts::PI / 180.0
    } else {
        1.0
    };
    let off = |unit: f64| {
        let (mut far, mut all) = (0_usize, 0_usize);
        for r in records.iter().filter(|r| r.azimuth.is_finite()) {
            let own = f64::from(r.xyz[1]).atan2(f64::from(r.xyz[0]));
            if own.is_finite() {
                all += 1;
                far += usize::from(wrapped(unit * r.azimuth - own).abs() > 0.02);
            }
        }
        far as f64 / all.max(1) as f64
    };
    [scale, -scale].into_iter().find(|unit| off(*unit) < 0.05)
}

/// An angle in −π…π.
fn wrapped(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn).round()
}

/// Width and height of an organised cloud.
type Grid = Option<(usize, usize)>;

/// The header, the grid of an organised cloud, and every point.
fn records(path: &Path, bytes: &[u8]) -> Result<(PcdMeta, Grid, Vec<Record>), Error> {
    let mut rest = bytes;
    let meta = PcdMeta::from_reader(&mut rest).map_err(|e| Error::parse(path, FORMAT, e))?;
    let organised = check(path, &meta, rest)?;
    // A viewpoint that is none is an error before the points are read.
    viewpoint(path, &meta)?;
    if meta.num_points == 0 {
        return Ok((meta, None, Vec::new()));
    }
    let reader =
        Reader::<Record, _>::from_reader(bytes).map_err(|e| Error::parse(path, FORMAT, e))?;
    let mut points = Vec::with_capacity(meta.num_points as usize);
    for record in reader {
        points.push(record.map_err(|e| Error::parse(path, FORMAT, e))?);
    }
    Ok((meta, organised, points))
}

/// Checks every size of the header against the others and against the data that follows it.
/// Returns the grid of an organised cloud.
fn check(path: &Path, meta: &PcdMeta, data: &[u8]) -> Result<Option<(usize, usize)>, Error> {
    let fail = |field: &str, cause: String| Err(Error::field(path, field, cause));
    for axis in ["x", "y", "z"] {
        match meta.field_defs.iter().find(|f| f.name == axis) {
            None => return fail("FIELDS", format!("has no {axis}")),
            Some(f) if f.count != 1 => return fail("COUNT", format!("{axis} occurs {}×", f.count)),
            Some(_) => {}
        }
    }
    let record = meta
        .field_defs
        .iter()
        .try_fold(0_u64, |sum, f| {
            sum.checked_add(f.count.checked_mul(f.kind.byte_size() as u64)?)
        })
        .filter(|&size| size <= RECORD_BYTES_MAX);
    let Some(record) = record else {
        return fail(
            "COUNT",
            format!("a point is longer than {RECORD_BYTES_MAX} bytes"),
        );
    };
    let n = meta.num_points;
    if meta.width.checked_mul(meta.height) != Some(n) {
        let cause = format!(
            "{n} is not WIDTH × HEIGHT = {} × {}",
            meta.width, meta.height
        );
        return fail("POINTS", cause);
    }
    let Some(total) = n.checked_mul(record) else {
        return fail("POINTS", format!("{n} points cannot be in any file"));
    };
    let there = data.len() as u64;
    match meta.data {
        DataKind::Binary if total > there => {
            return fail(
                "POINTS",
                format!("{n} points need {total} bytes, {there} follow"),
            );
        }
        // Each token of a line takes a digit and a separator (the last line may lack its end).
        DataKind::Ascii if n.saturating_mul(6) > there + 1 => {
            return fail(
                "POINTS",
                format!("{n} lines cannot be in the {there} bytes that follow"),
            );
        }
        DataKind::BinaryCompressed => {
            let size = |at: usize| {
                let word = data.get(at..at + 4)?.try_into().ok()?;
                Some(u64::from(u32::from_le_bytes(word)))
            };
            let (Some(packed), Some(unpacked)) = (size(0), size(4)) else {
                return fail(
                    "DATA",
                    "ends before the sizes of the compressed block".to_owned(),
                );
            };
            if packed + 8 > there {
                let cause = format!("{packed} compressed bytes stated, {} follow", there - 8);
                return fail("DATA", cause);
            }
            if unpacked != total || unpacked > packed.saturating_mul(LZF_RATIO_MAX) {
                let cause = format!("{packed} bytes unpack to {unpacked}, {n} points are {total}");
                return fail("DATA", cause);
            }
        }
        _ => {}
    }
    let (width, height) = (meta.width as usize, meta.height as usize);
    Ok((height > 1 && width > 1).then_some((width, height)))
}

/// VIEWPOINT as X_WV.
fn viewpoint(path: &Path, meta: &PcdMeta) -> Result<Isometry3<f64>, Error> {
    let v = &meta.viewpoint;
    let pose = stated_pose([v.tx, v.ty, v.tz], [v.qx, v.qy, v.qz, v.qw]);
    pose.ok_or_else(|| {
        let cause =
            format!("{v:?} is not a position within {WORLD_M} m and a unit quaternion (w x y z)");
        Error::field(path, "VIEWPOINT", cause)
    })
}

/// What is used of one point; the other fields are skipped without being stored.
#[derive(Clone, Copy)]
struct Record {
    xyz: [f32; 3],
    ring: f64,
    azimuth: f64,
    time: f64,
}

impl Record {
    const EMPTY: Self = Self {
        xyz: [f32::NAN; 3],
        ring: f64::NAN,
        azimuth: f64::NAN,
        time: f64::NAN,
    };

    fn set(&mut self, field: &FieldDef, value: f64) {
        match field.name.as_str() {
            "x" => self.xyz[0] = value as f32,
            "y" => self.xyz[1] = value as f32,
            "z" => self.xyz[2] = value as f32,
            AZIMUTH => self.azimuth = value,
            name if RING.contains(&name) => self.ring = value,
            name if TIME.contains(&name) => self.time = value,
            _ => {}
        }
    }

    /// Whether a field's text is looked at.
    fn reads(name: &str) -> bool {
        matches!(name, "x" | "y" | "z" | AZIMUTH) || RING.contains(&name) || TIME.contains(&name)
    }
}

impl PcdDeserialize for Record {
    fn is_dynamic() -> bool {
        true
    }

    fn read_spec() -> Vec<(Option<String>, ValueKind, Option<usize>)> {
        Vec::new()
    }

    fn read_chunk<R: BufRead>(reader: &mut R, fields: &Schema) -> pcd_rs::Result<Self> {
        let mut point = Self::EMPTY;
        for field in fields.iter() {
            let size = field.kind.byte_size();
            for _ in 0..field.count {
                let mut word = [0_u8; 8];
                reader.read_exact(&mut word[..size])?;
                point.set(field, value(field.kind, word));
            }
        }
        Ok(point)
    }

    fn read_line<R: BufRead>(reader: &mut R, fields: &Schema) -> pcd_rs::Result<Self> {
        let mut line = String::new();
        reader.read_line(&mut line)?;
        let mut point = Self::EMPTY;
        let mut tokens = line.split_ascii_whitespace();
        for field in fields.iter() {
            for _ in 0..field.count {
                let token = tokens
                    .next()
                    .ok_or_else(|| pcd_rs::Error::InvalidArgumentError {
                        desc: format!("a point ends before its {}: {line:?}", field.name),
                    })?;
                if Self::reads(&field.name) {
                    point.set(field, token.parse()?);
                }
            }
        }
        Ok(point)
    }
}

/// A little-endian word as a number.
fn value(kind: ValueKind, w: [u8; 8]) -> f64 {
    let [a, b, c, d, ..] = w;
    match kind {
        ValueKind::U8 => f64::from(a),
        ValueKind::I8 => f64::from(a as i8),
        ValueKind::U16 => f64::from(u16::from_le_bytes([a, b])),
        ValueKind::I16 => f64::from(i16::from_le_bytes([a, b])),
        ValueKind::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
        ValueKind::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
        ValueKind::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        ValueKind::U64 => u64::from_le_bytes(w) as f64,
        ValueKind::I64 => i64::from_le_bytes(w) as f64,
        ValueKind::F64 => f64::from_le_bytes(w),
    }
}
