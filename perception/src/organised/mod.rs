//! A depth image → planar surfaces, without nearest neighbours.
//!
//! For a pinhole, inverse depth on a plane is linear in the pixel, 1/z = a u + b v + c, and its
//! noise is nearly constant for sensors that triangulate. So sums over cells of pixels add up to
//! a near maximum-likelihood plane of any union of cells: no normals, no eigenvalues, no search.

mod contour;
mod cover;
mod face;
mod growth;
mod image;
mod labels;
mod mask;
mod merge;
mod moments;
mod plane;

use nalgebra::{Isometry3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use surfaces::{ConvexPolygon, Source, Surface};

pub use cover::CoverConfig;
pub use growth::GrowthConfig;
pub use mask::MaskConfig;
pub use merge::MergeConfig;

use crate::Error;
use crate::extraction::{Extraction, Segmentation, Statistics};
use crate::scan::{DepthImage, tangent_frame};
use crate::sensor::Noise;
use face::{Face, Raster};
use growth::{Region, grow};
use image::{Grid, InverseImage};
use plane::Plane;

/// Parameters of the organised path, a table a step.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OrganisedConfig {
    /// Growth of planar regions over cells.
    pub growth: GrowthConfig,
    /// Merging of neighbouring regions.
    pub merge: MergeConfig,
    /// From labelled pixels to faces.
    pub mask: MaskConfig,
    /// From faces to convex polygons.
    pub cover: CoverConfig,
}

impl OrganisedConfig {
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.growth.check()?;
        self.merge.check()?;
        self.mask.check()?;
        self.cover.check()
    }
}

/// The planar surfaces of a depth image taken from `X_WV`.
///
/// # Errors
/// [`Error::Surface`] if a polygon is refused.
#[allow(non_snake_case)]
pub(crate) fn extract(
    depth: &DepthImage,
    noise: &Noise,
    X_WV: &Isometry3<f64>,
    range_max_m: f64,
    config: &OrganisedConfig,
) -> Result<Extraction, Error> {
    // 1. Inverse depth, and one pass to the moments of its cells.
    let image = InverseImage::new(depth, range_max_m);
    let small = Grid::new(&image);

    // 2. Regions over large cells, merged where one plane explains two neighbours.
    let large = small.coarser();
    let grown = grow(&large, &|_| true, noise, &config.growth);
    let regions = grown
        .into_iter()
        .map(|region| refined(&large, &small, region))
        .collect();
    let regions = merge::merge(&small, regions, noise, &config.merge);

    // 3. A second pass over the small cells that are left; merge again.
    let mut taken = vec![false; small.cells.len()];
    for &cell in regions.iter().flat_map(|region: &Region| &region.cells) {
        taken[cell] = true;
    }
    let more = grow(&small, &|i| !taken[i], noise, &config.growth);
    let regions = regions.into_iter().chain(more).collect();
    let regions = merge::merge(&small, regions, noise, &config.merge);

    // 4. Every pixel to the nearest of the planes around it; gaps closed, edges taken off.
    let mut labels = labels::label(&image, &small, &regions, noise);
    mask::close(&image, &regions, &mut labels, noise, config.mask.gap_px);
    let eroded = mask::erode(&labels, image.width, image.height, config.mask.edge_px);

    // 5. The final planes, fitted to the pixels that surely lie on their face.
    let planes = plane::fit(&image, &eroded, regions.len(), noise);

    // 6. Each connected face of a plane, covered by convex polygons.
    let mut found = Vec::new();
    for face in face::faces(&eroded, image.width) {
        if let Some(Some(plane)) = planes.get(usize::from(face.label)) {
            found.extend(pieces(&image, &face, plane, noise, X_WV, config));
        }
    }

    // 7. Frames to the world, last; ids by falling area.
    found.sort_by(|a, b| b.polygon.area().total_cmp(&a.polygon.area()));
    let shared = |label: u16| found.iter().filter(|p| p.label == label).count() > 1;
    let mut surfaces = Vec::with_capacity(found.len());
    for (i, piece) in found.iter().enumerate() {
        let Some(plane) = planes
            .get(usize::from(piece.label))
            .and_then(Option::as_ref)
        else {
            continue;
        };
        surfaces.push(Surface {
            outline: piece.outline.clone(),
            inliers: plane.inliers,
            rms_m: plane.rms_m,
            plane_covariance: piece.covariance,
            source: Source::Scan,
            face: shared(piece.label).then(|| format!("f{}", piece.label)),
            ..Surface::new(format!("s{i}"), X_WV * piece.X_VS, piece.polygon.clone())
        });
    }
    let statistics = Statistics {
        points: depth.z_m.len(),
        valid: depth.z_m.iter().filter(|z| **z > 0.0).count(),
        used: image.w.iter().filter(|w| **w > 0.0).count(),
        regions: regions.len(),
        planes: planes.iter().flatten().count(),
        assigned: labels.iter().filter(|l| **l != labels::NONE).count(),
    };
    let segmentation = Segmentation {
        width: image.width,
        height: image.height,
        labels,
        plane_of_surface: found.iter().map(|p| p.label).collect(),
        planes_V: planes
            .iter()
            .map(|p| p.map(|p| (-p.normal, p.distance)))
            .collect(),
    };
    Ok(Extraction {
        surfaces,
        statistics,
        segmentation: Some(segmentation),
    })
}

/// A region's cells on the grid that is twice as fine.
fn refined(large: &Grid, small: &Grid, region: Region) -> Region {
    let fine = |i: &usize| {
        let corner = 2 * (i / large.cols) * small.cols + 2 * (i % large.cols);
        [
            corner,
            corner + 1,
            corner + small.cols,
            corner + small.cols + 1,
        ]
    };
    Region {
        cells: region.cells.iter().flat_map(fine).collect(),
        ..region
    }
}

