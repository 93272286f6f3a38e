//! What a set of poses can tell of the mount.

use std::fmt;

use nalgebra::{DMatrix, Isometry3, Matrix3, Vector3};

use super::{PaperParameters, PlanePair};

/// Tilts that are nearer to each other than this share of the wanted spread are one.
const SAME_TILT: f64 = 0.5;
/// Cosine of the angle within which an axis is called x or y of R: 10°.
const ALONG_AXIS: f64 = 0.984_807_753;

/// Why a set of poses does not determine the mount.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Degeneracy {
    /// All poses have one tilt.
    ConstantTilt,
    /// Fewer than three different tilts.
    FewTilts {
        /// How many there are.
        found: usize,
    },
    /// The body only pitches: the place of the sensor along y_R moves nothing.
    PitchOnly,
    /// The body only rolls: the place of the sensor along x_R moves nothing.
    RollOnly,
    /// The body turns about one level axis only.
    OneAxis {
        /// Direction of that axis from x_R toward y_R, rad.
        heading_rad: f64,
    },
}

impl fmt::Display for Degeneracy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ConstantTilt => write!(
                f,
                "constant tilt: all poses have the same tilt, so the turn about the ground's normal \
                 and two parts of the position move nothing; roll and pitch the body"
            ),
            Self::FewTilts { found } => write!(
                f,
                "{found} different tilts: at least 3 are needed, not all about one axis; roll and \
                 pitch the body"
            ),
            Self::PitchOnly => write!(
                f,
                "pitch only: the position along the robot's y (left; the paper's p_z) moves \
                 nothing; add poses that roll"
            ),
            Self::RollOnly => write!(
                f,
                "roll only: the position along the robot's x (forward; the paper's p_x) moves \
                 nothing; add poses that pitch"
            ),
            Self::OneAxis { heading_rad } => write!(
                f,
                "tilts about one axis only, {:.0}° from the robot's x: the position along that \
                 axis moves nothing; add poses that tilt about another",
                heading_rad.to_degrees()
            ),
        }
    }
}

/// Rank and condition of the identification for a set of poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Observability {
    /// Different tilts.
    pub tilts: usize,
    /// Root mean square by which the normals vary along their second and third direction, rad.
    pub spread_rad: [f64; 2],
    /// Singular values of ∂(a, b, c, d)/∂(α, β, γ, p), unweighted, largest first; rad, m.
    pub singular_values: [f64; 6],
    /// Those above a thousandth of the largest.
    pub rank: usize,
    /// Largest over smallest.
    pub condition: f64,
    /// Why the poses do not do, if they do not.
    pub degeneracy: Option<Degeneracy>,
}

impl Observability {
    /// What the robot's planes of `pairs` can tell of any mount; `spread_min_rad` is the root mean
    /// square by which tilts must vary in every direction.
    ///
    /// With N the matrix of the normals n_R, one a row, the position is found from N p = d − h and
    /// the rotation from the directions alone: both need normals that span space, N's three
    /// singular values well above zero.
    pub fn of(pairs: &[PlanePair], spread_min_rad: f64) -> Self {
        let normals: Vec<Vector3<f64>> = pairs.iter().map(|pair| *pair.robot.normal).collect();
        let tilts = different(&normals, SAME_TILT * spread_min_rad);
        let count = normals.len().max(1) as f64;
        let scatter: Matrix3<f64> = normals.iter().map(|n| n * n.transpose() / count).sum();
        let eigen = scatter.symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let spread_rad = [1, 2].map(|k| eigen.eigenvalues[order[k]].max(0.0).sqrt());
        let lost = eigen.eigenvectors.column(order[2]).into_owned();
        let degeneracy = if spread_rad[0] < spread_min_rad || tilts < 2 {
            Some(Degeneracy::ConstantTilt)
        } else if tilts < 3 {
            Some(Degeneracy::FewTilts { found: tilts })
        } else if spread_rad[1] < spread_min_rad {
            Some(about_one_axis(&lost))
        } else {
            None
        };
        Self {
            tilts,
            spread_rad,
            singular_values: [0.0; 6],
            rank: 0,
            condition: f64::INFINITY,
            degeneracy,
        }
    }

    /// The same with rank and condition at a mount.
    ///
    ///   J = [ R_RVᵀ \[n_R\]×   0 ;   0   n_Rᵀ ] · ∂(δθ, δp)/∂(α, β, γ, p), all poses stacked
    #[must_use]
    pub fn at(mut self, pairs: &[PlanePair], X_RV: &Isometry3<f64>) -> Self {
        let to_step = PaperParameters::of_mount(X_RV).to_step();
        let R_VR = X_RV.rotation.inverse().to_rotation_matrix().into_inner();
        // Four rows a pose; at least six, so that there are six singular values.
        let mut J = DMatrix::zeros((4 * pairs.len()).max(6), 6);
        for (i, pair) in pairs.iter().enumerate() {
            let n_R = pair.robot.normal.into_inner();
            let turn = R_VR * n_R.cross_matrix() * to_step.fixed_view::<3, 3>(0, 0);
            let shift = n_R.transpose() * to_step.fixed_view::<3, 3>(3, 3);
            J.fixed_view_mut::<3, 3>(4 * i, 0).copy_from(&turn);
            J.fixed_view_mut::<1, 3>(4 * i + 3, 3).copy_from(&shift);
        }
        let mut values: Vec<f64> = J.singular_values().iter().copied().collect();
        values.sort_by(|a, b| b.total_cmp(a));
        self.singular_values = [0, 1, 2, 3, 4, 5].map(|k| values[k]);
        let [largest, .., smallest] = self.singular_values;
        self.rank = values.iter().filter(|v| **v > 1e-3 * largest).count();
        self.condition = largest / smallest;
        self
    }
}

