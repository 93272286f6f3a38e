//! Fitted planes → ground and slopes as they are described, with what is known of them.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use super::calibration::LidarCalibration;
use super::config::LidarConfig;
use super::description::Description;
use super::edges;
use super::field::Field;
use super::plane::Plane;
use super::refine::{CLEAR_M, Refined, meet};
use super::scan::{Ground, Slope};

/// Covariance of (rotation about x_W, about y_W, height) of the calibrated ground.
pub(super) fn ground_covariance(calibration: &LidarCalibration) -> Matrix3<f64> {
    let rows = [0, 1, 3];
    Matrix3::from_fn(|i, j| calibration.covariance[rows[i]][rows[j]])
}

pub(super) fn ground_of(
    fitted: &Option<Refined>,
    plane_V: Plane,
    seen: bool,
    X_WV: &Isometry3<f64>,
    known: Matrix3<f64>,
) -> Ground {
    let mut ground = Ground {
        plane_V,
        seen,
        rms_m: 0.0,
        covariance: known,
        centre_W: Point3::origin(),
        members: Vec::new(),
    };
    if let Some(fitted) = fitted.as_ref().filter(|f| f.first_slope == 1) {
        let (fit, n) = (&fitted.fit, plane_V.normal);
        // A tilt θ₁ along t₁ is a rotation by θ₁ about n × t₁.
        let [a, b] = fit.tangents[0].map(|t| X_WV * n.cross(&t));
        let turn = Matrix3::new(a.x, b.x, 0.0, a.y, b.y, 0.0, 0.0, 0.0, -1.0);
        let block = fit.covariance.fixed_view::<3, 3>(0, 0);
        ground.covariance = turn * block * turn.transpose();
        ground.rms_m = fit.rms_m[0];
        ground.centre_W = X_WV * Point3::from(fit.centres[0]);
        ground.members.clone_from(&fitted.ground);
    }
    ground
}

/// The description of slope `k` and its uncertainty; `None` where slope and ground do not meet.
pub(super) fn described(
    field: &Field,
    fitted: &Refined,
    k: usize,
    ground: &Plane,
    X_WV: &Isometry3<f64>,
    known: &Matrix3<f64>,
    config: &LidarConfig,
) -> Option<Slope> {
    let fit = &fitted.fit;
    let at = fitted.first_slope + k;
    let plane = fit.planes[at];
    let (n_s, n_g) = (plane.normal, ground.normal);
    // Eqs. 11 and 14: l along the intersection, ψ uphill.
    let l = n_s.cross(&n_g).try_normalize(1e-6)?;
    let psi = l.cross(&n_s);
    let ahead = l.cross(&n_g);
    let delta = n_s.dot(&n_g).clamp(-1.0, 1.0).acos();
    let inclinations = config.inclination_min_rad..=config.inclination_max_rad;
    if !inclinations.contains(&delta) {
        return None;
    }
    // Ground beside the slope lies in its plane as well, near the line.
    let clear: Vec<u32> = (fitted.members[k].iter().copied())
        .filter(|&i| ground.distance(&field.point(i as usize)).abs() > CLEAR_M)
        .collect();
    let origin = meet(ground, &plane, &Vector3::zeros())?;
    let edges = edges::along(field, &clear, &l, &plane, ground, &origin)?;
    let ends = edges.ends.map(|end| origin + l * (end.at - origin.dot(&l)));

    // Derivatives by the planes' errors (θ₁, θ₂, δ).
    let [s1, s2] = fit.tangents[at];
    let ground_frame = (fitted.first_slope == 1).then(|| (fit.tangents[0], fit.centres[0]));
    // A calibrated ground's errors are rotations about x_W and y_W, and the height.
    let R_VW = X_WV.rotation.inverse();
    let ([g1, g2], g_centre, sign) = match ground_frame {
        Some((tangents, centre)) => (tangents, centre, 1.0),
        None => (
            [R_VW * -Vector3::y(), R_VW * Vector3::x()],
            X_WV.inverse_transform_point(&Point3::origin()).coords,
            -1.0,
        ),
    };
    let delta_variance = fitted.variance(
        k,
        &[ahead.dot(&g1), ahead.dot(&g2), 0.0],
        &[-psi.dot(&s1), -psi.dot(&s2), 0.0],
        known,
    );
    // Across the line the intersection moves by (e_s − e_g cos δ)/sin δ.
    let across = ends.map(|q| {
        let (ds, dg) = (q - fit.centres[at], q - g_centre);
        let by_slope = [s1.dot(&ds), s2.dot(&ds), 1.0].map(|v| v / delta.sin());
        let by_ground = [g1.dot(&dg), g2.dot(&dg), sign].map(|v| -v * delta.cos() / delta.sin());
        fitted.variance(k, &by_ground, &by_slope, known).sqrt()
    });
    // Edges are seen up the slope, so that an error of l turns them about the start line.
    let turned = fitted.variance(
        k,
        &[g1, g2, Vector3::zeros()].map(|g| -l.dot(&g) * delta.cos() / delta.sin()),
        &[s1, s2, Vector3::zeros()].map(|s| l.dot(&s) / delta.sin()),
        known,
    );
    let along = edges.ends.map(|end| {
        let arm = ahead.dot(&(end.middle - origin));
        (end.sigma.powi(2) + arm * arm * turned).sqrt()
    });
    let [p1_W, p2_W] = ends.map(|q| X_WV * Point3::from(q));
    let block = fit
        .covariance
        .fixed_view::<3, 3>(3 * at, 3 * at)
        .into_owned();
    Some(Slope {
        description: Description {
            p1_W,
            p2_W,
            l_W: X_WV * l,
            psi_W: X_WV * psi,
            normal_W: X_WV * n_s,
            delta_rad: delta,
        },
        delta_sigma_rad: delta_variance.sqrt(),
        across_sigma_m: across,
        along_sigma_m: along,
        hidden: edges.ends.map(|end| end.hidden),
        plane_V: plane,
        covariance: block,
        centre_V: fit.centres[at],
        tangents_V: fit.tangents[at],
        rms_m: fit.rms_m[at],
        members: fitted.members[k].clone(),
    })
}
