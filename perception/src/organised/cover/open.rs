//! What of a region is in no piece yet, and where.

use wide::f32x8;

use super::rows::{Frame, GROUPS, NOWHERE, ROWS, Rows};
use super::segments::{Point, least};

/// The open parts of a region, in layers: of each row several intervals.
pub(super) struct Open {
    /// The whole region.
    whole: Vec<Rows>,
    open: Vec<Rows>,
}

impl Open {
    /// All that is between the edges.
    pub fn new(frame: &Frame, edges: &[(Point, Point)]) -> Self {
        // Crossings of the rows with the edges: odd intervals are inside.
        let row = |y: f32| {
            let at = (y - frame.low) / frame.pitch_m + 0.5;
            (at as usize).min(ROWS)
        };
        let mut crossings: Vec<u64> = Vec::with_capacity(4 * ROWS);
        for (a, b) in edges {
            let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
            let (first, end) = (row(a[1]), row(b[1]));
            if first < end {
                let slope = (b[0] - a[0]) / (b[1] - a[1]);
                let at = |row: usize| a[0] + (frame.y(row) - a[1]) * slope;
                crossings.extend((first..end).map(|row| crossing(row, at(row))));
            }
        }
        crossings.sort_unstable();
        let mut open: Vec<Rows> = Vec::new();
        let mut used = [0; ROWS];
        for pair in crossings.as_chunks::<2>().0 {
            let [(row, from), (_, to)] = pair.map(row_and_place);
            put(&mut open, row, used[row], from, to);
            used[row] += 1;
        }
        Self {
            whole: open.clone(),
            open,
        }
    }

    /// Area that is open, m².
    pub fn area(&self, frame: &Frame) -> f32 {
        self.open.iter().map(|layer| layer.area(frame)).sum()
    }

    /// Area of a piece that is open, m².
    pub fn gain(&self, frame: &Frame, piece: &Rows) -> f32 {
        let layers = self.open.iter();
        layers.map(|layer| layer.area_both(frame, piece)).sum()
    }

    /// Closes what is in a piece.
    pub fn close(&mut self, piece: &Rows) {
        for row in 0..ROWS {
            let (from, to) = piece.get(row);
            if from >= to {
                continue;
            }
            for layer in 0..self.open.len() {
                let (low, high) = self.open[layer].get(row);
                if low >= high || high <= from || to <= low {
                    continue;
                }
                let (left, right) = (low < from, to < high);
                let here = match (left, right) {
                    (true, _) => (low, from),
                    (false, true) => (to, high),
                    (false, false) => (NOWHERE, -NOWHERE),
                };
                self.open[layer].set(row, here);
                if left && right {
                    let empty = |layer: &Rows| layer.get(row).0 >= layer.get(row).1;
                    let free = self.open.iter().position(empty);
                    let free = free.unwrap_or(self.open.len());
                    put(&mut self.open, row, free, to, high);
                }
            }
        }
    }

    /// Middles of open intervals, those farthest from the region's border first, each out of the
    /// free circles of those before it; at most `count`.
    pub fn seeds(&self, frame: &Frame, count: usize) -> Vec<Point> {
        // Every other row will do.
        let looked_at = f32x8::from(std::array::from_fn(|k| (k % 2) as f32)).simd_eq(f32x8::ZERO);
        let mut places: Vec<Middles> = Vec::with_capacity(GROUPS * self.open.len());
        for layer in &self.open {
            for i in 0..GROUPS {
                let open = layer.from[i].simd_lt(layer.to[i]) & looked_at;
                if open.any() {
                    let (x, y) = ((layer.from[i] + layer.to[i]) * 0.5, frame.y[i]);
                    let most = self.along(i, x).fast_min(frame.end(y));
                    let depth = open & most;
                    places.push(Middles {
                        x,
                        y,
                        depth,
                        known: 0,
                    });
                }
            }
        }
        let mut seeds = Vec::with_capacity(count);
        while seeds.len() < count {
            let deepest = places.iter().fold(f32x8::ZERO, |m, p| m.fast_max(p.depth));
            let deepest = -least(-deepest);
            let is_deepest = |p: &Middles| p.depth.simd_eq(f32x8::splat(deepest)).to_bitmask();
            let found = places.iter_mut().find(|p| is_deepest(p) != 0);
            let Some(group) = found.filter(|_| deepest > 0.0) else {
                break;
            };
            let k = is_deepest(group).trailing_zeros() as usize;
            let p = [group.x, group.y].map(|lanes| lanes.as_array()[k]);
            if group.known >> k & 1 == 0 {
                group.depth.as_mut_array()[k] = self.depth(frame, &p);
                group.known |= 1 << k;
                continue;
            }
            seeds.push(p);
            for group in &mut places {
                let (x, y) = (group.x - p[0], group.y - p[1]);
                let out = (x * x + y * y).simd_gt(f32x8::splat(4.0 * deepest * deepest));
                group.depth &= out;
            }
        }
        seeds
    }

