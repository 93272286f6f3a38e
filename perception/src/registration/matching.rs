//! Which planes of a scan are which known ones.

use nalgebra::{Isometry3, Matrix3, Matrix3x6, Matrix6, Translation3, Vector3, Vector6};
use surfaces::outline::Outline;
use surfaces::{Face, covariance};

use super::pose::Pose;

/// Planes that lean against each other by more than this are not one however little is known, rad.
const TILT_MAX_RAD: f64 = 0.2;
/// Planes that are farther apart than this are not one however little is known, m.
const OFFSET_MAX_M: f64 = 0.3;
/// Planes that disagree by more standard deviations than this are not one.
const GATE_SIGMAS: f64 = 4.5;

/// Two faces of one plane, in a frame C on the known one, in the middle of what they share.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    /// Index among the known faces.
    pub known: usize,
    /// Index among the scanned ones.
    pub scanned: usize,
    /// The area that they share, m².
    shared_m2: f64,
    pub X_WC: Isometry3<f64>,
    /// Pose of the scanned face, as far as it is known by now.
    X_WF: Isometry3<f64>,
    /// Covariance of the scanned plane in its own frame.
    own: Matrix3<f64>,
    /// Covariance of the known plane in C.
    known_C: Matrix3<f64>,
}

impl Pair {
    /// The scanned plane in C after a motion: (θ_x, θ_y, z), and the covariance of the difference.
    pub fn difference(&self, moved: &Isometry3<f64>) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let X_CF = self.X_WC.inverse() * moved * self.X_WF;
        let (d, sigma) = covariance::plane_in(&X_CF, &self.own)?;
        Some((d, sigma + self.known_C))
    }

    /// The two, where they may be one: they look the same way, lie over each other and near each other.
    fn of(known: &Face, face: &Face, X_WF: Isometry3<f64>) -> Option<Self> {
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
        let (_, known_C) = covariance::plane_in(&X_KC.inverse().into(), &sigma)?;
        let pair = Self {
            known: 0,
            scanned: 0,
            shared_m2: common.area(),
            X_WC: known.X_WF * X_KC,
            X_WF,
            own,
            known_C,
        };
        let (d, _) = pair.difference(&Isometry3::identity())?;
        (d.z.abs() <= OFFSET_MAX_M).then_some(pair)
    }
}

/// The pairs that agree on a pose, the most of all: of each face of the scan one at most.
///
/// Of planes that may be one, some are not: a ramp's end over the floor, what was moved in between. Each in
/// turn is believed first and the others after it by the area that they share, each as far as it agrees with
/// those before it and with the pose that was given,
///
///   rᵀ V⁻¹ r ≤ k²,   r = d + J x,   V = S + J P Jᵀ,
///
/// x and P being the pose and its covariance by then (the gate and the step of \[kalman1960\]). What then
/// counts is the sum of these squares, k² for a face that agrees with none.
pub(super) fn pairs(known: &[Face], scanned: &[Face], pose: &Pose) -> Vec<Pair> {
    let mut candidates: Vec<Pair> = Vec::new();
    for (scanned, face) in scanned.iter().enumerate() {
        let X_WF = pose.X_W * face.X_WF;
        let all = known.iter().enumerate();
        candidates.extend(all.filter_map(|(known, other)| {
            let pair = Pair::of(other, face, X_WF)?;
            Some(Pair {
                known,
                scanned,
                ..pair
            })
        }));
    }
    candidates.sort_by(|a, b| b.shared_m2.total_cmp(&a.shared_m2));
    let told: Vec<Told> = (candidates.iter())
        .filter_map(|pair| {
            let (d, S) = pair.difference(&Isometry3::identity())?;
            let J = pose.jacobian(&pair.X_WC);
            Some(Told { pair, J, d, S })
        })
        .collect();
    let sets = (0..told.len()).map(|first| agreeing(&told, first, pose, scanned.len()));
    let best = sets.reduce(|a, b| if b.0 < a.0 { b } else { a });
    best.map_or_else(Vec::new, |(_, pairs)| pairs)
}

/// What a pair tells of the pose: its difference is d + J x.
struct Told<'a> {
    pair: &'a Pair,
    J: Matrix3x6<f64>,
    d: Vector3<f64>,
    S: Matrix3<f64>,
}

/// The pairs that agree with one of them and with each other, and what they cost.
fn agreeing(told: &[Told], first: usize, pose: &Pose, faces: usize) -> (f64, Vec<Pair>) {
    let mut P = pose.given;
    let mut x: Vector6<f64> = -pose.off();
    let mut cost = 0.0;
    let mut pairs: Vec<Option<Pair>> = vec![None; faces];
    for Told { pair, J, d, S } in [&told[first]].into_iter().chain(told) {
        let taken = pairs[pair.scanned].is_some();
        let r = d + J * x;
        let Some(weight) = (S + J * P * J.transpose()).try_inverse().filter(|_| !taken) else {
            continue;
        };
        let square = r.dot(&(weight * r));
        if square > GATE_SIGMAS.powi(2) {
            continue;
        }
        let gain = P * J.transpose() * weight;
        x -= gain * r;
        P = (Matrix6::identity() - gain * J) * P;
        cost += square;
        pairs[pair.scanned] = Some(**pair);
    }
    let pairs: Vec<Pair> = pairs.into_iter().flatten().collect();
    (
        cost + GATE_SIGMAS.powi(2) * (faces - pairs.len()) as f64,
        pairs,
    )
}
