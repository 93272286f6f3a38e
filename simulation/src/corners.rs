//! The points of a patch at which the controller lets forces act.

use nalgebra::{DMatrix, Isometry3, Matrix3, Vector3, Vector6};
use robot_model::ContactPatch;
use surfaces::ConvexPolygon;

use crate::Error;
use crate::reference::ReferenceContact;

/// The corners of a patch, drawn in by a margin; a ball has the point that touches.
#[derive(Clone, Debug)]
pub(crate) struct Corners {
    /// Corners in C, m.
    points_C: Vec<Vector3<f64>>,
    /// Radius of a point patch, m.
    radius_m: Option<f64>,
    /// From force and moment about C's origin to the corner forces of least norm, all in C.
    spread: DMatrix<f64>,
}

impl Corners {
    /// The corners of a patch, `inset_m` inside its edges.
    pub fn new(patch: &ContactPatch, inset_m: f64) -> Result<Self, Error> {
        let refuse = |cause: String| Error::Robot(format!("patch \"{}\": {cause}", patch.name));
        let radius_m = patch.point_radius_m();
        let points_C: Vec<Vector3<f64>> = if radius_m.is_some() {
            vec![Vector3::zeros()]
        } else {
            let polygon = ConvexPolygon::new(patch.polygon.clone());
            let inside = polygon.map_err(|e| refuse(e.to_string()))?.inset(inset_m);
            let none = || refuse(format!("nothing of it lies {inset_m} m inside its edges"));
            let vertices = inside.ok_or_else(none)?;
            let corners = vertices.vertices().iter();
            corners.map(|p| Vector3::new(p.x, p.y, 0.0)).collect()
        };
        let mut grasp = DMatrix::zeros(6, 3 * points_C.len());
        for (k, p) in points_C.iter().enumerate() {
            let mut block = grasp.fixed_columns_mut::<3>(3 * k);
            block.rows_mut(0, 3).fill_with_identity();
            block.rows_mut(3, 3).copy_from(&p.cross_matrix());
        }
        let spread = grasp.pseudo_inverse(1e-9);
        let spread = spread.map_err(|cause| refuse(cause.to_owned()))?;
        Ok(Self {
            points_C,
            radius_m,
            spread,
        })
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.points_C.len()
    }

    /// The corners in W with the patch at `X_WC`.
    pub fn points_W(&self, X_WC: &Isometry3<f64>, contact: &ReferenceContact) -> Vec<Vector3<f64>> {
        match self.radius_m {
            // The ball's point nearest to the planned surface.
            Some(radius) => {
                let normal = contact.X_WC.rotation * Vector3::z();
                vec![X_WC.translation.vector - normal * radius]
            }
            None => {
                let place = |p| X_WC.rotation * p + X_WC.translation.vector;
                self.points_C.iter().map(place).collect()
            }
        }
    }

    /// Corner forces in the contact's axes R that come nearest to the contact's planned wrench,
    /// none of them pulling.
    pub fn spread(&self, contact: &ReferenceContact, R: &Matrix3<f64>) -> Vec<Vector3<f64>> {
        let force = R.transpose() * contact.force_W;
        let moment = R.transpose() * contact.moment_W;
        let wrench = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
        let forces = &self.spread * wrench;
        (0..self.count())
            .map(|k| Vector3::new(forces[3 * k], forces[3 * k + 1], forces[3 * k + 2].max(0.0)))
            .collect()
    }
}
