//! The motion that brings matched planes together.

use nalgebra::{
    Isometry3, Matrix3, Matrix3x6, Matrix6, Point3, SVD, SymmetricEigen, Translation3,
    UnitQuaternion, Vector3, Vector6,
};

use super::matching::Pair;
use crate::Error;

/// Standard deviation that a direction of the pose may have at most before it counts as open, m.
const SHIFT_SIGMA_MAX_M: f64 = 0.015;
/// The same of a turn, rad.
const TURN_SIGMA_MAX_RAD: f64 = 0.015;

/// Steps of Gauss and Newton after the closed form, which is off by little.
const STEPS: usize = 4;
/// A direction of the normals with less than this part of their sum of squares is not spanned:
/// all normals within 4° of the others' plane.
const SPAN_MIN: f64 = 0.005;

pub(super) struct Solved {
    pub X_W: Isometry3<f64>,
    pub covariance: Matrix6<f64>,
    pub about_W: Point3<f64>,
    pub misfit: f64,
}

/// The covariance-weighted motion of the scanned planes onto the known ones.
pub(super) fn solve(pairs: &[Pair]) -> Result<Solved, Error> {
    if pairs.len() < 3 {
        return Err(Error::FewPlanes { pairs: pairs.len() });
    }
    spanned(pairs)?;
    let sum = pairs.iter().map(|pair| pair.X_WC.translation.vector);
    let about_W = Point3::from(sum.sum::<Vector3<f64>>() / pairs.len() as f64);
    let mut X_W = closed_form(pairs, &about_W);
    let mut square = 0.0;
    let mut information = Matrix6::zeros();
    for step in 0..=STEPS {
        let mut gradient = Vector6::zeros();
        (information, square) = (Matrix6::zeros(), 0.0);
        for pair in pairs {
            let Some((d, s)) = pair.difference(&X_W) else {
                continue;
            };
            let Some(weight) = s.try_inverse() else {
                continue;
            };
            let jacobian = jacobian(pair, &about_W);
            information += jacobian.transpose() * weight * jacobian;
            gradient += jacobian.transpose() * weight * d;
            square += d.dot(&(weight * d));
        }
        if step == STEPS {
            break;
        }
        let Some(inverse) = information.try_inverse() else {
            break;
        };
        let change = -(inverse * gradient);
        X_W = motion(&change, &about_W) * X_W;
    }
    let covariance = information
        .try_inverse()
        .ok_or_else(|| degenerate(pairs, "the pose".to_owned()))?;
    known_well(pairs, &covariance)?;
    let freedom = (3 * pairs.len() - 6).max(1) as f64;
    Ok(Solved {
        X_W,
        covariance,
        about_W,
        misfit: square / freedom,
    })
}

/// Root mean square distance between the planes of pairs after a motion, m.
pub(super) fn offset_rms_m(pairs: &[Pair], moved: &Isometry3<f64>) -> f64 {
    let offsets = pairs.iter().filter_map(|pair| pair.difference(moved));
    let square: f64 = offsets.map(|(d, _)| d.z * d.z).sum();
    (square / pairs.len().max(1) as f64).sqrt()
}

/// How (turn, shift) about a point changes a pair's (θ_x, θ_y, z).
fn jacobian(pair: &Pair, about_W: &Point3<f64>) -> Matrix3x6<f64> {
    let axes = pair.X_WC.rotation.to_rotation_matrix();
    let (x, y, z) = (
        axes.matrix().column(0).into_owned(),
        axes.matrix().column(1).into_owned(),
        axes.matrix().column(2).into_owned(),
    );
    let arm = pair.X_WC.translation.vector - about_W.coords;
    // z · (ω × arm) = ω · (arm × z)
    let lever = arm.cross(&z);
    Matrix3x6::new(
        x.x, x.y, x.z, 0.0, 0.0, 0.0, //
        y.x, y.y, y.z, 0.0, 0.0, 0.0, //
        lever.x, lever.y, lever.z, z.x, z.y, z.z,
    )
}

