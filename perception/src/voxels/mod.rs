//! A cloud without an image → plane faces, by the moments of hashed voxels.
//!
//! The same growth as on images, in space: sums over the points of voxels add up to the plane of any
//! union of voxels, so that no point has a normal and no nearest neighbour is sought. Voxels of
//! several sizes serve dense clouds and sparse ones alike; a distance limit holds throughout. Several
//! clouds that were merged, or a cloud that was moved after the scan, are clouds as any other.

mod grid;
mod lattice;
mod moments;
mod near;
mod outline;
mod points;
mod tolerance;

use nalgebra::{
    Isometry3, Matrix3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3,
};
use rayon::prelude::*;
use surfaces::outline::Outline;
use surfaces::{Edge, EdgeKind, EdgeView, Error, FACE_AREA_MIN_M2, Face, Fit};

use crate::config::{Config, Method};
use crate::extraction::{Extraction, Segmentation, Statistics};
use crate::face::{Faces, Known, face};
use crate::plane_covariance;
use crate::scan::{Scan, tangent_frame};
use crate::segmentation;
use crate::sensor::Noise;
use crate::spherical_range_image::SphericalRangeImage;
use grid::Grid;
use lattice::{POINTS_ALIKE, VoxelLattice, WAVE_RAD};
use near::Near;
use points::Final;
use tolerance::Tolerance;

/// Side of the smallest voxels, m, and the number of sizes, each twice the one before.
const LEAF_M: f64 = 0.04;
const LEVELS: usize = 4;
/// The distance limit: no tolerance is ever larger, m.
const DISTANCE_MAX_M: f64 = 0.06;
/// The cloud's own noise counts where it is more than the sensor's, up to this many times that.
const NOISE_FACTOR_MAX: f64 = 10.0;

/// The faces of a cloud taken from `X_WV`.
pub(crate) fn extract(scan: &Scan, X_WV: &Isometry3<f64>, config: &Config) -> Extraction {
    // 1. The points within range, about the eye; their voxels, in several sizes.
    let near = Near::new(scan, config.range_max_m);
    let grid = Grid::new(near.iter(), LEAF_M, LEVELS);
    let noise = tolerance::measured(&grid.levels, &scan.noise, NOISE_FACTOR_MAX);
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
    let mut labels = points::label(&near, &grid, &found, &tolerance);
    let mut planes = points::fit(&near, &mut labels);
    // Labels are 16 bits.
    planes.truncate(usize::from(Segmentation::NONE));

    // 4. The outline of each by its points; what ends it at its edges is told by the points beside it
    // as the sensor saw them.
    let mut of_point = vec![Segmentation::NONE; scan.cloud.points.len()];
    for (number, plane) in planes.iter().enumerate() {
        for &i in &plane.members {
            of_point[near.places[i as usize] as usize] = number as u16;
        }
    }
    let own = |p: &Final| (p.plane.normal, p.plane.offset);
    let directions = SphericalRangeImage::new(
        (&scan.cloud.points, &of_point),
        &scan.eye_V,
        planes.iter().map(own).collect(),
        config.range_max_m,
        &noise,
    );
    let cloud = Cloud {
        points: &near,
        sure: &labels.sure,
        directions: &directions,
        eye_V: &scan.eye_V,
        noise: &noise,
        X_WV,
    };
    let of_plane = |(number, plane): (usize, &Final)| cloud.faces(plane, number as u16);
    let found: Vec<Vec<_>> = planes.par_iter().enumerate().map(of_plane).collect();
    let Faces {
        faces,
        planes: plane_of_face,
        refused,
    } = Faces::new(found.into_iter().flatten());

    // 5. The plane of every point.
    let grid = scan.cloud.organised;
    let (width, height) = grid.unwrap_or((scan.cloud.points.len(), 1));
    let segmentation = Segmentation {
        width,
        height,
        labels: of_point,
        plane_of_face,
        planes_V: planes.iter().map(|p| Some(p.toward(&scan.eye_V))).collect(),
    };
    let statistics = Statistics {
        points: scan.cloud.points.len(),
        valid: scan.cloud.finite().count(),
        used: near.places.len(),
        regions,
        planes: planes.len(),
        assigned: (labels.of_point.iter())
            .filter(|r| **r != segmentation::NONE)
            .count(),
    };
    Extraction {
        method: Method::Voxels,
        faces,
        refused,
        statistics,
        segmentation: Some(segmentation),
        on_face: Vec::new(),
    }
}

/// The points of a scan, and how they were seen.
struct Cloud<'a> {
    points: &'a Near<'a>,
    /// Which of them surely belong to their plane.
    sure: &'a [bool],
    directions: &'a SphericalRangeImage<'a>,
    eye_V: &'a Vector3<f64>,
    noise: &'a Noise,
    X_WV: &'a Isometry3<f64>,
}

