//! Files beside the images of data sets: trajectories (TUM RGB-D, Open3D) and a pinhole camera (Open3D).

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use nalgebra::{Isometry3, Matrix3, Matrix4, Quaternion, Rotation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use surfaces::beyond_world;

use crate::provenance::Inputs;

/// A pose of a trajectory may be taken from this long before its first and after its last, and between two that
/// are not farther apart, s: about three frames.
const GAP_S: f64 = 0.1;
/// How far written decimals may leave a rotation from being one.
const ROTATION_TOLERANCE: f64 = 1e-3;

/// The pose of an optical frame by `FILE@TIME` (TUM: a line `time tx ty tz qx qy qz qw`, interpolated) or, for a
/// file that ends in `.log`, `FILE@NUMBER` (Open3D: a line of numbers, the first of them this, then a 4×4 matrix).
///
/// # Errors
/// A file that cannot be read or is no trajectory, with the line; a time or number of which it knows nothing.
pub fn pose(file: &Path, key: &str, inputs: &mut Inputs) -> Result<Isometry3<f64>> {
    let text = inputs.text("trajectory", file)?;
    let is_log = (file.extension()).is_some_and(|end| end.eq_ignore_ascii_case("log"));
    let found = match is_log {
        true => logged(&text, key),
        false => timed(&text, key),
    };
    found.with_context(|| file.display().to_string())
}

/// The lines that say something, with their numbers from 1 on.
fn lines(text: &str) -> impl Iterator<Item = (usize, Result<Vec<f64>>)> {
    let lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim()));
    let said = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    said.map(|(number, line)| {
        let values = line.split([' ', '\t', ',']).filter(|word| !word.is_empty());
        let values = values.map(|word| word.parse::<f64>().ok().filter(|v| v.is_finite()));
        let values: Option<Vec<f64>> = values.collect();
        (
            number,
            values.with_context(|| format!("line {number}: is no list of numbers")),
        )
    })
}

fn timed(text: &str, key: &str) -> Result<Isometry3<f64>> {
    let at_s: f64 = key.parse().with_context(|| format!("{key:?} is no time"))?;
    // The poses next to the time, before and after it.
    let (mut before, mut after) = (None::<(f64, _)>, None::<(f64, _)>);
    for (number, values) in lines(text) {
        let values = values?;
        let [t, x, y, z, qx, qy, qz, qw] = values[..] else {
            let given = values.len();
            bail!("line {number}: {given} numbers, not time tx ty tz qx qy qz qw");
        };
        let pose = rigid([x, y, z], Quaternion::new(qw, qx, qy, qz));
        let pose = pose.with_context(|| format!("line {number}"))?;
        if t <= at_s && before.is_none_or(|(other, _)| t >= other) {
            before = Some((t, pose));
        } else if t > at_s && after.is_none_or(|(other, _)| t < other) {
            after = Some((t, pose));
        }
    }
    match (before, after) {
        (Some((t0, pose)), Some((t1, next))) if t1 - t0 <= GAP_S => {
            let slerp = pose.try_lerp_slerp(&next, (at_s - t0) / (t1 - t0), 1e-9);
            Ok(slerp.unwrap_or(pose))
        }
        (Some((t, pose)), _) | (_, Some((t, pose))) if (t - at_s).abs() <= GAP_S / 2.0 => Ok(pose),
        (None, None) => bail!("has no pose"),
        (before, after) => {
            let next = [before, after].map(|p| p.map_or("none".to_owned(), |(t, _)| t.to_string()));
            bail!(
                "has no pose at {at_s}: the one before is {}, after {}",
                next[0],
                next[1]
            )
        }
    }
}

fn logged(text: &str, key: &str) -> Result<Isometry3<f64>> {
    let wanted: usize = key
        .parse()
        .with_context(|| format!("{key:?} is no number"))?;
    let mut lines = lines(text);
    let mut numbers = Vec::new();
    while let Some((number, head)) = lines.next() {
        let id = head?.first().copied().unwrap_or(-1.0);
        let rows: Vec<Vec<f64>> = lines
            .by_ref()
            .take(4)
            .map(|(_, row)| row)
            .collect::<Result<_>>()?;
        let whole = rows.len() == 4 && rows.iter().all(|row| row.len() == 4);
        ensure!(
            whole,
            "line {number}: is not followed by four rows of four numbers"
        );
        if id == wanted as f64 {
            let T = Matrix4::from_row_iterator(rows.into_iter().flatten());
            return matrix(&T).with_context(|| format!("line {number}"));
        }
        numbers.push(id);
    }
    let (first, last) = (numbers.first(), numbers.last());
    bail!(
        "has no pose {wanted}: {} poses from {first:?} to {last:?}",
        numbers.len()
    )
}

