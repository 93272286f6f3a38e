//! The angle about the vertical between the levelled frame R and the world W, from poles.

use nalgebra::{Matrix2, Matrix3, Rotation2, Vector2, Vector3};

use super::LidarExtrinsicsConfig;
use super::poles::Pole;
use crate::Error;

/// The drift angle and what it rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Drift {
    /// φ: R's x axis in W, rad.
    pub angle_rad: f64,
    /// Its standard deviation, rad.
    pub sigma_rad: f64,
    /// Origin of R in W, x and y, m; zero where it is taken to be W's.
    pub offset_m: [f64; 2],
    /// Which pole is which.
    pub matches: Vec<PoleMatch>,
}

/// A pole that was found and the one that was given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoleMatch {
    /// Index among those found.
    pub found: usize,
    /// Index among those given.
    pub given: usize,
    /// Distance between the two after the fit, m.
    pub residual_m: f64,
}

/// Pairs of a found and a given pole.
type Pairs = Vec<(usize, usize)>;

/// A pole that is found and one that is given are the same up to this, m.
const MATCH_M: f64 = 0.15;
/// Standard deviation of a pole's place along the ray, m.
const RADIAL_SIGMA_M: f64 = 0.010;
/// Standard deviation of a pole's place across the ray, m.
const TANGENTIAL_SIGMA_M: f64 = 0.003;
/// Steps of the fit; it is nearly linear.
const STEPS: usize = 5;
/// Standard deviation of an offset that is taken to be zero, m.
const FIXED_M: f64 = 1e-6;
/// Standard deviation of an offset of which nothing is known, m.
const FREE_M: f64 = 1e3;

/// The drift angle from poles found in R and given in W.
///
///   φ₀ = atan2(Σ p̃ × P̃, Σ p̃ · P̃) over centred positions, then
///   min Σ ‖ R(φ) p + t − P ‖²_Σ,  Σ = R(φ) (σ_r² û ûᵀ + σ_t² v̂ v̂ᵀ) R(φ)ᵀ,  t ~ N(0, s²)
///
/// Which pole is which is found by trying every pair. Two poles alone can be exchanged; of solutions
/// that explain as many poles equally well the one with the smallest angle is taken.
///
/// # Errors
/// [`Error::Lidar`] when fewer than two are given, or fewer than two of them are found.
/// Source: \[meng\] Eqs. 4 and 5; deviation: the signed angle, and the poles' own uncertainty.
pub fn drift(
    found: &[Pole],
    given: &[[f64; 2]],
    config: &LidarExtrinsicsConfig,
) -> Result<Drift, Error> {
    let fail = |cause: String| Err(Error::Lidar { cause });
    if given.len() < 2 {
        return fail(format!(
            "{} pole is given; the heading needs two",
            given.len()
        ));
    }
    if let Some(pole) = given.iter().find(|p| p.iter().any(|c| !c.is_finite())) {
        return fail(format!("the pole {pole:?} is not finite"));
    }
    let given: Vec<Vector2<f64>> = given.iter().map(|p| Vector2::from(*p)).collect();
    let places: Vec<Vector2<f64>> = found.iter().map(|p| p.p_R).collect();
    // Residual, pairs, angle of the best so far.
    let mut best: Option<(f64, Pairs, f64)> = None;
    for (a, b) in pairs(places.len()) {
        for (i, j) in pairs(given.len()) {
            let (apart, wanted) = ((places[b] - places[a]).norm(), (given[j] - given[i]).norm());
            if (apart - wanted).abs() > 2.0 * MATCH_M || wanted < MATCH_M {
                continue;
            }
            let Some((phi, t)) = closed_form(&places, &given, &[(a, i), (b, j)]) else {
                continue;
            };
            if config.origin_below_sensor && t.norm() > 2.0 * MATCH_M {
                continue;
            }
            let t = if config.origin_below_sensor {
                Vector2::zeros()
            } else {
                t
            };
            let matches = matched(&places, &given, phi, &t);
            let cost: f64 = matches
                .iter()
                .map(|&(f, g)| (Rotation2::new(phi) * places[f] + t - given[g]).norm_squared())
                .sum();
            // More poles; then a clearly smaller residual; then the smaller angle.
            let better = best.as_ref().is_none_or(|(least, pairs, angle)| {
                let alike = (cost - least).abs() < MATCH_M.powi(2) / 4.0;
                matches.len() > pairs.len()
                    || matches.len() == pairs.len()
                        && (if alike {
                            phi.abs() < angle.abs()
                        } else {
                            cost < *least
                        })
            });
            if matches.len() >= 2 && better {
                best = Some((cost, matches, phi));
            }
        }
    }
    let Some((_, matches, _)) = best else {
        return fail(format!(
            "none of the {} poles found stand as the {} given ones do (to {} m)",
            places.len(),
            given.len(),
            MATCH_M
        ));
    };
    refined(&places, &given, &matches, config).ok_or_else(|| Error::Lidar {
        cause: "the poles lie in one place".to_owned(),
    })
}

/// All ordered pairs of different numbers below `n`.
fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |a| (0..n).filter(move |b| *b != a).map(move |b| (a, b)))
}

