//! Bitmaps of the image, 64 pixels a word: what is said of pixels near each other, by bitwise AND.

use super::labels::NONE;

/// One bit a pixel, row by row; a row begins with a word of its own.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Bits {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Words of a row.
    stride: usize,
    words: Vec<u64>,
}

impl Bits {
    /// The bitmap of an image, each row by `row`: the row and its words, which are all zero.
    pub fn new(width: usize, height: usize, row: impl Fn(usize, &mut [u64])) -> Self {
        let stride = width.div_ceil(64);
        let mut words = vec![0; stride * height];
        if stride > 0 {
            for (v, words) in words.chunks_exact_mut(stride).enumerate() {
                row(v, words);
            }
        }
        Self {
            width,
            height,
            stride,
            words,
        }
    }

    /// How many pixels are in it, if none beyond the rows' ends are.
    pub fn count(&self) -> usize {
        self.words
            .iter()
            .map(|word| word.count_ones() as usize)
            .sum()
    }

    /// Whether a pixel is in it.
    #[cfg(test)]
    pub fn has(&self, u: usize, v: usize) -> bool {
        self.words[v * self.stride + u / 64] >> (u % 64) & 1 == 1
    }

    /// Takes a pixel out.
    pub fn clear(&mut self, u: usize, v: usize) {
        self.words[v * self.stride + u / 64] &= !(1 << (u % 64));
    }

    /// Those of its pixels for which `is` holds for what the image has there.
    pub fn filter<A: Copy>(mut self, image: &[A], is: impl Fn(A) -> bool) -> Self {
        let rows = self.words.chunks_exact_mut(self.stride.max(1));
        for (row, words) in rows.zip(image.chunks_exact(self.width.max(1))) {
            for (pixels, word) in words.chunks(64).zip(row) {
                if *word != 0 {
                    *word &= packed(pixels, pixels, |a, _| is(a));
                }
            }
        }
        self
    }

    /// The pixels in both.
    pub fn and(mut self, other: &Self) -> Self {
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            *a &= b;
        }
        self
    }

    /// The pixels in either.
    pub fn or(mut self, other: &Self) -> Self {
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            *a |= b;
        }
        self
    }

    /// The pixels that are not in it.
    pub fn not(mut self) -> Self {
        self.words.iter_mut().for_each(|word| *word = !*word);
        self
    }

    /// The pixels after one that is in it, in their row.
    pub fn shifted_along(mut self) -> Self {
        for row in self.words.chunks_exact_mut(self.stride.max(1)) {
            let mut carry = 0;
            for word in row {
                (*word, carry) = (*word << 1 | carry, *word >> 63);
            }
        }
        self
    }

    /// The pixels below one that is in it.
    pub fn shifted_down(mut self) -> Self {
        let n = self.words.len();
        self.words
            .copy_within(..n - self.stride.min(n), self.stride.min(n));
        self.words[..self.stride.min(n)].fill(0);
        self
    }

    /// Calls `with` for the column and the row of every pixel in it, row by row.
    pub fn for_each(&self, mut with: impl FnMut(usize, usize)) {
        for (v, row) in self.words.chunks_exact(self.stride.max(1)).enumerate() {
            for (i, &word) in row.iter().enumerate() {
                let mut left = word;
                while left != 0 {
                    let u = 64 * i + left.trailing_zeros() as usize;
                    if u < self.width {
                        with(u, v);
                    }
                    left &= left - 1;
                }
            }
        }
    }

    /// The pixels of which all those from `back` columns before to `ahead` columns after are in
    /// it; beyond the image all are.
    pub fn all_along(mut self, back: usize, ahead: usize) -> Self {
        // Bits beyond the row's end count as set.
        let last = !0_u64 << (self.width % 64) & if self.width.is_multiple_of(64) { 0 } else { !0 };
        for row in self.words.chunks_exact_mut(self.stride.max(1)) {
            if let Some(end) = row.last_mut() {
                *end |= last;
            }
            for _ in 0..ahead {
                for i in 0..row.len() {
                    let next = row.get(i + 1).copied().unwrap_or(!0);
                    row[i] &= row[i] >> 1 | next << 63;
                }
            }
            for _ in 0..back {
                for i in (0..row.len()).rev() {
                    let before = if i > 0 { row[i - 1] } else { !0 };
                    row[i] &= row[i] << 1 | before >> 63;
                }
            }
        }
        self
    }

    /// The same along the columns.
    pub fn all_down(mut self, back: usize, ahead: usize) -> Self {
        let n = self.words.len();
        for _ in 0..ahead {
            for i in self.stride..n {
                self.words[i - self.stride] &= self.words[i];
            }
        }
        for _ in 0..back {
            for i in (self.stride..n).rev() {
                self.words[i] &= self.words[i - self.stride];
            }
        }
        self
    }

    /// The pixels of which all those within `r` (in the maximum norm) are in it.
    pub fn eroded(self, r: usize) -> Self {
        self.all_along(r, r).all_down(r, r)
    }

    /// The pixels within `r` of one that is in it.
    pub fn dilated(self, r: usize) -> Self {
        self.not().eroded(r).not()
    }

    /// The labels of the pixels in it, and [`NONE`] for all others.
    pub fn kept(&self, labels: &[u16]) -> Vec<u16> {
        let mut kept = Vec::with_capacity(labels.len());
        let rows = labels.chunks_exact(self.width.max(1));
        for (labels, words) in rows.zip(self.words.chunks_exact(self.stride.max(1))) {
            for (labels, &word) in labels.chunks(64).zip(words) {
                match word {
                    0 => kept.resize(kept.len() + labels.len(), NONE),
                    _ if word == !0 => kept.extend_from_slice(labels),
                    _ => kept.extend(labels.iter().enumerate().map(|(i, &label)| {
                        // All bits set where it is not.
                        label | ((word >> i & 1) as u16).wrapping_sub(1)
                    })),
                }
            }
        }
        kept
    }
}

