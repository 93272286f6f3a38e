//! The robot's pose from its distances to three feet.

use nalgebra::{Isometry3, Point3};

use crate::{Error, nearest_rotation};

/// The pose of R from three feet at known places.
///
///   ‖p_GR − f_G,i‖ = ‖f_R,i‖,   i = 1, 2, 3
///
/// Two points have these distances, mirror images in the plane of the feet; the body is the one
/// above the ground. The rotation is the nearest one that turns the f_R into the f_G − p_GR.
///
/// # Errors
/// [`Error::Feet`] where no point has these distances; [`Error::Collinear`].
/// Source: \[chai2015\] Eqs. 21–25; deviation: the matrix of Eq. 25 is not a rotation as soon as
/// there is noise.
pub fn trilateration(
    feet_R: &[Point3<f64>; 3],
    feet_G: &[Point3<f64>; 3],
) -> Result<Isometry3<f64>, Error> {
    let collinear = Error::Collinear { what: "feet" };
    let [a, b, c] = feet_G;
    let [ra, rb, rc] = feet_R.map(|foot| foot.coords.norm_squared());

    // Axes in the plane of the feet: x from a to b, c on the side of y.
    let (ab, ac) = (b - a, c - a);
    let x = ab.try_normalize(1e-9).ok_or(collinear)?;
    let across = ac - x * ac.dot(&x);
    let y = across.try_normalize(1e-9);
    let y = y.ok_or(Error::Collinear { what: "feet" })?;
    let up = x.cross(&y);
    let normal = if up.z < 0.0 { -up } else { up };

    // Differences of the three squared distances are linear in the place within the plane.
    let u = (ra - rb + ab.norm_squared()) / (2.0 * ab.norm());
    let v = (ra - rc + ac.norm_squared() - 2.0 * u * ac.dot(&x)) / (2.0 * across.norm());
    let height_squared = ra - u * u - v * v;
    let exists = height_squared > 0.0;
    if !exists {
        let [a, b, c] = [ra, rb, rc].map(f64::sqrt);
        let cause =
            format!("no point has the distances {a:.3}, {b:.3} and {c:.3} m to the three feet");
        return Err(Error::Feet { cause });
    }
    let p_GR = a.coords + x * u + y * v + normal * height_squared.sqrt();
    let arms_G = feet_G.map(|foot| foot.coords - p_GR);
    let pairs = feet_R.iter().map(|foot| &foot.coords).zip(&arms_G);
    let rotation = nearest_rotation(pairs, "feet")?;
    Ok(Isometry3::from_parts(p_GR.into(), rotation))
}
