//! A counter-based random stream: the value at any place, without a state.

/// Random numbers that depend on a seed, a stream and a counter only, so that neither the order
/// of work nor the number of threads changes them.
///
/// Source: the mixing function of splitmix64 [steele2014].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stream(u64);

impl Stream {
    /// Stream number `stream` of `seed`.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(mix(
            mix(seed) ^ mix(stream.wrapping_add(0x6a09_e667_f3bc_c909))
        ))
    }

    /// A number in 0..n at place `counter`; `n` must not be 0.
    pub fn below(&self, counter: u64, n: usize) -> usize {
        let x = mix(self.0.wrapping_add(counter.wrapping_mul(GAMMA)));
        // The high word of x · n: a bias of n / 2⁶⁴.
        ((u128::from(x) * n as u128) >> 64) as usize
    }
}

const GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(GAMMA);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_spread_evenly_and_streams_differ() {
        let stream = Stream::new(7, 0);
        let mut counts = [0_usize; 10];
        for i in 0..10_000 {
            counts[stream.below(i, 10)] += 1;
        }
        // Ten bins of 1000 ± 30: five standard deviations.
        assert!(counts.iter().all(|n| (850..1150).contains(n)), "{counts:?}");
        let other = Stream::new(7, 1);
        let same = (0..1000)
            .filter(|&i| stream.below(i, 1000) == other.below(i, 1000))
            .count();
        assert!(same < 20, "{same}");
    }
}