/// The motion of a turn about a point and a shift.
fn motion(change: &Vector6<f64>, about_W: &Point3<f64>) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(change.fixed_rows::<3>(0).into_owned());
    let shift = change.fixed_rows::<3>(3).into_owned();
    let place = about_W.coords + shift - turn * about_W.coords;
    Isometry3::from_parts(Translation3::from(place), turn)
}

/// Kabsch on the normals, then least squares on the offsets, each weighted by its variance.
fn closed_form(pairs: &[Pair], about_W: &Point3<f64>) -> Isometry3<f64> {
    let sigma = |pair: &Pair| pair.difference(&Isometry3::identity()).map(|(_, s)| s);
    let mut products = Matrix3::zeros();
    for pair in pairs {
        let Some(s) = sigma(pair) else { continue };
        let weight = 1.0 / (s[(0, 0)] + s[(1, 1)]).max(1e-12);
        products += weight * pair.normal_W() * pair.scanned_W().1.transpose();
    }
    let svd = SVD::new(products, true, true);
    let turn = match (svd.u, svd.v_t) {
        (Some(u), Some(v_t)) => {
            let sign = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
            let matrix = u * Matrix3::from_diagonal(&sign) * v_t;
            UnitQuaternion::from_matrix(&matrix)
        }
        _ => UnitQuaternion::identity(),
    };
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for pair in pairs {
        let Some(s) = sigma(pair) else { continue };
        let (m, (p, _)) = (pair.normal_W(), pair.scanned_W());
        let turned = about_W.coords + turn * (p - about_W);
        let off = m.dot(&(pair.X_WC.translation.vector - turned));
        let weight = 1.0 / s[(2, 2)].max(1e-12);
        normal += weight * m * m.transpose();
        right += weight * off * m;
    }
    let shift = normal
        .try_inverse()
        .map_or_else(Vector3::zeros, |inverse| inverse * right);
    let turned = turn.scaled_axis();
    let change = Vector6::new(turned.x, turned.y, turned.z, shift.x, shift.y, shift.z);
    motion(&change, about_W)
}

/// Refuses normals that leave a shift open, whatever their weights.
fn spanned(pairs: &[Pair]) -> Result<(), Error> {
    let outer = pairs.iter().map(|pair| {
        let n = pair.normal_W();
        n * n.transpose()
    });
    let scatter = outer.sum::<Matrix3<f64>>() / pairs.len() as f64;
    let eigen = SymmetricEigen::new(scatter);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let axis = |i: usize| named(&eigen.eigenvectors.column(order[i]).into_owned());
    if eigen.eigenvalues[order[1]] < SPAN_MIN {
        let open = format!("the turn about {} and the shifts across it", axis(0));
        return Err(degenerate(pairs, open));
    }
    if eigen.eigenvalues[order[2]] < SPAN_MIN {
        return Err(degenerate(pairs, format!("the shift along {}", axis(2))));
    }
    Ok(())
}

/// Refuses a pose of which a direction is hardly known.
fn known_well(pairs: &[Pair], covariance: &Matrix6<f64>) -> Result<(), Error> {
    for (what, at, limit) in [
        ("turn about", 0, TURN_SIGMA_MAX_RAD),
        ("shift along", 3, SHIFT_SIGMA_MAX_M),
    ] {
        let block = covariance.fixed_view::<3, 3>(at, at).into_owned();
        let eigen = SymmetricEigen::new(block);
        let worst = eigen.eigenvalues.imax();
        if eigen.eigenvalues[worst].max(0.0).sqrt() > limit {
            let axis = named(&eigen.eigenvectors.column(worst).into_owned());
            return Err(degenerate(pairs, format!("the {what} {axis}")));
        }
    }
    Ok(())
}

fn degenerate(pairs: &[Pair], open: String) -> Error {
    let pairs = pairs.len();
    Error::Degenerate { pairs, open }
}

/// A direction in words: an axis where it is one, else its coordinates, the largest positive.
fn named(direction: &Vector3<f64>) -> String {
    let main = direction.iamax();
    if direction[main].abs() > 0.999 {
        return ["x", "y", "z"][main].to_owned();
    }
    let d = direction * direction[main].signum();
    format!("({:.2}, {:.2}, {:.2})", d.x, d.y, d.z)
}
