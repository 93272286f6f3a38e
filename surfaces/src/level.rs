//! Treads, floors and tables are level where nothing speaks against it.
//!
//! A plane fitted to a small face seen at a flat angle may lean by degrees, and its covariance says
//! so; that most faces one can stand on are level says more. With the errors θ = (θ_x, θ_y, z) of
//! the plane and Σ their covariance, "level up to σ" is a measurement of the two tilts:
//!
//!   h = (−u_y, u_x),   H = [1 0 0; 0 1 0],   S = H Σ Hᵀ + σ² 1,   θ̂ = Σ Hᵀ S⁻¹ h
//!
//! with u the vertical in F. It is taken only where hᵀ S⁻¹ h stays within the gate: a ramp that is
//! seen well stays a ramp. The offset follows through Σ, so that faces of one plane, whose
//! covariances are that plane's, stay in it.
//! Source: the linear minimum-variance update of \[kalman1960\], with a χ² gate.

use crate::Face;
use nalgebra::{
    Isometry3, Matrix2, Matrix2x3, Matrix3, Translation3, UnitQuaternion, Vector2, Vector3,
};

/// Standard deviation of the tilt of what was built to be level, rad.
const SIGMA_RAD: f64 = 0.005;
/// Faces that lean by more than this many standard deviations are not level.
const GATE_SIGMAS: f64 = 2.5;
/// Faces that lean by more than this are not level however little is known of them, rad.
const TILT_MAX_RAD: f64 = 0.12;

/// Adds to a face's plane what "it is level" tells; unchanged where it is not consistent with that, has
/// no covariance, or faces down or sideways. Its views keep the plane in which they found the edges.
pub fn apply_level_prior(face: &mut Face) {
    if let Some(before) = face.plane_covariance
        && let Some((X, after)) = updated(&face.X_WF, &before)
    {
        face.X_WF *= X;
        face.plane_covariance = Some(after);
        for view in &mut face.views {
            view.plane_covariance.get_or_insert(before);
        }
    }
}

/// How the frame of a plane moves by what "it is level" tells, and the covariance afterwards.
fn updated(X_WF: &Isometry3<f64>, rows: &[[f64; 3]; 3]) -> Option<(Isometry3<f64>, [[f64; 3]; 3])> {
    let up_F = X_WF.rotation.inverse() * Vector3::z();
    if up_F.z < TILT_MAX_RAD.cos() {
        return None;
    }
    let covariance = Matrix3::from_fn(|i, j| rows[i][j]);
    let h = Vector2::new(-up_F.y, up_F.x);
    let observe = Matrix2x3::<f64>::identity();
    let spread =
        observe * covariance * observe.transpose() + Matrix2::identity() * SIGMA_RAD.powi(2);
    let inverse = spread.try_inverse()?;
    if h.dot(&(inverse * h)) > GATE_SIGMAS.powi(2) {
        return None;
    }
    let gain = covariance * observe.transpose() * inverse;
    let theta = gain * h;
    let left = (Matrix3::identity() - gain * observe) * covariance;
    let moved = Isometry3::from_parts(
        Translation3::new(0.0, 0.0, theta.z),
        UnitQuaternion::from_scaled_axis(Vector3::new(theta.x, theta.y, 0.0)),
    );
    Some((moved, crate::covariance::rows(&left)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EdgeView;

    fn tilted(tilt_rad: f64, sigma_rad: f64) -> Face {
        let turn =
            UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.8, 0.5).normalize() * tilt_rad);
        let pose = Isometry3::from_parts(Translation3::new(1.0, 2.0, 0.3), turn);
        let (t, z) = (sigma_rad * sigma_rad, 1e-5);
        Face {
            plane_covariance: Some([[t, 0.0, 0.0], [0.0, t, 0.0], [0.0, 0.0, z]]),
            ..Face::rectangle("f", pose, [0.4, 0.2]).unwrap()
        }
    }

    fn leveled(mut face: Face) -> Face {
        apply_level_prior(&mut face);
        face.validate().unwrap();
        face
    }

    fn tilt(face: &Face) -> f64 {
        face.normal_W().angle(&Vector3::z())
    }

    #[test]
    fn a_tread_that_leans_within_its_uncertainty_becomes_level() {
        let before = tilted(0.05, 0.045);
        let after = leveled(before.clone());
        assert!(tilt(&before) > 0.04);
        assert!(tilt(&after) < 0.002, "{}", tilt(&after));
        assert!(after.plane_covariance.unwrap()[0][0] < 1.1 * 0.005 * 0.005);
    }

    #[test]
    fn a_ramp_seen_well_stays_a_ramp_and_so_does_a_steep_one_seen_badly() {
        for face in [tilted(0.05, 0.01), tilted(0.3, 0.5), tilted(3.1, 0.5)] {
            assert_eq!(leveled(face.clone()), face);
        }
    }

    /// The plane moves, and its edges keep the error with which they were seen.
    #[test]
    fn the_prior_leaves_the_errors_of_edges_as_they_were() {
        let mut face = tilted(0.05, 0.045);
        face.views = vec![EdgeView {
            eye_W: face.X_WF * nalgebra::Point3::new(-2.0, 0.5, 2.0),
            sigma_rad: 0.0,
            plane_covariance: None,
        }];
        let edges = face.region.edges_mut().flatten();
        edges.for_each(|edge| edge.view = Some(0));
        let before = face.edge_insets_m(2.0);
        let after = leveled(face).edge_insets_m(2.0);
        let largest = before[0].iter().copied().fold(0.0, f64::max);
        for (before, after) in before[0].iter().zip(&after[0]) {
            assert!((before - after).abs() < 0.15 * largest, "{before} {after}");
        }
    }

    /// Two faces whose covariances are one plane's, carried along it, stay in one plane.
    #[test]
    fn faces_of_one_plane_stay_in_one_plane() {
        let a = tilted(0.03, 0.03);
        let (x, y) = (0.4, -0.2);
        let mut b = a.clone();
        b.X_WF *= Translation3::new(x, y, 0.0);
        let carried = |rows| crate::covariance::carried(rows, &Vector2::new(x, y));
        b.plane_covariance = a.plane_covariance.as_ref().map(carried);
        let (a, b) = (leveled(a), leveled(b));
        assert!(a.normal_W().angle(&b.normal_W()) < 1e-9);
        let apart = b.X_WF.translation.vector - a.X_WF.translation.vector;
        assert!(a.normal_W().dot(&apart).abs() < 5e-4 * apart.norm());
    }
}
