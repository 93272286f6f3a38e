//! What a role asks of a surface, and the reason when a surface does not serve.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::Surface;

/// What a surface must be like to serve a role; what is not set is not asked for.
#[allow(non_snake_case)]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Filter {
    /// Smallest tilt from the horizontal, rad.
    pub tilt_min_rad: Option<f64>,
    /// Largest tilt from the horizontal, rad: for a foot the steepest slope to walk on.
    pub tilt_max_rad: Option<f64>,
    /// The highest point of the surface must not be lower than this, m in W.
    pub height_min_m: Option<f64>,
    /// The lowest point of the surface must not be higher than this, m in W.
    pub height_max_m: Option<f64>,
    /// Direction in W to which the normal should point; need not be a unit vector.
    pub facing_W: Option<[f64; 3]>,
    /// Largest angle between the normal and `facing_W`, rad; π/2 where it is not set.
    pub facing_max_rad: Option<f64>,
    /// Smallest radius of the inscribed circle of the effective polygon, m.
    pub radius_min_m: Option<f64>,
    /// Smallest area of the effective polygon, m².
    pub area_min_m2: Option<f64>,
}

/// Why a surface does not serve a role.
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
    /// The surface is too low.
    #[error("its highest point is at {height_m:.3} m, below {min_m:.3} m")]
    TooLow {
        /// Height of its highest point, m.
        height_m: f64,
        /// Smallest allowed, m.
        min_m: f64,
    },
    /// The surface is too high.
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
    /// Nothing is left of the polygon after the inset.
    #[error("nothing is left of it after an inset of {inset_m} m")]
    Empty {
        /// The inset, m.
        inset_m: f64,
    },
    /// The surface is too narrow.
    #[error("its largest inscribed circle has a radius of {radius_m:.3} m, less than {min_m:.3}")]
    TooNarrow {
        /// Radius of the largest inscribed circle, m.
        radius_m: f64,
        /// Smallest allowed, m.
        min_m: f64,
    },
    /// The surface is too small.
    #[error("its area is {area_m2:.4} m², less than {min_m2:.4}")]
    TooSmall {
        /// Its area, m².
        area_m2: f64,
        /// Smallest allowed, m².
        min_m2: f64,
    },
}

impl Filter {
    /// Surfaces to walk on: tilted by at most `tilt_max_rad` from the horizontal.
    pub fn walkable(tilt_max_rad: f64) -> Self {
        Self {
            tilt_max_rad: Some(tilt_max_rad),
            ..Self::default()
        }
    }

    /// Whether a surface serves.
    ///
    /// # Errors
    /// The first [`Rejection`] in the order of the fields: this is an answer, not a failure.
    #[allow(non_snake_case)]
    pub fn accepts(&self, surface: &Surface) -> Result<(), Rejection> {
        let normal = surface.normal_W();
        self.check_normal(&normal)?;
        self.check_height(surface)?;
        self.check_size(surface)
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

    fn check_height(&self, surface: &Surface) -> Result<(), Rejection> {
        let heights: Vec<f64> = surface.vertices_W().iter().map(|p| p.z).collect();
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
        match (self.height_min_m, self.height_max_m) {
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

    fn check_size(&self, surface: &Surface) -> Result<(), Rejection> {
        let inset_m = surface.inset_m;
        let Some(polygon) = surface.effective_polygon() else {
            return Err(Rejection::Empty { inset_m });
        };
        if let Some(min_m) = self.radius_min_m {
            let (_, radius_m) = polygon.inscribed_circle();
            if radius_m < min_m {
                return Err(Rejection::TooNarrow { radius_m, min_m });
            }
        }
        if let Some(min_m2) = self.area_min_m2 {
            let area_m2 = polygon.area();
            if area_m2 < min_m2 {
                return Err(Rejection::TooSmall { area_m2, min_m2 });
            }
        }
        Ok(())
    }
}

impl Filter {
    /// What is set here, and for the rest what is set in `other`.
    pub(super) fn or(self, other: Self) -> Self {
        Self {
            tilt_min_rad: self.tilt_min_rad.or(other.tilt_min_rad),
            tilt_max_rad: self.tilt_max_rad.or(other.tilt_max_rad),
            height_min_m: self.height_min_m.or(other.height_min_m),
            height_max_m: self.height_max_m.or(other.height_max_m),
            facing_W: self.facing_W.or(other.facing_W),
            facing_max_rad: self.facing_max_rad.or(other.facing_max_rad),
            radius_min_m: self.radius_min_m.or(other.radius_min_m),
            area_min_m2: self.area_min_m2.or(other.area_min_m2),
        }
    }
}
