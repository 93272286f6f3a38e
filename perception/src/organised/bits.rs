//! Bitmaps of the image, 64 pixels a word: what is said of pixels near each other, by bitwise AND.

use wide::u64x4;

use super::words::{Ones, between, firsts, pack, packed, runs};

/// Words after the last row: four at a time are read from one beyond it on.
const SPARE: usize = 5;

/// One bit a pixel, row by row. Every row begins with a spare word, a spare row is above the first one
/// and below the last one, and a few words follow: so every word of pixels has all its neighbours,
/// wherever it is. Bits that are no pixel's are not set.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Bits {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Words of a row, with the spare one.
    stride: usize,
    words: Vec<u64>,
}

impl Bits {
    /// The bitmap of an image, each row by `row`: the row and its words, which are all zero.
    pub fn new(width: usize, height: usize, mut row: impl FnMut(usize, &mut [u64])) -> Self {
        let mut bits = Self::empty(width, height);
        (0..height).for_each(|v| row(v, bits.row_mut(v)));
        bits.ended()
    }

    /// A bitmap without a pixel.
    pub fn empty(width: usize, height: usize) -> Self {
        let stride = width.div_ceil(64) + 1;
        Self {
            width,
            height,
            stride,
            words: vec![0; stride * (height + 2) + SPARE],
        }
    }

    /// The pixels of an image, in rows of `width`, for which `is` holds.
    pub fn of<A: Copy>(image: &[A], width: usize, is: impl Fn(A) -> bool) -> Self {
        let height = image.len() / width.max(1);
        Self::new(width, height, |v, words| {
            let line = &image[v * width..][..width];
            pack(line, line, words, |a, _| is(a));
        })
    }

    /// The pixels of a row, 64 a word.
    pub fn row(&self, v: usize) -> &[u64] {
        &self.words[(v + 1) * self.stride..][1..self.stride]
    }

    /// The same to be changed; what lies beyond the row's end must not be set.
    pub fn row_mut(&mut self, v: usize) -> &mut [u64] {
        &mut self.words[(v + 1) * self.stride..][1..self.stride]
    }

    /// Without what is no pixel.
    fn ended(mut self) -> Self {
        // Of a row's last word, what is the image's.
        let end = match self.width % 64 {
            0 => !0,
            pixels => !(!0 << pixels),
        };
        let (stride, height) = (self.stride, self.height);
        let (above, rows) = self.words.split_at_mut(stride);
        let (rows, below) = rows.split_at_mut(stride * height);
        above.fill(0);
        below.fill(0);
        for row in rows.chunks_exact_mut(stride) {
            row[0] = 0;
            row[stride - 1] &= end;
        }
        self
    }

    /// A bitmap of the size of others, each of its words by `with` from those around the same place of each
    /// of them: the row above, its own and the one below, of each the word before, itself and the one after.
    #[inline(always)]
    pub fn around<const N: usize>(of: [&Self; N], with: impl Fn([[Three; 3]; N]) -> u64x4) -> Self {
        let mut bits = Self::empty(of[0].width, of[0].height);
        let stride = bits.stride;
        // The first of all is a spare one.
        let fours = (stride * bits.height).div_ceil(4);
        let mut near: [[[&[[u64; 4]]; 3]; 3]; N] = [[[&[]; 3]; 3]; N];
        for (near, bits) in near.iter_mut().zip(of) {
            for (y, row) in near.iter_mut().enumerate() {
                for (x, words) in row.iter_mut().enumerate() {
                    *words = bits.words[y * stride + x..][..4 * fours].as_chunks().0;
                }
            }
        }
        let words = bits.words[stride + 1..][..4 * fours].as_chunks_mut().0;
        for (i, four) in words.iter_mut().enumerate() {
            let mut here = [[[u64x4::ZERO; 3]; 3]; N];
            for (here, near) in here.iter_mut().zip(&near) {
                for (here, near) in here.iter_mut().zip(near) {
                    for (here, near) in here.iter_mut().zip(near) {
                        *here = u64x4::from(near[i]);
                    }
                }
            }
            *four = with(here).to_array();
        }
        bits.ended()
    }

    /// How many pixels are in it.
    pub fn count(&self) -> usize {
        self.words
            .iter()
            .map(|word| word.count_ones() as usize)
            .sum()
    }

    /// Whether a pixel is in it.
    pub fn has(&self, u: usize, v: usize) -> bool {
        self.row(v)[u / 64] >> (u % 64) & 1 == 1
    }

    /// Takes a pixel out.
    pub fn clear(&mut self, u: usize, v: usize) {
        self.row_mut(v)[u / 64] &= !(1 << (u % 64));
    }

    /// Takes the pixels within `r` columns of one out, if that is in the image's rows.
    pub fn clear_along(&mut self, u: isize, v: isize, r: isize) {
        if v < 0 || v >= self.height as isize {
            return;
        }
        let column = |u: isize| u.clamp(0, self.width as isize) as usize;
        let (a, b) = (column(u - r), column(u + r + 1));
        self.span(v as usize, a, b, |word, its| *word &= !its);
    }

    /// Puts the pixels of a row from column `a` on in, up to the one before `b`.
    pub fn fill(&mut self, v: usize, a: usize, b: usize) {
        self.span(v, a, b, |word, its| *word |= its);
    }

