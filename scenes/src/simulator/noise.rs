//! The errors of a structured-light depth sensor, with their sizes.

use serde::{Deserialize, Serialize};

/// Sizes of every error; [`DepthNoise::default`] is an Asus Xtion or Kinect v1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DepthNoise {
    /// σ_z = a + b·(z − c)², m: a, m.
    pub sigma_floor_m: f64,
    /// b, 1/m.
    pub sigma_growth_per_m: f64,
    /// c, m.
    pub sigma_nearest_m: f64,
    /// σ of the Gaussian that correlates the depth noise, pixels.
    pub correlation_px: f64,
    /// RMS of the smooth distortion of the whole image, fraction of z.
    pub distortion: f64,
    /// σ of the Gaussian that shapes that distortion, pixels.
    pub distortion_px: f64,
    /// Step of the disparity, pixels; 0 leaves the depth continuous.
    pub disparity_step_px: f64,
    /// Distance between projector and camera, m; the projector stands on +x of the camera.
    pub baseline_m: f64,
    /// RMS of the displacement of what a pixel sees, pixels.
    pub jitter_px: f64,
    /// Probability that a pixel within two of a depth edge has no value.
    pub edge_dropout: f64,
    /// Probability that a pixel has no value where the cosine of incidence is below
    /// `grazing_cosine`.
    pub grazing_dropout: f64,
    /// Cosine of incidence below which pixels begin to drop out.
    pub grazing_cosine: f64,
    /// Cosine of incidence below which no pixel has a value.
    pub blind_cosine: f64,
    /// Probability that any pixel has no value.
    pub speckle_dropout: f64,
    /// Height of the level, in RMS of a 3 px smooth field, above which blobs drop out.
    pub blob_level: f64,
    /// Least depth, m.
    pub range_min_m: f64,
    /// Greatest depth, m.
    pub range_max_m: f64,
}

impl Default for DepthNoise {
    /// Axial noise of Nguyen, Izadi and Lovell (3DIMPVT 2012), eq. 2 at small incidence; distortion
    /// and correlation as measured on real Kinect v1 and Xtion walls and floors.
    fn default() -> Self {
        Self {
            sigma_floor_m: 0.0012,
            sigma_growth_per_m: 0.0019,
            sigma_nearest_m: 0.4,
            correlation_px: 1.8,
            distortion: 0.004,
            distortion_px: 40.0,
            disparity_step_px: 0.125,
            baseline_m: 0.075,
            jitter_px: 0.5,
            edge_dropout: 0.75,
            grazing_dropout: 0.6,
            grazing_cosine: 0.2,
            blind_cosine: 0.08,
            speckle_dropout: 0.0002,
            blob_level: 3.3,
            range_min_m: 0.45,
            range_max_m: 8.0,
        }
    }
}

impl DepthNoise {
    /// No errors at all: true depths, rounded to the image's millimetre.
    pub fn none() -> Self {
        Self {
            sigma_floor_m: 0.0,
            sigma_growth_per_m: 0.0,
            distortion: 0.0,
            disparity_step_px: 0.0,
            baseline_m: 0.0,
            jitter_px: 0.0,
            edge_dropout: 0.0,
            grazing_dropout: 0.0,
            blind_cosine: 0.0,
            speckle_dropout: 0.0,
            blob_level: f64::INFINITY,
            range_min_m: 0.0,
            range_max_m: f64::INFINITY,
            ..Self::default()
        }
    }

    /// σ_z at depth z, m.
    pub fn sigma_m(&self, depth_m: f64) -> f64 {
        let beyond = depth_m - self.sigma_nearest_m;
        self.sigma_floor_m + self.sigma_growth_per_m * beyond * beyond
    }

    /// The depth that the sensor reports for `depth_m`: rounded in disparity f·B/z.
    pub fn quantise(&self, depth_m: f64, focal_px: f64) -> f64 {
        let scale = focal_px * self.baseline_m;
        if self.disparity_step_px <= 0.0 || scale <= 0.0 || depth_m <= 0.0 {
            return depth_m;
        }
        let steps = (scale / depth_m / self.disparity_step_px).round().max(1.0);
        scale / (steps * self.disparity_step_px)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn quantisation_is_nearest_in_disparity() {
        let noise = DepthNoise::default();
        for i in 0..1000 {
            let z = 0.5 + f64::from(i) * 0.005;
            let q = noise.quantise(z, 525.0);
            let disparity = |z: f64| 525.0 * 0.075 / z;
            assert!((disparity(q) - disparity(z)).abs() <= 0.0625 + 1e-9);
            assert_relative_eq!(
                disparity(q) * 8.0,
                (disparity(q) * 8.0).round(),
                epsilon = 1e-9
            );
        }
        assert_relative_eq!(DepthNoise::none().quantise(1.2345, 525.0), 1.2345);
    }

    #[test]
    fn sigma_is_the_published_polynomial() {
        assert_relative_eq!(DepthNoise::default().sigma_m(2.4), 0.0012 + 0.0019 * 4.0);
    }
}
