//! What a robust run changes, drawn from a seed.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::config::Spread;
use crate::physics::Scales;
use crate::used_faces::Used;
use crate::world::WorldBody;

/// Duration of a push, s.
const PUSH_S: f64 = 0.2;
/// Largest turn of a body of the world about each axis: what a plane from a scan is off, rad.
const TURN_RAD: f64 = 0.0175;
/// Distance of a sole's rim from its middle: a body turns about what stands on it, m.
const SOLE_M: f64 = 0.1;

/// A push on the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Push {
    /// When it begins, s.
    pub t_s: f64,
    /// How long it lasts, s.
    pub duration_s: f64,
    /// Force in W, N.
    pub force_W: [f64; 3],
}

/// How a body of the world is displaced: turned about a point, then shifted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Displacement {
    /// Shift in W, m.
    pub shift_W: [f64; 3],
    /// Rotation vector in W, rad.
    pub turn_W: [f64; 3],
    /// The point, in W, m.
    pub about_W: [f64; 3],
}

impl Displacement {
    /// The motion in W.
    pub fn motion_W(&self) -> Isometry3<f64> {
        let about = Translation3::from(self.about_W);
        let turned = UnitQuaternion::new(self.turn_W.into());
        Translation3::from(self.shift_W) * about * turned * about.inverse()
    }
}

/// How one run differs from what was planned.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Perturbation {
    /// Factor of the coefficients of friction.
    pub friction_factor: Option<f64>,
    /// Factor of all masses and inertias.
    pub mass_factor: Option<f64>,
    /// Displacement of each body of the world; none where empty.
    pub moved: Vec<Displacement>,
    /// Pushes on the base.
    pub pushes: Vec<Push>,
    /// Seed of the noise of what the controller is told; exact and at once without one.
    #[serde(default)]
    pub sensing: Option<u64>,
}

/// What a run may be disturbed in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Kinds {
    /// Less friction.
    pub friction: bool,
    /// Another mass.
    pub mass: bool,
    /// Bodies of the world elsewhere.
    pub surfaces: bool,
    /// Pushes.
    pub pushes: bool,
    /// Noise and delay of what the controller is told.
    pub sensing: bool,
}

impl Kinds {
    /// Everything.
    pub const ALL: Self = Self {
        friction: true,
        mass: true,
        surfaces: true,
        pushes: true,
        sensing: true,
    };
}

impl Perturbation {
    /// Run `run` of the seed's runs.
    ///
    /// `used` tells of each body of the world how contacts use the thing that it is a part of, `None` for one that
    /// stays where it is. A thing is displaced along all axes, and turned about its contacts as far as none of
    /// them is displaced farther by that.
    pub fn draw(
        seed: u64,
        run: u64,
        spread: &Spread,
        kinds: Kinds,
        used: &[Option<Used>],
        duration_s: f64,
    ) -> Self {
        let draw = |what: u64, index: u64| symmetric(seed, run, what, index);
        let three = |what: u64, k: u64| Vector3::from([0, 1, 2].map(|axis| draw(what + axis, k)));
        let displacement = |used: &Option<Used>| {
            used.map_or_else(Displacement::default, |used| {
                let k = used.first as u64;
                let turn = TURN_RAD.min(spread.surface_m / used.reach_m.max(SOLE_M));
                Displacement {
                    shift_W: (three(4, k) * spread.surface_m).into(),
                    turn_W: (three(7, k) * turn).into(),
                    about_W: used.centre_W.into(),
                }
            })
        };
        let moved = if kinds.surfaces { used } else { &[] };
        // As many as come nearest, each in its part of the motion: what comes after is neither executed nor settled.
        let count = match kinds.pushes && spread.push_every_s > 0.0 {
            true => (duration_s / spread.push_every_s).round().max(1.0),
            false => 0.0,
        };
        let push = |k: u64| {
            let within = (draw(2, k) + 1.0) / 2.0;
            let (sin, cos) = (draw(3, k) * std::f64::consts::PI).sin_cos();
            Push {
                t_s: (k as f64 + within) / count * duration_s,
                duration_s: PUSH_S,
                force_W: [spread.push_n * cos, spread.push_n * sin, 0.0],
            }
        };
        Self {
            friction_factor: kinds.friction.then_some(spread.friction_factor),
            mass_factor: kinds.mass.then(|| 1.0 + spread.mass * draw(0, 0)),
            moved: moved.iter().map(displacement).collect(),
            pushes: (0..count as u64).map(push).collect(),
            sensing: kinds
                .sensing
                .then(|| mix(mix(seed).wrapping_add(run)) >> 12),
        }
    }

