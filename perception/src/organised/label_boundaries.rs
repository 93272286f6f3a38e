//! Where neighbouring pixels of the image have different labels.

use super::bits::{Bits, beside, on_left, on_right};
use super::words::{firsts, pack};

/// The cuts between neighbours in a row and in a column: bit u of row v is the one from (u, v) to the
/// next column, or to the next row.
#[derive(Clone)]
pub(super) struct LabelBoundaries {
    along: Bits,
    down: Bits,
}

impl LabelBoundaries {
    /// Between labels that are not the same.
    pub fn new(labels: &[u16], width: usize, height: usize) -> Self {
        let line = |v: usize| &labels[v * width..][..width];
        let down = Bits::new(width, height, |v, words| {
            if v + 1 < height {
                pack(line(v), line(v + 1), words, |a, b| a != b);
            }
        });
        let along = along(labels, width, height);
        Self { along, down }
    }

    /// Those in a row, or those in a column.
    pub fn toward(&self, along: bool) -> &Bits {
        if along { &self.along } else { &self.down }
    }

    /// Takes out the cut after a pixel, in its row or in its column.
    pub fn clear(&mut self, along: bool, u: usize, v: usize) {
        let cuts = if along {
            &mut self.along
        } else {
            &mut self.down
        };
        cuts.clear(u, v);
    }

    /// Calls `with` for every run of pixels in a row that are in `of` and have one label: the row,
    /// the first column, one past the last.
    pub fn for_runs(&self, of: &Bits, with: impl FnMut(usize, usize, usize)) {
        of.for_runs(&self.along, with);
    }

    /// Of 64 columns, the `i`th such word, those at which a block of `N` × `N` pixels begins that all
    /// are in `of` and have one label; blocks begin at every `N`th column and at row `top`.
    pub fn blocks<const N: usize>(&self, of: &Bits, i: usize, top: usize) -> u64 {
        let all = (top..top + N).fold(!0, |all, v| all & of.row(v)[i]);
        // After the last column and the last row of a block there may be a cut.
        let along = (top..top + N).fold(0, |any, v| any | self.along.row(v)[i]);
        let down = (top..top + N - 1).fold(0, |any, v| any | self.down.row(v)[i]);
        let last = firsts::<N>() << (N - 1);
        let all = all & !(along & !last | down);
        let whole = (0..N).fold(!0, |whole, k| whole & all >> k);
        whole & firsts::<N>()
    }

    /// The pixels with a cut within `r` (in the maximum norm), but for cuts from and to the pixels of
    /// `open`.
    pub fn near(&self, r: usize, open: Option<&Bits>) -> Bits {
        if r == 0 {
            return Bits::empty(self.along.width, self.along.height);
        }
        let (mut along, mut down) = (&self.along, &self.down);
        let closed;
        if let Some(open) = open {
            // A cut is from a pixel to the next one on the right, or below.
            closed = [
                Bits::around([along, open], |[cuts, open]| {
                    cuts[1][1] & !(open[1][1] | on_right(open[1]))
                }),
                Bits::around([down, open], |[cuts, open]| {
                    cuts[1][1] & !(open[1][1] | open[2][1])
                }),
            ];
            [along, down] = closed.each_ref();
        }
        let next = Bits::around([along, down], |[along, down]| {
            let [above, here, below] = along.map(|row| row[1] | on_left(row));
            above | here | below | beside([0, 1, 2].map(|k| down[0][k] | down[1][k]))
        });
        // A cut is within r of a pixel where it is within 1 of one that is within r − 1.
        next.dilated(r - 1)
    }
}

/// Where a label is not the same as in the next column.
pub(super) fn along(labels: &[u16], width: usize, height: usize) -> Bits {
    Bits::new(width, height, |v, words| {
        let line = &labels[v * width..][..width];
        pack(line, &line[1.min(width)..], words, |a, b| a != b);
    })
}

#[cfg(test)]
mod tests {
    use super::super::bits::tests::at;
    use super::*;

    #[test]
    fn a_cut_is_near_where_the_window_has_two_labels() {
        let (width, height) = (70, 20);
        let label = |u: usize, v: usize| u16::from(u > 30 + v) + 4 * u16::from(v > 12);
        let labels: Vec<u16> = (0..width * height)
            .map(|i| label(i % width, i / width))
            .collect();
        let cuts = LabelBoundaries::new(&labels, width, height);
        let open = |u: usize, v: usize| (u * 7 + v * 5) % 11 < 3;
        let opened = Bits::new(width, height, |v, words| {
            let those = (0..width).filter(|u| open(*u, v));
            those.for_each(|u| words[u / 64] |= 1 << (u % 64));
        });
        for (r, some) in (0..4).flat_map(|r| [(r, false), (r, true)]) {
            let near = cuts.near(r, some.then_some(&opened));
            let cut = |(u, v): (usize, usize), (x, y): (usize, usize)| {
                label(u, v) != label(x, y) && !(some && (open(u, v) || open(x, y)))
            };
            for (v, u) in (0..height).flat_map(|v| (0..width).map(move |u| (v, u))) {
                let rows = v.saturating_sub(r)..(v + r + 1).min(height);
                let columns = u.saturating_sub(r)..(u + r + 1).min(width);
                let (right, below) = (columns.end - 1, rows.end - 1);
                let expected =
                    rows.flat_map(|y| columns.clone().map(move |x| (x, y)))
                        .any(|(x, y)| {
                            x < right && cut((x, y), (x + 1, y))
                                || y < below && cut((x, y), (x, y + 1))
                        });
                let got = at(&near, u as i64, v as i64, false);
                assert_eq!(got, expected, "({u}, {v}), {r}, {some}");
            }
        }
    }
}
