//! The paper's chain: points → convex surfaces, a file a stage.

mod crop;
mod hull;
mod normals;
mod plane_extraction;
mod projection;
mod random;
mod region_growing;
mod voxel_grid;

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Vector3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use surfaces::{ConvexPolygon, EdgeKind, Source, Surface};

pub use hull::HullConfig;
pub use normals::NormalsConfig;
pub(crate) use normals::{neighbours, normals};
pub use plane_extraction::PlaneExtractionConfig;
pub(crate) use random::Stream;
pub use region_growing::RegionGrowingConfig;
pub use voxel_grid::VoxelGridConfig;

use crate::Error;
use crate::directions::Directions;
use crate::edges::NONE;
use crate::extraction::{Extraction, Statistics};
use crate::scan::Scan;

/// Parameters of the paper's chain, a table a stage.
///
/// The paper's author used a crop at 4 m, `leaf_m` 0.01, regions of 500 to 70 000 points and the
/// other defaults. A voxel of 16 mm and smaller regions suit the noise beyond 2 m better.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ChainConfig {
    /// One point for every occupied voxel.
    pub voxel_grid: VoxelGridConfig,
    /// Normals by principal components.
    pub normals: NormalsConfig,
    /// Region growing on normals.
    pub region_growing: RegionGrowingConfig,
    /// Recursive plane extraction per cluster.
    pub plane_extraction: PlaneExtractionConfig,
    /// The convex hull.
    pub hull: HullConfig,
}

impl ChainConfig {
    pub(crate) fn check(&self, range_max_m: f64) -> Result<(), Error> {
        self.voxel_grid.check(range_max_m)?;
        self.normals.check()?;
        self.region_growing.check()?;
        self.plane_extraction.check()?;
        self.hull.check()
    }
}

/// The planar surfaces of a cloud taken from `X_WV`.
///
/// Source: [brossette2013] III-B to III-F.
///
/// # Errors
/// [`Error::Neighbours`].
#[allow(non_snake_case)]
pub(crate) fn extract(
    scan: &Scan,
    X_WV: &Isometry3<f64>,
    range_max_m: f64,
    config: &ChainConfig,
) -> Result<Extraction, Error> {
    // III-B: points within range; one for every voxel.
    let near = crop::crop(scan.cloud.points.iter(), &scan.eye_V, range_max_m);
    let points = voxel_grid::voxel_grid(&near, &scan.eye_V, &config.voxel_grid);

    // III-C: clusters of neighbours with alike normals.
    let k = config
        .normals
        .neighbours
        .max(config.region_growing.neighbours + 1);
    let neighbours = normals::neighbours(&points, k)?;
    let normals = normals::normals(&points, &neighbours, config.normals.neighbours, &scan.eye_V);
    let clusters =
        region_growing::region_growing(&points, &normals, &neighbours, &config.region_growing);

    // III-D: the planes of each cluster, recursively.
    let planes: Vec<plane_extraction::PlaneFit> = clusters
        .par_iter()
        .enumerate()
        .map(|(i, cluster)| {
            let stage = &config.plane_extraction;
            plane_extraction::plane_extraction(&points, cluster, i as u64, stage)
        })
        .collect::<Vec<_>>()
        .into_iter()
        .flatten()
        .collect();

    // III-E: inliers projected onto their plane, and their convex hull.
    let R_VW = X_WV.rotation.inverse();
    let (forward, up) = (R_VW * Vector3::x(), R_VW * Vector3::z());
    let seen = directions(scan, &points, &planes, range_max_m);
    let mut surfaces = Vec::new();
    for (number, plane) in planes.iter().enumerate() {
        let projected = projection::projection(&points, plane, &scan.eye_V, &forward, &up);
        let Some(polygon) = hull::hull(&projected.points, &config.hull) else {
            continue;
        };
        // What ends the face at the edges of its hull.
        let polygon_edges = kinds(&seen, number, &polygon, &projected.X_VS, &scan.eye_V);
        // III-F: re-orientation, of the frame only.
        surfaces.push(Surface {
            polygon_edges,
            inset_m: config.hull.inset_m,
            inliers: plane.inliers.len(),
            rms_m: plane.rms_m,
            plane_covariance: covariance(scan, plane, &projected.points),
            source: Source::Scan,
            ..Surface::new("", X_WV * projected.X_VS, polygon)
        });
    }

    // Ids by falling area.
    surfaces.sort_by(|a, b| b.polygon.area().total_cmp(&a.polygon.area()));
    for (i, surface) in surfaces.iter_mut().enumerate() {
        surface.id = format!("s{i}");
    }
    let statistics = Statistics {
        points: scan.cloud.points.len(),
        valid: scan.cloud.finite().count(),
        used: points.len(),
        regions: clusters.len(),
        planes: planes.len(),
        assigned: planes.iter().map(|p| p.inliers.len()).sum(),
    };
    Ok(Extraction {
        surfaces,
        obstacles: Vec::new(),
        statistics,
        segmentation: None,
    })
}

