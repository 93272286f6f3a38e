//! Closest points of two segments, in closed form.

use nalgebra::Vector3;

/// The closest points of the segments p ± half_p·u and q ± half_q·w, u and w unit.
///
///   min ‖(p + s u) − (q + t w)‖  s.t.  |s| ≤ half_p, |t| ≤ half_q
///
/// Returns (point on the first, point on the second).
pub(crate) fn closest_points(
    p: &Vector3<f64>,
    u: &Vector3<f64>,
    half_p: f64,
    q: &Vector3<f64>,
    w: &Vector3<f64>,
    half_q: f64,
) -> (Vector3<f64>, Vector3<f64>) {
    let r = p - q;
    let (b, d, e) = (u.dot(w), u.dot(&r), w.dot(&r));
    // The unconstrained minimum; nearly parallel lines have none worth the name, and begin
    // opposite the second segment's centre.
    let denominator = 1.0 - b * b;
    let mut s = if denominator > 1e-14 {
        (b * e - d) / denominator
    } else {
        -d
    };
    s = s.clamp(-half_p, half_p);
    // The best t for that s, and the best s for the t that its segment allows: since the square
    // of the distance is convex, clamping once each way ends at the minimum.
    let t = (b * s + e).clamp(-half_q, half_q);
    s = (b * t - d).clamp(-half_p, half_p);
    (p + u * s, q + w * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-1.0..1.0_f64).prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn nothing_on_a_grid_is_closer(
            p in vector(), q in vector(), u in vector(), w in vector(),
            half_p in 0.0..1.0_f64, half_q in 0.0..1.0_f64,
        ) {
            prop_assume!(u.norm() > 0.1 && w.norm() > 0.1);
            let (u, w) = (u.normalize(), w.normalize());
            let (a, b) = closest_points(&p, &u, half_p, &q, &w, half_q);
            let best = (a - b).norm();
            prop_assert!((a - p).norm() <= half_p + 1e-12 && (b - q).norm() <= half_q + 1e-12);
            for i in -20..=20 {
                for j in -20..=20 {
                    let s = half_p * f64::from(i) / 20.0;
                    let t = half_q * f64::from(j) / 20.0;
                    prop_assert!(best <= (p + u * s - q - w * t).norm() + 1e-9);
                }
            }
        }

        #[test]
        fn parallel_segments_are_handled(
            p in vector(), q in vector(), u in vector(),
            half_p in 0.0..1.0_f64, half_q in 0.0..1.0_f64, flip in any::<bool>(),
        ) {
            prop_assume!(u.norm() > 0.1);
            let u = u.normalize();
            let w = if flip { -u } else { u };
            let (a, b) = closest_points(&p, &u, half_p, &q, &w, half_q);
            let along = ((p - q).dot(&u).abs() - half_p - half_q).max(0.0);
            let across = ((p - q) - u * (p - q).dot(&u)).norm();
            prop_assert!(((a - b).norm() - along.hypot(across)).abs() < 1e-9);
        }
    }
}
