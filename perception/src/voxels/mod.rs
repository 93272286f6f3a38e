//! A cloud without an image → planar surfaces, by the moments of hashed voxels.
//!
//! The same growth as on images, in space: sums over the points of voxels add up to the plane of any
//! union of voxels, so that no point has a normal and no nearest neighbour is sought. Voxels of
//! several sizes serve dense clouds and sparse ones alike; a distance limit holds throughout. Several
//! clouds that were merged, or a cloud that was moved after the scan, are clouds as any other.

mod grid;
mod growth;
mod merge;
mod moments;
mod outline;
mod points;
mod tolerance;

use nalgebra::{
    Isometry3, Matrix3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use surfaces::edge::ring_edges;
use surfaces::outline::Outline;
use surfaces::{ConvexPolygon, EdgeKind, Source, Surface, cover};

pub use growth::VoxelGrowthConfig;
pub use outline::VoxelOutlineConfig;

use crate::Error;
use crate::directions::Directions;
use crate::error::within;
use crate::extraction::{Extraction, Segmentation, Statistics};
use crate::scan::{Scan, tangent_frame};
use crate::sensor::Noise;
use grid::{Grid, NONE};
use points::Final;
use tolerance::Tolerance;

/// Parameters of the path of voxels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VoxelConfig {
    /// Side of the smallest voxels, m.
    pub leaf_m: f64,
    /// Number of sizes, each twice the one before.
    pub levels: usize,
    /// The cloud's own noise counts where it is more than the sensor's, up to this many times that.
    pub noise_factor_max: f64,
    /// Growth of planar regions over voxels.
    pub growth: VoxelGrowthConfig,
    /// From planes to outlines and convex polygons.
    pub outline: VoxelOutlineConfig,
}

impl Default for VoxelConfig {
    fn default() -> Self {
        Self {
            leaf_m: 0.04,
            levels: 4,
            noise_factor_max: 10.0,
            growth: VoxelGrowthConfig::default(),
            outline: VoxelOutlineConfig::default(),
        }
    }
}

impl VoxelConfig {
    pub(crate) fn check(&self, range_max_m: f64) -> Result<(), Error> {
        // A voxel's place along an axis has to fit 21 bits.
        let least = (range_max_m / f64::from(1 << 19)).max(1e-6);
        let cause = "must be positive, and not tiny for the range";
        within("leaf_m", self.leaf_m, least, 1e3, cause)?;
        within(
            "levels",
            self.levels as f64,
            1.0,
            16.0,
            "must be in [1, 16]",
        )?;
        let factor = self.noise_factor_max;
        within("noise_factor_max", factor, 1.0, 1e3, "must be in [1, 1000]")?;
        self.growth.check()?;
        self.outline.check()
    }
}

/// The planar surfaces of a cloud taken from `X_WV`.
#[allow(non_snake_case)]
pub(crate) fn extract(
    scan: &Scan,
    X_WV: &Isometry3<f64>,
    range_max_m: f64,
    config: &VoxelConfig,
) -> Extraction {
    // 1. The points within range, about the eye; their voxels, in several sizes.
    let square = range_max_m * range_max_m;
    let (mut near, mut places) = (Vec::new(), Vec::new());
    for (place, p) in scan.cloud.points.iter().enumerate() {
        let p = Vector3::from(p.map(f64::from)) - scan.eye_V;
        // Not so for what is not finite.
        if p.norm_squared() <= square {
            near.push(p);
            places.push(place);
        }
    }
    let grid = Grid::new(&near, config.leaf_m, config.levels);
    let noise = tolerance::measured(&grid.levels[0], &scan.noise, config.noise_factor_max);
    let tolerance = Tolerance {
        noise: &noise,
        distance_max_m: config.growth.distance_max_m,
    };

    // 2. Regions over the voxels, from the largest down; neighbours in one plane merged.
    let mut grown = growth::grow(&grid, &tolerance, &config.growth);
    let regions = grown.regions.len();
    merge::merge(&grid.levels[0], &mut grown, &tolerance);

    // 3. Every point to the nearest plane around it, and the final planes.
    let labels = points::label(&near, &grid, &grown, &tolerance);
    let least = config.growth.points_min;
    let mut planes = points::fit(&near, &labels, &grown, &tolerance, least);
    // Labels are 16 bits.
    planes.truncate(usize::from(Segmentation::NONE));

    // 4. The outline of each by its points, covered by convex polygons; what ends it at its edges is
    // told by the points beside it as the sensor saw them.
    let mut of_point = vec![Segmentation::NONE; scan.cloud.points.len()];
    for (number, plane) in planes.iter().enumerate() {
        for &i in &plane.members {
            of_point[places[i as usize]] = number as u16;
        }
    }
    let all = scan.cloud.points.iter().zip(&of_point);
    let from_eye = all
        .map(|(p, label)| (Vector3::from(p.map(f64::from)) - scan.eye_V, *label))
        .filter(|(p, _)| p.iter().all(|x| x.is_finite()));
    let own = |p: &Final| (p.plane.normal, p.plane.offset);
    let directions = Directions::new(
        from_eye,
        planes.iter().map(own).collect(),
        range_max_m,
        &noise,
    );
    let faces = Faces {
        points: &near,
        directions: &directions,
        eye_V: &scan.eye_V,
        noise: &noise,
        X_WV,
        config,
    };
    let found: Vec<Vec<(u16, Surface)>> = (planes.par_iter().enumerate())
        .map(|(number, plane)| {
            let pieces = faces.of(plane, number).into_iter();
            pieces.map(|piece| (number as u16, piece)).collect()
        })
        .collect();
    let mut found: Vec<(u16, Surface)> = found.into_iter().flatten().collect();

    // 5. Ids by falling area; the plane of every point.
    found.sort_by(|a, b| b.1.polygon.area().total_cmp(&a.1.polygon.area()));
    let (plane_of_surface, mut surfaces): (Vec<u16>, Vec<Surface>) = found.into_iter().unzip();
    for (i, surface) in surfaces.iter_mut().enumerate() {
        surface.id = format!("s{i}");
    }
    let grid = scan.cloud.organised;
    let (width, height) = grid.unwrap_or((scan.cloud.points.len(), 1));
    let segmentation = Segmentation {
        width,
        height,
        labels: of_point,
        plane_of_surface,
        planes_V: planes.iter().map(|p| Some(p.toward(&scan.eye_V))).collect(),
    };
    let statistics = Statistics {
        points: scan.cloud.points.len(),
        valid: scan.cloud.finite().count(),
        used: near.len(),
        regions,
        planes: planes.len(),
        assigned: labels.iter().filter(|r| **r != NONE).count(),
    };
    Extraction {
        surfaces,
        obstacles: Vec::new(),
        statistics,
        segmentation: Some(segmentation),
    }
}

