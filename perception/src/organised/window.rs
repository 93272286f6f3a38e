//! What the labels in a square window around each pixel have in common.
//!
//! A label l stands as the pair (l, !l) in 32 bits. Bitwise OR over a window leaves the pair as it
//! is where all labels agree; where two differ, a bit of l is set in both halves. So the test of a
//! window is a handful of ORs, whatever the labels are.

/// Stands for what is compatible with any label.
pub(super) const OPEN: u32 = 0;

/// A label as it is OR-ed.
pub(super) fn packed(label: u16) -> u32 {
    u32::from(label) | u32::from(!label) << 16
}

/// The label that a window has in common; `None` where it has two, or nothing but [`OPEN`].
pub(super) fn single(common: u32) -> Option<u16> {
    let (label, inverse) = (common as u16, (common >> 16) as u16);
    (label == !inverse).then_some(label)
}

/// OR over the pixels within `r` of each pixel in the maximum norm; beyond the image is [`OPEN`].
///
/// `row` fills the packed labels of a row; `sink` takes what a row of windows has in common.
pub(super) fn common(
    (width, height): (usize, usize),
    r: usize,
    mut row: impl FnMut(usize, &mut [u32]),
    mut sink: impl FnMut(usize, &[u32]),
) {
    let span = 2 * r + 1;
    // A row with r open pixels on either side; the last `span` rows, OR-ed along themselves.
    let mut padded = vec![OPEN; width + 2 * r];
    let mut rows = vec![OPEN; width * span];
    let mut joined = vec![OPEN; width];
    for v in 0..height + r {
        let slot = (v % span) * width;
        let along = &mut rows[slot..slot + width];
        if v < height {
            row(v, &mut padded[r..r + width]);
            along.copy_from_slice(&padded[..width]);
            for d in 1..span {
                or_all(along, &padded[d..d + width]);
            }
        } else {
            along.fill(OPEN);
        }
        if v >= r {
            joined.copy_from_slice(&rows[..width]);
            for other in rows.chunks_exact(width.max(1)).skip(1) {
                or_all(&mut joined, other);
            }
            sink(v - r, &joined);
        }
    }
}

fn or_all(to: &mut [u32], from: &[u32]) {
    for (a, b) in to.iter_mut().zip(from) {
        *a |= b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_tell_one_label_from_two_and_from_none() {
        // All pairs of labels that differ in one bit only are told apart, too.
        let picture: Vec<u16> = vec![5, 5, 4, 4, 4, 9, 9, 9, 9, 9];
        let open = [5, 6];
        let mut got = Vec::new();
        let row = |_: usize, out: &mut [u32]| {
            for (u, (out, &label)) in out.iter_mut().zip(&picture).enumerate() {
                *out = if open.contains(&u) {
                    OPEN
                } else {
                    packed(label)
                };
            }
        };
        common((10, 1), 1, row, |_, line| {
            got.extend(line.iter().map(|&c| single(c)))
        });
        let expected = [5, 0, 0, 4, 4, 4, 9, 9, 9, 9].map(|l| (l > 0).then_some(l));
        assert_eq!(got, expected);
    }

    #[test]
    fn a_window_reaches_over_rows_and_ends_with_the_image() {
        let (width, height, r) = (7, 5, 2);
        let odd = (3, 2);
        let row = |v: usize, out: &mut [u32]| {
            for (u, out) in out.iter_mut().enumerate() {
                *out = packed(if (u, v) == odd { 2 } else { 1 });
            }
        };
        common((width, height), r, row, |v, line| {
            for (u, &c) in line.iter().enumerate() {
                let near = u.abs_diff(odd.0) <= r && v.abs_diff(odd.1) <= r;
                assert_eq!(single(c), (!near).then_some(1), "({u}, {v})");
            }
        });
    }
}
