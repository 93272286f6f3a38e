//! Words of 64 bits, one a pixel.

use wide::u8x16;

/// Of 64 columns, the `i`th such word, those from `a` on, up to the one before `b`.
pub(super) fn between(a: usize, b: usize, i: usize) -> u64 {
    let below = |column: usize| match column.saturating_sub(64 * i) {
        0 => 0,
        count => !0 >> (64 - count.min(64)),
    };
    below(b) & !below(a)
}

/// The places of a word's bits that are set, the lowest first.
pub(super) struct Ones(pub u64);

impl Iterator for Ones {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        let place = (self.0 != 0).then(|| self.0.trailing_zeros() as usize);
        self.0 &= self.0.wrapping_sub(1);
        place
    }
}

/// The places of all bits of a row of words that are set.
pub(super) fn places(row: &[u64]) -> impl Iterator<Item = usize> {
    let words = row.iter().enumerate();
    words.flat_map(|(i, &word)| Ones(word).map(move |bit| 64 * i + bit))
}

/// Every `N`th bit, from the first one on.
pub(super) fn firsts<const N: usize>() -> u64 {
    (0..64).step_by(N).fold(0, |all, bit| all | 1 << bit)
}

/// Calls `with` for every run of bits in a row of words: the first one, one past the last. A run ends
/// with a bit that is in `cuts`, if these are given.
#[inline]
pub(super) fn runs(row: &[u64], cuts: Option<&[u64]>, mut with: impl FnMut(usize, usize)) {
    let (mut first, mut joined) = (None, 0);
    for (i, &word) in row.iter().enumerate() {
        let linked = word & !cuts.map_or(0, |cuts| cuts[i]);
        let next = word >> 1 | row.get(i + 1).map_or(0, |next| next << 63);
        // Starts and ends take turns; a start may have been in a word before.
        let mut starts = Ones(word & !(linked << 1 | joined));
        for end in Ones(word & !(linked & next)) {
            let start = first.take().or_else(|| Some(64 * i + starts.next()?));
            start.into_iter().for_each(|a| with(a, 64 * i + end + 1));
        }
        first = first.or_else(|| Some(64 * i + starts.next()?));
        joined = linked >> 63;
    }
}

/// Writes the bits of up to 64 pixels a word, where `is` holds for what the two lines have there.
#[inline]
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
pub(super) fn packed<A: Copy, B: Copy>(a: &[A], b: &[B], is: impl Fn(A, B) -> bool) -> u64 {
    if let (Some(a), Some(b)) = (a.first_chunk(), b.first_chunk()) {
        return packed_64(a, b, is);
    }
    // Fewer pixels are made 64: loops of that length are what is fast.
    let count = a.len().min(b.len());
    let (Some(&x), Some(&y)) = (a.first(), b.first()) else {
        return 0;
    };
    let (mut xs, mut ys) = ([x; 64], [y; 64]);
    xs[..count].copy_from_slice(&a[..count]);
    ys[..count].copy_from_slice(&b[..count]);
    packed_64(&xs, &ys, is) & between(0, count, 0)
}

#[inline]
fn packed_64<A: Copy, B: Copy>(a: &[A; 64], b: &[B; 64], is: impl Fn(A, B) -> bool) -> u64 {
    let parts = a.as_chunks().0.iter().zip(b.as_chunks().0).enumerate();
    parts.fold(0, |word, (k, (a, b))| {
        word | packed_16(a, b, &is) << (16 * k)
    })
}

/// The bits of 16 pixels.
#[inline]
pub(super) fn packed_16<A: Copy, B: Copy>(
    a: &[A; 16],
    b: &[B; 16],
    is: impl Fn(A, B) -> bool,
) -> u64 {
    let mut flags = [0_u8; 16];
    for i in 0..16 {
        flags[i] = if is(a[i], b[i]) { !0 } else { 0 };
    }
    u8x16::from(flags).to_bitmask().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_where_the_pixels_are() {
        for count in [64, 37] {
            let values: Vec<usize> = (0..count).map(|i| i * i % 11).collect();
            let word = packed(&values, &values, |a, _| a > 4);
            let set: Vec<usize> = Ones(word).collect();
            let expected: Vec<usize> = (0..count).filter(|i| values[*i] > 4).collect();
            assert_eq!(set, expected);
        }
    }

    #[test]
    fn a_range_of_columns_is_cut_into_words() {
        for (a, b) in [
            (3, 9),
            (0, 64),
            (60, 70),
            (64, 128),
            (70, 200),
            (9, 9),
            (9, 3),
        ] {
            for i in 0..4 {
                let expected = (0..64).filter(|bit| (a..b).contains(&(64 * i + bit)));
                let got: Vec<usize> = Ones(between(a, b, i)).collect();
                assert_eq!(got, expected.collect::<Vec<_>>(), "{a} to {b}, {i}");
            }
        }
    }
}