    /// The scales of the simulated robot.
    pub fn scales(&self) -> Scales {
        Scales {
            mass: self.mass_factor.unwrap_or(1.0),
            friction: self.friction_factor.unwrap_or(1.0),
        }
    }

    /// The world with its bodies displaced.
    pub fn applied(&self, world: &[WorldBody]) -> Vec<WorldBody> {
        let mut world = world.to_vec();
        for (body, moved) in world.iter_mut().zip(&self.moved) {
            body.transform(&moved.motion_W());
        }
        world
    }

    /// The force on the base at a time, N.
    pub fn force_W(&self, t_s: f64) -> Vector3<f64> {
        let lasts = |push: &&Push| t_s >= push.t_s && t_s < push.t_s + push.duration_s;
        let now = self.pushes.iter().filter(lasts);
        now.map(|push| Vector3::from(push.force_W)).sum()
    }
}

/// A number in [−1, 1) that depends on its place alone (SplitMix64 of a counter).
pub(crate) fn symmetric(seed: u64, run: u64, what: u64, index: u64) -> f64 {
    let mut x = mix(seed);
    for part in [run, what, index] {
        x = mix(x.wrapping_add(0x9E37_79B9_7F4A_7C15).wrapping_add(part));
    }
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn draws_are_spread_and_repeat() {
        let all: Vec<f64> = (0..2000).map(|k| symmetric(7, 3, 1, k)).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        assert!(all.iter().all(|x| (-1.0..1.0).contains(x)));
        // Standard error of the mean of 2000 uniform numbers: 0.013.
        assert!(mean.abs() < 0.05, "{mean}");
        assert!(all.iter().any(|x| *x > 0.95) && all.iter().any(|x| *x < -0.95));
        assert_eq!(symmetric(7, 3, 1, 5), all[5]);
        assert_ne!(symmetric(8, 3, 1, 5), all[5]);
        // The runs of one seed are not those of another.
        assert_ne!(symmetric(8, 2, 1, 5), all[5]);
    }

    #[test]
    fn a_run_changes_what_it_says() {
        let used = |first, reach_m| {
            let centre_W = Vector3::x();
            Some(Used {
                first,
                centre_W,
                reach_m,
            })
        };
        let used = [None, used(1, 0.1), used(2, 2.0)];
        let spread = Spread::default();
        let drawn = Perturbation::draw(1, 0, &spread, Kinds::ALL, &used, 25.0);
        assert_eq!(drawn.scales().friction, 0.75);
        assert!((drawn.scales().mass - 1.0).abs() <= 0.05 && drawn.scales().mass != 1.0);
        assert_eq!(drawn.moved[0], Displacement::default());
        for (moved, turn) in drawn.moved[1..].iter().zip([TURN_RAD, 0.005]) {
            let inside =
                |values: [f64; 3], most| values.iter().all(|x| x.abs() <= most && *x != 0.0);
            assert!(
                inside(moved.shift_W, 0.01) && inside(moved.turn_W, turn),
                "{moved:?}"
            );
            let there = moved.motion_W() * Point3::new(1.0, 0.0, 0.0);
            assert!((there.coords - Vector3::x() - Vector3::from(moved.shift_W)).norm() < 1e-12);
        }
        assert_eq!(drawn.pushes.len(), 3);
        for (k, push) in drawn.pushes.iter().enumerate() {
            let part_s = 25.0 / 3.0;
            assert!(push.t_s >= part_s * k as f64 && push.t_s < part_s * (k + 1) as f64);
            let force = drawn.force_W(push.t_s + 0.1);
            assert!((force.norm() - 60.0).abs() < 1e-9);
            assert_eq!(drawn.force_W(push.t_s + 0.2), Vector3::zeros());
        }
        let plain = Perturbation::draw(1, 0, &spread, Kinds::default(), &used, 25.0);
        assert_eq!(plain, Perturbation::default());
    }
}