/// From planes to surfaces.
#[allow(non_snake_case)]
struct Faces<'a> {
    points: &'a [Vector3<f64>],
    directions: &'a Directions<'a>,
    eye_V: &'a Vector3<f64>,
    noise: &'a Noise,
    X_WV: &'a Isometry3<f64>,
    config: &'a VoxelConfig,
}

impl Faces<'_> {
    /// The convex pieces of one plane.
    #[allow(non_snake_case)]
    fn of(&self, found: &Final, number: usize) -> Vec<Surface> {
        let config = &self.config.outline;
        // The normal toward the eye, which is the origin of the points.
        let toward = if found.plane.offset > 0.0 { -1.0 } else { 1.0 };
        let normal = found.plane.normal * toward;
        // Axes of the plane that depend on the sensor only, so that its pose moves the pieces and
        // does not change them.
        let R_VP =
            Rotation3::from_matrix_unchecked(tangent_frame(&normal, &Vector3::z(), &-Vector3::y()));
        let foot = normal * (found.plane.offset * toward);
        let in_P = |i: &u32| {
            let q = R_VP.inverse() * (self.points[*i as usize] - foot);
            Point2::new(q.x, q.y)
        };
        let points: Vec<Point2<f64>> = found.members.iter().map(in_P).collect();
        let parts = outline::outlines(&points, config);
        let whole_m2: f64 = parts.iter().map(Outline::area).sum();
        let gain = (config.gain * whole_m2).min(config.gain_m2);
        let covering = cover::Config {
            gain_min_m2: config.cover.gain_min_m2.max(gain),
            ..config.cover.clone()
        };
        let R_VW = self.X_WV.rotation.inverse();
        let up_W = R_VW * Vector3::z();
        let R_VS =
            Rotation3::from_matrix_unchecked(tangent_frame(&normal, &(R_VW * Vector3::x()), &up_W));
        let R_SP = R_VS.inverse() * R_VP;
        let turn = |x: f64, y: f64| (R_SP * Vector3::new(x, y, 0.0)).xy();
        let mut surfaces = Vec::new();
        for part in &parts {
            let rings = part.rings();
            let in_V = |p: &Point2<f64>| Point3::from(foot + R_VP * p.coords.push(0.0));
            let kinds = self.kinds(number, &rings, in_V, &R_VP);
            for piece in part.pieces(&covering) {
                let large = piece.area() >= config.area_min_m2
                    && 2.0 * piece.inscribed_circle().1 >= config.width_min_m;
                let c = piece.centroid().coords;
                let corners = piece.vertices().iter().map(|v| turn(v.x - c.x, v.y - c.y));
                let corners: Vec<Point2<f64>> = corners.map(Point2::from).collect();
                let (true, Ok(polygon)) = (large, ConvexPolygon::hull(&corners)) else {
                    continue;
                };
                let ring = |ring: &Vec<[f64; 2]>| -> Vec<[f64; 2]> {
                    let moved = ring.iter().map(|p| turn(p[0] - c.x, p[1] - c.y));
                    moved.map(Into::into).collect()
                };
                let origin = foot + R_VP * Vector3::new(c.x, c.y, 0.0);
                let X_VS = Isometry3::from_parts(
                    Translation3::from(origin + self.eye_V),
                    UnitQuaternion::from_rotation_matrix(&R_VS),
                );
                let mut surface = Surface {
                    outline: rings.iter().map(ring).collect(),
                    inset_m: config.inset_m,
                    inliers: found.members.len(),
                    rms_m: found.rms_m,
                    plane_covariance: self.covariance(found, &origin, &R_VS, part.area()),
                    source: Source::Scan,
                    ..Surface::new("", self.X_WV * X_VS, polygon)
                };
                surface.set_outline_edges(kinds.clone());
                surfaces.push(surface);
            }
        }
        if surfaces.len() > 1 {
            let face = format!("f{number}");
            surfaces
                .iter_mut()
                .for_each(|s| s.face = Some(face.clone()));
        }
        surfaces
    }

    /// What ends a face at the edges of its rings, which [`Outline`] gives with the face on their left.
    #[allow(non_snake_case)]
    fn kinds(
        &self,
        number: usize,
        rings: &[Vec<[f64; 2]>],
        in_V: impl Fn(&Point2<f64>) -> Point3<f64>,
        R_VP: &Rotation3<f64>,
    ) -> Vec<Vec<EdgeKind>> {
        let of_ring = |ring: &Vec<[f64; 2]>| {
            let corners: Vec<_> = ring_edges(ring).map(|(a, _)| in_V(&a)).collect();
            let out: Vec<_> = ring_edges(ring)
                .map(|(a, b)| (b - a).try_normalize(1e-12).unwrap_or_default())
                .map(|along| R_VP * Vector3::new(along.y, -along.x, 0.0))
                .collect();
            self.directions.kinds(number as u16, &corners, &out)
        };
        rings.iter().map(of_ring).collect()
    }

    /// Covariance of (rotation about x_S, rotation about y_S, offset along z_S): rad, rad, m.
    ///
    ///   Σ = N (Σ g gᵀ/σ_n²)⁻¹ + (κ d)²/m (Σ g gᵀ/n)⁻¹,  g = (y_S, −x_S, 1),  σ_n = σ |n·r̂|
    ///
    /// with N points whose errors go together, and m waves of the slowly varying error on the face;
    /// the second term is bounded for faces smaller than such a wave: the offset by κ d, the tilts
    /// by the slope of the wave.
    #[allow(non_snake_case)]
    fn covariance(
        &self,
        found: &Final,
        origin: &Vector3<f64>,
        R_VS: &Rotation3<f64>,
        area_m2: f64,
    ) -> Option<[[f64; 3]; 3]> {
        let step = (found.members.len() / SUPPORT).max(1);
        let weight = step as f64;
        let (mut white, mut shape) = (Matrix3::zeros(), Matrix3::zeros());
        let mut range = 0.0;
        let mut count = 0.0;
        for &i in found.members.iter().step_by(step) {
            let p = &self.points[i as usize];
            let q = R_VS.inverse() * (p - origin);
            let g = Vector3::new(q.y, -q.x, 1.0);
            let r = p.norm();
            let slant = (found.plane.normal.dot(p).abs() / r.max(1e-9)).max(0.1);
            let sigma = self.noise.sigma_z_m(r) * slant;
            white += g * g.transpose() * (weight / (sigma * sigma));
            shape += g * g.transpose();
            range += r;
            count += 1.0;
        }
        range /= count;
        let wave = WAVE_RAD * range;
        let waves = (area_m2 / (4.0 * std::f64::consts::PI * wave * wave)).max(1.0);
        let kd = self.noise.systematic_ratio * found.plane.offset.abs();
        let mut slow = (shape / count).try_inverse()? * (kd * kd / waves);
        let slope = kd / (std::f64::consts::SQRT_2 * wave);
        for (i, limit) in [slope, slope, kd].into_iter().enumerate() {
            let sigma = slow[(i, i)].max(0.0).sqrt();
            if sigma > limit && sigma > 0.0 {
                slow.row_mut(i).scale_mut(limit / sigma);
                slow.column_mut(i).scale_mut(limit / sigma);
            }
        }
        let sigma = white.try_inverse()? * POINTS_ALIKE + slow;
        let symmetric = (sigma + sigma.transpose()) * 0.5;
        let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| symmetric[(i, j)]));
        rows.iter().flatten().all(|x| x.is_finite()).then_some(rows)
    }
}

/// Points whose errors go together: one in this many counts.
const POINTS_ALIKE: f64 = 30.0;
/// Angle over which the slowly varying error keeps its sign: 40 px of a lens of 525 px.
const WAVE_RAD: f64 = 0.076;
/// About so many points stand for all in a covariance.
const SUPPORT: usize = 400;
