//! A cloud without an image → planar surfaces, by the moments of hashed voxels.
//!
//! The same growth as on images, in space: sums over the points of voxels add up to the plane of any
//! union of voxels, so that no point has a normal and no nearest neighbour is sought. Voxels of
//! several sizes serve dense clouds and sparse ones alike; a distance limit holds throughout. Several
//! clouds that were merged, or a cloud that was moved after the scan, are clouds as any other.

mod grid;
mod lattice;
mod moments;
mod outline;
mod points;
mod tolerance;

use nalgebra::{
    Isometry3, Matrix3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3,
};
use rayon::prelude::*;
use surfaces::edge::ring_edges;
use surfaces::outline::Outline;
use surfaces::{ConvexPolygon, Edge, EdgeKind, EdgeView, Face, Fit, Source, Surface, cover};

pub(crate) use outline::INSET_M;

use crate::config::Config;
use crate::extraction::{Extraction, Segmentation, Statistics};
use crate::face::{self, Known};
use crate::scan::{Scan, tangent_frame};
use crate::segmentation;
use crate::sensor::Noise;
use crate::spherical_range_image::SphericalRangeImage;
use grid::Grid;
use lattice::{POINTS_ALIKE, VoxelLattice, WAVE_RAD};
use points::Final;
use tolerance::Tolerance;

/// Side of the smallest voxels, m, and the number of sizes, each twice the one before.
const LEAF_M: f64 = 0.04;
const LEVELS: usize = 4;
/// The distance limit: no tolerance is ever larger, m.
const DISTANCE_MAX_M: f64 = 0.06;
/// The cloud's own noise counts where it is more than the sensor's, up to this many times that.
const NOISE_FACTOR_MAX: f64 = 10.0;

/// The planar surfaces of a cloud taken from `X_WV`.
#[allow(non_snake_case)]
pub(crate) fn extract(scan: &Scan, X_WV: &Isometry3<f64>, config: &Config) -> Extraction {
    // 1. The points within range, about the eye; their voxels, in several sizes.
    let square = config.range_max_m * config.range_max_m;
    let (mut near, mut places) = (Vec::new(), Vec::new());
    for (place, p) in scan.cloud.points.iter().enumerate() {
        let p = Vector3::from(p.map(f64::from)) - scan.eye_V;
        // Not so for what is not finite.
        if p.norm_squared() <= square {
            near.push(p);
            places.push(place);
        }
    }
    let grid = Grid::new(&near, LEAF_M, LEVELS);
    let noise = tolerance::measured(&grid.levels[0], &scan.noise, NOISE_FACTOR_MAX);
    let tolerance = Tolerance {
        noise: &noise,
        distance_max_m: DISTANCE_MAX_M,
    };

    // 2. Regions over the voxels, from the largest down.
    let lattices = grid.levels.iter().rev().map(|level| VoxelLattice {
        level,
        tolerance: &tolerance,
    });
    let lattices: Vec<VoxelLattice> = lattices.collect();
    let found = segmentation::segment(&lattices.iter().collect::<Vec<_>>());
    let regions = found.regions.len();

    // 3. Every point to the nearest plane around it, and the final planes.
    let (labels, sure) = points::label(&near, &grid, &found, &tolerance);
    let mut planes = points::fit(&near, &labels, &found, &tolerance);
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
    let directions = SphericalRangeImage::new(
        from_eye,
        planes.iter().map(own).collect(),
        config.range_max_m,
        &noise,
    );
    let faces = Faces {
        points: &near,
        sure: &sure,
        directions: &directions,
        eye_V: &scan.eye_V,
        noise: &noise,
        X_WV,
        config,
    };
    let numbered = planes.par_iter().enumerate();
    let found: Vec<_> = numbered
        .map(|(number, plane)| faces.of(plane, number))
        .collect();
    let (mut found, mut whole) = (found, Vec::new());
    let numbered = found
        .iter_mut()
        .enumerate()
        .flat_map(|(number, (pieces, faces))| {
            whole.append(faces);
            std::mem::take(pieces)
                .into_iter()
                .map(move |piece| (number as u16, piece))
        });
    let mut found: Vec<(u16, Surface)> = numbered.collect();
    let whole = face::named(whole);

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
        assigned: labels.iter().filter(|r| **r != segmentation::NONE).count(),
    };
    Extraction {
        surfaces,
        faces: whole,
        obstacles: Vec::new(),
        statistics,
        segmentation: Some(segmentation),
    }
}

/// From planes to surfaces.
#[allow(non_snake_case)]
struct Faces<'a> {
    points: &'a [Vector3<f64>],
    /// Which of them surely belong to their plane.
    sure: &'a [bool],
    directions: &'a SphericalRangeImage<'a>,
    eye_V: &'a Vector3<f64>,
    noise: &'a Noise,
    X_WV: &'a Isometry3<f64>,
    config: &'a Config,
}

impl Faces<'_> {
    /// The convex pieces of one plane.
    #[allow(non_snake_case)]
    fn of(&self, found: &Final, number: usize) -> (Vec<Surface>, Vec<Face>) {
        let config = self.config;
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
        let sure = found.members.iter().filter(|i| self.sure[**i as usize]);
        let points: Vec<Point2<f64>> = sure.map(in_P).collect();
        let parts = outline::outlines(&points, config.area_min_m2);
        let whole_m2: f64 = parts.iter().map(Outline::area).sum();
        let gain = (outline::GAIN * whole_m2).min(outline::GAIN_M2);
        let covering = cover::Config {
            gain_min_m2: outline::COVER.gain_min_m2.max(gain),
            ..outline::COVER
        };
        let R_VW = self.X_WV.rotation.inverse();
        let up_W = R_VW * Vector3::z();
        let R_VS =
            Rotation3::from_matrix_unchecked(tangent_frame(&normal, &(R_VW * Vector3::x()), &up_W));
        let R_SP = R_VS.inverse() * R_VP;
        let turn = |x: f64, y: f64| (R_SP * Vector3::new(x, y, 0.0)).xy();
        let X_VP = Isometry3::from_parts(
            Translation3::from(foot + self.eye_V),
            UnitQuaternion::from_rotation_matrix(&R_VS),
        );
        let mut faces = Vec::new();
        let mut surfaces = Vec::new();
        for part in &parts {
            let rings = part.rings();
            let in_V = |p: &Point2<f64>| Point3::from(foot + R_VP * p.coords.push(0.0));
            let kinds = self.kinds(number, &rings, in_V, &R_VP);
            let on_plane =
                |ring: &Vec<[f64; 2]>| ring.iter().map(|p| turn(p[0], p[1]).into()).collect();
            let on_plane: Vec<Vec<Point2<f64>>> = rings.iter().map(on_plane).collect();
            let edge = |ring: usize, i: usize| Edge {
                kind: kinds[ring][i],
                further_m: INSET_M,
                view: Some(0),
                ..Edge::default()
            };
            let known = Known {
                fit: Fit {
                    points: found.members.len(),
                    rms_m: found.rms_m,
                },
                view: EdgeView {
                    eye_W: self.X_WV * Point3::from(*self.eye_V),
                    sigma_rad: 0.0,
                    plane_covariance: None,
                },
            };
            faces.extend(face::face(
                &on_plane,
                edge,
                &(self.X_WV * X_VP),
                known,
                |origin| {
                    let origin = foot + R_VS * origin.coords.push(0.0);
                    self.covariance(found, &origin, &R_VS, part.area())
                },
            ));
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
                    inset_m: INSET_M,
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
        (surfaces, faces)
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

/// About so many points stand for all in a covariance.
const SUPPORT: usize = 400;
