//! E57 → the points of one of its scans in the scanner's frame, and its pose in the file's.

use std::io::Cursor;
use std::path::Path;

use e57::{CartesianCoordinate, E57Reader, PointCloud, RecordDataType, RecordName};
use nalgebra::Isometry3;
use surfaces::WORLD_M;

use super::stated_pose;
use crate::Error;

const FORMAT: &str = "E57";
pub(super) const MAGIC: &[u8] = b"ASTM-E57";
/// No scan has more fields a point; the reader holds a packet of all.
const FIELDS_MAX: usize = 32;

/// The points in V, m, and X_WV; of several scans the one of that name, or at that place from 0 on.
///
/// # Errors
/// [`Error::File`] with the list of scans where it is not clear which, and for a scan without coordinates or
/// pose, or what is not E57.
pub(super) fn parse(
    path: &Path,
    bytes: &[u8],
    wanted: Option<&str>,
) -> Result<(Vec<[f64; 3]>, Isometry3<f64>), Error> {
    let broken = |e: e57::Error| Error::parse(path, FORMAT, e);
    let mut file = E57Reader::new(Cursor::new(bytes)).map_err(broken)?;
    let scans = file.pointclouds();
    let name = |i: usize| scans[i].name.as_deref().unwrap_or_default();
    let chosen = match wanted {
        Some(wanted) => (0..scans.len()).find(|&i| name(i) == wanted || i.to_string() == wanted),
        None => (scans.len() == 1).then_some(0),
    };
    let Some(chosen) = chosen else {
        let listed = (0..scans.len().min(50)).map(|i| format!("{i} {:?}", name(i)));
        let listed: Vec<String> = listed.collect();
        let cause = format!(
            "it has {} scans; name one of them as topic: {}",
            scans.len(),
            listed.join(", ")
        );
        return Err(Error::field(path, "data3D", cause));
    };
    let scan = &scans[chosen];
    check(path, scan, bytes.len())?;
    let X_WV = pose(path, scan)?;
    let mut points = file.pointcloud_simple(scan).map_err(broken)?;
    points.apply_pose(false);
    let mut read = Vec::new();
    for point in points {
        read.push(match point.map_err(broken)?.cartesian {
            CartesianCoordinate::Valid { x, y, z } => [x, y, z],
            _ => [f64::NAN; 3],
        });
    }
    Ok((read, X_WV))
}

/// That every point takes bytes of the file, so that no more are promised than there are.
fn check(path: &Path, scan: &PointCloud, there: usize) -> Result<(), Error> {
    let takes = |name: RecordName| {
        let mut fields = scan.prototype.iter().filter(|field| field.name == name);
        fields.any(|field| match field.data_type {
            RecordDataType::Single { .. } | RecordDataType::Double { .. } => true,
            RecordDataType::ScaledInteger { min, max, .. }
            | RecordDataType::Integer { min, max } => min < max,
        })
    };
    use RecordName::{CartesianX, CartesianY, CartesianZ, SphericalRange};
    let measured = [CartesianX, CartesianY, CartesianZ, SphericalRange].map(takes);
    if !measured.contains(&true) || scan.prototype.len() > FIELDS_MAX {
        let cause = format!(
            "{} fields without coordinates that vary",
            scan.prototype.len()
        );
        return Err(Error::field(path, "prototype", cause));
    }
    if scan.records > 8 * there as u64 {
        let cause = format!("{} points cannot be in {there} bytes", scan.records);
        return Err(Error::field(path, "points", cause));
    }
    Ok(())
}

fn pose(path: &Path, scan: &PointCloud) -> Result<Isometry3<f64>, Error> {
    let Some(pose) = &scan.transform else {
        return Ok(Isometry3::identity());
    };
    let (r, t) = (&pose.rotation, &pose.translation);
    let stated = stated_pose([t.x, t.y, t.z], [r.x, r.y, r.z, r.w]);
    stated.ok_or_else(|| {
        let cause = format!("is not a position within {WORLD_M} m and a unit quaternion");
        Error::field(path, "pose", cause)
    })
}