/// Writes the bits of up to 64 pixels a word, where `is` holds for what the two lines have there.
pub(super) fn pack<A: Copy, B: Copy>(
    a: &[A],
    b: &[B],
    words: &mut [u64],
    is: impl Fn(A, B) -> bool,
) {
    for ((a, b), word) in a.chunks(64).zip(b.chunks(64)).zip(words) {
        *word = packed(a, b, &is);
    }
}

/// The bits of up to 64 pixels.
#[inline]
fn packed<A: Copy, B: Copy>(a: &[A], b: &[B], is: impl Fn(A, B) -> bool) -> u64 {
    let mut flags = [0_u8; 64];
    if let (Some(a), Some(b)) = (a.first_chunk::<64>(), b.first_chunk::<64>()) {
        // Of a length that the compiler knows.
        for i in 0..64 {
            flags[i] = u8::from(is(a[i], b[i]));
        }
    } else {
        for ((flag, &a), &b) in flags.iter_mut().zip(a).zip(b) {
            *flag = u8::from(is(a, b));
        }
    }
    let eights = flags.as_chunks().0.iter().copied().map(u64::from_le_bytes);
    let (all, any) = eights
        .clone()
        .fold((!0, 0), |(all, any), eight| (all & eight, any | eight));
    // Most words are all one or the other.
    match (all, any) {
        (_, 0) => 0,
        (0x0101_0101_0101_0101, _) => !0,
        // Gathers the lowest bits of eight bytes in the highest byte, the first one lowest.
        _ => (0..).zip(eights).fold(0, |word, (i, eight)| {
            word | (eight.wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * i)
        }),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Whether (u, v) is in it, counting what lies beyond the image as `beyond`.
    pub fn at(bits: &Bits, u: i64, v: i64, beyond: bool) -> bool {
        if u < 0 || v < 0 || u >= bits.width as i64 || v >= bits.height as i64 {
            return beyond;
        }
        bits.has(u as usize, v as usize)
    }

    fn picture(width: usize, height: usize, odds: usize) -> Bits {
        Bits::new(width, height, |v, words| {
            for u in 0..width {
                // A fixed pattern without a period in either direction.
                let x = (u * 2654435761 + v * 40503 + (u * v) % 97) % 101;
                words[u / 64] |= u64::from(x >= odds) << (u % 64);
            }
        })
    }

    #[test]
    fn erosion_and_dilation_are_those_of_the_definition() {
        for (width, height, r) in [(70, 9, 1), (64, 11, 2), (130, 12, 3), (5, 4, 2)] {
            for (odds, erode) in [(2, true), (97, false)] {
                let bits = picture(width, height, odds);
                let got = if erode {
                    bits.clone().eroded(r)
                } else {
                    bits.clone().dilated(r)
                };
                let r = r as i64;
                for (v, u) in
                    (0..height as i64).flat_map(|v| (0..width as i64).map(move |u| (v, u)))
                {
                    let mut around = (-r..=r).flat_map(|y| (-r..=r).map(move |x| (x, y)));
                    let expected = if erode {
                        around.all(|(x, y)| at(&bits, u + x, v + y, true))
                    } else {
                        around.any(|(x, y)| at(&bits, u + x, v + y, false))
                    };
                    assert_eq!(at(&got, u, v, true), expected, "({u}, {v})");
                }
            }
        }
    }
}
