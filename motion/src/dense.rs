//! The little dense algebra of the projection, on rows in one slice.

/// Scalar product.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four sums: the additions need not wait for each other.
    let mut sum = [0.0; 4];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    for (x, y) in a.iter().zip(b) {
        for k in 0..4 {
            sum[k] += x[k] * y[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    rest + (sum[0] + sum[1]) + (sum[2] + sum[3])
}

/// Factorises the lower triangle in place, A = L Lᵀ; false where it is not positive definite.
pub(crate) fn cholesky(A: &mut [f64], m: usize) -> bool {
    for i in 0..m {
        let (above, row) = A.split_at_mut(i * m);
        for k in 0..i {
            let other = &above[k * m..k * m + k + 1];
            let sum = dot(&row[..k], &other[..k]);
            row[k] = (row[k] - sum) / other[k];
        }
        let pivot = row[i] - dot(&row[..i], &row[..i]);
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        row[i] = pivot.sqrt();
    }
    true
}

/// Solves L Lᵀ x = b in place.
pub(crate) fn cholesky_solve(L: &[f64], m: usize, x: &mut [f64]) {
    forward_solve(L, m, x);
    backward_solve(L, m, x);
}

/// Solves L x = b in place.
pub(crate) fn forward_solve(L: &[f64], m: usize, x: &mut [f64]) {
    for i in 0..m {
        x[i] = (x[i] - dot(&L[i * m..i * m + i], &x[..i])) / L[i * m + i];
    }
}

/// Solves Lᵀ x = b in place.
pub(crate) fn backward_solve(L: &[f64], m: usize, x: &mut [f64]) {
    for i in (0..m).rev() {
        let (above, from) = x.split_at_mut(i);
        let row = &L[i * m..=i * m + i];
        from[0] /= row[i];
        let solved = from[0];
        above
            .iter_mut()
            .zip(row)
            .for_each(|(x, l)| *x -= l * solved);
    }
}