/// The points by their directions, with the number of their plane.
fn directions<'a>(
    scan: &'a Scan,
    points: &[Point3<f64>],
    planes: &[plane_extraction::PlaneFit],
    range_max_m: f64,
) -> Directions<'a> {
    let mut of_point = vec![NONE; points.len()];
    for (number, plane) in planes.iter().enumerate().take(usize::from(NONE)) {
        for &i in &plane.inliers {
            of_point[i] = number as u16;
        }
    }
    let from_eye = points.iter().zip(&of_point);
    let from_eye = from_eye.map(|(p, label)| (p.coords - scan.eye_V, *label));
    let from_origin = |plane: &plane_extraction::PlaneFit| {
        let offset = plane.normal.dot(&(plane.centroid.coords - scan.eye_V));
        (plane.normal, offset)
    };
    let planes = planes.iter().map(from_origin).collect();
    Directions::new(from_eye, planes, range_max_m, &scan.noise)
}

/// What ends a face at each edge of its hull in S.
#[allow(non_snake_case)]
fn kinds(
    seen: &Directions,
    number: usize,
    hull: &ConvexPolygon,
    X_VS: &Isometry3<f64>,
    eye_V: &Vector3<f64>,
) -> Vec<EdgeKind> {
    let corner = |p: &Point2<f64>| X_VS * Point3::new(p.x, p.y, 0.0) - eye_V;
    let corners: Vec<_> = hull.vertices().iter().map(corner).collect();
    let out = |h: surfaces::HalfPlane| X_VS.rotation * Vector3::new(h.n.x, h.n.y, 0.0);
    let out: Vec<_> = hull.half_planes().into_iter().map(out).collect();
    seen.kinds(number.min(usize::from(NONE)) as u16, &corners, &out)
}

/// Voxels whose errors go together: one in this many counts.
const VOXELS_ALIKE: f64 = 9.0;

/// Covariance of (rotation about x_S, rotation about y_S, offset along z_S): rad, rad, m.
///
///   Σ = N (rms² (Σ g gᵀ)⁻¹) + diag(0, 0, (κ r)²),  g = (y_S, −x_S, 1)
///
/// with N neighbours alike and the mean range r.
fn covariance(
    scan: &Scan,
    plane: &plane_extraction::PlaneFit,
    points: &[Point2<f64>],
) -> Option<[[f64; 3]; 3]> {
    let mut information = Matrix3::zeros();
    for p in points {
        let g = Vector3::new(p.y, -p.x, 1.0);
        information += g * g.transpose();
    }
    let mut sigma = information.cholesky()?.inverse() * (VOXELS_ALIKE * plane.rms_m * plane.rms_m);
    let range = (plane.centroid.coords - scan.eye_V).norm();
    sigma[(2, 2)] += (scan.noise.systematic_ratio * range).powi(2);
    let symmetric = (sigma + sigma.transpose()) * 0.5;
    let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| symmetric[(i, j)]));
    rows.iter().flatten().all(|x| x.is_finite()).then_some(rows)
}
