//! Counter-based random numbers: the value is a pure function of seed, stream and index.

/// One stream of random numbers; streams of the same seed are independent of one another.
#[derive(Clone, Copy, Debug)]
pub struct Stream {
    key: u64,
}

impl Stream {
    /// The stream with this number under this seed.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self {
            key: mix(mix(seed) ^ mix(stream.wrapping_add(GOLDEN))),
        }
    }

    /// 64 random bits at `index`.
    pub fn bits(&self, index: u64) -> u64 {
        mix(self.key.wrapping_add(index.wrapping_mul(GOLDEN)))
    }

    /// Uniform in [0, 1) at `index`.
    pub fn uniform(&self, index: u64) -> f64 {
        (self.bits(index) >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Zero mean, unit variance, nearly normal at `index`.
    ///
    /// The sum of twelve uniform numbers less 6 (Irwin-Hall): exact in every platform's arithmetic,
    /// which the logarithm and cosine of Box-Muller are not; its tails end at 6σ.
    pub fn normal(&self, index: u64) -> f64 {
        let first = index.wrapping_mul(12);
        (0..12)
            .map(|k| self.uniform(first.wrapping_add(k)))
            .sum::<f64>()
            - 6.0
    }
}

/// The odd integer nearest to 2⁶⁴/φ.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// The finaliser of SplitMix64 (variant 13 of Stafford's mixers): a bijection that avalanches.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_has_the_moments_of_a_normal_distribution() {
        let stream = Stream::new(3, 1);
        let n = 200_000u64;
        let moment = |p: i32| (0..n).map(|i| stream.normal(i).powi(p)).sum::<f64>() / n as f64;
        // Standard errors: 1/√n = 0.0022, √(2/n) = 0.0032, √(15/n) = 0.0087; four of them allowed.
        assert!(moment(1).abs() < 0.009, "mean {}", moment(1));
        assert!((moment(2) - 1.0).abs() < 0.013, "variance {}", moment(2));
        assert!(moment(3).abs() < 0.035, "skewness {}", moment(3));
        // Irwin-Hall of 12 has excess kurtosis −0.1.
        assert!((moment(4) - 2.9).abs() < 0.08, "kurtosis {}", moment(4));
    }

    #[test]
    fn streams_and_seeds_are_uncorrelated() {
        let n = 100_000u64;
        let correlation = |a: Stream, b: Stream| {
            (0..n).map(|i| a.normal(i) * b.normal(i)).sum::<f64>() / n as f64
        };
        for (a, b) in [
            ((1, 1), (1, 2)),
            ((1, 1), (2, 1)),
            ((0, 0), (0, 1)),
            ((1, 2), (2, 1)),
        ] {
            let c = correlation(Stream::new(a.0, a.1), Stream::new(b.0, b.1));
            assert!(
                c.abs() < 4.0 / (n as f64).sqrt(),
                "streams {a:?} and {b:?}: {c}"
            );
        }
        // Neighbours within a stream.
        let s = Stream::new(7, 7);
        let c = (0..n).map(|i| s.normal(i) * s.normal(i + 1)).sum::<f64>() / n as f64;
        assert!(c.abs() < 4.0 / (n as f64).sqrt(), "neighbours: {c}");
    }
}