    /// Distances of places in eight rows from what is not of the region along their rows, 0 outside.
    #[inline]
    fn along(&self, i: usize, x: f32x8) -> f32x8 {
        let inside = |layer: &Rows| (x - layer.from[i]).fast_min(layer.to[i] - x);
        let layers = self.whole.iter().map(inside);
        layers.fold(f32x8::ZERO, f32x8::fast_max)
    }

    /// Distance of a place from what is not of the region, about, m.
    fn depth(&self, frame: &Frame, p: &Point) -> f32 {
        let mut nearest = f32x8::splat(NOWHERE);
        for i in 0..GROUPS {
            let along = self.along(i, f32x8::splat(p[0]));
            let up = frame.y[i] - p[1];
            nearest = nearest.fast_min(along * along + up * up);
        }
        let [end, ..] = frame.end(f32x8::splat(p[1])).to_array();
        least(nearest).min(end * end).sqrt()
    }
}

/// The middles of intervals in eight rows.
struct Middles {
    x: f32x8,
    y: f32x8,
    /// The depth of each, or more: that along its row, or to the region's top or bottom; 0 where
    /// none is looked for.
    depth: f32x8,
    /// Which are known, one bit each.
    known: u32,
}

/// A row and a place in it as a number that sorts like them.
fn crossing(row: usize, x: f32) -> u64 {
    let bits = x.to_bits();
    // Of negative numbers the larger have the smaller bits.
    let flip = if bits >> 31 == 1 { u32::MAX } else { 1 << 31 };
    (row as u64) << 32 | u64::from(bits ^ flip)
}

fn row_and_place(crossing: u64) -> (usize, f32) {
    let bits = crossing as u32;
    let flip = if bits >> 31 == 1 { 1 << 31 } else { u32::MAX };
    ((crossing >> 32) as usize, f32::from_bits(bits ^ flip))
}

/// Puts an interval of a row into a layer.
fn put(layers: &mut Vec<Rows>, row: usize, layer: usize, from: f32, to: f32) {
    if layer == layers.len() {
        layers.push(Rows::NONE);
    }
    layers[layer].set(row, (from, to));
}

#[cfg(test)]
mod tests {
    use super::super::rows::tests::{near, rows, square};
    use super::*;

    #[test]
    fn areas_are_those_of_the_region_without_its_hole_and_pieces() {
        let frame = Frame::new(0.0, 4.0);
        let edges = [square(0.0, 0.0, 4.0), square(1.0, 1.0, 2.0)].concat();
        let mut open = Open::new(&frame, &edges);
        assert!(near(open.area(&frame), 12.0));
        // A piece that lies half in the hole, then one over it.
        let piece = rows(&frame, &square(0.0, 1.0, 2.0));
        assert!(near(piece.area(&frame), 4.0));
        assert!(near(open.gain(&frame, &piece), 2.0));
        open.close(&piece);
        assert!(near(open.area(&frame), 10.0));
        assert_eq!(open.gain(&frame, &piece), 0.0);
        let over = rows(&frame, &square(0.0, 0.0, 3.0));
        assert!(near(open.gain(&frame, &over), 3.0));
        // One that splits rows.
        open.close(&rows(&frame, &square(1.5, 3.0, 1.0)));
        assert!(near(open.area(&frame), 9.0));
        assert!(near(
            open.gain(&frame, &rows(&frame, &square(0.0, 0.0, 4.0))),
            9.0
        ));
    }

    #[test]
    fn crossings_sort_by_row_and_place() {
        let places = [-3.5, -1e-3, 0.0, 2e-5, 7.25];
        let of = |row: usize| places.map(|x| crossing(row, x));
        let all = [of(0), of(1), of(31)].concat();
        assert!(all.is_sorted());
        for (i, &c) in all.iter().enumerate() {
            assert_eq!(row_and_place(c), ([0, 1, 31][i / 5], places[i % 5]));
        }
    }

    #[test]
    fn the_first_seed_is_where_most_is_free() {
        // A large square with a small one beside it.
        let frame = Frame::new(0.0, 2.0);
        let edges = [square(0.0, 0.0, 2.0), square(2.0, 0.0, 1.0)].concat();
        let mut open = Open::new(&frame, &edges);
        let seeds = open.seeds(&frame, 2);
        let off = |p: &Point, x: f32, y: f32| (p[0] - x).hypot(p[1] - y);
        assert!(off(&seeds[0], 1.0, 1.0) < 0.25, "{seeds:?}");
        open.close(&rows(&frame, &square(0.0, 0.0, 2.0)));
        let seeds = open.seeds(&frame, 2);
        assert!(off(&seeds[0], 2.5, 0.5) < 0.25, "{seeds:?}");
    }
}
