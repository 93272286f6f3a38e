//! A depth image → planar surfaces, without nearest neighbours.
//!
//! For a pinhole, inverse depth on a plane is linear in the pixel, 1/z = a u + b v + c, and its
//! noise is nearly constant for sensors that triangulate. So sums over cells of pixels add up to
//! a near maximum-likelihood plane of any union of cells: no normals, no eigenvalues, no search.

mod ambiguous_borders;
mod bits;
mod borders;
mod boundary_trace;
mod cell;
mod chart;
mod contour;
mod cover;
mod edges;
mod face;
mod image;
mod label_boundaries;
mod labelling;
mod labels;
mod lattice;
mod mask;
mod moments;
mod neighbourhood;
mod object_bases;
mod outline;
mod parts;
mod pixels;
mod plane;
mod seed;
mod spread;
mod unseen_extension;
mod words;

use std::cell::Cell;

use nalgebra::Isometry3;
use rayon::prelude::*;
use surfaces::{Source, Surface};

use crate::config::Config;
use crate::extraction::{Extraction, Segmentation, Statistics};
use crate::inset;
use crate::scan::DepthImage;
use crate::segmentation::{self, Partition};
use crate::sensor::Noise;
use face::Face;
use image::{Grid, InverseImage};
use label_boundaries::LabelBoundaries;
use lattice::ImageLattice;
use moments::Moments;
use object_bases::ObjectBases;
use outline::Piece;

/// What the last image of a thread took: to be given megabytes anew takes longer than to fill them.
#[derive(Default)]
struct ScratchBuffers {
    inverse: Vec<f32>,
    small: Vec<Moments>,
    large: Vec<Moments>,
}

thread_local! {
    static SCRATCH: Cell<ScratchBuffers> = const {
        Cell::new(ScratchBuffers {
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
    config: &Config,
) -> Extraction {
    // 1. Inverse depth, and one pass to the moments of its small and large cells.
    let room = SCRATCH.take();
    let (image, valid, used) = InverseImage::new(depth, config.range_max_m, room.inverse);
    let (small, large) = Grid::both(&image, [room.small, room.large]);

    // 2. Regions over large cells, then over small ones.
    let lattice = |grid| ImageLattice { grid, noise };
    let Partition { regions, owner } = segmentation::segment(&[&lattice(&large), &lattice(&small)]);

    // 3. Every pixel to the nearest of the planes around it; gaps closed.
    let (mut labels, cells) = labels::label(&image, &small, &regions, owner, noise);
    let (none, unmeasured) = mask::close(&image, &regions, &mut labels, noise);

    // 4. The pixels that surely lie on their face: edges taken off, the feet of what stands there,
    // doubtful borders, necks.
    let cuts = LabelBoundaries::new(&labels, image.width, image.height);
    let assigned = labels.len() - none.count();
    let mut sure = mask::erode(&none, &unmeasured, &cuts);
    let feet = ObjectBases {
        image: &image,
        regions: &regions,
        labels: &labels,
        cuts: &cuts,
        none: &none,
        unmeasured: &unmeasured,
    };
    feet.drop(mask::EDGE_SEEN_PX, noise, &mut sure);
    ambiguous_borders::drop_ambiguous(&image, &regions, &cells, &labels, &mut sure, noise);
    let sure = mask::open(sure);

    // 5. The final planes, fitted to the pixels that surely lie on their face.
    let grids = (&small, &large);
    let planes = plane::fit(&image, grids, &labels, &sure, &cuts, &regions, noise);

    // 6. Each connected face of a plane, covered by convex polygons.
    let around = edges::Seen::new(depth, &image, &labels, &planes, noise);
    let pieces = |face: &Face| {
        let plane = planes.get(usize::from(face.label)).and_then(Option::as_ref);
        plane.map_or_else(Default::default, |plane| {
            outline::pieces(&image, face, &around, plane, noise, X_WV, config)
        })
    };
    // Each on its own, so on as many threads as there are.
    let connected = face::faces(&labels, &sure, &cuts);
    let found: Vec<(Vec<Piece>, Option<surfaces::Face>)> =
        connected.par_iter().map(pieces).collect();
    let (found, faces): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let mut found: Vec<Piece> = found.into_iter().flatten().collect();
    let faces = crate::face::named(faces.into_iter().flatten().collect());

    // 7. Frames to the world, last; ids by falling area.
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
        let view = config
            .inset
            .of_image(X_WV, pixel_rad, &piece.edges.inside_rad);
        inset::apply(&mut surface, &view);
        surfaces.push(surface);
    }
    // 8. What the image's border cuts may go on beyond it.
    let obstacles = unseen_extension::bodies(&faces, config.unseen_extension_m);
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
    SCRATCH.set(ScratchBuffers {
        inverse: image.w,
        small: small.cells,
        large: large.cells,
    });
    Extraction {
        surfaces,
        faces,
        obstacles,
        statistics,
        segmentation: Some(segmentation),
    }
}
