//! Contact sets of which nothing is known but that they are plausible.

use nalgebra::{Isometry3, Translation3};

use super::Maker;
use super::draw::Draws;
use super::forces::{self, Pyramid};
use super::limbs::{Limb, Wanted};
use super::place::Under;
use super::record::ProblemRecord;

/// How far contacts are moved away from the configuration they come from, m.
const MOVED_M: f64 = 0.03;
/// How far they are turned, rad.
const TURNED: f64 = 0.05;
/// Largest tilt of the base of that configuration, rad.
const BASE_TILT: f64 = 0.35;

impl Maker<'_> {
    /// The contacts of a configuration that is within the joint limits and clear of itself, moved
    /// a little, if friction can carry a weight somewhere.
    pub fn plausible(
        &self,
        limbs: &[&Limb],
        range: [f64; 2],
        fits: &dyn Fn(&Limb, &Isometry3<f64>) -> bool,
        under: Under,
        mu: f64,
        draws: &mut Draws,
    ) -> Option<ProblemRecord> {
        let wanted = Wanted {
            limbs: limbs.to_vec(),
            range,
            base_tilt: BASE_TILT,
            fits,
        };
        let mut q = self.configuration(&wanted, draws)?;
        if !self.is_clear_of_itself(&q, 0.0) {
            return None;
        }
        self.set_down(&mut q, limbs, draws);
        let mut touches = self.touches(&q, limbs, under, draws);
        for touch in &mut touches {
            touch.X_WS = moved(&touch.X_WS, draws);
        }
        let supports = self.supports(&touches, 0.0);
        (forces::carry_somewhere(&supports, mu, Pyramid::Inscribed) == Some(true))
            .then(|| self.fixed(&touches, mu))
    }
}

fn moved(X_WS: &Isometry3<f64>, draws: &mut Draws) -> Isometry3<f64> {
    let p = X_WS.translation.vector + draws.in_ball(MOVED_M);
    Isometry3::from_parts(Translation3::from(p), draws.turn(TURNED) * X_WS.rotation)
}
