//! A face as it stands in a file.

use nalgebra::Point2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{EdgeView, Face, FaceId, Fit};
use crate::pose::Pose;
use crate::{Edge, Error, Region, Ring, Source};

/// A face as it stands in a file, not yet checked: `region`, or `polygon` as its only ring with real
/// edges.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FaceRecord {
    id: FaceId,
    X_WF: Pose,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    polygon: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    region: Vec<RingRecord>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    plane_covariance: Option<[[f64; 3]; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fit: Option<Fit>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    views: Vec<EdgeView>,
    #[serde(default, skip_serializing_if = "is_zero")]
    depth_m: f64,
    #[serde(default)]
    source: Source,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    roles: Option<Vec<String>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    friction: Option<f64>,
}

/// A ring; without edges all are real.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RingRecord {
    vertices: Vec<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    edges: Vec<Edge>,
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

impl From<RingRecord> for Ring {
    fn from(record: RingRecord) -> Self {
        let vertices: Vec<Point2<f64>> = record.vertices.into_iter().map(Point2::from).collect();
        let all_real = record.edges.is_empty();
        let mut ring = Self::from(vertices);
        if !all_real {
            ring.edges = record.edges;
        }
        ring
    }
}

impl From<Ring> for RingRecord {
    fn from(ring: Ring) -> Self {
        let plain = ring.edges.iter().all(|edge| *edge == Edge::default());
        Self {
            vertices: ring.vertices.iter().map(|p| [p.x, p.y]).collect(),
            edges: if plain { Vec::new() } else { ring.edges },
        }
    }
}

impl TryFrom<FaceRecord> for Face {
    type Error = Error;

    fn try_from(record: FaceRecord) -> Result<Self, Error> {
        let named = |cause: Error| cause.of_face(record.id.as_str());
        let rings = match (record.polygon, record.region.is_empty()) {
            (Some(vertices), true) => vec![RingRecord {
                vertices,
                edges: Vec::new(),
            }],
            (None, false) => record.region,
            _ => {
                let wrong = "it needs either `region`, a list of rings, or `polygon`, one ring";
                return Err(named(Error::Shape(wrong.into())));
            }
        };
        let face = Self {
            X_WF: record.X_WF.try_into().map_err(&named)?,
            region: Region::new(rings.into_iter().map(Ring::from)).map_err(&named)?,
            id: record.id,
            plane_covariance: record.plane_covariance,
            fit: record.fit,
            views: record.views,
            depth_m: record.depth_m,
            source: record.source,
            roles: record.roles,
            friction: record.friction,
        };
        face.validate()?;
        Ok(face)
    }
}

impl From<Face> for FaceRecord {
    fn from(face: Face) -> Self {
        let rings = face.region.into_rings().into_iter();
        Self {
            id: face.id,
            X_WF: Pose::from(&face.X_WF),
            polygon: None,
            region: rings.map(RingRecord::from).collect(),
            plane_covariance: face.plane_covariance,
            fit: face.fit,
            views: face.views,
            depth_m: face.depth_m,
            source: face.source,
            roles: face.roles,
            friction: face.friction,
        }
    }
}
