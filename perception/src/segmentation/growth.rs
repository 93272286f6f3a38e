//! Breadth-first growth of planar regions over cells.

use super::lattice::{Lattice, PlaneOf, Seed, Shape};
use super::moments::Moments;
use super::partition::{Grown, NONE, Partition, Region};

/// Sort the best 1/8 of the remaining seeds at a time, at least 8.
const PARTS: usize = 8;
const SORTED_MIN: usize = 8;
/// How many cells of a hole in a row a region may have before it, and goes on beyond.
const HOLE_CELLS: u8 = 8;
/// Cells that grew in vain to regions of this many times [`IN_VAIN`] cells, once or one after the other, are no seeds any
/// more: each would grow to all of them once more, which takes the square of their number, as of a floor in whose plane the
/// sensor's place lies: it is seen under no angle. Smaller regions may be tried from each of their cells.
const VAIN_MAX: u8 = 8;
const IN_VAIN: usize = 64;

/// Growth over the cells of a lattice.
pub(super) struct Growth<'a, L: Lattice> {
    pub lattice: &'a L,
    /// Those of the lattice's cells that take part, and the index of each among them.
    cells: Vec<L::Cell>,
    index: Vec<u32>,
    /// Which take no part, or belong to a region by now.
    shut: Vec<bool>,
    /// How many times [`IN_VAIN`] cells they grew to that were refused.
    vain: Vec<u8>,
    /// How many cells of a hole lead from the region that grows to one of a hole, this one counted; one more than
    /// [`HOLE_CELLS`] where none did so far, none of cells that are no hole. And those that were reached.
    depth: Vec<u8>,
    reached: Vec<usize>,
    /// Cells of the region that grows, and those to go on from.
    members: Vec<usize>,
    queue: Vec<usize>,
    refusing: Vec<usize>,
}

impl<'a, L: Lattice> Growth<'a, L> {
    /// Over those cells for which `free` holds.
    pub fn new(lattice: &'a L, free: impl Fn(usize) -> bool) -> Self {
        let count = lattice.cells().len();
        let mut cells = Vec::with_capacity(count);
        let (mut index, mut shut) = (vec![0; count], vec![true; count]);
        let mut depth = vec![0; count];
        for i in (0..count).filter(|i| free(*i)) {
            if let Some(cell) = lattice.cell(i) {
                (index[i], shut[i]) = (cells.len() as u32, false);
                cells.push(cell);
            } else if lattice.is_hole(i) {
                depth[i] = HOLE_CELLS + 1;
            }
        }
        Self {
            lattice,
            cells,
            index,
            shut,
            vain: vec![0; count],
            depth,
            reached: Vec::new(),
            members: Vec::new(),
            queue: Vec::new(),
            refusing: Vec::new(),
        }
    }

    /// The regions that grow from seeds of a shape.
    ///
    /// Seeds are planar cells, the flattest first; each grows breadth-first with accumulated moments, its
    /// plane refitted as it doubles, and is kept if it is large enough. Every cell belongs to one region
    /// at most, in an order that depends on the cells only; those of earlier calls keep theirs.
    pub fn regions(&mut self, shape: Shape) -> Vec<Grown<L::Moments>> {
        let of = |i: usize| &self.cells[self.index[i] as usize];
        let mut left: Vec<Seed> = self.lattice.seeds(shape, of, &self.shut);
        let mut regions = Vec::new();
        let mut block = Vec::new();
        while !left.is_empty() {
            // The flattest in order. What they grow to has most of the others, which need none then: a
            // cell that a region has stays with it.
            let count = (left.len() / PARTS).max(SORTED_MIN).min(left.len());
            left.select_nth_unstable(count - 1);
            let rest = left.split_off(count);
            left.sort_unstable();
            for seed in left {
                if self.is_open(shape, seed, &mut block) {
                    self.members.clone_from(&block);
                    regions.extend(self.one(shape));
                }
            }
            left = rest;
            left.retain(|&seed| self.is_open(shape, seed, &mut block));
        }
        regions
    }

    /// Puts the cells of a seed in place of others; `false` where too few of them are open.
    fn is_open(&self, shape: Shape, seed: Seed, cells: &mut Vec<usize>) -> bool {
        let of = |i: usize| &self.cells[self.index[i] as usize];
        let open = self.lattice.open_cells(shape, seed, of, &self.shut, cells);
        open && self.vain[cells[0]] < VAIN_MAX
    }

