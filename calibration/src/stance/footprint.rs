//! Where the feet stand on the ground, and the poses of all postures over it.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};

use super::foot_error_m;
use crate::{Error, register};

/// Rounds in which places and poses are made to agree; each gains a digit or more.
const ROUNDS: usize = 20;
/// A round that moves no foot farther than this is the last, m.
const MOVED_MIN: f64 = 1e-9;

/// Largest root mean square by which feet may miss their places, m: more is a foot that slipped, or
/// joints that are not the robot's.
const FOOT_ERROR_MAX_M: f64 = 0.02;

/// The feet's places in G and the robot's poses over it.
#[derive(Debug, Clone, PartialEq)]
pub struct Footprint {
    /// Places of the feet in G, each at its own height over the ground, m.
    pub feet_G: Vec<Point3<f64>>,
    /// Pose of R in G of every posture.
    pub X_GR: Vec<Isometry3<f64>>,
    /// Root mean square by which the feet of every posture miss their places, m.
    pub error_m: Vec<f64>,
}

/// Feet that stayed where they stood while the body moved → their places and the body's poses.
///
/// `postures` holds the feet's places in R, m, one list a posture; `heights_m` how high the tracked
/// point of every foot is over the ground (a ball's radius, 0 for a vertex of a sole). G lies below
/// R of the first posture, x_G over its x. Places and poses are found in turns, as in generalised
/// Procrustes analysis \[gower1975\], with the heights kept.
///
/// # Errors
/// [`Error::Feet`] naming the posture of which the feet do not fit the others'; [`Error::Collinear`].
pub fn footprint(postures: &[Vec<Point3<f64>>], heights_m: &[f64]) -> Result<Footprint, Error> {
    let first = postures.first().ok_or_else(|| Error::Feet {
        cause: "there is no posture".to_owned(),
    })?;
    for (i, feet) in postures.iter().enumerate() {
        if feet.len() != heights_m.len() || feet.len() < 3 {
            let cause = format!(
                "posture {}: {} points of feet, {} heights; three at least are needed, and as many",
                i + 1,
                feet.len(),
                heights_m.len()
            );
            return Err(Error::Feet { cause });
        }
    }
    // 1. The first posture by itself: the plane through its feet.
    let X_GR = over_plane(first, heights_m)?;
    let mut feet_G: Vec<Point3<f64>> = first
        .iter()
        .zip(heights_m)
        .map(|(foot, height)| {
            let p = X_GR * foot;
            Point3::new(p.x, p.y, *height)
        })
        .collect();
    let mut poses = Vec::new();
    for _ in 0..ROUNDS {
        // 2. Every posture against the places.
        poses = postures
            .iter()
            .enumerate()
            .map(|(i, feet)| {
                register(feet, &feet_G, "feet").map_err(|error| Error::Feet {
                    cause: format!("posture {}: {error}", i + 1),
                })
            })
            .collect::<Result<Vec<_>, _>>()?;
        // 3. Every place as the mean of where the postures put it, at its height. The frame G is
        //    held by the first posture's heading and centre, which the mean keeps to first order.
        let mut moved: f64 = 0.0;
        for (k, place) in feet_G.iter_mut().enumerate() {
            let sum: Vector3<f64> = poses
                .iter()
                .zip(postures)
                .map(|(X_GR, feet)| (X_GR * feet[k]).coords)
                .sum();
            let mean = sum / postures.len() as f64;
            moved = moved.max((mean.xy() - place.coords.xy()).norm());
            (place.x, place.y) = (mean.x, mean.y);
        }
        if moved < MOVED_MIN {
            break;
        }
    }
    let error_m: Vec<f64> = poses
        .iter()
        .zip(postures)
        .map(|(X_GR, feet)| foot_error_m(X_GR, feet, &feet_G))
        .collect();
    let misfit = |error: &f64| error.is_nan() || *error > FOOT_ERROR_MAX_M;
    if let Some(i) = error_m.iter().position(misfit) {
        let cause = format!(
            "posture {}: they miss their places by {:.1} mm (root mean square), more than {:.1} mm; \
             a foot has slipped or lifted, or the joints are not this robot's",
            i + 1,
            1e3 * error_m[i],
            1e3 * FOOT_ERROR_MAX_M
        );
        return Err(Error::Feet { cause });
    }
    Ok(Footprint {
        feet_G,
        X_GR: poses,
        error_m,
    })
}

