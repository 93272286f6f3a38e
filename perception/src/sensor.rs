//! The sensor table: default intrinsics, noise, systematic error and range by name.

use serde::{Deserialize, Serialize};

use crate::Error;

/// Pinhole intrinsics, px: u = fx x/z + cx, v = fy y/z + cy, pixel centres at integers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Intrinsics {
    /// Focal length along the rows, px.
    pub fx: f64,
    /// Focal length along the columns, px.
    pub fy: f64,
    /// Column of the principal point, px.
    pub cx: f64,
    /// Row of the principal point, px.
    pub cy: f64,
}

/// Noise of one depth pixel along the optical axis.
///
///   σ_z(z) = a + b (z − z₀)²,  z ≥ z₀;  σ_z = a below z₀
///
/// Source: \[nguyen2012\] for the a, b, z₀ of structured light; correlation and κ of that were measured
/// on real walls, those of the other sensors are taken to be of the same order.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// a: standard deviation at close range, m.
    pub floor_m: f64,
    /// b: growth with the square of the distance, 1/m.
    pub quadratic_per_m: f64,
    /// z₀: where the growth begins, m.
    pub knee_m: f64,
    /// Standard deviation of the Gaussian that correlates neighbouring pixels' noise, px.
    pub correlation_px: f64,
    /// κ: root mean square of the slowly varying depth error, as a ratio of z.
    pub systematic_ratio: f64,
    /// Standard deviation of the Gaussian that shapes the slowly varying error, px.
    pub systematic_scale_px: f64,
    /// Whether the sensor is unknown and this a guess, which a cloud's own points go before.
    #[serde(default)]
    pub guessed: bool,
}

impl Noise {
    /// σ_z at depth `z_m`, m.
    pub fn sigma_z_m(&self, z_m: f64) -> f64 {
        let beyond = (z_m - self.knee_m).max(0.0);
        self.floor_m + self.quadratic_per_m * beyond * beyond
    }

    /// σ of inverse depth at depth `z_m`, 1/m: σ_z / z².
    pub fn sigma_inverse(&self, z_m: f64) -> f64 {
        self.sigma_z_m(z_m) / (z_m * z_m)
    }

    /// The same at inverse depth `w`, 1/m, without a division: a w² + b (1 − z₀ w)².
    pub fn sigma_at_inverse(&self, w: f64) -> f64 {
        let beyond = (1.0 - self.knee_m * w).max(0.0);
        self.floor_m * w * w + self.quadratic_per_m * beyond * beyond
    }
}

/// One entry of the sensor table.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// The name that scene files use.
    pub name: &'static str,
    /// Image size that the default intrinsics belong to, px.
    pub nominal_px: (usize, usize),
    /// Default intrinsics at the nominal size, if the sensor type has typical ones.
    pub intrinsics: Option<Intrinsics>,
    /// Metres per unit of a depth image of whole numbers.
    pub depth_scale_m: f64,
    /// Depths that the sensor measures, m.
    pub range_m: (f64, f64),
    /// Noise model.
    pub noise: Noise,
}

const STRUCTURED_LIGHT: Noise = Noise {
    floor_m: 0.0012,
    quadratic_per_m: 0.0019,
    knee_m: 0.4,
    correlation_px: 1.8,
    systematic_ratio: 0.004,
    systematic_scale_px: 40.0,
    guessed: false,
};

const fn pinhole(fx: f64, fy: f64, cx: f64, cy: f64) -> Option<Intrinsics> {
    Some(Intrinsics { fx, fy, cx, cy })
}

const XTION: Sensor = Sensor {
    name: "xtion",
    nominal_px: (640, 480),
    intrinsics: pinhole(525.0, 525.0, 319.5, 239.5),
    depth_scale_m: 0.001,
    range_m: (0.4, 8.0),
    noise: STRUCTURED_LIGHT,
};

