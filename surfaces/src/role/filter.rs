//! What a role asks of a face, and the reason when a face does not serve.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::Face;

/// What a face must be like to serve a role; what is not set is not asked for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Filter {
    /// Smallest tilt from the horizontal, rad.
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub tilt_min_rad: Option<f64>,
    /// Largest tilt from the horizontal, rad: for a foot the steepest slope to walk on.
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub tilt_max_rad: Option<f64>,
    /// The highest point of the face must not be lower than this, m in W.
    #[schemars(range(min = -10_000.0, max = 10_000.0))]
    pub height_min_m: Option<f64>,
    /// The lowest point of the face must not be higher than this, m in W.
    #[schemars(range(min = -10_000.0, max = 10_000.0))]
    pub height_max_m: Option<f64>,
    /// The highest point of the face must not be lower than this over the lowest ground for feet, m; not asked for by
    /// default where `height_min_m` is set.
    #[schemars(range(min = -10_000.0, max = 10_000.0))]
    pub over_ground_min_m: Option<f64>,
    /// The lowest point of the face must not be higher than this over the highest ground for feet, m; not asked for by
    /// default where `height_max_m` is set.
    #[schemars(range(min = -10_000.0, max = 10_000.0))]
    pub over_ground_max_m: Option<f64>,
    /// Direction in W to which the normal should point; need not be a unit vector.
    #[schemars(inner(range(min = -1000.0, max = 1000.0)))]
    pub facing_W: Option<[f64; 3]>,
    /// Largest angle between the normal and `facing_W`, rad; π/2 where it is not set.
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub facing_max_rad: Option<f64>,
    /// Smallest radius of the inscribed circle of what is surely there, m.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub radius_min_m: Option<f64>,
    /// Smallest area of what is surely there, m².
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub area_min_m2: Option<f64>,
}

/// Why a face does not serve a role.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Rejection {
    /// The normal is outside the range of tilts.
    #[error("tilted by {tilt_rad:.3} rad, not {min_rad:.3} … {max_rad:.3}")]
    Tilt {
        /// Angle between the normal and the upward direction, rad.
        tilt_rad: f64,
        /// Smallest allowed, rad.
        min_rad: f64,
        /// Largest allowed, rad.
        max_rad: f64,
    },
    /// The face is too low.
    #[error("its highest point is at {height_m:.3} m, below {min_m:.3} m")]
    TooLow {
        /// Height of its highest point, m.
        height_m: f64,
        /// Smallest allowed, m.
        min_m: f64,
    },
    /// The face is too high.
    #[error("its lowest point is at {height_m:.3} m, above {max_m:.3} m")]
    TooHigh {
        /// Height of its lowest point, m.
        height_m: f64,
        /// Largest allowed, m.
        max_m: f64,
    },
    /// The normal points elsewhere.
    #[error("its normal is {angle_rad:.3} rad off the wanted direction, more than {max_rad:.3}")]
    Facing {
        /// Angle between the normal and the wanted direction, rad.
        angle_rad: f64,
        /// Largest allowed, rad.
        max_rad: f64,
    },
    /// Nothing is left of it that is surely there.
    #[error("nothing is left of it but for what its edges may be off")]
    Empty,
    /// The face is too narrow.
    #[error("no circle with a radius of {min_m:.3} m fits in it")]
    TooNarrow {
        /// Smallest allowed radius, m.
        min_m: f64,
    },
    /// The face is too small.
    #[error("its area is {area_m2:.4} m², less than {min_m2:.4}")]
    TooSmall {
        /// Its area, m².
        area_m2: f64,
        /// Smallest allowed, m².
        min_m2: f64,
    },
}

impl Filter {
    /// Faces to walk on: tilted by at most `tilt_max_rad` from the horizontal.
    pub fn walkable(tilt_max_rad: f64) -> Self {
        Self {
            tilt_max_rad: Some(tilt_max_rad),
            ..Self::default()
        }
    }

    /// Whether a face serves, of which the part counts that is surely there with `k_sigma` standard
    /// deviations ([`Face::inset_region`]). `ground_m` are the lowest and the highest place of the ground
    /// for feet, in W ([`super::Config::ground_m`]).
    ///
    /// # Errors
    /// The first [`Rejection`] in the order of the fields: this is an answer, not a failure.
    pub fn serves(&self, face: &Face, k_sigma: f64, ground_m: [f64; 2]) -> Result<(), Rejection> {
        self.check_normal(&face.normal_W())?;
        self.check_height(&face.vertices_W(), ground_m)?;
        self.check_size(face, k_sigma)
    }