/// Rotation and translation by the centred positions.
fn closed_form(
    places: &[Vector2<f64>],
    given: &[Vector2<f64>],
    matches: &[(usize, usize)],
) -> Option<(f64, Vector2<f64>)> {
    let n = matches.len() as f64;
    let mean_p = matches.iter().map(|m| places[m.0]).sum::<Vector2<f64>>() / n;
    let mean_w = matches.iter().map(|m| given[m.1]).sum::<Vector2<f64>>() / n;
    let (mut cross, mut dot) = (0.0, 0.0);
    for (f, g) in matches {
        let (p, w) = (places[*f] - mean_p, given[*g] - mean_w);
        cross += p.perp(&w);
        dot += p.dot(&w);
    }
    if cross.hypot(dot) < 1e-12 {
        return None;
    }
    let phi = cross.atan2(dot);
    Some((phi, mean_w - Rotation2::new(phi) * mean_p))
}

/// For every given pole the nearest found one within reach.
fn matched(places: &[Vector2<f64>], given: &[Vector2<f64>], phi: f64, t: &Vector2<f64>) -> Pairs {
    let turn = Rotation2::new(phi);
    given
        .iter()
        .enumerate()
        .filter_map(|(g, w)| {
            places
                .iter()
                .enumerate()
                .map(|(f, p)| (f, (turn * p + t - w).norm()))
                .filter(|(_, d)| *d <= MATCH_M)
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .map(|(f, _)| (f, g))
        })
        .collect()
}

/// The weighted fit of φ and t.
fn refined(
    places: &[Vector2<f64>],
    given: &[Vector2<f64>],
    matches: &[(usize, usize)],
    config: &LidarExtrinsicsConfig,
) -> Option<Drift> {
    let (mut phi, mut t) = closed_form(places, given, matches)?;
    let (mut offset_sigma, mut unknowns) = (FREE_M, 3.0);
    if config.origin_below_sensor {
        (offset_sigma, unknowns, t) = (FIXED_M, 1.0, Vector2::zeros());
    }
    let mut information = Matrix3::zeros();
    let mut chi_squared = 0.0;
    for _ in 0..STEPS {
        information = Matrix3::zeros();
        let mut right = Vector3::zeros();
        chi_squared = 0.0;
        let turn = Rotation2::new(phi);
        for &(f, g) in matches {
            let p_W = turn * places[f];
            let residual = p_W + t - given[g];
            let u = p_W.try_normalize(1e-9)?;
            let v = Vector2::new(-u.y, u.x);
            let weight: Matrix2<f64> = u * u.transpose() / RADIAL_SIGMA_M.powi(2)
                + v * v.transpose() / TANGENTIAL_SIGMA_M.powi(2);
            // d(R p)/dφ = the vector turned by a right angle.
            let by_phi = Vector2::new(-p_W.y, p_W.x);
            let jacobian = nalgebra::Matrix2x3::from_columns(&[by_phi, Vector2::x(), Vector2::y()]);
            information += jacobian.transpose() * weight * jacobian;
            right -= jacobian.transpose() * weight * residual;
            chi_squared += (residual.transpose() * weight * residual)[(0, 0)];
        }
        for i in 0..2 {
            let prior = 1.0 / offset_sigma.powi(2);
            information[(1 + i, 1 + i)] += prior;
            right[1 + i] -= prior * t[i];
        }
        let step = information.cholesky()?.solve(&right);
        phi += step[0];
        t += Vector2::new(step[1], step[2]);
    }
    let degrees = (2.0 * matches.len() as f64 - unknowns).max(1.0);
    let variance = information.cholesky()?.inverse()[(0, 0)] * (chi_squared / degrees).max(1.0);
    let turn = Rotation2::new(phi);
    Some(Drift {
        angle_rad: phi,
        sigma_rad: variance.sqrt(),
        offset_m: if config.origin_below_sensor {
            [0.0; 2]
        } else {
            t.into()
        },
        matches: matches
            .iter()
            .map(|&(found, given_index)| PoleMatch {
                found,
                given: given_index,
                residual_m: (turn * places[found] + t - given[given_index]).norm(),
            })
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pole(p: Vector2<f64>) -> Pole {
        Pole {
            p_R: p,
            points: 100,
            height_m: 1.0,
        }
    }

    const GIVEN: [[f64; 2]; 3] = [[2.6, 1.6], [3.4, -1.9], [1.5, 2.4]];

    proptest! {
        #[test]
        fn the_sign_and_size_of_the_drift_come_out(phi in -1.2f64..1.2, x in -0.5f64..0.5, free in any::<bool>()) {
            let config = LidarExtrinsicsConfig { origin_below_sensor: !free, ..LidarExtrinsicsConfig::default() };
            let t = if free { Vector2::new(x, -x / 2.0) } else { Vector2::zeros() };
            let back = Rotation2::new(-phi);
            // Another thing stands there too, and the order is another one.
            let mut found: Vec<Pole> = GIVEN.iter().rev().map(|g| pole(back * (Vector2::from(*g) - t))).collect();
            found.insert(1, pole(Vector2::new(0.9, 0.7)));
            let drift = drift(&found, &GIVEN, &config).unwrap();
            prop_assert!((drift.angle_rad - phi).abs() < 1e-6, "{} {}", drift.angle_rad, phi);
            prop_assert_eq!(drift.matches.len(), 3);
            prop_assert!((Vector2::from(drift.offset_m) - t).norm() < 1e-5);
        }
    }

    #[test]
    fn too_few_or_unlike_poles_are_refused() {
        let config = LidarExtrinsicsConfig::default();
        let found = [pole(Vector2::new(2.0, 0.0)), pole(Vector2::new(0.0, 2.0))];
        for given in [&GIVEN[..1], &[[5.0, 5.0], [9.0, -3.0]][..]] {
            assert!(drift(&found, given, &config).is_err());
        }
        assert!(drift(&[], &GIVEN, &config).is_err());
        assert!(drift(&found, &[[f64::NAN, 0.0], [1.0, 1.0]], &config).is_err());
    }
}
