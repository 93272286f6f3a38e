//! A depth image → plane faces, without nearest neighbours.
//!
//! For a pinhole, inverse depth on a plane is linear in the pixel, 1/z = a u + b v + c, and its
//! noise is nearly constant for sensors that triangulate. So sums over cells of pixels add up to
//! a near maximum-likelihood plane of any union of cells: no normals, no eigenvalues, no search.

mod ambiguous_borders;
mod binning;
mod bits;
mod borders;
mod boundary_trace;
mod cell;
mod chart;
mod contour;
mod edges;
mod face;
mod folds;
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
mod words;

use std::cell::Cell;

use nalgebra::Isometry3;
use rayon::prelude::*;

use crate::config::{Config, Method};
use crate::extraction::{Extraction, Segmentation, Statistics};
use crate::face::Faces;
use crate::scan::DepthImage;
use crate::segmentation::{self, Partition};
use crate::sensor::Noise;
use chart::Chart;
use face::Face;
use image::{Grid, InverseImage};
use label_boundaries::LabelBoundaries;
use lattice::ImageLattice;
use moments::Moments;
use object_bases::ObjectBases;
use plane::Plane;
use spread::Spread;

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

/// Where the median small cell has fewer pixels, the outlines of the image fall apart, and a cloud shows more: of 4 of 16
/// measured at random both cover the same of the faces.
const USUAL_MIN: f64 = 4.0;

/// The faces of a depth image taken from `X_WV`; `None` where too many pixels are missing, unless the
/// image is asked for.
pub(crate) fn extract(
    depth: &DepthImage,
    noise: &Noise,
    X_WV: &Isometry3<f64>,
    config: &Config,
) -> Option<Extraction> {
    // An image finer than pixels are meant here is taken in blocks of them.
    let (all, ratio) = (depth, binning::ratio(depth));
    let coarse = (ratio > 1).then(|| binning::binned(all, ratio, noise));
    let depth = coarse.as_ref().unwrap_or(all);

    // 1. Inverse depth, and one pass to the moments of its small and large cells.
    let room = SCRATCH.take();
    let (image, valid, used) = InverseImage::new(depth, config.range_max_m, room.inverse);
    let (small, large) = Grid::both(&image, [room.small, room.large]);

    // 2. Regions over large cells, then over small ones.
    let lens = &image.lens();
    let lattice = |grid| ImageLattice { grid, lens, noise };
    if config.method == Method::Auto && small.usual < USUAL_MIN && used > 0 {
        return None;
    }
    let Partition { regions, owner } = segmentation::segment(&[&lattice(&large), &lattice(&small)]);

    // 3. Every pixel to the nearest of the planes around it; gaps closed.
    let (mut labels, cells) = labels::label(&image, &small, &regions, owner, noise);
    let (none, unmeasured) = mask::close(&image, &regions, &mut labels, noise);

    // 4. The pixels that surely lie on their face: edges taken off, the feet of what stands there,
    // doubtful borders, necks.
    let cuts = LabelBoundaries::new(&labels, image.width, image.height);
    let assigned = labels.len() - none.count();
    let [edges, steps] = folds::without_folds(&image, &regions, &labels, &cuts, noise);
    let mut sure = mask::erode(&none, &unmeasured, &edges, &steps);
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

    // 6. How well each plane is known, and each connected face of it, on as many threads as there are.
    let around = edges::Seen::new(depth, &image, &labels, &planes, noise);
    let connected = face::faces(&labels, &sure, &cuts);
    let known = |label: usize| {
        let plane: &Plane = planes[label].as_ref()?;
        let its = connected
            .iter()
            .filter(|face| usize::from(face.label) == label);
        let chart = Chart::new(&image, plane);
        let spread = Spread::new(&its.collect::<Vec<_>>(), plane, &chart, noise);
        Some((plane, chart, spread))
    };
    let known: Vec<_> = (0..planes.len()).into_par_iter().map(known).collect();
    let of_pixels = |pixels: &Face| {
        let known = known.get(usize::from(pixels.label))?.as_ref()?;
        let face = outline::face(&image, pixels, &around, known, noise, X_WV)?;
        Some((pixels.label, face))
    };
    let found: Vec<_> = connected.par_iter().map(of_pixels).collect();
    let mut on_face = vec![false; labels.len()];
    let is_face =
        |(_, found): &(&Face, &Option<(u16, Result<_, _>)>)| matches!(found, Some((_, Ok(_))));
    let held = connected.iter().zip(&found).filter(is_face);
    for &(v, a, b) in held.flat_map(|(pixels, _)| &pixels.runs) {
        let [first, end] = [a, b].map(|u| v as usize * image.width + u as usize);
        on_face[first..end].fill(true);
    }
    let found: Vec<_> = found.into_iter().flatten().collect();
    let Faces {
        faces,
        planes: plane_of_face,
        refused,
    } = Faces::new(found);

    let statistics = Statistics {
        points: depth.z_m.len(),
        valid,
        used,
        regions: regions.len(),
        planes: planes.iter().flatten().count(),
        assigned,
    };
    let segmentation = Segmentation {
        width: all.width,
        height: all.height,
        labels: match ratio {
            1 => labels,
            _ => binning::spread(&labels, image.width, all, ratio, Segmentation::NONE),
        },
        plane_of_face,
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
    Some(Extraction {
        method: Method::Organised,
        faces,
        refused,
        statistics,
        segmentation: Some(segmentation),
        on_face: match ratio {
            1 => on_face,
            _ => binning::spread(&on_face, image.width, all, ratio, false),
        },
    })
}
