//! Axis-parallel boxes around points, what is in them, and which of many meet one.

use nalgebra::Point3;

/// The box around some points.
#[derive(Clone)]
pub(crate) struct Bounds {
    pub low: Point3<f64>,
    pub high: Point3<f64>,
}

impl Bounds {
    pub fn new(points: &[Point3<f64>]) -> Self {
        let fold = |pick: fn(f64, f64) -> f64, start: f64| {
            let init = Point3::from([start; 3]);
            points
                .iter()
                .fold(init, |a, b| Point3::from(a.coords.zip_map(&b.coords, pick)))
        };
        Self {
            low: fold(f64::min, f64::INFINITY),
            high: fold(f64::max, f64::NEG_INFINITY),
        }
    }

    /// Whether two boxes have a point in common, up to a millimetre.
    pub fn overlaps(&self, other: &Self) -> bool {
        let apart =
            |i: usize| self.low[i] > other.high[i] + 1e-3 || other.low[i] > self.high[i] + 1e-3;
        !(0..3).any(apart)
    }
}

/// Boxes in a tree: which of them meet one is found without looking at all.
pub(crate) struct BoundsTree {
    boxes: Vec<Bounds>,
    order: Vec<usize>,
    /// Every node before those in it.
    nodes: Vec<Node>,
}

/// A stretch of the tree's order.
struct Node {
    bounds: Bounds,
    from: usize,
    to: usize,
    /// The first node that is not in this one.
    next: usize,
}

/// A node of so many boxes is not parted.
const LEAF: usize = 8;

impl BoundsTree {
    pub fn new(boxes: Vec<Bounds>) -> Self {
        let mut tree = Self {
            order: (0..boxes.len()).collect(),
            boxes,
            nodes: Vec::new(),
        };
        tree.part(0, tree.order.len());
        tree
    }

    /// Parts a stretch of the order in halves, along the axis that it is longest in.
    fn part(&mut self, from: usize, to: usize) {
        let (boxes, order) = (&self.boxes, &mut self.order[from..to]);
        let corners = order.iter().flat_map(|&i| [boxes[i].low, boxes[i].high]);
        let bounds = Bounds::new(&corners.collect::<Vec<_>>());
        let axis = (bounds.high - bounds.low).imax();
        let (number, middle) = (self.nodes.len(), order.len() / 2);
        let is_leaf = order.len() <= LEAF;
        if !is_leaf {
            let centre = |i: usize| boxes[i].low[axis] + boxes[i].high[axis];
            let along = |a: &usize, b: &usize| centre(*a).total_cmp(&centre(*b)).then(a.cmp(b));
            order.select_nth_unstable_by(middle, along);
        }
        self.nodes.push(Node {
            bounds,
            from,
            to,
            next: number + 1,
        });
        if !is_leaf {
            self.part(from, from + middle);
            self.part(from + middle, to);
            self.nodes[number].next = self.nodes.len();
        }
    }

    /// The numbers of the boxes that meet one, up to a millimetre.
    pub fn meeting(&self, asked: &Bounds) -> Vec<usize> {
        let mut found = Vec::new();
        let mut number = 0;
        while let Some(node) = self.nodes.get(number) {
            let meets = node.bounds.overlaps(asked);
            if meets && node.to - node.from <= LEAF {
                let stretch = self.order[node.from..node.to].iter().copied();
                found.extend(stretch.filter(|&i| self.boxes[i].overlaps(asked)));
            }
            number = if meets { number + 1 } else { node.next };
        }
        found
    }
}

/// The part of a convex ring in space where a linear function is not positive.
pub(crate) fn clip(ring: &[Point3<f64>], value: impl Fn(&Point3<f64>) -> f64) -> Vec<Point3<f64>> {
    let mut kept = Vec::with_capacity(ring.len() + 1);
    for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        let (value_a, value_b) = (value(a), value(b));
        if value_a <= 0.0 {
            kept.push(*a);
        }
        if (value_a < 0.0 && value_b > 0.0) || (value_a > 0.0 && value_b < 0.0) {
            kept.push(a + (b - a) * (value_a / (value_a - value_b)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_looking_at_all_finds() {
        let at = |i: usize, k: usize| ((i * 37 + k * 17) % 101) as f64;
        let corner = |i: usize| Point3::new(at(i, 0), at(i, 1), at(i, 2));
        let of = |i: usize| {
            let size = nalgebra::Vector3::repeat(1.0 + (i % 13) as f64);
            Bounds::new(&[corner(i), corner(i) + size])
        };
        let boxes: Vec<Bounds> = (0..200).map(of).collect();
        let tree = BoundsTree::new(boxes.clone());
        for asked in boxes.iter().step_by(7) {
            let mut found = tree.meeting(asked);
            found.sort_unstable();
            let all = (0..boxes.len()).filter(|&i| boxes[i].overlaps(asked));
            assert_eq!(found, all.collect::<Vec<_>>());
        }
        assert!(BoundsTree::new(Vec::new()).meeting(&boxes[0]).is_empty());
    }
}
