//! Regions of one plane that are several bodies.
//!
//! Seats of one height are one plane, and a region grows from one to the next where what is between them was not
//! measured. Where the sensor looked through the plane between parts of it they are not one body.

use std::borrow::Cow;
use std::cmp::Reverse;

use super::between::{Ends, Lines, ends};
use super::lattice::{Lattice, PlaneOf, Shape, View};
use super::moments::Moments;
use super::partition::{Grown, NONE, Partition, Region};

/// Leaves each region one of its bodies; the others become regions.
///
/// Parts that do not touch in the view, and are large enough to be regions, are two bodies where most rows and columns of the view
/// that hold both show what is beyond the plane between them. Smaller ones are of the body next to them.
pub(super) fn part<L: Lattice>(lattice: &L, view: &View, partition: &mut Partition<L::Moments>) {
    let mut regions = parts(view, &partition.owner, partition.regions.len());
    regions.retain_mut(|parts| {
        // The largest first, and then those that would be regions.
        parts.sort_by_key(|part| Reverse(part.len()));
        let mut number = 0..;
        parts.retain(|part| {
            let is_large = || lattice.is_region(Shape::Block, &sum(lattice, part), part.len());
            number.next() == Some(0) || is_large()
        });
        parts.len() > 1
    });
    if regions.is_empty() {
        return;
    }
    let mut number = vec![NONE; partition.owner.len()];
    for (k, part) in (0..).zip(regions.iter().flatten()) {
        part.iter().for_each(|cell| number[*cell] = k);
    }
    let ends = ends(view, &number, regions.iter().map(Vec::len).sum());
    let mut ends = &ends[..];
    for parts in regions {
        let its;
        (its, ends) = ends.split_at(parts.len());
        let own = partition.owner[parts[0][0]];
        let plane = partition.regions[usize::from(own)].plane;
        let body = bodies(lattice, view, its, &plane);
        if body.iter().all(|k| *k == 0) {
            continue;
        }
        number.fill(NONE);
        for (part, body) in parts.iter().zip(&body) {
            part.iter().for_each(|cell| number[*cell] = *body);
        }
        spread(lattice, &mut number);
        for other in (1..).take(parts.len() - 1).filter(|k| body.contains(k)) {
            let is_its = |cell: &usize| partition.owner[*cell] == own && number[*cell] == other;
            let cells: Vec<usize> = (0..number.len()).filter(is_its).collect();
            let moments = sum(lattice, &cells);
            if let Some(plane) = moments.plane() {
                let region = Region { moments, plane };
                partition.add(Grown { region, cells });
                let left = &mut partition.regions[usize::from(own)].moments;
                left.add(&moments, -1.0);
            }
        }
        let left = &mut partition.regions[usize::from(own)];
        left.plane = left.moments.plane().unwrap_or(left.plane);
    }
}

/// The first part of each part's body, from the ends of all.
fn bodies<L: Lattice>(lattice: &L, view: &View, ends: &[Ends], plane: &PlaneOf<L>) -> Vec<u16> {
    let mut first: Vec<u16> = Vec::new();
    for (number, its) in (0..).zip(ends) {
        let (mut body, mut is_told) = (None, false);
        for (other, of_other) in first.iter().zip(ends) {
            let lines = Lines::new(lattice, view, [of_other, its], plane);
            let others = lines.hidden + lines.other;
            is_told |= lines.through > 0;
            if others > 0 && lines.through <= others {
                body = Some(*other);
                break;
            }
        }
        first.push(body.unwrap_or(if is_told { number } else { 0 }));
    }
    first
}

fn sum<L: Lattice>(lattice: &L, cells: &[usize]) -> L::Moments {
    let mut sum = L::Moments::default();
    cells
        .iter()
        .for_each(|cell| sum.add(&lattice.cells()[*cell], 1.0));
    sum
}

/// The cells of each region that the view shows, by parts that are connected in it.
///
/// Runs of adjacent rows that overlap in a column are joined (union–find).
fn parts(view: &View, owner: &[u16], regions: usize) -> Vec<Vec<Vec<usize>>> {
    let shown: Cow<[u16]> = match &view.cell {
        None => owner.into(),
        Some(_) => (0..view.rows * view.cols)
            .map(|place| view.at(place).map_or(NONE, |cell| owner[cell]))
            .collect(),
    };
    // Each run's region, first place and one past the last; as root the earliest run of its part.
    let mut runs: Vec<(u16, usize, usize)> = Vec::new();
    let mut parent: Vec<usize> = Vec::new();
    let mut above = 0..0;
    for (y, row) in shown.chunks_exact(view.cols.max(1)).enumerate() {
        let (begin, mut first) = (runs.len(), y * view.cols);
        for run in row.chunk_by(|a, b| a == b) {
            let (region, end) = (run[0], first + run.len());
            while above.start < above.end && runs[above.start].2 + view.cols <= first {
                above.start += 1;
            }
            let mut own = runs.len();
            parent.push(own);
            let over = above.clone().take_while(|k| runs[*k].1 + view.cols < end);
            for k in over.filter(|k| region != NONE && runs[*k].0 == region) {
                let other = root(&parent, k);
                parent[own.max(other)] = own.min(other);
                own = own.min(other);
            }
            runs.push((region, first, end));
            first = end;
        }
        above = begin..runs.len();
    }
    let mut part = vec![None; runs.len()];
    let mut parts = vec![Vec::new(); regions];
    for (k, &(region, first, end)) in runs.iter().enumerate().filter(|(_, run)| run.0 != NONE) {
        let its: &mut Vec<Vec<usize>> = &mut parts[usize::from(region)];
        let part = *part[root(&parent, k)].get_or_insert(its.len());
        if part == its.len() {
            its.push(Vec::new());
        }
        match view.cell {
            None => its[part].extend(first..end),
            Some(_) => its[part].extend((first..end).filter_map(|place| view.at(place))),
        }
    }
    parts
}

fn root(parent: &[usize], mut i: usize) -> usize {
    while parent[i] != i {
        i = parent[i];
    }
    i
}

/// Gives each cell without a number that of the cell with one that is the fewest cells away.
fn spread<L: Lattice>(lattice: &L, number: &mut [u16]) {
    let mut reached: Vec<usize> = (0..number.len()).filter(|i| number[*i] != NONE).collect();
    let mut next = 0;
    while let Some(&cell) = reached.get(next) {
        next += 1;
        for k in lattice.beside(cell).filter(|k| *k != cell) {
            if number[k] == NONE {
                number[k] = number[cell];
                reached.push(k);
            }
        }
    }
}