/// The pose over z = 0 of a body of which the feet are at these heights: the plane that leaves the
/// least squares, the body above it.
fn over_plane(feet_R: &[Point3<f64>], heights_m: &[f64]) -> Result<Isometry3<f64>, Error> {
    // n·p + d = height: start from equal heights, then once more with the true ones.
    let n = feet_R.len() as f64;
    let mean: Vector3<f64> = feet_R.iter().map(|p| p.coords).sum::<Vector3<f64>>() / n;
    let mean_height = heights_m.iter().sum::<f64>() / n;
    let mut normal = Vector3::z();
    for _ in 0..3 {
        let on_ground = |(p, h): (&Point3<f64>, &f64)| p.coords - mean - normal * (h - mean_height);
        let scatter: Matrix3<f64> = feet_R
            .iter()
            .zip(heights_m)
            .map(on_ground)
            .map(|p| p * p.transpose())
            .sum();
        let eigen = scatter.symmetric_eigen();
        let mut values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
        values.sort_by(f64::total_cmp);
        let spans_a_plane = values[1] > 1e-9 * values[2];
        if !spans_a_plane {
            return Err(Error::Collinear { what: "feet" });
        }
        normal = eigen
            .eigenvectors
            .column(eigen.eigenvalues.imin())
            .into_owned();
        // The body is above its feet.
        if normal.dot(&mean) > 0.0 {
            normal = -normal;
        }
    }
    let x = (Vector3::x() - normal * normal.x)
        .try_normalize(1e-6)
        .ok_or_else(|| Error::Feet {
            cause: "the robot's x axis points at the ground".to_owned(),
        })?;
    // Rows are G's axes in R.
    let R_RG = UnitQuaternion::from_basis_unchecked(&[x, normal.cross(&x), normal]);
    let height = Translation3::new(0.0, 0.0, mean_height - normal.dot(&mean));
    Ok(Isometry3::from_parts(height, R_RG.inverse()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RADIUS: f64 = 0.03;

    fn feet_G() -> Vec<Point3<f64>> {
        (0..6)
            .map(|k| f64::from(30 + 60 * k).to_radians())
            .map(|at| Point3::new(0.78 * at.cos(), 0.78 * at.sin(), RADIUS))
            .collect()
    }

    fn pose(rpy_deg: [f64; 3], p: [f64; 3]) -> Isometry3<f64> {
        let [r, t, y] = rpy_deg.map(f64::to_radians);
        let rotation = UnitQuaternion::from_euler_angles(r, t, y);
        Isometry3::from_parts(Vector3::from(p).into(), rotation)
    }

    fn in_R(X_GR: &Isometry3<f64>) -> Vec<Point3<f64>> {
        feet_G().iter().map(|p| X_GR.inverse() * p).collect()
    }

    proptest! {
        #[test]
        fn unknown_places_are_found_with_the_poses(
            tilts in prop::collection::vec(prop::array::uniform3(-15.0f64..15.0), 2..6),
        ) {
            // The first posture sets the frame: its heading and place are zero.
            let mut poses = vec![pose([4.0, -7.0, 0.0], [0.0, 0.0, 0.68])];
            poses.extend(tilts.iter().map(|rpy| pose(*rpy, [0.02, -0.05, 0.7])));
            let feet: Vec<_> = poses.iter().map(in_R).collect();
            let found = footprint(&feet, &[RADIUS; 6]).unwrap();
            for (found, X_GR) in found.X_GR.iter().zip(&poses) {
                // Heading is a convention; tilt and height are not.
                let up = |X: &Isometry3<f64>| X.rotation.inverse() * Vector3::z();
                prop_assert!((up(found) - up(X_GR)).norm() < 1e-9);
                prop_assert!((found.translation.z - X_GR.translation.z).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_foot_that_slipped_is_named_by_its_posture() {
        let poses = [0.0, 5.0, 10.0].map(|roll| pose([roll, 2.0, 0.0], [0.0, 0.0, 0.68]));
        let mut feet: Vec<_> = poses.iter().map(in_R).collect();
        feet[2][4].x += 0.2;
        let error = footprint(&feet, &[RADIUS; 6]).unwrap_err();
        assert!(error.to_string().contains("posture"), "{error}");
        let two: Vec<_> = feet.iter().map(|f| f[..2].to_vec()).collect();
        assert!(footprint(&two, &[RADIUS; 2]).is_err());
    }
}
