//! The paper's chain: points → convex faces, a file a stage.

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
use surfaces::covariance::carried;
use surfaces::{ConvexPolygon, Edge, EdgeKind, EdgeView, Fit};

pub(crate) use normals::{neighbours, normals};
pub(crate) use random::Stream;

use crate::Error;
use crate::edges::NONE;
use crate::error::within;
use crate::extraction::{Extraction, Statistics};
use crate::face::{Faces, Known, face};
use crate::scan::Scan;
use crate::spherical_range_image::SphericalRangeImage;

/// Parameters of the method of \[brossette2013\].
///
/// The paper's author used a crop at 4 m, a `leaf_m` of 0.01 and regions from 500 points on. A voxel of
/// 16 mm and smaller regions suit the noise beyond 2 m better.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Brossette2013Config {
    /// Side of the voxels of which each keeps one point, m.
    #[schemars(range(min = 0.002, max = 1.0))]
    pub leaf_m: f64,
    /// Smallest region and smallest plane, points.
    #[schemars(range(min = 3, max = 1_000_000))]
    pub points_min: usize,
    /// Seed of the random samples.
    #[serde(skip)]
    pub seed: u64,
}

impl Default for Brossette2013Config {
    fn default() -> Self {
        Self {
            leaf_m: 0.016,
            points_min: 150,
            seed: 0,
        }
    }
}

impl Brossette2013Config {
    pub(crate) fn check(&self, range_max_m: f64) -> Result<(), Error> {
        // A voxel's place along an axis has to fit 21 bits.
        let least = (range_max_m / f64::from(1 << 19)).max(1e-6);
        let cause = "must be positive, and not tiny for the range";
        within("brossette2013.leaf_m", self.leaf_m, least, 1e3, cause)
    }
}

/// Neighbours that a normal is fitted to, the point itself included.
const NORMAL_NEIGHBOURS: usize = 50;

/// The faces of a cloud taken from `X_WV`.
///
/// Source: \[brossette2013\] III-B to III-F.
///
/// # Errors
/// [`Error::Neighbours`].
pub(crate) fn extract(
    scan: &Scan,
    X_WV: &Isometry3<f64>,
    range_max_m: f64,
    config: &Brossette2013Config,
) -> Result<Extraction, Error> {
    // III-B: points within range; one for every voxel.
    let near = crop::crop(scan.cloud.points.iter(), &scan.eye_V, range_max_m);
    let points = voxel_grid::voxel_grid(&near, &scan.eye_V, config.leaf_m);

    // III-C: clusters of neighbours with alike normals.
    let k = NORMAL_NEIGHBOURS.max(region_growing::NEIGHBOURS + 1);
    let neighbours = normals::neighbours(&points, k)?;
    let normals = normals::normals(&points, &neighbours, NORMAL_NEIGHBOURS, &scan.eye_V);
    let clusters =
        region_growing::region_growing(&points, &normals, &neighbours, config.points_min);

    // III-D: the planes of each cluster, recursively.
    let planes: Vec<plane_extraction::PlaneFit> = clusters
        .par_iter()
        .enumerate()
        .map(|(i, cluster)| plane_extraction::plane_extraction(&points, cluster, i as u64, config))
        .collect::<Vec<_>>()
        .into_iter()
        .flatten()
        .collect();

    // III-E: inliers projected onto their plane, and their convex hull.
    let R_VW = X_WV.rotation.inverse();
    let (forward, up) = (R_VW * Vector3::x(), R_VW * Vector3::z());
    let seen = directions(scan, &points, &planes, range_max_m);
    let mut found = Vec::new();
    for (number, plane) in planes.iter().enumerate() {
        let projected = projection::projection(&points, plane, &scan.eye_V, &forward, &up);
        let Some(hull) = hull::hull(&projected.points) else {
            continue;
        };
        // What ends the face at the edges of its hull.
        let number = number.min(usize::from(NONE)) as u16;
        let kinds = kinds(&seen, number, &hull, &projected.X_VS, &scan.eye_V);
        let edge = |_, i: usize| Edge {
            kind: kinds[i],
            further_m: hull::INSET_M,
            view: Some(0),
            ..Edge::default()
        };
        let known = Known {
            plane: number,
            fit: Fit {
                points: plane.inliers.len(),
                rms_m: plane.rms_m,
            },
            view: EdgeView {
                eye_W: X_WV * Point3::from(scan.eye_V),
                sigma_rad: 0.0,
                plane_covariance: None,
            },
        };
        let sigma = covariance(scan, plane, &projected.points);
        let at = |origin: &Point2<f64>| sigma.map(|rows| carried(&rows, &origin.coords));
        // III-F: re-orientation, of the frame only.
        let rings = [hull.vertices().to_vec()];
        found.push((
            number,
            face(&rings, edge, &(X_WV * projected.X_VS), &known, at),
        ));
    }
    let Faces { faces, refused, .. } = Faces::new(found);
    let statistics = Statistics {
        points: scan.cloud.points.len(),
        valid: scan.cloud.finite().count(),
        used: points.len(),
        regions: clusters.len(),
        planes: planes.len(),
        assigned: planes.iter().map(|p| p.inliers.len()).sum(),
    };
    Ok(Extraction {
        method: crate::Method::Brossette2013,
        faces,
        refused,
        statistics,
        segmentation: None,
        on_face: Vec::new(),
    })
}

/// The points by their directions, with the number of their plane.
fn directions<'a>(
    scan: &'a Scan,
    points: &[Point3<f64>],
    planes: &[plane_extraction::PlaneFit],
    range_max_m: f64,
) -> SphericalRangeImage<'a> {
    let mut of_point = vec![NONE; points.len()];
    for (number, plane) in planes.iter().enumerate().take(usize::from(NONE)) {
        for &i in &plane.inliers {
            of_point[i] = number as u16;
        }
    }
    let points: Vec<[f32; 3]> = (points.iter())
        .map(|p| [p.x, p.y, p.z].map(|c| c as f32))
        .collect();
    let from_origin = |plane: &plane_extraction::PlaneFit| {
        let offset = plane.normal.dot(&(plane.centroid.coords - scan.eye_V));
        (plane.normal, offset)
    };
    let planes = planes.iter().map(from_origin).collect();
    SphericalRangeImage::new(
        (&points, &of_point),
        &scan.eye_V,
        planes,
        range_max_m,
        &scan.noise,
    )
}

/// What ends a face at each edge of its hull in S.
fn kinds(
    seen: &SphericalRangeImage,
    number: u16,
    hull: &ConvexPolygon,
    X_VS: &Isometry3<f64>,
    eye_V: &Vector3<f64>,
) -> Vec<EdgeKind> {
    let corner = |p: &Point2<f64>| X_VS * Point3::new(p.x, p.y, 0.0) - eye_V;
    let corners: Vec<_> = hull.vertices().iter().map(corner).collect();
    let out = |h: surfaces::HalfPlane| X_VS.rotation * Vector3::new(h.n.x, h.n.y, 0.0);
    let out: Vec<_> = hull.half_planes().into_iter().map(out).collect();
    seen.kinds(number, &corners, &out)
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
