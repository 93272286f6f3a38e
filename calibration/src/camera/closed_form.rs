//! The start of the refinement: rotation and position one after the other.

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::PlanePair;
use crate::{Error, nearest_rotation};

/// The mount with unweighted directions and distances.
///
///   R_RV = argmin Σ ‖n_R − R n_V‖²,      p_RV = argmin Σ (n_R · p + h − d)²
///
/// # Errors
/// [`Error::Collinear`] when the normals do not determine them; poses that pass
/// [`Observability`](super::Observability) do.
/// Source: \[chai2015\] Eq. 31, of which these are the two halves.
pub fn closed_form(pairs: &[PlanePair]) -> Result<Isometry3<f64>, Error> {
    let what = "normals of the ground";
    let normals = pairs.iter();
    let normals = normals.map(|pair| (&*pair.sensor.normal, &*pair.robot.normal));
    let R_RV = nearest_rotation(normals, what)?;
    let mut A = Matrix3::zeros();
    let mut b = Vector3::zeros();
    for pair in pairs {
        let n = &pair.robot.normal;
        A += n.into_inner() * n.transpose();
        b += n.into_inner() * (pair.sensor.distance_m - pair.robot.distance_m);
    }
    let p_RV = A.cholesky().map(|cholesky| cholesky.solve(&b));
    let p_RV = p_RV.filter(|p| p.iter().all(|x| x.is_finite()));
    let p_RV = p_RV.ok_or(Error::Collinear { what })?;
    Ok(Isometry3::from_parts(p_RV.into(), R_RV))
}