    /// Regions that there are go on over the cells beside them that are open, the largest first.
    pub fn resume(&mut self, partition: &mut Partition<L::Moments>) {
        let mut cells: Vec<Vec<usize>> = vec![Vec::new(); partition.regions.len()];
        for (cell, &owner) in partition.owner.iter().enumerate() {
            if owner != NONE {
                cells[usize::from(owner)].push(cell);
            }
        }
        let mut order: Vec<usize> = (0..partition.regions.len()).collect();
        let count = |i: &usize| partition.regions[*i].moments.count();
        order.sort_by(|a, b| count(b).total_cmp(&count(a)).then(a.cmp(b)));
        for number in order {
            self.members.clone_from(&cells[number]);
            let Region { moments, plane } = &mut partition.regions[number];
            let known = self.members.len();
            *plane = self.grow(moments, *plane);
            for &cell in &self.members[known..] {
                partition.owner[cell] = number as u16;
            }
        }
    }

    /// Adds to the members and their moments the cells around them that fit, the plane refitted as they
    /// double; the plane of all. What was not measured ends no plane: cells beyond a hole are around it, too.
    fn grow(&mut self, moments: &mut L::Moments, mut plane: PlaneOf<L>) -> PlaneOf<L> {
        let (lattice, shut, members) = (self.lattice, &mut self.shut, &mut self.members);
        let (queue, refusing) = (&mut self.queue, &mut self.refusing);
        let (depth, reached) = (&mut self.depth, &mut self.reached);
        let cells = lattice.cells();
        let refit = |moments: &L::Moments, plane| moments.plane().unwrap_or(plane);
        let mut test = lattice.test(&plane);
        let mut refit_at = 2 * members.len();
        queue.clone_from(members);
        // Twice: what the early planes refused, the final one may accept.
        for _ in 0..2 {
            refusing.clear();
            let mut next = 0;
            while let Some(&i) = queue.get(next) {
                next += 1;
                let steps = depth[i] + 1;
                for k in lattice.beside(i) {
                    if shut[k] {
                        if steps < depth[k] {
                            if depth[k] > HOLE_CELLS {
                                reached.push(k);
                            }
                            depth[k] = steps;
                            queue.push(k);
                        }
                        continue;
                    }
                    if !lattice.fits(k, &self.cells[self.index[k] as usize], &test) {
                        if refusing.last() != Some(&i) {
                            refusing.push(i);
                        }
                        continue;
                    }
                    shut[k] = true;
                    moments.add(&cells[k], 1.0);
                    members.push(k);
                    queue.push(k);
                    if members.len() >= refit_at {
                        plane = refit(moments, plane);
                        test = lattice.test(&plane);
                        refit_at = members.len() * 3 / 2;
                    }
                }
            }
            plane = refit(moments, plane);
            test = lattice.test(&plane);
            std::mem::swap(queue, refusing);
        }
        (reached.drain(..)).for_each(|k| depth[k] = HOLE_CELLS + 1);
        plane
    }

    /// One region from the members that it begins with; gives its cells back if it stays too small.
    fn one(&mut self, shape: Shape) -> Option<Grown<L::Moments>> {
        let cells = self.lattice.cells();
        let mut moments = L::Moments::default();
        for &i in &self.members {
            moments.add(&cells[i], 1.0);
            self.shut[i] = true;
        }
        let begun = moments.plane();
        let (mut grown, mut times) = (Vec::new(), 0);
        if let Some(plane) = begun {
            let test = self.grow(&mut moments, plane);
            if self.members.len() >= IN_VAIN {
                times = u8::try_from(self.members.len() / IN_VAIN).unwrap_or(u8::MAX);
                grown.clone_from(&self.members);
            }
            // Cells that the final plane no longer fits go back.
            let (lattice, shut) = (self.lattice, &mut self.shut);
            let test = lattice.test(&test);
            let (of, index) = (&self.cells, &self.index);
            self.members.retain(|&i| {
                let stays = lattice.fits(i, &of[index[i] as usize], &test);
                if !stays {
                    moments.add(&cells[i], -1.0);
                }
                shut[i] = stays;
                stays
            });
        }
        let large = begun.is_some() && self.lattice.is_region(shape, &moments, self.members.len());
        match moments.plane().filter(|_| large) {
            Some(plane) => Some(Grown {
                region: Region { moments, plane },
                cells: self.members.clone(),
            }),
            None => {
                self.members.iter().for_each(|&i| self.shut[i] = false);
                for i in grown {
                    self.vain[i] = self.vain[i].saturating_add(times);
                }
                None
            }
        }
    }
}
