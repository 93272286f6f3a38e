//! Random images: white noise smoothed by a Gaussian.

use super::rng::Stream;

/// A real image, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values, row by row.
    pub values: Vec<f64>,
}

impl Field {
    /// White noise of unit variance.
    pub fn white(width: usize, height: usize, stream: Stream) -> Self {
        let values = (0..(width * height) as u64)
            .map(|i| stream.normal(i))
            .collect();
        Self {
            width,
            height,
            values,
        }
    }

    /// White noise smoothed by a Gaussian of `sigma_px` and scaled to an RMS of 1.
    pub fn smooth(width: usize, height: usize, sigma_px: f64, stream: Stream) -> Self {
        Self::white(width, height, stream)
            .gaussian(sigma_px)
            .unit_rms()
    }

    /// Convolution with a Gaussian cut off at 4σ, the image mirrored at its borders.
    ///
    ///   w_k ∝ exp(−k²/2σ²),  applied to the rows, then to the columns
    pub fn gaussian(&self, sigma_px: f64) -> Self {
        let kernel = kernel(sigma_px);
        let rows = convolve_rows(&self.values, self.width, self.height, &kernel);
        let columns = transpose(&rows, self.width, self.height);
        let both = convolve_rows(&columns, self.height, self.width, &kernel);
        Self {
            values: transpose(&both, self.height, self.width),
            ..*self
        }
    }

    /// Root mean square.
    pub fn rms(&self) -> f64 {
        (self.values.iter().map(|v| v * v).sum::<f64>() / self.values.len().max(1) as f64).sqrt()
    }

    fn unit_rms(mut self) -> Self {
        let rms = self.rms();
        if rms > 0.0 {
            self.values.iter_mut().for_each(|v| *v /= rms);
        }
        self
    }
}

/// Half of the symmetric kernel: weights of the offsets 0, 1, …, ⌈4σ⌉, the whole summing to 1.
fn kernel(sigma_px: f64) -> Vec<f64> {
    if sigma_px <= 0.0 {
        return vec![1.0];
    }
    let radius = (4.0 * sigma_px).ceil() as usize;
    let weight = |k: usize| exp_minus((k * k) as f64 / (2.0 * sigma_px * sigma_px));
    let mut half: Vec<f64> = (0..=radius).map(weight).collect();
    let sum = half[0] + 2.0 * half[1..].iter().sum::<f64>();
    half.iter_mut().for_each(|w| *w /= sum);
    half
}

/// exp(−x) for 0 ≤ x ≤ 20 from a Taylor series of exp(−x/64), squared six times: the same bits on
/// every platform.
fn exp_minus(x: f64) -> f64 {
    let y = -x / 64.0;
    let mut term = 1.0;
    let mut sum = 1.0;
    for k in 1..=16 {
        term *= y / f64::from(k);
        sum += term;
    }
    (0..6).fold(sum, |value, _| value * value)
}

fn convolve_rows(values: &[f64], width: usize, height: usize, half: &[f64]) -> Vec<f64> {
    let radius = half.len() - 1;
    let mut out = Vec::with_capacity(values.len());
    let mut padded = vec![0.0; width + 2 * radius];
    for y in 0..height {
        let row = &values[y * width..(y + 1) * width];
        for (i, value) in padded.iter_mut().enumerate() {
            *value = row[mirror(i as isize - radius as isize, width)];
        }
        for x in 0..width {
            let centre = x + radius;
            let sides = (1..=radius).map(|k| half[k] * (padded[centre - k] + padded[centre + k]));
            out.push(half[0] * padded[centre] + sides.sum::<f64>());
        }
    }
    out
}

/// The index inside 0…n−1 that the mirrored image (… c b a | a b c | c b a …) has at `i`.
fn mirror(i: isize, n: usize) -> usize {
    let period = 2 * n as isize;
    let i = i.rem_euclid(period);
    (if i < n as isize { i } else { period - 1 - i }) as usize
}

fn transpose(values: &[f64], width: usize, height: usize) -> Vec<f64> {
    (0..width)
        .flat_map(|x| (0..height).map(move |y| values[y * width + x]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn exponential_agrees_with_the_platform() {
        for i in 0..=200 {
            let x = f64::from(i) * 0.1;
            assert_relative_eq!(exp_minus(x), (-x).exp(), max_relative = 1e-13);
        }
    }

    #[test]
    fn an_impulse_spreads_to_the_gaussian() {
        let (w, h, sigma) = (31, 21, 1.8);
        let mut impulse = Field {
            width: w,
            height: h,
            values: vec![0.0; w * h],
        };
        impulse.values[10 * w + 15] = 1.0;
        let spread = impulse.gaussian(sigma);
        assert_relative_eq!(spread.values.iter().sum::<f64>(), 1.0, epsilon = 1e-12);
        let value = |x: usize, y: usize| spread.values[y * w + x];
        let r2 = (3 * 3 + 2 * 2) as f64;
        assert_relative_eq!(
            value(18, 8) / value(15, 10),
            (-r2 / (2.0 * sigma * sigma)).exp(),
            max_relative = 1e-12
        );
    }

    #[test]
    fn mirrored_borders_keep_a_constant_image() {
        let image = Field {
            width: 9,
            height: 5,
            values: vec![2.5; 45],
        };
        for value in image.gaussian(4.0).values {
            assert_relative_eq!(value, 2.5, epsilon = 1e-12);
        }
    }

    #[test]
    fn smoothed_noise_has_the_wanted_correlation_length() {
        let (w, h, sigma) = (256, 256, 1.8);
        let field = Field::smooth(w, h, sigma, Stream::new(1, 5));
        assert_relative_eq!(field.rms(), 1.0, epsilon = 1e-12);
        // Autocorrelation of Gaussian-filtered white noise: exp(−d²/4σ²).
        for d in [1usize, 2, 4] {
            let mut sum = 0.0;
            for y in 0..h {
                for x in 0..w - d {
                    sum += field.values[y * w + x] * field.values[y * w + x + d];
                }
            }
            let correlation = sum / (h * (w - d)) as f64;
            let expected = (-((d * d) as f64) / (4.0 * sigma * sigma)).exp();
            // 256²/(4πσ²) ≈ 1600 independent spots: standard error 0.025.
            assert!(
                (correlation - expected).abs() < 0.1,
                "lag {d}: {correlation} vs {expected}"
            );
        }
    }
}