/// A pose by its position, m, and a quaternion of length 1.
///
/// # Errors
/// Another length; a position beyond the world.
pub fn rigid(position: [f64; 3], rotation: Quaternion<f64>) -> Result<Isometry3<f64>> {
    let length = rotation.norm();
    let is_one = (length - 1.0).abs() <= ROTATION_TOLERANCE;
    ensure!(is_one, "the quaternion has length {length}, not 1");
    ensure!(
        beyond_world(&position).is_none(),
        "{position:?} is beyond the world"
    );
    let rotation = UnitQuaternion::new_normalize(rotation);
    Ok(Isometry3::from_parts(
        Vector3::from(position).into(),
        rotation,
    ))
}

fn matrix(T: &Matrix4<f64>) -> Result<Isometry3<f64>> {
    let R: Matrix3<f64> = T.fixed_view::<3, 3>(0, 0).into();
    let off = (R * R.transpose() - Matrix3::identity()).abs().max();
    let last = T.row(3) - Matrix4::identity().row(3);
    let is_one = off <= ROTATION_TOLERANCE && R.determinant() > 0.0 && last.abs().max() < 1e-9;
    ensure!(is_one, "the matrix is no pose");
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&R));
    rigid([T[(0, 3)], T[(1, 3)], T[(2, 3)]], rotation.into_inner())
}

/// Open3D's `PinholeCameraIntrinsic`, or the part of `PinholeCameraParameters` that is one.
#[derive(Deserialize)]
#[serde(untagged)]
enum Camera {
    Parameters { intrinsic: Pinhole },
    Intrinsic(Pinhole),
}

#[derive(Deserialize)]
struct Pinhole {
    /// Column by column.
    intrinsic_matrix: [f64; 9],
}

/// fx, fy, cx, cy of a file of Open3D's intrinsics (JSON, its matrix column by column), px.
///
/// # Errors
/// A file that cannot be read or holds no such matrix, with its name; a focal length that is not positive.
pub fn pinhole(path: &Path, inputs: &mut Inputs) -> Result<[f64; 4]> {
    let text = inputs.text("intrinsics", path)?;
    let file = path.display();
    let what = || format!("{file}: no intrinsics of Open3D (width, height, intrinsic_matrix)");
    let (Camera::Parameters { intrinsic } | Camera::Intrinsic(intrinsic)) =
        serde_json::from_str(&text).with_context(what)?;
    let [fx, zero0, zero1, skew, fy, zero2, cx, cy, one] = intrinsic.intrinsic_matrix;
    let is_one = [zero0, zero1, skew, zero2] == [0.0; 4] && one == 1.0;
    ensure!(
        is_one,
        "{file}: intrinsic_matrix: is not fx 0 0, 0 fy 0, cx cy 1, column by column"
    );
    ensure!(
        fx > 0.0 && fy > 0.0,
        "{file}: focal lengths must be positive"
    );
    Ok([fx, fy, cx, cy])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tum_poses_are_interpolated_and_gaps_refused() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let text = format!(
            "# time\n10.00 0 0 1 0 0 0 1\n10.02 2 0 1 0 0 {half} {half}\n11 0 0 0 0 0 0 1\n"
        );
        let middle = timed(&text, "10.01").unwrap();
        assert!((middle.translation.vector - Vector3::new(1.0, 0.0, 1.0)).norm() < 1e-9);
        assert!((middle.rotation.angle() - std::f64::consts::FRAC_PI_4).abs() < 1e-9);
        assert_eq!(timed(&text, "11").unwrap().translation.vector.z, 0.0);
        for (key, said) in [
            ("10.5", "no pose at 10.5: the one before is 10.02, after 11"),
            ("x", "no time"),
        ] {
            assert!(
                format!("{:#}", timed(&text, key).unwrap_err()).contains(said),
                "{key}"
            );
        }
        for (line, said) in [
            ("1 2 3", "line 1: 3 numbers"),
            ("1 0 0 0 0 0 0 2", "length 2"),
            ("a", "line 1: is no"),
        ] {
            assert!(
                format!("{:#}", timed(line, "1").unwrap_err()).contains(said),
                "{line}"
            );
        }
    }

    #[test]
    fn open3d_poses_are_found_by_their_number() {
        let one = |i: usize| format!("{i} {i} {}\n0 -1 0 {i}\n1 0 0 2\n0 0 1 3\n0 0 0 1\n", i + 1);
        let text = one(0) + &one(1);
        let pose = logged(&text, "1").unwrap();
        let moved = pose * nalgebra::Point3::new(1.0, 0.0, 0.0);
        assert!((moved - nalgebra::Point3::new(1.0, 3.0, 3.0)).norm() < 1e-9);
        for (text, key, said) in [
            (text.as_str(), "7", "no pose 7: 2 poses"),
            ("0 0 1\n1 0 0 0\n0 1 0 0", "0", "line 1: is not followed"),
            ("0 0 1\n2 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1", "0", "no pose"),
        ] {
            assert!(
                format!("{:#}", logged(text, key).unwrap_err()).contains(said),
                "{said}"
            );
        }
    }
}