impl Cloud<'_> {
    /// The connected faces of one plane.
    fn faces(&self, found: &Final, number: u16) -> Vec<(u16, Result<Face, Error>)> {
        // The normal toward the eye, which is the origin of the points.
        let toward = if found.plane.offset > 0.0 { -1.0 } else { 1.0 };
        let normal = found.plane.normal * toward;
        let foot = normal * (found.plane.offset * toward);
        // 1. Outlines in axes P that depend on the sensor only, so that its pose moves the faces and does
        // not change them.
        let R_VP =
            Rotation3::from_matrix_unchecked(tangent_frame(&normal, &Vector3::z(), &-Vector3::y()));
        let R_PV = R_VP.inverse();
        let in_P = |i: &u32| (R_PV * (self.points.at(*i) - foot)).xy().into();
        let sure = found.members.iter().filter(|i| self.sure[**i as usize]);
        // Nearly all are.
        let mut points: Vec<Point2<f64>> = Vec::with_capacity(found.members.len());
        points.extend(sure.map(in_P));
        let standing: Vec<Point2<f64>> = found.standing.iter().map(in_P).collect();

        let parts = outline::outlines(&points, &standing, FACE_AREA_MIN_M2);
        let area_m2 = parts.iter().map(Outline::area).sum();

        // 2. Their rings with the tangents of the world.
        let R_VW = self.X_WV.rotation.inverse();
        let up_W = R_VW * Vector3::z();
        let R_VS =
            Rotation3::from_matrix_unchecked(tangent_frame(&normal, &(R_VW * Vector3::x()), &up_W));
        let R_SP = R_VS.inverse() * R_VP;
        let in_S = |p: &[f64; 2]| (R_SP * Vector3::new(p[0], p[1], 0.0)).xy().into();
        let X_VS = Isometry3::from_parts(
            Translation3::from(foot + self.eye_V),
            UnitQuaternion::from_rotation_matrix(&R_VS),
        );
        let known = Known {
            plane: number,
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
        let of_part = |part: &Outline| {
            let rings = part.rings();
            let rings: Vec<Vec<Point2<f64>>> = (rings.iter())
                .map(|ring| ring.iter().map(in_S).collect())
                .collect();
            let kinds: Vec<Vec<EdgeKind>> = (rings.iter())
                .map(|ring| self.kinds(number, ring, &foot, &R_VS))
                .collect();
            let edge = |ring: usize, i: usize| Edge {
                kind: kinds[ring][i],
                further_m: outline::INSET_M,
                view: Some(0),
                ..Edge::default()
            };
            let covariance = |origin: &Point2<f64>| {
                let origin = foot + R_VS * origin.coords.push(0.0);
                self.covariance(found, &origin, &R_VS, area_m2)
            };
            (
                number,
                face(&rings, edge, &(self.X_WV * X_VS), &known, covariance),
            )
        };
        parts.iter().map(of_part).collect()
    }

    /// What ends a face at the edges of a ring in S, with the face on its left.
    fn kinds(
        &self,
        number: u16,
        ring: &[Point2<f64>],
        foot: &Vector3<f64>,
        R_VS: &Rotation3<f64>,
    ) -> Vec<EdgeKind> {
        let corner = |p: &Point2<f64>| Point3::from(foot + R_VS * p.coords.push(0.0));
        let corners: Vec<Point3<f64>> = ring.iter().map(corner).collect();
        let next = ring.iter().cycle().skip(1);
        let out = ring.iter().zip(next).map(|(a, b)| {
            let along = (b - a).try_normalize(1e-12).unwrap_or_default();
            R_VS * Vector3::new(along.y, -along.x, 0.0)
        });
        self.directions
            .kinds(number, &corners, &out.collect::<Vec<_>>())
    }

    /// Covariance of (rotation about x_S, rotation about y_S, offset along z_S): rad, rad, m.
    ///
    ///   σ_n² = N (σ n·r̂)²,  s² = (κ d)²/m,  tilts of the slow error up to its waves' slope
    ///
    /// with N points whose errors go together, and m waves of the slowly varying error on the faces.
    fn covariance(
        &self,
        found: &Final,
        origin: &Vector3<f64>,
        R_VS: &Rotation3<f64>,
        area_m2: f64,
    ) -> Option<[[f64; 3]; 3]> {
        let step = (found.members.len() / SUPPORT).max(1);
        let members = || found.members.iter().step_by(step);
        let count = members().count() as f64;
        let points = || members().map(|&i| self.points.at(i));
        let middle = points().sum::<Vector3<f64>>() / count;
        let (mut white, mut shape, mut range) = (Matrix3::zeros(), Matrix3::zeros(), 0.0);
        for p in points() {
            let q = R_VS.inverse() * (p - middle);
            let g = Vector3::new(q.y, -q.x, 1.0);
            let r = p.norm();
            let slant = (found.plane.normal.dot(&p).abs() / r.max(1e-9)).max(0.1);
            let sigma = self.noise.sigma_z_m(r) * slant;
            white += g * g.transpose() * (step as f64 / (POINTS_ALIKE * sigma * sigma));
            shape += g * g.transpose() / count;
            range += r / count;
        }
        let wave = WAVE_RAD * range;
        let waves = (area_m2 / (4.0 * std::f64::consts::PI * wave * wave)).max(1.0);
        let kd = self.noise.systematic_ratio * found.plane.offset.abs();
        let slope = kd / (std::f64::consts::SQRT_2 * wave);
        let to = (R_VS.inverse() * (origin - middle)).xy();
        let slow = shape * (waves / (kd * kd));
        plane_covariance::covariance(&white, &slow, [slope, slope, kd], &to)
    }
}

/// About so many points stand for all in a covariance.
const SUPPORT: usize = 400;
