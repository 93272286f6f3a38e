//! Where faces may go on that the image's border cuts.
//!
//! A wall that leaves the image does not end there. Nothing was seen of the rest, so a body is
//! assumed in its plane, as far as a robot could reach into it. Faces that one could stand on are
//! let be: their edges are found again by the robot's own feet, and a body in their plane would
//! stand in no one's way.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point2, Point3, Vector2};
use serde::{Deserialize, Serialize};
use surfaces::{Obstacle, Surface};

use crate::Error;
use crate::error::within;
use crate::scan::DepthImage;

/// How far cut faces are taken to go on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BeyondConfig {
    /// How far a face may go on beyond the view, m; none is taken to where it is 0.
    pub reach_m: f64,
    /// Edges this near to the border of what the image measured are cut by it, px.
    pub border_px: f64,
    /// Faces whose normal is at least this far from the vertical go on, rad.
    pub steep_rad: f64,
    /// Depth of the assumed bodies, m.
    pub thickness_m: f64,
}

impl Default for BeyondConfig {
    fn default() -> Self {
        Self {
            reach_m: 0.5,
            border_px: 8.0,
            steep_rad: 0.8,
            thickness_m: 0.2,
        }
    }
}

impl BeyondConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        for (key, value) in [
            ("reach_m", self.reach_m),
            ("thickness_m", self.thickness_m),
            ("steep_rad", self.steep_rad),
            ("border_px", self.border_px),
        ] {
            within(key, value, 0.0, 1e3, "must not be negative")?;
        }
        Ok(())
    }
}

/// Shorter edges are corners that the border rounds off, m.
const EDGE_MIN_M: f64 = 0.03;

/// An edge is cut where leaving the face over it leaves the view as directly as this, cos 45°.
const ALONG: f64 = 0.7;

/// The part of the image in which something was measured, px.
struct View {
    low: Point2<f64>,
    high: Point2<f64>,
}

impl View {
    fn new(depth: &DepthImage) -> Option<Self> {
        let measured = |z: &f32| *z > 0.0;
        let width = depth.width.max(1);
        let rows = || depth.z_m.chunks_exact(width);
        let top = rows().position(|row| row.iter().any(measured))?;
        let bottom = rows().rposition(|row| row.iter().any(measured))?;
        let first = |row: &[f32]| row.iter().position(measured);
        let last = |row: &[f32]| row.iter().rposition(measured);
        let left = rows().filter_map(first).min()?;
        let right = rows().filter_map(last).max()?;
        Some(Self {
            low: Point2::new(left as f64, top as f64),
            high: Point2::new(right as f64, bottom as f64),
        })
    }

    /// The direction out of the view, px, at the side to which both ends are this near.
    fn out_at(&self, a: &Point2<f64>, b: &Point2<f64>, border_px: f64) -> Option<Vector2<f64>> {
        (0..2).find_map(|axis| {
            let mut out = Vector2::zeros();
            if a[axis].max(b[axis]) <= self.low[axis] + border_px {
                out[axis] = -1.0;
            } else if a[axis].min(b[axis]) >= self.high[axis] - border_px {
                out[axis] = 1.0;
            }
            (out != Vector2::zeros()).then_some(out)
        })
    }
}

/// A body beyond every edge of a steep face that the view's border cuts, in W.
///
/// `surfaces` were extracted from this image taken from `X_WV`; those of one face have one outline,
/// of which the first surface's counts.
pub(super) fn bodies(
    depth: &DepthImage,
    surfaces: &[Surface],
    X_WV: &Isometry3<f64>,
    config: &BeyondConfig,
) -> Vec<Obstacle> {
    let mut bodies = Vec::new();
    if config.reach_m <= 0.0 || config.thickness_m <= 0.0 {
        return bodies;
    }
    let Some(view) = View::new(depth) else {
        return bodies;
    };
    let k = &depth.intrinsics;
    for (index, surface) in surfaces.iter().enumerate() {
        let steep = surface.normal_W().z.abs() < config.steep_rad.cos();
        let Some(ring) = surface.outline.first().filter(|_| steep) else {
            continue;
        };
        if surfaces[..index].iter().any(|s| s.shares_outline(surface)) {
            continue;
        }
        let X_VS = X_WV.inverse() * surface.X_WS;
        let pixel = |p: &Vector2<f64>| {
            let p_V = X_VS * Point3::new(p.x, p.y, 0.0);
            (p_V.z > 1e-3)
                .then(|| Point2::new(k.fx * p_V.x / p_V.z + k.cx, k.fy * p_V.y / p_V.z + k.cy))
        };
        let corners: Vec<Vector2<f64>> = ring.iter().map(|p| Vector2::from(*p)).collect();
        let next = corners.iter().cycle().skip(1);
        let edges = || corners.iter().zip(next.clone());
        let turn: f64 = edges().map(|(a, b)| a.perp(b)).sum();
        for (number, (a, b)) in edges().enumerate() {
            let along = b - a;
            let (Some(pa), Some(pb)) = (pixel(a), pixel(b)) else {
                continue;
            };
            let side = view.out_at(&pa, &pb, config.border_px);
            let (Some(side), true) = (side, along.norm() >= EDGE_MIN_M) else {
                continue;
            };
            // A corner near the border has edges that look elsewhere.
            let out = Vector2::new(along.y, -along.x) * (turn.signum() / along.norm());
            let leaves = pixel(&(a + out * EDGE_MIN_M)).is_some_and(|moved| {
                let step = moved - pa;
                step.dot(&side) >= ALONG * step.norm()
            });
            if !leaves {
                continue;
            }
            let far = out * config.reach_m;
            let ring = [*a, *b, b + far, a + far];
            let at = |z: f64| ring.map(|p| surface.X_WS * Point3::new(p.x, p.y, z));
            bodies.push(Obstacle {
                id: format!("{}/beyond{number}", surface.id),
                points_W: [at(0.0), at(-config.thickness_m)].concat(),
                surface: None,
                assumed: true,
            });
        }
    }
    bodies
}
