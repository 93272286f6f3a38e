//! Which planes of a scan are which known ones.

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Translation3, Vector3};
use surfaces::{ConvexPolygon, Surface, covariance};

/// Planes match that lean against each other by no more than this, rad.
const TILT_MAX_RAD: f64 = 0.1;
/// Planes match that are no farther apart than this, m.
const OFFSET_MAX_M: f64 = 0.1;

/// Two surfaces of one plane, in a frame C on the known one, in the middle of what they share.
pub(super) struct Pair {
    /// Index among the known surfaces.
    pub known: usize,
    /// Index among the scanned ones.
    pub scanned: usize,
    pub X_WC: Isometry3<f64>,
    /// Pose of the scanned surface, as far as it is known by now.
    pub X_WS: Isometry3<f64>,
    /// Covariance of the scanned plane in its own frame.
    pub own: Matrix3<f64>,
    /// Covariance of the known plane in C.
    pub known_C: Matrix3<f64>,
}

impl Pair {
    /// The scanned plane in C after a motion: (θ_x, θ_y, z), and the covariance of the difference.
    pub fn difference(&self, moved: &Isometry3<f64>) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let X_CS = self.X_WC.inverse() * moved * self.X_WS;
        let (d, sigma) = covariance::plane_in(&X_CS, &self.own)?;
        Some((d, sigma + self.known_C))
    }
}

/// Pairs of surfaces that may be one plane: they look the same way, lie over each other and near
/// each other. Of every face of the scan that part counts that shares most with a known surface.
pub(super) fn pairs(
    known: &[Surface],
    scanned: &[Surface],
    moved: &Isometry3<f64>,
    gate: Option<f64>,
) -> Vec<Pair> {
    let mut best: Vec<(f64, Pair)> = Vec::new();
    for (index, surface) in scanned.iter().enumerate() {
        let here = Surface {
            X_WS: moved * surface.X_WS,
            ..surface.clone()
        };
        let found = known.iter().enumerate().filter_map(|(k, other)| {
            let (shared_m2, mut pair) = matched(other, &here)?;
            (pair.known, pair.scanned) = (k, index);
            let fits = gate.is_none_or(|sigmas| {
                let agreed = pair.difference(&Isometry3::identity());
                agreed.is_some_and(|(d, s)| {
                    let inverse = s.try_inverse();
                    inverse.is_some_and(|w| d.dot(&(w * d)) <= sigmas * sigmas)
                })
            });
            fits.then_some((shared_m2, pair))
        });
        let Some(found) = found.reduce(|a, b| if b.0 > a.0 { b } else { a }) else {
            continue;
        };
        // Pieces of one face are one measurement.
        let same = |(_, other): &&mut (f64, Pair)| {
            surface.face.is_some() && scanned[other.scanned].face == surface.face
        };
        match best.iter_mut().find(same) {
            Some(other) if found.0 > other.0 => *other = found,
            Some(_) => {}
            None => best.push(found),
        }
    }
    best.into_iter().map(|(_, pair)| pair).collect()
}

/// The area that two surfaces share and their pair, if they may be one plane.
fn matched(known: &Surface, here: &Surface) -> Option<(f64, Pair)> {
    if known.normal_W().dot(&here.normal_W()) < TILT_MAX_RAD.cos() {
        return None;
    }
    let matrix = |s: &Surface| {
        let rows = s.plane_covariance?;
        Some(Matrix3::from_fn(|i, j| rows[i][j]))
    };
    let (sigma, own) = (matrix(known)?, matrix(here)?);
    let ring: Vec<Point2<f64>> = (here.vertices_W().iter())
        .map(|p| known.X_WS.inverse_transform_point(p).xy())
        .collect();
    let common = ConvexPolygon::hull(&ring)
        .ok()?
        .intersection(&known.polygon)?;
    let c = common.centroid();
    let X_SC = Translation3::new(c.x, c.y, 0.0);
    let X_WC = known.X_WS * X_SC;
    let (d, _) = covariance::plane_in(&(X_WC.inverse() * here.X_WS), &own)?;
    if d.z.abs() > OFFSET_MAX_M {
        return None;
    }
    let (_, known_C) = covariance::plane_in(&X_SC.inverse().into(), &sigma)?;
    let pair = Pair {
        known: 0,
        scanned: 0,
        X_WC,
        X_WS: here.X_WS,
        own,
        known_C,
    };
    Some((common.area(), pair))
}

impl Pair {
    /// The known normal in W.
    pub fn normal_W(&self) -> Vector3<f64> {
        self.X_WC.rotation * Vector3::z()
    }

    /// A point of the scanned plane near C, and its normal, in W.
    pub fn scanned_W(&self) -> (Point3<f64>, Vector3<f64>) {
        let n = self.X_WS.rotation * Vector3::z();
        let c = Point3::from(self.X_WC.translation.vector);
        let off = n.dot(&(c.coords - self.X_WS.translation.vector));
        (c - n * off, n)
    }
}