    /// Calls `with` for the words of a row that have columns from `a` on, up to the one before `b`, and
    /// which of a word these are.
    #[inline]
    fn span(&mut self, v: usize, a: usize, b: usize, with: impl Fn(&mut u64, u64)) {
        let words = self.row_mut(v).iter_mut().enumerate();
        for (i, word) in words.take(b.div_ceil(64)).skip(a / 64) {
            with(word, between(a, b, i));
        }
    }

    /// What words have in common with those of another bitmap, from rows `v` and `w` on down to the end of
    /// either, where that is anything: how many rows down, the number of the word, its pixels.
    pub fn common(
        &self,
        v: usize,
        other: &Self,
        w: usize,
    ) -> impl Iterator<Item = (usize, usize, u64)> {
        let (stride, from) = (self.stride, |bits: &Self, v: usize| (v + 1) * bits.stride);
        let words = self.words[from(self, v)..].iter();
        let both = words.zip(&other.words[from(other, w)..]).enumerate();
        both.filter(|(_, (a, b))| **a & **b != 0)
            .map(move |(i, (a, b))| (i / stride, i % stride - 1, a & b))
    }

    /// Those of its pixels for which `is` holds for what the image has there.
    pub fn filter<A: Copy>(mut self, image: &[A], is: impl Fn(A) -> bool) -> Self {
        for (v, pixels) in image.chunks_exact(self.width.max(1)).enumerate() {
            for (pixels, word) in pixels.chunks(64).zip(self.row_mut(v)) {
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

    /// Those of its pixels from which the one `x` columns and `y` rows on is in the other one; `x` is less
    /// than 64.
    pub fn and_moved(mut self, other: &Self, x: isize, y: isize) -> Self {
        // Rows follow each other, a spare word between: all is one row of bits.
        let ahead = 64 * y * self.stride as isize + x;
        let (words, bits) = (ahead.div_euclid(64), ahead.rem_euclid(64));
        let (before, from) = ((-words).max(0) as usize, words.max(0) as usize);
        let of = &other.words[from.min(other.words.len() - 1)..];
        let moved = of.iter().zip(&of[1..]);
        let moved = moved.map(|(word, next)| word >> bits | (next << 1) << (63 - bits));
        // The last word is a spare one.
        let count = moved.len().min(self.words.len().saturating_sub(before));
        let before = self.words.len().min(before);
        self.words[..before].fill(0);
        self.words[before + count..].fill(0);
        for (a, b) in self.words[before..].iter_mut().zip(moved) {
            *a &= b;
        }
        self
    }

    /// The pixels that are not in it.
    pub fn not(mut self) -> Self {
        self.words.iter_mut().for_each(|word| *word = !*word);
        self.ended()
    }

    /// Of 64 columns, the `i`th such word, those at which a block of `N` × `N` pixels begins of which
    /// some are in it; blocks begin at every `N`th column and at row `top`.
    pub fn some<const N: usize>(&self, i: usize, top: usize) -> u64 {
        let some = (top..top + N).fold(0, |some, v| some | self.row(v)[i]);
        let some = (0..N).fold(0, |all, k| all | some >> k);
        some & firsts::<N>()
    }

    /// Calls `with` for the column and the row of every pixel in it, row by row.
    pub fn for_each(&self, mut with: impl FnMut(usize, usize)) {
        for v in 0..self.height {
            for (i, &word) in self.row(v).iter().enumerate() {
                if word != 0 {
                    Ones(word).for_each(|bit| with(64 * i + bit, v));
                }
            }
        }
    }

    /// Calls `with` for every run of pixels in a row that are in it, row by row: the row, the first
    /// column, one past the last. A run ends with a pixel that is in `cuts`.
    pub fn for_runs(&self, cuts: &Self, mut with: impl FnMut(usize, usize, usize)) {
        for v in 0..self.height {
            runs(self.row(v), Some(cuts.row(v)), |a, b| with(v, a, b));
        }
    }

    /// The pixels within `r` (in the maximum norm) of one that is in it.
    pub fn dilated(self, r: usize) -> Self {
        (0..r).fold(self, |bits, _| {
            Self::around([&bits], |[near]| {
                beside([0, 1, 2].map(|k| near[0][k] | near[1][k] | near[2][k]))
            })
        })
    }

    /// The pixels of which all those within `r` are in it; beyond the image all are.
    pub fn eroded(self, r: usize) -> Self {
        self.not().dilated(r).not()
    }
}

/// Four words, each between the one before it and the one after it.
pub(super) type Three = [u64x4; 3];

/// The pixels of which the one on the left is in it.
#[inline(always)]
pub(super) fn on_left([before, word, _]: Three) -> u64x4 {
    word << 1 | before >> 63
}

/// The pixels of which the one on the right is in it.
#[inline(always)]
pub(super) fn on_right([_, word, after]: Three) -> u64x4 {
    word >> 1 | after << 63
}

/// The pixels that are in it, or beside one of their row that is.
#[inline(always)]
pub(super) fn beside(three: Three) -> u64x4 {
    three[1] | on_left(three) | on_right(three)
}

#[cfg(test)]
pub(super) mod tests;
