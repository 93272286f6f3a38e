//! Planar regions over cells of additive moments, whatever the cells are.
//!
//! ```text
//! from the largest cells down:  grow ─ border refinement (images) ─ merge
//! over the smallest:            thin faces ─ merge ─ border refinement ─ bodies ─ slivers ─ occlusion merge
//! ```
//!
//! The cells are those of an image or hashed voxels ([`Lattice`]); each step is written once.

mod between;
mod bodies;
mod border_refinement;
mod growth;
mod lattice;
mod merge;
mod moments;
mod occlusion_merge;
mod partition;
mod slivers;
mod thin_faces;

pub(crate) use lattice::{Border, Lattice, Seed, Shape, View, seed_of};
pub(crate) use moments::Moments;
pub(crate) use partition::{NONE, Partition, Region};
#[cfg(test)]
pub(crate) use slivers::drop_slivers;

use growth::Growth;

/// A cell joins a region while its misfit to the plane, beyond its own noise, is below
/// √((k σ)² + (m κ)²): k and m.
pub(crate) const MISFIT: (f64, f64) = (1.2, 1.5);
/// Points belong to a plane within √((k σ)² + (m κ)²) of it: k and m.
pub(crate) const ON_PLANE: (f64, f64) = (3.0, 2.0);

/// The border between planes that agree to this many κ is anywhere: it is in neither face's outline.
pub(crate) const AMBIGUOUS_SYSTEMATICS: f64 = 1.5;

/// The regions of the smallest cells; `levels` are from the largest cells to the smallest.
pub(crate) fn segment<L: Lattice>(levels: &[&L]) -> Partition<L::Moments> {
    let mut partition = Partition::default();
    let mut coarse: Option<&L> = None;
    for (i, &level) in levels.iter().enumerate() {
        // 1. What the larger cells have shown, merged where one plane explains two neighbours.
        match coarse {
            None => partition.owner = vec![NONE; level.cells().len()],
            Some(coarse) => {
                partition.owner = level.inherit_owners(coarse, &partition.owner);
                // A ramp takes a band of the floor along its foot, and what lies before that would be beside
                // the ramp alone. Clouds gain nothing by it: as much is off the faces, and of nine tilted blocks
                // of a real one eight are left. Regions that one plane explains keep their border, which is none
                // of a face's: it would only part them more.
                if !L::RESUMES {
                    let apart = merge::apart(level, &partition);
                    border_refinement::refine(level, &mut partition, |pair| apart.contains(pair));
                }
                merge::merge(level, &mut partition);
            }
        }
        coarse = Some(level);
        // 2. Over the cells that are left those regions go on, and new ones grow.
        let mut growth = Growth::new(level, |cell| partition.owner[cell] == NONE);
        if L::RESUMES && i > 0 {
            growth.resume(&mut partition);
        }
        growth
            .regions(Shape::Block)
            .into_iter()
            .for_each(|grown| partition.add(grown));
        // 3. At last thin faces, which no block of cells fits in.
        if i + 1 == levels.len() {
            let thin = thin_faces::found(&mut growth, &partition);
            thin.into_iter().for_each(|grown| partition.add(grown));
        }
    }
    let Some(finest) = coarse else {
        return partition;
    };
    // 4. Merge again, move the borders to where the planes meet, tell bodies in one plane apart, and drop what the planes
    // around it explain.
    merge::merge(finest, &mut partition);
    border_refinement::refine(finest, &mut partition, |_| true);
    let view = finest.view();
    bodies::part(finest, &view, &mut partition);
    slivers::drop_slivers(finest, &mut partition);
    // 5. One plane for what goes on behind something nearer.
    occlusion_merge::merge(finest, &view, &mut partition);
    partition
}
