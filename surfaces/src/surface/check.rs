//! What a surface's fields must be like.

use nalgebra::{Isometry3, Matrix3};

use super::Surface;
use crate::pose::PoseRecord;
use crate::{EdgeKind, Error};

impl Surface {
    pub(super) fn check(&self) -> Result<(), Error> {
        Isometry3::try_from(PoseRecord::from(&self.X_WS))?;
        for (field, value) in [
            ("inset_m", self.inset_m),
            ("edge_m", self.edge_m),
            ("depth_m", self.depth_m),
            ("rms_m", self.rms_m),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::BadNumber {
                    field: field.into(),
                    value,
                    expected: "a finite number ≥ 0",
                });
            }
        }
        for &value in &self.edge_insets_m {
            if !(value >= 0.0 && value <= self.inset_m) {
                return Err(Error::BadNumber {
                    field: "edge_insets_m".into(),
                    value,
                    expected: "between 0 and inset_m",
                });
            }
        }
        for (ring, points) in self.outline.iter().enumerate() {
            check_ring(points).map_err(|cause| Error::Outline {
                ring,
                cause: Box::new(cause),
            })?;
        }
        self.check_edges()?;
        self.plane_covariance
            .as_ref()
            .map_or(Ok(()), check_covariance)
    }

    /// One kind and one inset an edge, or none at all; outlines have no seams.
    fn check_edges(&self) -> Result<(), Error> {
        let counted = |field: String, found: usize, edges: usize| {
            let what = if field == "edge_insets_m" {
                "insets"
            } else {
                "kinds"
            };
            (found == edges).then_some(()).ok_or(Error::EdgeCount {
                field,
                found: format!("{found} {what}"),
                expected: format!("{edges} edges"),
            })
        };
        let edges = self.polygon.vertices().len();
        if !self.polygon_edges.is_empty() {
            counted("polygon_edges".into(), self.polygon_edges.len(), edges)?;
        }
        if !self.edge_insets_m.is_empty() {
            counted("edge_insets_m".into(), self.edge_insets_m.len(), edges)?;
        }
        if self.outline_edges.is_empty() {
            return Ok(());
        }
        if self.outline_edges.len() != self.outline.len() {
            return Err(Error::EdgeCount {
                field: "outline_edges".into(),
                found: format!("kinds of {} rings", self.outline_edges.len()),
                expected: format!("{} rings", self.outline.len()),
            });
        }
        for (ring, (points, kinds)) in self.outline.iter().zip(&self.outline_edges).enumerate() {
            let field = format!("outline_edges of ring {ring}");
            counted(field, kinds.len(), points.len())?;
            if let Some(edge) = kinds.iter().position(|kind| *kind == EdgeKind::Seam) {
                return Err(Error::OutlineSeam { ring, edge });
            }
        }
        Ok(())
    }
}

/// A ring needs three finite points; it need not be convex.
fn check_ring(points: &[[f64; 2]]) -> Result<(), Error> {
    if points.len() < 3 {
        return Err(Error::TooFewVertices {
            count: points.len(),
        });
    }
    match points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        Some(vertex) => Err(Error::NonFiniteVertex {
            vertex,
            point: points[vertex].to_vec(),
        }),
        None => Ok(()),
    }
}

/// A covariance is finite, symmetric and has no negative eigenvalue, up to rounding.
fn check_covariance(rows: &[[f64; 3]; 3]) -> Result<(), Error> {
    let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
    let scale = matrix.abs().max();
    if !matrix.iter().all(|c| c.is_finite()) {
        let why = "an entry is not finite".into();
        return Err(Error::BadCovariance { why });
    }
    // 1e-9 of the largest entry: what a product of f64 matrices or a printed number may be off.
    let tolerance = 1e-9 * scale;
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let (upper, lower) = (rows[i][j], rows[j][i]);
        if (upper - lower).abs() > tolerance {
            let why = format!("entry ({i}, {j}) is {upper}, entry ({j}, {i}) is {lower}");
            return Err(Error::BadCovariance { why });
        }
    }
    let smallest = matrix.symmetric_eigenvalues().min();
    if smallest < -tolerance {
        let why = format!("its smallest eigenvalue is {smallest}");
        return Err(Error::BadCovariance { why });
    }
    Ok(())
}
