//! A depth image → planar surfaces, without nearest neighbours.
//!
//! For a pinhole, inverse depth on a plane is linear in the pixel, 1/z = a u + b v + c, and its
//! noise is nearly constant for sensors that triangulate. So sums over cells of pixels add up to
//! a near maximum-likelihood plane of any union of cells: no normals, no eigenvalues, no search.

mod beyond;
mod bits;
mod borders;
mod boundary;
mod cell;
mod chart;
mod claimed;
mod contour;
mod cover;
mod cuts;
mod doubt;
mod edges;
mod exchange;
mod face;
mod feet;
mod growth;
mod hidden;
mod image;
mod labels;
mod mask;
mod merge;
mod moments;
mod narrow;
mod near;
mod outline;
mod painter;
mod partition;
mod parts;
mod pixels;
mod plane;
mod seed;
mod words;

use std::cell::Cell;

use nalgebra::Isometry3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use surfaces::{Source, Surface};

pub use beyond::BeyondConfig;
pub use cover::CoverConfig;
pub use growth::GrowthConfig;
pub use mask::MaskConfig;
pub use merge::MergeConfig;
pub use outline::OutlineConfig;

use crate::Error;
use crate::extraction::{Extraction, Segmentation, Statistics};
use crate::inset::{self, InsetConfig};
use crate::scan::DepthImage;
use crate::sensor::Noise;
use cuts::Cuts;
use face::Face;
use feet::Feet;
use growth::Growth;
use image::{Grid, InverseImage};
use moments::Moments;
use outline::Piece;
use partition::Partition;
use seed::Shape;

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
    /// From faces to outlines and convex polygons.
    pub outline: OutlineConfig,
    /// Where faces may go on beyond the image.
    pub beyond: BeyondConfig,
}

impl OrganisedConfig {
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.growth.check()?;
        self.merge.check()?;
        self.mask.check()?;
        self.outline.check()?;
        self.beyond.check()
    }
}

/// What the last image of a thread took: to be given megabytes anew takes longer than to fill them.
#[derive(Default)]
struct Room {
    inverse: Vec<f32>,
    small: Vec<Moments>,
    large: Vec<Moments>,
}

thread_local! {
    static ROOM: Cell<Room> = const {
        Cell::new(Room {
            inverse: Vec::new(),
            small: Vec::new(),
            large: Vec::new(),
        })
    };
}

