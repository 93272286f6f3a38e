//! Where neighbouring pixels of the image have the same label.

use super::bits::{Bits, pack};

/// The links between neighbours in a row and in a column: set where they agree, at the image's
/// border too. Bit u of row v is the link from (u, v) to the next column, or to the next row.
pub(super) struct Links {
    along: Bits,
    down: Bits,
}

impl Links {
    /// Set where neighbouring labels are the same.
    pub fn new(labels: &[u16], width: usize, height: usize) -> Self {
        let line = |v: usize| &labels[v * width..(v + 1) * width];
        let along = Bits::new(width, height, |v, words| {
            pack(line(v), &line(v)[1.min(width)..], words, |a, b| a == b);
            if let Some(last) = words.last_mut() {
                *last |= 1 << ((width - 1) % 64);
            }
        });
        let down = Bits::new(width, height, |v, words| {
            if v + 1 < height {
                pack(line(v), line(v + 1), words, |a, b| a == b);
            } else {
                words.fill(!0);
            }
        });
        Self { along, down }
    }

    /// With the links from and to the pixels of `open` set too.
    pub fn through(&self, open: &Bits) -> Self {
        // From a pixel, or to the one after it: a shift by one, by ANDs of what is not open.
        let shut = || open.clone().not();
        Self {
            along: self.along.clone().or(&shut().all_along(0, 1).not()),
            down: self.down.clone().or(&shut().all_down(0, 1).not()),
        }
    }

    /// The pixels around which all links within `r` (in the maximum norm) are set.
    pub fn uniform(&self, r: usize) -> Bits {
        if r == 0 {
            return Bits::new(self.along.width, self.along.height, |_, words| {
                words.fill(!0)
            });
        }
        let along = self.along.clone().all_along(r, r - 1).all_down(r, r);
        along.and(&self.down.clone().all_along(r, r).all_down(r, r - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::super::bits::tests::at;
    use super::*;

    #[test]
    fn windows_are_uniform_where_all_their_labels_are_the_same() {
        let (width, height) = (70, 20);
        let label = |u: usize, v: usize| u16::from(u > 30 + v) + 4 * u16::from(v > 12);
        let labels: Vec<u16> = (0..width * height)
            .map(|i| label(i % width, i / width))
            .collect();
        let links = Links::new(&labels, width, height);
        for r in 0..4 {
            let uniform = links.uniform(r);
            for (v, u) in (0..height).flat_map(|v| (0..width).map(move |u| (v, u))) {
                let rows = v.saturating_sub(r)..(v + r + 1).min(height);
                let columns = u.saturating_sub(r)..(u + r + 1).min(width);
                let expected = rows
                    .into_iter()
                    .all(|y| columns.clone().all(|x| label(x, y) == label(u, v)));
                assert_eq!(
                    at(&uniform, u as i64, v as i64, true),
                    expected,
                    "({u}, {v}), {r}"
                );
            }
        }
    }
}
