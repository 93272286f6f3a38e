//! What the robot is to do: configuration, contacts and forces at every time.

use nalgebra::{DVector, Isometry3, Vector3};
use robot_model::Configuration;

/// A reference of configurations and contacts over time.
pub trait Reference {
    /// Its end, s; what comes later is as at the end.
    fn duration_s(&self) -> f64;
    /// What is wanted at time `t_s`, written over `wanted`.
    fn at(&self, t_s: f64, wanted: &mut ReferenceState);
}

/// What is wanted at one instant.
#[derive(Clone, Debug)]
pub struct ReferenceState {
    /// Configuration.
    pub configuration: Configuration,
    /// Velocity [v_B, ω_B, joint rates…], v_B and ω_B in W; nv.
    pub v: DVector<f64>,
    /// Its derivative; nv.
    pub a: DVector<f64>,
    /// Contacts that are closed.
    pub contacts: Vec<ReferenceContact>,
    /// The patch that moves through the air.
    pub swing: Option<usize>,
    /// Where that patch is to touch, bearing nothing yet.
    pub landing: Option<ReferenceContact>,
}

/// A closed contact and what it bears.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceContact {
    /// Index of the robot's patch.
    pub patch: usize,
    /// Where the patch is planned to be.
    pub X_WC: Isometry3<f64>,
    /// Coefficient of friction of the pair.
    pub friction: f64,
    /// Force on the robot, in W, N.
    pub force_W: Vector3<f64>,
    /// Moment on the robot about C's origin, in W, N·m.
    pub moment_W: Vector3<f64>,
}

impl ReferenceContact {
    /// A contact that bears forces at points.
    ///
    /// Frames: points and forces in W.  Units: m, N.
    pub fn new(
        patch: usize,
        X_WC: Isometry3<f64>,
        friction: f64,
        points_W: &[Vector3<f64>],
        forces_W: &[Vector3<f64>],
    ) -> Self {
        let origin = X_WC.translation.vector;
        let moment_W = points_W
            .iter()
            .zip(forces_W)
            .map(|(p, f)| (p - origin).cross(f))
            .sum();
        Self {
            patch,
            X_WC,
            friction,
            force_W: forces_W.iter().sum(),
            moment_W,
        }
    }

    /// The part of the friction that the force takes; 0 where nothing presses.
    pub fn friction_use(&self) -> f64 {
        let normal_n = self.normal_n();
        let across_n = (self.force_W.norm_squared() - normal_n * normal_n).max(0.0);
        match self.friction * normal_n > 0.0 {
            true => across_n.sqrt() / (self.friction * normal_n),
            false => 0.0,
        }
    }

    /// The part of the force that presses on the surface, N.
    pub fn normal_n(&self) -> f64 {
        self.force_W.dot(&(self.X_WC.rotation * Vector3::z()))
    }
}

impl ReferenceState {
    /// The robot at rest at a configuration without contacts.
    pub fn at_rest(configuration: Configuration) -> Self {
        let nv = 6 + configuration.joints.len();
        Self {
            configuration,
            v: DVector::zeros(nv),
            a: DVector::zeros(nv),
            contacts: Vec::new(),
            swing: None,
            landing: None,
        }
    }

    /// The robot standing still on contacts.
    pub fn standing(configuration: Configuration, contacts: Vec<ReferenceContact>) -> Self {
        Self {
            contacts,
            ..Self::at_rest(configuration)
        }
    }
}

/// What is wanted all the time.
impl Reference for ReferenceState {
    fn duration_s(&self) -> f64 {
        0.0
    }

    fn at(&self, _t_s: f64, wanted: &mut ReferenceState) {
        wanted.clone_from(self);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;

    #[test]
    fn what_a_contact_takes_of_its_friction_is_across_over_along_its_normal() {
        let turned = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.2);
        let X_WC = Isometry3::from_parts(Vector3::x().into(), turned);
        let contact = |force_W| ReferenceContact::new(0, X_WC, 0.5, &[Vector3::x()], &[force_W]);
        let use_of = |force_W| contact(force_W).friction_use();
        assert!((use_of(Vector3::z() * 300.0) - 0.2_f64.tan() / 0.5).abs() < 1e-12);
        assert_eq!(use_of(Vector3::zeros()), 0.0);
    }
}