/// The planar surfaces of a depth image taken from `X_WV`.
#[allow(non_snake_case)]
pub(crate) fn extract(
    depth: &DepthImage,
    noise: &Noise,
    X_WV: &Isometry3<f64>,
    range_max_m: f64,
    config: &OrganisedConfig,
    inset: &InsetConfig,
) -> Extraction {
    // 1. Inverse depth, and one pass to the moments of its small and large cells.
    let room = ROOM.take();
    let (image, valid, used) = InverseImage::new(depth, range_max_m, room.inverse);
    let (small, large) = Grid::both(&image, [room.small, room.large]);

    // 2. Regions over large cells, merged where one plane explains two neighbours.
    let least = config.growth.pixels_min;
    let grown =
        Growth::new(&large, |_| true, noise, &config.growth).regions(&[Shape::BLOCK], least);
    let mut partition = Partition::new(&small);
    let grown = grown.into_iter();
    grown.for_each(|grown| partition.add_large(grown, &large, &small));
    merge::merge(&small, &mut partition, noise, &config.merge);

    // 3. A second pass over the small cells that are left, then narrow faces; merge again, move the
    // borders between regions to where the planes are, and drop what the planes around it explain.
    let free = |i: usize| partition.owner[i] == labels::NONE;
    let mut growth = Growth::new(&small, free, noise, &config.growth);
    let grown = growth.regions(&[Shape::BLOCK], least).into_iter();
    grown.for_each(|grown| partition.add(grown));
    let grown = narrow::found(&mut growth, &partition, noise).into_iter();
    grown.for_each(|grown| partition.add(grown));
    merge::merge(&small, &mut partition, noise, &config.merge);
    exchange::exchange(&small, &mut partition, noise, &config.growth);
    claimed::drop_claimed(&small, &mut partition, noise, &config.growth);

    // 4. One plane for what goes on behind something nearer.
    hidden::merge(&small, &mut partition, noise, &config.merge);

    // 5. Every pixel to the nearest of the planes around it; gaps closed.
    let Partition { regions, owner } = partition;
    let (mut labels, cells) = labels::label(&image, &small, &regions, owner, noise);
    let mask = &config.mask;
    let (none, unmeasured) = mask::close(&image, &regions, &mut labels, noise, mask.gap_px);

    // 6. The pixels that surely lie on their face: edges taken off, the feet of what stands there,
    // doubtful borders, necks.
    let cuts = Cuts::new(&labels, image.width, image.height);
    let assigned = labels.len() - none.count();
    let (unseen, seen) = (mask.edge_unseen_px, mask.edge_seen_px);
    let mut sure = mask::erode(&none, &unmeasured, &cuts, unseen, seen);
    let feet = Feet {
        image: &image,
        regions: &regions,
        labels: &labels,
        cuts: &cuts,
        none: &none,
        unmeasured: &unmeasured,
    };
    feet.drop(seen, noise, &mut sure);
    let doubt = mask.doubt_systematics;
    doubt::drop_doubtful(&image, &regions, &cells, &labels, &mut sure, doubt, noise);
    let sure = mask::open(sure, mask.neck_px);

    // 7. The final planes, fitted to the pixels that surely lie on their face.
    let grids = (&small, &large);
    let planes = plane::fit(&image, grids, &labels, &sure, &cuts, &regions, noise);

    // 8. Each connected face of a plane, covered by convex polygons.
    let around = edges::Seen::new(depth, &image, &labels, &planes, noise);
    let pieces = |face: &Face| {
        let plane = planes.get(usize::from(face.label)).and_then(Option::as_ref);
        plane.map_or_else(Vec::new, |plane| {
            let config = &config.outline;
            outline::pieces(&image, face, &around, plane, noise, X_WV, config)
        })
    };
    // Each on its own, so on as many threads as there are.
    let connected = face::faces(&labels, &sure, &cuts);
    let of_faces = connected.par_iter().map(pieces);
    let mut found: Vec<Piece> = of_faces.flatten_iter().collect();

    // 9. Frames to the world, last; ids by falling area.
    found.sort_by(|a, b| b.polygon.area().total_cmp(&a.polygon.area()));
    let plane_of_surface: Vec<u16> = found.iter().map(|p| p.label).collect();
    let mut surfaces = Vec::with_capacity(found.len());
    for (i, piece) in found.into_iter().enumerate() {
        let label = usize::from(piece.label);
        let Some(plane) = planes.get(label).and_then(Option::as_ref) else {
            continue;
        };
        let of_plane = plane_of_surface.iter().filter(|l| **l == piece.label);
        let mut surface = Surface {
            outline: piece.outline,
            inliers: plane.inliers,
            rms_m: plane.rms_m,
            plane_covariance: piece.covariance,
            source: Source::Scan,
            face: (of_plane.count() > 1).then(|| format!("f{label}")),
            ..Surface::new(format!("s{i}"), X_WV * piece.X_VS, piece.polygon)
        };
        surface.set_outline_edges(piece.edges.kinds.clone());
        let pixel_rad = 1.0 / image.intrinsics.fx;
        let view = inset.of_image(X_WV, pixel_rad, &piece.edges.inside_rad);
        inset::apply(&mut surface, &view);
        surfaces.push(surface);
    }
    // 10. What the image's border cuts may go on beyond it.
    let obstacles = beyond::bodies(&surfaces, &config.beyond);
    let statistics = Statistics {
        points: depth.z_m.len(),
        valid,
        used,
        regions: regions.len(),
        planes: planes.iter().flatten().count(),
        assigned,
    };
    let segmentation = Segmentation {
        width: image.width,
        height: image.height,
        labels,
        plane_of_surface,
        planes_V: planes
            .iter()
            .map(|p| p.map(|p| (-p.normal, p.distance)))
            .collect(),
    };
    ROOM.set(Room {
        inverse: image.w,
        small: small.cells,
        large: large.cells,
    });
    Extraction {
        surfaces,
        obstacles,
        statistics,
        segmentation: Some(segmentation),
    }
}