/// The sensors known by name.
///
/// `generic` has no intrinsics: they must come with the scan.
pub const SENSORS: [Sensor; 6] = [
    XTION,
    Sensor {
        name: "kinect_v1",
        intrinsics: pinhole(575.8, 575.8, 314.5, 235.5),
        ..XTION
    },
    Sensor {
        // The data sets of TUM RGB-D: 5000 units a metre, and the pinhole that they recommend.
        name: "tum",
        depth_scale_m: 0.0002,
        ..XTION
    },
    Sensor {
        // Time of flight: noise that hardly grows with the distance, as [fankhauser2015] found it
        // (a few mm to 3 m); it repeats itself over fewer pixels than a pattern's.
        name: "kinect_v2",
        nominal_px: (512, 424),
        intrinsics: pinhole(365.4, 365.4, 254.9, 207.4),
        noise: Noise {
            floor_m: 0.0018,
            quadratic_per_m: 0.0004,
            knee_m: 0.5,
            correlation_px: 1.0,
            systematic_ratio: 0.003,
            ..STRUCTURED_LIGHT
        },
        ..XTION
    },
    Sensor {
        // Stereo: σ_z = z² σ_d / (f B) [keselman2017], with 0.08 px of σ_d and B = 50 mm at 848 px.
        name: "realsense_d4xx",
        nominal_px: (848, 480),
        intrinsics: pinhole(424.0, 424.0, 423.5, 239.5),
        range_m: (0.2, 10.0),
        noise: Noise {
            floor_m: 0.001,
            quadratic_per_m: 0.0038,
            knee_m: 0.2,
            correlation_px: 2.5,
            systematic_ratio: 0.006,
            systematic_scale_px: 30.0,
            guessed: false,
        },
        ..XTION
    },
    Sensor {
        name: "generic",
        nominal_px: (0, 0),
        intrinsics: None,
        range_m: (0.05, 100.0),
        noise: Noise {
            floor_m: 0.002,
            quadratic_per_m: 0.002,
            knee_m: 0.5,
            systematic_ratio: 0.005,
            guessed: true,
            ..STRUCTURED_LIGHT
        },
        ..XTION
    },
];

impl Sensor {
    /// The table's entry of that name.
    ///
    /// # Errors
    /// [`Error::UnknownSensor`], which lists the table's names.
    pub fn named(name: &str) -> Result<&'static Self, Error> {
        SENSORS
            .iter()
            .find(|sensor| sensor.name == name)
            .ok_or_else(|| Error::UnknownSensor {
                name: name.to_owned(),
                candidates: SENSORS.iter().map(|sensor| sensor.name).collect(),
            })
    }

    /// Default intrinsics for an image of this size: the nominal ones, scaled when the image is
    /// the nominal one shrunk or enlarged by the same factor both ways; `None` otherwise.
    pub fn intrinsics_for(&self, width: usize, height: usize) -> Option<Intrinsics> {
        let nominal = self.intrinsics?;
        let (w0, h0) = self.nominal_px;
        if width * h0 != height * w0 {
            return None;
        }
        let s = width as f64 / w0 as f64;
        // A pixel's centre is at integer + 0: scaling moves the centre of the first pixel.
        Some(Intrinsics {
            fx: nominal.fx * s,
            fy: nominal.fy * s,
            cx: (nominal.cx + 0.5) * s - 0.5,
            cy: (nominal.cy + 0.5) * s - 0.5,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_sensor_lists_the_known_ones() {
        let message = Sensor::named("xtoin").unwrap_err().to_string();
        for sensor in &SENSORS {
            assert!(message.contains(sensor.name), "{message}");
        }
    }

    #[test]
    fn intrinsics_follow_the_image_size_and_keep_the_image_centre() {
        let xtion = Sensor::named("xtion").unwrap();
        let half = xtion.intrinsics_for(320, 240).unwrap();
        assert_eq!((half.fx, half.cx, half.cy), (262.5, 159.5, 119.5));
        assert!(xtion.intrinsics_for(512, 424).is_none());
    }

    #[test]
    fn noise_grows_with_depth_from_its_floor() {
        let noise = Sensor::named("xtion").unwrap().noise;
        assert_eq!(noise.sigma_z_m(0.3), 0.0012);
        assert!((noise.sigma_z_m(2.4) - 0.0088).abs() < 1e-12);
    }
}
