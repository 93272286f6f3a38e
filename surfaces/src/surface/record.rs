//! A surface as it stands in a file.

use serde::{Deserialize, Serialize};

use super::{Source, Surface};
use crate::pose::PoseRecord;
use crate::{EdgeKind, Error};

/// Whether a number that is left out of files is.
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// A surface as it stands in a file, not yet checked.
#[allow(non_snake_case)]
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SurfaceRecord {
    id: String,
    X_WS: PoseRecord,
    polygon: Vec<[f64; 2]>,
    #[serde(default)]
    outline: Vec<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    outline_edges: Vec<Vec<EdgeKind>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    polygon_edges: Vec<EdgeKind>,
    #[serde(default)]
    inset_m: f64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    edge_insets_m: Vec<f64>,
    #[serde(default, skip_serializing_if = "is_zero")]
    edge_m: f64,
    #[serde(default, skip_serializing_if = "is_zero")]
    depth_m: f64,
    #[serde(default)]
    inliers: usize,
    #[serde(default)]
    rms_m: f64,
    #[serde(default)]
    plane_covariance: Option<[[f64; 3]; 3]>,
    #[serde(default)]
    source: Source,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    face: Option<String>,
}

impl TryFrom<SurfaceRecord> for Surface {
    type Error = Error;

    fn try_from(record: SurfaceRecord) -> Result<Self, Error> {
        let named = |cause: Error| Error::Surface {
            id: record.id.clone(),
            cause: Box::new(cause),
        };
        let surface = Self {
            X_WS: record.X_WS.try_into().map_err(&named)?,
            polygon: record.polygon.try_into().map_err(&named)?,
            id: record.id,
            outline: record.outline,
            outline_edges: record.outline_edges,
            polygon_edges: record.polygon_edges,
            inset_m: record.inset_m,
            edge_insets_m: record.edge_insets_m,
            edge_m: record.edge_m,
            depth_m: record.depth_m,
            inliers: record.inliers,
            rms_m: record.rms_m,
            plane_covariance: record.plane_covariance,
            source: record.source,
            face: record.face,
        };
        surface.validate()?;
        Ok(surface)
    }
}

impl From<Surface> for SurfaceRecord {
    fn from(surface: Surface) -> Self {
        Self {
            X_WS: PoseRecord::from(&surface.X_WS),
            polygon: surface.polygon.into(),
            id: surface.id,
            outline: surface.outline,
            outline_edges: surface.outline_edges,
            polygon_edges: surface.polygon_edges,
            inset_m: surface.inset_m,
            edge_insets_m: surface.edge_insets_m,
            edge_m: surface.edge_m,
            depth_m: surface.depth_m,
            inliers: surface.inliers,
            rms_m: surface.rms_m,
            plane_covariance: surface.plane_covariance,
            source: surface.source,
            face: surface.face,
        }
    }
}