/// One convex polygon of a face, in its frame.
#[allow(non_snake_case)]
struct Piece {
    label: u16,
    X_VS: Isometry3<f64>,
    polygon: ConvexPolygon,
    outline: Vec<Vec<[f64; 2]>>,
    covariance: Option<[[f64; 3]; 3]>,
}

/// The convex pieces that cover a face.
///
/// A plane maps to the image by a homography that keeps convex sets convex, so the cover is found
/// on the pixels, where the uncertainty of an edge has one size, and then mapped to the plane.
#[allow(non_snake_case)]
fn pieces(
    image: &InverseImage,
    face: &Face,
    plane: &Plane,
    noise: &Noise,
    X_WV: &Isometry3<f64>,
    config: &OrganisedConfig,
) -> Vec<Piece> {
    let area: f64 = face
        .runs
        .iter()
        .map(|&(v, a, b)| {
            let middle = f64::from(a + b - 1) / 2.0;
            f64::from(b - a) * plane.pixel_area(image, middle, f64::from(v))
        })
        .sum();
    if area < config.cover.area_min_m2 {
        return Vec::new();
    }
    let (Ok(hull), Some(raster)) = (ConvexPolygon::hull(&face.extremes()), Raster::new(face))
    else {
        return Vec::new();
    };
    let region = cover::Region {
        samples: samples(image, &raster, &hull, plane),
        outside: raster.outside(),
        hull,
    };
    let outline = contour::rings(&raster, 1.0);
    let chunks = chunks(face);
    let rotation = frame(plane, X_WV);
    let in_V = |p: &Point2<f64>| plane.point(image, p.x, p.y);
    let mut pieces = Vec::new();
    for piece in cover::cover(&region, &config.cover) {
        // Corners on the plane; the origin at the piece's centroid.
        let Some(corners) = piece
            .vertices()
            .iter()
            .map(in_V)
            .collect::<Option<Vec<_>>>()
        else {
            continue;
        };
        let Some(anchor) = corners.first().copied() else {
            continue;
        };
        let onto = |origin: Point3<f64>| {
            move |p: &Point3<f64>| {
                let q = rotation.inverse() * (p - origin);
                Point2::new(q.x, q.y)
            }
        };
        let Ok(rough) = ConvexPolygon::hull(&corners.iter().map(onto(anchor)).collect::<Vec<_>>())
        else {
            continue;
        };
        let rough = rough.simplified_inside(config.cover.vertices_max);
        let c = rough.centroid();
        let origin = anchor + rotation * Vector3::new(c.x, c.y, 0.0);
        let moved: Vec<_> = rough.vertices().iter().map(|v| v - c.coords).collect();
        let Ok(polygon) = ConvexPolygon::new(moved) else {
            continue;
        };
        let narrow = 2.0 * polygon.inscribed_circle().1 < config.cover.width_min_m;
        if polygon.area() < config.cover.area_min_m2 || narrow {
            continue;
        }
        let X_VS = Isometry3::from_parts(
            Translation3::from(origin),
            UnitQuaternion::from_rotation_matrix(&rotation),
        );
        let ring = |ring: &Vec<Point2<f64>>| {
            ring.iter()
                .filter_map(in_V)
                .map(|p| onto(origin)(&p).coords.into())
                .collect()
        };
        pieces.push(Piece {
            label: face.label,
            X_VS,
            outline: outline.iter().map(ring).collect(),
            covariance: plane::covariance(image, &chunks, plane, &origin, &rotation, noise),
            polygon,
        });
    }
    pieces
}

/// Orientation of S in V: z_S toward the sensor.
#[allow(non_snake_case)]
fn frame(plane: &Plane, X_WV: &Isometry3<f64>) -> Rotation3<f64> {
    let R_VW = X_WV.rotation.inverse();
    let columns = tangent_frame(
        &-plane.normal,
        &(R_VW * Vector3::x()),
        &(R_VW * Vector3::z()),
    );
    Rotation3::from_matrix_unchecked(columns)
}

/// A lattice of samples of the hull, at most about a thousand.
fn samples(
    image: &InverseImage,
    raster: &Raster,
    hull: &ConvexPolygon,
    plane: &Plane,
) -> Vec<cover::Sample> {
    let stride = ((raster.inside.len() as f64 / 1200.0).sqrt().ceil() as usize).max(1);
    let planes = hull.half_planes();
    let rows = raster.inside.len() / raster.stride.max(1);
    let mut samples = Vec::new();
    for y in (stride / 2..rows).step_by(stride) {
        for x in (stride / 2..raster.stride).step_by(stride) {
            let i = y * raster.stride + x;
            let p = raster.point(i);
            let inside = raster.inside[i];
            if inside || planes.iter().all(|h| h.value(&p) <= 0.0) {
                let cells = (stride * stride) as f64;
                let area_m2 = cells * plane.pixel_area(image, p.x, p.y);
                samples.push(cover::Sample { p, area_m2, inside });
            }
        }
    }
    samples
}

/// Middle and number of pixels of pieces of the face's runs.
fn chunks(face: &Face) -> Vec<(f64, f64, f64)> {
    let mut chunks = Vec::new();
    for &(v, a, b) in face.runs.iter().step_by(4) {
        let mut u = a;
        while u < b {
            let end = (u + 16).min(b);
            let n = f64::from(end - u);
            // Every fourth row stands for four.
            chunks.push((f64::from(u) + (n - 1.0) / 2.0, f64::from(v), 4.0 * n));
            u = end;
        }
    }
    chunks
}
