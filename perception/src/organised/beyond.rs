//! Where faces may go on that the image's border cuts.
//!
//! A wall that leaves the image does not end there: such edges of its outline are labelled
//! [`EdgeKind::FieldOfView`]. Nothing was seen of the rest, so a body is assumed in its plane, as far as a robot could reach into it. Faces that one could stand on are
//! let be: their edges are found again by the robot's own feet, and a body in their plane would
//! stand in no one's way.
#![allow(non_snake_case)]

use nalgebra::{Point3, Vector2};
use serde::{Deserialize, Serialize};
use surfaces::edge::ring_edges;
use surfaces::{EdgeKind, Obstacle, Surface};

use crate::Error;
use crate::error::within;

/// How far cut faces are taken to go on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BeyondConfig {
    /// How far a face may go on beyond the view, m; none is taken to where it is 0.
    pub reach_m: f64,
    /// Faces whose normal is at least this far from the vertical go on, rad.
    pub steep_rad: f64,
    /// Depth of the assumed bodies, m.
    pub thickness_m: f64,
}

impl Default for BeyondConfig {
    fn default() -> Self {
        Self {
            reach_m: 0.5,
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
        ] {
            within(key, value, 0.0, 1e3, "must not be negative")?;
        }
        Ok(())
    }
}

/// Shorter edges are corners that the border rounds off, m.
const EDGE_MIN_M: f64 = 0.03;

/// A body beyond every edge of a steep face that the view's border cuts, in W.
///
/// `surfaces` are those of one image; those of one face have one outline, of which the first
/// surface's counts.
pub(super) fn bodies(surfaces: &[Surface], config: &BeyondConfig) -> Vec<Obstacle> {
    let mut bodies = Vec::new();
    if config.reach_m <= 0.0 || config.thickness_m <= 0.0 {
        return bodies;
    }
    for (index, surface) in surfaces.iter().enumerate() {
        let steep = surface.normal_W().z.abs() < config.steep_rad.cos();
        let Some(ring) = surface.outline.first().filter(|_| steep) else {
            continue;
        };
        if surfaces[..index].iter().any(|s| s.shares_outline(surface)) {
            continue;
        }
        let turn: f64 = ring_edges(ring)
            .map(|(a, b)| a.coords.perp(&b.coords))
            .sum();
        for (number, (a, b)) in ring_edges(ring).enumerate() {
            let along = b - a;
            let cut = surface.outline_edge(0, number) == EdgeKind::FieldOfView;
            if !cut || along.norm() < EDGE_MIN_M {
                continue;
            }
            let out = Vector2::new(along.y, -along.x) * (turn.signum() / along.norm());
            let far = out * config.reach_m;
            let ring = [a, b, b + far, a + far];
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
