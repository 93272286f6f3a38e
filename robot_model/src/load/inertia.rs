//! Mass, centre of mass and inertia of the links that move as one.

use nalgebra::{Isometry3, Matrix3, SymmetricEigen, Vector3};

use super::Findings;
use super::urdf::pose;
use crate::{Body, Error, JointKind};

/// Moving bodies below this mass are massless: dummy links carry 1e-6 kg and the like.
const MASSLESS_KG: f64 = 1e-5;
/// A negative moment up to this part of the greatest is a slip, which no motion feels.
const SLIGHT: f64 = 0.02;
/// Moments of inertia below this are none: a gram at a third of a millimetre; kg·m².
const NO_INERTIA: f64 = 1e-10;

/// Sums the inertias of links fixed to one body.
#[derive(Clone, Debug, Default)]
pub(super) struct Lump {
    /// (mass, centre of mass in B, inertia about it in B's axes)
    parts: Vec<(f64, Vector3<f64>, Matrix3<f64>)>,
}

impl Lump {
    /// Adds what a link at `X_BL` states.
    ///
    /// # Errors
    /// [`Error::Part`] for a negative mass.
    pub fn add(
        &mut self,
        file: &str,
        link: &urdf_rs::Link,
        X_BL: &Isometry3<f64>,
    ) -> Result<(), Error> {
        let mass_kg = link.inertial.mass.value;
        if mass_kg < 0.0 {
            let cause = format!("its mass is {mass_kg} kg");
            return Err(Error::part(file, "link", &link.name, cause));
        }
        let of = &link.inertial.inertia;
        let inertia = Matrix3::new(
            of.ixx, of.ixy, of.ixz, of.ixy, of.iyy, of.iyz, of.ixz, of.iyz, of.izz,
        );
        let X_BI = X_BL * pose(&link.inertial.origin);
        let R_BI = X_BI.rotation.to_rotation_matrix();
        let inertia_B = R_BI.matrix() * inertia * R_BI.matrix().transpose();
        let com = X_BI.translation.vector;
        self.parts.push((mass_kg, com, inertia_B));
        Ok(())
    }

    /// Mass, centre of mass and inertia about it, in B.
    ///
    ///   I = Σ Iᵢ + mᵢ (‖rᵢ‖² 1 − rᵢ rᵢᵀ),  rᵢ from the common centre
    pub fn total(&self) -> (f64, Vector3<f64>, Matrix3<f64>) {
        let mass: f64 = self.parts.iter().map(|part| part.0).sum();
        let moment: Vector3<f64> = self.parts.iter().map(|part| part.1 * part.0).sum();
        // Without mass there is no moment either.
        let com = moment / if mass > 0.0 { mass } else { 1.0 };
        let inertia = self.parts.iter().map(|(m, p, inertia)| {
            let r = p - com;
            inertia + (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * *m
        });
        (mass, com, inertia.sum())
    }
}

/// Whether every moving body can be one: some mass to move, an inertia that masses can have.
///
/// Refused are a robot without mass and an inertia with a clearly negative principal moment, unless `findings` is
/// lenient; lesser flaws, which do not touch statics,
/// become notes.
pub(super) fn check(file: &str, bodies: &[Body], findings: &mut Findings) {
    let mut carried: Vec<f64> = bodies.iter().map(|b| b.mass_kg).collect();
    for (i, body) in bodies.iter().enumerate().rev() {
        if let Some(parent) = body.parent {
            carried[parent] += carried[i];
        }
    }
    for (body, carried) in bodies.iter().zip(&carried) {
        let link = body.name.as_str();
        let refuse = |cause: String| Error::part(file, "link", link, cause);
        if *carried < MASSLESS_KG {
            if body.kind == JointKind::Floating {
                let cause = "the whole robot is massless".to_owned();
                findings.refuse_unless_lenient(refuse(cause));
            } else {
                // Its joint needs no torque: statics and motions are those of the rest.
                let what = "links that are massless, as is all that they carry, weigh nothing";
                findings.list(what, link);
            }
        } else if body.mass_kg < MASSLESS_KG {
            findings.list("links that move have no mass of their own", link);
        }
        let mut moments = SymmetricEigen::new(body.inertia_B).eigenvalues;
        moments.as_mut_slice().sort_unstable_by(f64::total_cmp);
        let [small, middle, large] = [moments[0], moments[1], moments[2]];
        let rounding = 1e-6 * large.abs() + NO_INERTIA;
        if large.is_finite() && small < -rounding && small > -SLIGHT * large {
            findings.note(format!(
                "link \"{link}\": principal moments {small:.3e}, {middle:.3e}, {large:.3e} kg·m²: a \
                 negative one is none of a body's; kept as given, statics does not use it"
            ));
        } else if !large.is_finite() || small < -rounding {
            let cause = format!("its inertia has the principal moments {small}, {middle}, {large}");
            findings.refuse_unless_lenient(refuse(cause));
        } else if small + middle < large * (1.0 - 1e-3) - NO_INERTIA {
            // One part in a thousand: tensors are written with a few digits.
            findings.note(format!(
                "link \"{link}\": principal moments {small:.3e}, {middle:.3e}, {large:.3e} kg·m² \
                 break the triangle inequality; kept as given, statics does not use them"
            ));
        } else if body.mass_kg >= MASSLESS_KG && large <= NO_INERTIA {
            findings.note(format!("link \"{link}\" has a mass but no inertia"));
        }
    }
}
