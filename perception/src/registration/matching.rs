//! Which planes of a scan are which known ones.

use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};
use surfaces::outline::Outline;
use surfaces::{Face, covariance};

/// Planes match that lean against each other by no more than this, rad.
const TILT_MAX_RAD: f64 = 0.1;
/// Planes match that are no farther apart than this, m.
const OFFSET_MAX_M: f64 = 0.1;

/// Two faces of one plane, in a frame C on the known one, in the middle of what they share.
pub(super) struct Pair {
    /// Index among the known faces.
    pub known: usize,
    /// Index among the scanned ones.
    pub scanned: usize,
    pub X_WC: Isometry3<f64>,
    /// Pose of the scanned face, as far as it is known by now.
    pub X_WF: Isometry3<f64>,
    /// Covariance of the scanned plane in its own frame.
    pub own: Matrix3<f64>,
    /// Covariance of the known plane in C.
    pub known_C: Matrix3<f64>,
}

impl Pair {
    /// The scanned plane in C after a motion: (θ_x, θ_y, z), and the covariance of the difference.
    pub fn difference(&self, moved: &Isometry3<f64>) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let X_CF = self.X_WC.inverse() * moved * self.X_WF;
        let (d, sigma) = covariance::plane_in(&X_CF, &self.own)?;
        Some((d, sigma + self.known_C))
    }
}

/// Pairs of faces that may be one plane: they look the same way, lie over each other and near each
/// other. To each face of the scan belongs the known one that it shares most with.
pub(super) fn pairs(
    known: &[Face],
    scanned: &[Face],
    moved: &Isometry3<f64>,
    gate: Option<f64>,
) -> Vec<Pair> {
    let fits = |pair: &Pair| {
        gate.is_none_or(|sigmas| {
            let agreed = pair.difference(&Isometry3::identity());
            agreed.is_some_and(|(d, s)| {
                let inverse = s.try_inverse();
                inverse.is_some_and(|w| d.dot(&(w * d)) <= sigmas * sigmas)
            })
        })
    };
    let of_face = |(scanned, face): (usize, &Face)| {
        let X_WF = moved * face.X_WF;
        let found = known.iter().enumerate().filter_map(|(known, other)| {
            let (shared_m2, pair) = matched(other, face, X_WF)?;
            let pair = Pair {
                known,
                scanned,
                ..pair
            };
            fits(&pair).then_some((shared_m2, pair))
        });
        found.reduce(|a, b| if b.0 > a.0 { b } else { a })
    };
    let best = scanned.iter().enumerate().filter_map(of_face);
    best.map(|(_, pair)| pair).collect()
}

/// The area that a known face shares with one at `X_WF` and their pair, if they may be one plane.
fn matched(known: &Face, face: &Face, X_WF: Isometry3<f64>) -> Option<(f64, Pair)> {
    if known.normal_W().dot(&(X_WF.rotation * Vector3::z())) < TILT_MAX_RAD.cos() {
        return None;
    }
    let matrix = |face: &Face| {
        let rows = face.plane_covariance?;
        Some(Matrix3::from_fn(|i, j| rows[i][j]))
    };
    let (sigma, own) = (matrix(known)?, matrix(face)?);
    let X_KF = known.X_WF.inverse() * X_WF;
    let common = Outline::from(&known.region).common(&Outline::from(&face.region).moved(&X_KF));
    let c = common.middle()?;
    let X_KC = Translation3::new(c.x, c.y, 0.0);
    let X_WC = known.X_WF * X_KC;
    let (d, _) = covariance::plane_in(&(X_WC.inverse() * X_WF), &own)?;
    if d.z.abs() > OFFSET_MAX_M {
        return None;
    }
    let (_, known_C) = covariance::plane_in(&X_KC.inverse().into(), &sigma)?;
    let pair = Pair {
        known: 0,
        scanned: 0,
        X_WC,
        X_WF,
        own,
        known_C,
    };
    Some((common.area(), pair))
}