/// How many of the directions are farther than `angle_rad` from all that were counted before.
fn different(normals: &[Vector3<f64>], angle_rad: f64) -> usize {
    let mut counted: Vec<&Vector3<f64>> = Vec::new();
    for normal in normals {
        let is_new = |known: &&&Vector3<f64>| normal.cross(known).norm() <= angle_rad;
        if !counted.iter().any(|known| is_new(&known)) {
            counted.push(normal);
        }
    }
    counted.len()
}

/// The name of tilts about one axis, `axis` being the direction that no normal has.
fn about_one_axis(axis: &Vector3<f64>) -> Degeneracy {
    if axis.y.abs() > ALONG_AXIS {
        Degeneracy::PitchOnly
    } else if axis.x.abs() > ALONG_AXIS {
        Degeneracy::RollOnly
    } else {
        // The axis has no sign: turn it to the half plane ahead.
        let sign = if axis.x < 0.0 { -1.0 } else { 1.0 };
        Degeneracy::OneAxis {
            heading_rad: (sign * axis.y).atan2(sign * axis.x),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::residual::tests::{mount, stance};
    use super::*;
    use crate::GroundPlane;
    use crate::camera::{CameraConfig, identify};

    fn pairs(tilts_deg: &[(f64, f64)]) -> Vec<PlanePair> {
        let pair = |(i, (roll, pitch)): (usize, &(f64, f64))| {
            let height = 0.6 + 0.01 * (i % 7) as f64;
            let X_GR = stance(roll.to_radians(), pitch.to_radians(), height);
            let robot = GroundPlane::ground(&X_GR, Matrix3::identity() * 1e-6);
            PlanePair::new(robot, robot.seen_from(&mount()))
        };
        tilts_deg.iter().enumerate().map(pair).collect()
    }

    fn refusal(tilts_deg: &[(f64, f64)]) -> Degeneracy {
        match identify(&pairs(tilts_deg), &CameraConfig::default()) {
            Err(crate::Error::Degenerate(degeneracy)) => degeneracy,
            other => panic!("{tilts_deg:?} gave {other:?}"),
        }
    }

    #[test]
    fn poses_that_do_not_tell_are_refused_by_name() {
        let pitches: Vec<_> = (-4..=4).map(|k| (0.0, 5.0 * f64::from(k))).collect();
        let rolls: Vec<_> = (-4..=4).map(|k| (5.0 * f64::from(k), 0.0)).collect();
        let constant = vec![(7.0, -3.0); 9];
        assert_eq!(refusal(&pitches), Degeneracy::PitchOnly);
        assert_eq!(refusal(&rolls), Degeneracy::RollOnly);
        assert_eq!(refusal(&constant), Degeneracy::ConstantTilt);
        assert_eq!(refusal(&[]), Degeneracy::ConstantTilt);
        let two = [(10.0, 0.0), (0.0, 10.0), (10.0, 0.0), (0.0, 10.0)];
        assert_eq!(refusal(&two), Degeneracy::FewTilts { found: 2 });
        // Small tilts about a slanted axis, to first order: roll and pitch in one ratio.
        let slanted = [-8.0, -6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0, 8.0].map(|k| (k, k));
        let Degeneracy::OneAxis { heading_rad } = refusal(&slanted) else {
            panic!("{:?}", refusal(&slanted));
        };
        let heading = heading_rad.to_degrees();
        assert!((heading - 45.0).abs() < 2.0, "{heading}°");
        for (tilts, name) in [
            (&pitches[..], "pitch only"),
            (&rolls, "roll only"),
            (&constant, "constant tilt"),
            (&two, "2 different tilts"),
        ] {
            let text = refusal(tilts).to_string();
            assert!(text.contains(name), "{name}: {text}");
        }
    }

    #[test]
    fn ranks_are_those_of_the_named_sets() {
        let rank = |tilts: &[(f64, f64)]| {
            let pairs = pairs(tilts);
            Observability::of(&pairs, 0.017).at(&pairs, &mount()).rank
        };
        let pitches: Vec<_> = (-4..=4).map(|k| (0.0, 5.0 * f64::from(k))).collect();
        assert_eq!(rank(&pitches), 5);
        assert_eq!(rank(&[(10.0, 0.0), (0.0, 10.0)]), 5);
        assert_eq!(rank(&[(7.0, -3.0), (7.0, -3.0)]), 3);
        assert_eq!(rank(&[(10.0, 0.0), (0.0, 10.0), (-10.0, -10.0)]), 6);
    }
}
