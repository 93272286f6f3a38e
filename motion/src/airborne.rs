//! How near a patch in the air may come to what it passes.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point3, Vector3};

use crate::problem::{Setting, Swing};

/// Pairs whose normal leans less than 45° from the patch's are over one another.
const OVER: f64 = 0.7;

/// Where a patch in the air is on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Airborne {
    leaves: Option<usize>,
    lands: Option<usize>,
    /// Height over the planes of the surfaces that it leaves and lands on, m.
    heights: (f64, f64),
    /// Distance from the nearer end, m.
    from_end: f64,
    /// The patch's normal; of a ball, which has none, that of the surfaces.
    normal: Vector3<f64>,
}

impl Airborne {
    pub fn new(setting: &Setting, swing: &Swing, X_WC: &Isometry3<f64>) -> Self {
        let p = X_WC.translation.vector;
        let surfaces = &setting.environment.surfaces;
        let radius = setting.robot.patches[swing.patch].point_radius_m();
        // What touches of a ball is a radius below its centre.
        let height = |surface: Option<usize>| {
            surface.map_or(f64::INFINITY, |s| {
                surfaces[s].height_of(&Point3::from(p)) - radius.unwrap_or(0.0)
            })
        };
        let ends = [swing.leaves, swing.lands].into_iter().flatten();
        let normal = match radius {
            Some(_) => ends.map(|s| surfaces[s].normal_W()).sum::<Vector3<f64>>(),
            None => X_WC.rotation * Vector3::z(),
        };
        let distance = |end: &Isometry3<f64>| (p - end.translation.vector).norm();
        let zone = 2.0 * setting.config.straight_m;
        let near = |end: &Isometry3<f64>| distance(end) < zone;
        Self {
            // A surface is excepted near the end that lies on it, not elsewhere.
            leaves: swing.leaves.filter(|_| near(&swing.from)),
            lands: swing.lands.filter(|_| near(&swing.to)),
            heights: (height(swing.leaves), height(swing.lands)),
            from_end: distance(&swing.from).min(distance(&swing.to)),
            normal: normal.try_normalize(1e-3).unwrap_or_else(Vector3::z),
        }
    }

    /// The surface that the patch is so near to that it is excepted, with all behind its plane.
    pub fn surface(&self, setting: &Setting) -> Option<usize> {
        let low = setting.config.straight_m;
        let near = |surface: Option<usize>, height: f64| surface.filter(|_| height < low);
        near(self.leaves, self.heights.0).or(near(self.lands, self.heights.1))
    }

    /// Whether a body of the environment is excepted.
    pub fn touches(&self, setting: &Setting, obstacle: usize) -> bool {
        let low = setting.config.straight_m;
        let behind = &setting.environment.behind;
        let near = |surface: Option<usize>, height: f64| {
            height < low && surface.is_some_and(|s| behind[s][obstacle])
        };
        near(self.leaves, self.heights.0) || near(self.lands, self.heights.1)
    }

    /// The distance that is asked for from a body in the direction `normal_W` (toward the patch),
    /// m.
    pub fn required_m(&self, setting: &Setting, normal_W: &Vector3<f64>) -> f64 {
        let beside = setting.posture.clearance_m;
        if normal_W.dot(&self.normal) < OVER {
            return beside;
        }
        let part = (self.from_end / (2.0 * setting.config.straight_m)).min(1.0);
        beside + part * (setting.config.swing_clearance_m - beside).max(0.0)
    }
}
