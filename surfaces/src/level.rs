//! Treads, floors and tables are level where nothing speaks against it.
//!
//! A plane fitted to a small face seen at a flat angle may lean by degrees, and its covariance says
//! so; that most faces one can stand on are level says more. With the errors θ = (θ_x, θ_y, z) of
//! the plane and Σ their covariance, "level up to σ" is a measurement of the two tilts:
//!
//!   h = (−u_y, u_x),   H = [1 0 0; 0 1 0],   S = H Σ Hᵀ + σ² 1,   θ̂ = Σ Hᵀ S⁻¹ h
//!
//! with u the vertical in S. It is taken only where hᵀ S⁻¹ h stays within the gate: a ramp that is
//! seen well stays a ramp. The offset follows through Σ, so that the pieces of one face, whose
//! covariances are those of one plane, stay in one plane.
//! Source: the linear minimum-variance update of [kalman1960], with a χ² gate.

#![allow(non_snake_case)]

use nalgebra::{
    Isometry3, Matrix2, Matrix2x3, Matrix3, Translation3, UnitQuaternion, Vector2, Vector3,
};
use serde::{Deserialize, Serialize};

use crate::{Face, Surface};

/// How strongly faces that may be level are taken to be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Whether it is assumed at all.
    pub assume: bool,
}

/// Standard deviation of the tilt of what was built to be level, rad.
const SIGMA_RAD: f64 = 0.005;
/// Faces that lean by more than this many standard deviations are not level.
const GATE_SIGMAS: f64 = 2.5;
/// Faces that lean by more than this are not level however little is known of them, rad.
const TILT_MAX_RAD: f64 = 0.12;

impl Default for Config {
    fn default() -> Self {
        Self { assume: true }
    }
}

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

/// The surface with what "it is level" adds to its plane; unchanged where it is not consistent
/// with that, has no covariance, or faces down or sideways.
pub fn leveled(mut surface: Surface, config: &Config) -> Surface {
    let Some(rows) = surface.plane_covariance.filter(|_| config.assume) else {
        return surface;
    };
    if let Some((X, after)) = updated(&surface.X_WS, &rows) {
        surface.X_WS *= X;
        surface.plane_covariance = Some(after);
    }
    surface
}

/// How the frame of a plane moves by what "it is level" tells, and the covariance afterwards.
fn updated(X_WS: &Isometry3<f64>, rows: &[[f64; 3]; 3]) -> Option<(Isometry3<f64>, [[f64; 3]; 3])> {
    let up_S = X_WS.rotation.inverse() * Vector3::z();
    if up_S.z < TILT_MAX_RAD.cos() {
        return None;
    }
    let covariance = Matrix3::from_fn(|i, j| rows[i][j]);
    let h = Vector2::new(-up_S.y, up_S.x);
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
    use crate::ConvexPolygon;
    use nalgebra::Point2;

    fn tilted(tilt_rad: f64, sigma_rad: f64) -> Surface {
        let polygon = ConvexPolygon::new(
            [(-0.2, -0.1), (0.2, -0.1), (0.2, 0.1), (-0.2, 0.1)]
                .map(|(x, y)| Point2::new(x, y))
                .to_vec(),
        )
        .unwrap();
        let turn =
            UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.8, 0.5).normalize() * tilt_rad);
        let pose = Isometry3::from_parts(Translation3::new(1.0, 2.0, 0.3), turn);
        let mut surface = Surface::new("s", pose, polygon);
        let (t, z) = (sigma_rad * sigma_rad, 1e-5);
        surface.plane_covariance = Some([[t, 0.0, 0.0], [0.0, t, 0.0], [0.0, 0.0, z]]);
        surface
    }

    fn tilt(surface: &Surface) -> f64 {
        surface.normal_W().angle(&Vector3::z())
    }

    #[test]
    fn a_tread_that_leans_within_its_uncertainty_becomes_level() {
        let before = tilted(0.05, 0.045);
        let after = leveled(before.clone(), &Config::default());
        assert!(tilt(&before) > 0.04);
        assert!(tilt(&after) < 0.002, "{}", tilt(&after));
        assert!(after.plane_covariance.unwrap()[0][0] < 1.1 * 0.005 * 0.005);
        after.validate().unwrap();
    }

    #[test]
    fn a_ramp_seen_well_stays_a_ramp_and_so_does_a_steep_one_seen_badly() {
        for surface in [tilted(0.05, 0.01), tilted(0.3, 0.5), tilted(3.1, 0.5)] {
            assert_eq!(leveled(surface.clone(), &Config::default()), surface);
        }
        let config = Config { assume: false };
        let surface = tilted(0.05, 0.045);
        assert_eq!(leveled(surface.clone(), &config), surface);
    }

    /// A face's plane moves as a surface's, and its edges keep the error with which they were seen.
    #[test]
    fn the_prior_leaves_the_errors_of_edges_as_they_were() {
        let surface = tilted(0.05, 0.045);
        let mut face = Face::new("f", surface.X_WS, (&surface.polygon).into());
        face.plane_covariance = surface.plane_covariance;
        face.views = vec![crate::EdgeView {
            eye_W: surface.X_WS * nalgebra::Point3::new(-2.0, 0.5, 2.0),
            sigma_rad: 0.0,
            plane_covariance: None,
        }];
        let edges = face.region.edges_mut().flatten();
        edges.for_each(|edge| edge.view = Some(0));
        let before = face.edge_insets_m(2.0);
        apply_level_prior(&mut face);
        let after = leveled(surface, &Config::default());
        assert_eq!(
            (face.X_WF, face.plane_covariance),
            (after.X_WS, after.plane_covariance)
        );
        let largest = before[0].iter().copied().fold(0.0, f64::max);
        for (before, after) in before[0].iter().zip(&face.edge_insets_m(2.0)[0]) {
            assert!((before - after).abs() < 0.15 * largest, "{before} {after}");
        }
        face.validate().unwrap();
    }

    /// Two pieces whose covariances are one plane's, carried along it, stay in one plane.
    #[test]
    fn pieces_of_one_plane_stay_in_one_plane() {
        let a = tilted(0.03, 0.03);
        let (x, y) = (0.4, -0.2);
        let mut b = a.clone();
        b.X_WS *= Translation3::new(x, y, 0.0);
        // Offset at (x, y): z + θ_x y − θ_y x.
        let carry = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, y, -x, 1.0);
        let rows = a.plane_covariance.unwrap();
        let carried = carry * Matrix3::from_fn(|i, j| rows[i][j]) * carry.transpose();
        b.plane_covariance = Some(std::array::from_fn(|i| {
            std::array::from_fn(|j| carried[(i, j)])
        }));
        let (a, b) = (
            leveled(a, &Config::default()),
            leveled(b, &Config::default()),
        );
        assert!(a.normal_W().angle(&b.normal_W()) < 1e-9);
        let apart = b.X_WS.translation.vector - a.X_WS.translation.vector;
        assert!(a.normal_W().dot(&apart).abs() < 5e-4 * apart.norm());
    }
}