    fn check_normal(&self, normal: &Vector3<f64>) -> Result<(), Rejection> {
        let tilt_rad = normal.angle(&Vector3::z());
        let min_rad = self.tilt_min_rad.unwrap_or(0.0);
        let max_rad = self.tilt_max_rad.unwrap_or(std::f64::consts::PI);
        if !(min_rad..=max_rad).contains(&tilt_rad) {
            return Err(Rejection::Tilt {
                tilt_rad,
                min_rad,
                max_rad,
            });
        }
        if let Some(facing) = self.facing_W {
            let angle_rad = normal.angle(&Vector3::from(facing));
            let max_rad = self.facing_max_rad.unwrap_or(std::f64::consts::FRAC_PI_2);
            if angle_rad > max_rad {
                return Err(Rejection::Facing { angle_rad, max_rad });
            }
        }
        Ok(())
    }

    fn check_height(
        &self,
        vertices_W: &[Point3<f64>],
        ground_m: [f64; 2],
    ) -> Result<(), Rejection> {
        let [lowest, highest] = heights_m(vertices_W);
        let over = |least: Option<f64>, ground: f64| least.map(|over_m| ground + over_m);
        let least = [self.height_min_m, over(self.over_ground_min_m, ground_m[0])];
        let most = [self.height_max_m, over(self.over_ground_max_m, ground_m[1])];
        let least = least.into_iter().flatten().reduce(f64::max);
        let most = most.into_iter().flatten().reduce(f64::min);
        match (least, most) {
            (Some(min_m), _) if highest < min_m => Err(Rejection::TooLow {
                height_m: highest,
                min_m,
            }),
            (_, Some(max_m)) if lowest > max_m => Err(Rejection::TooHigh {
                height_m: lowest,
                max_m,
            }),
            _ => Ok(()),
        }
    }

    fn check_size(&self, face: &Face, k_sigma: f64) -> Result<(), Rejection> {
        let left = face.inset_region(k_sigma, 0.0);
        if left.is_empty() {
            return Err(Rejection::Empty);
        }
        let narrow = |radius_m: &f64| face.inset_region(k_sigma, *radius_m).is_empty();
        if let Some(min_m) = self.radius_min_m.filter(narrow) {
            return Err(Rejection::TooNarrow { min_m });
        }
        let area_m2 = left.area();
        match self.area_min_m2 {
            Some(min_m2) if area_m2 < min_m2 => Err(Rejection::TooSmall { area_m2, min_m2 }),
            _ => Ok(()),
        }
    }
}

/// The lowest and the highest of places, m.
pub(super) fn heights_m(vertices_W: &[Point3<f64>]) -> [f64; 2] {
    let heights = || vertices_W.iter().map(|p| p.z);
    let lowest = heights().fold(f64::INFINITY, f64::min);
    [lowest, heights().fold(f64::NEG_INFINITY, f64::max)]
}

impl Filter {
    /// What is set here, and for the rest what is set in `other`.
    pub(super) fn or(self, other: Self) -> Self {
        Self {
            tilt_min_rad: self.tilt_min_rad.or(other.tilt_min_rad),
            tilt_max_rad: self.tilt_max_rad.or(other.tilt_max_rad),
            // Who says heights in W means these alone.
            over_ground_min_m: (self.over_ground_min_m).or(other
                .over_ground_min_m
                .filter(|_| self.height_min_m.is_none())),
            over_ground_max_m: (self.over_ground_max_m).or(other
                .over_ground_max_m
                .filter(|_| self.height_max_m.is_none())),
            height_min_m: self.height_min_m.or(other.height_min_m),
            height_max_m: self.height_max_m.or(other.height_max_m),
            facing_W: self.facing_W.or(other.facing_W),
            facing_max_rad: self.facing_max_rad.or(other.facing_max_rad),
            radius_min_m: self.radius_min_m.or(other.radius_min_m),
            area_min_m2: self.area_min_m2.or(other.area_min_m2),
        }
    }
}
