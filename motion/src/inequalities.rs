//! The inequalities of a small quadratic program in dual form.
//!
//!   min ½‖y − y₀‖²  s.t.  E (y − y₀) = 0,  g_i·y ≥ b_i
//!   y = y₀ + P Gᵀ μ,   P = 1 − Eᵀ (E Eᵀ)⁻¹ E,   μ ≥ 0,   μ ⊥ G P Gᵀ μ + room ≥ 0
//!
//! solved by projected Gauss–Seidel over the few rows that are near.

use crate::dense::{cholesky_solve, dot};

/// Sweeps over the rows.
const SWEEPS: usize = 60;
/// A sweep that changes the multipliers by less than this part is the last.
const SETTLED: f64 = 1e-9;
/// A row that is violated by less is not worked with, m and rad.
const VIOLATED: f64 = 1e-9;
/// What keeps rows that contradict each other from running away.
const ELASTIC: f64 = 1e-6;

/// lower ≤ w y_k ≤ upper, and which of the two is a row.
struct Bound {
    k: usize,
    w: f64,
    limits: [f64; 2],
    is_row: [bool; 2],
}

/// Rows g with their room g·y₀ − b.
#[derive(Default)]
pub(crate) struct Inequalities {
    /// Bounds of single coordinates: a row each where a solution violates them.
    bounds: Vec<Bound>,
    rows: Vec<f64>,
    room: Vec<f64>,
    /// The rows that count so far: those that some solution violated.
    working: Vec<usize>,
    /// P gᵀ of each of them.
    projected: Vec<f64>,
    products: Vec<f64>,
    multiplier: Vec<f64>,
    along: Vec<f64>,
    /// y₀.
    before: Vec<f64>,
}

impl Inequalities {
    pub fn clear(&mut self) {
        self.bounds.clear();
        self.rows.clear();
        self.room.clear();
    }

    /// Lower and upper limit of `w` y_`k`.
    pub fn bound(&mut self, k: usize, w: f64, limits: [f64; 2]) {
        self.bounds.push(Bound {
            k,
            w,
            limits,
            is_row: [false; 2],
        });
    }

    /// A new row of zeros with its room.
    pub fn push(&mut self, n: usize, room: f64) -> &mut [f64] {
        let begin = self.rows.len();
        self.rows.resize(begin + n, 0.0);
        self.room.push(room);
        &mut self.rows[begin..]
    }

    /// Sets the room of the last row.
    pub fn set_room(&mut self, room: f64) {
        if let Some(last) = self.room.last_mut() {
            *last = room;
        }
    }

    /// Moves `y` from the solution of the `m` equations, whose rows are `equations` and whose
    /// Cholesky factor is `factor`, to that of all: of most rows it has room, and only those that it or
    /// a solution on the way violates are worked with.
    pub fn solve(&mut self, n: usize, m: usize, equations: &[f64], factor: &[f64], y: &mut [f64]) {
        self.working.clear();
        self.projected.clear();
        self.multiplier.clear();
        self.before.clear();
        self.before.extend_from_slice(y);
        loop {
            let known = self.working.len();
            for i in 0..self.room.len() {
                let moved = y.iter().zip(&self.before).map(|(y, before)| y - before);
                let row = &self.rows[i * n..(i + 1) * n];
                let room = self.room[i] + row.iter().zip(moved).map(|(g, d)| g * d).sum::<f64>();
                if room < -VIOLATED && !self.working[..known].contains(&i) {
                    self.working.push(i);
                }
            }
            self.bounded(n, y);
            if self.working.len() == known {
                return;
            }
            self.project(n, m, equations, factor, known);
            self.sweep();
            y.copy_from_slice(&self.before);
            for (row, mu) in self.projected.chunks_exact(n).zip(&self.multiplier) {
                y.iter_mut().zip(row).for_each(|(y, p)| *y += mu * p);
            }
        }
    }

    /// Makes rows of the bounds that `y` violates: what gives way to one thing may come to another.
    fn bounded(&mut self, n: usize, y: &[f64]) {
        for bound in &mut self.bounds {
            for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                let room = |y: &[f64]| sign * (bound.w * y[bound.k] - bound.limits[side]);
                if !bound.is_row[side] && room(y) < -VIOLATED {
                    bound.is_row[side] = true;
                    self.working.push(self.room.len());
                    self.room.push(room(&self.before));
                    self.rows.resize(self.rows.len() + n, 0.0);
                    let begin = self.rows.len() - n;
                    self.rows[begin + bound.k] = sign * bound.w;
                }
            }
        }
    }

    /// P gᵀ of the working rows from number `known` on, and the products of all.
    fn project(&mut self, n: usize, m: usize, equations: &[f64], factor: &[f64], known: usize) {
        for &i in &self.working[known..] {
            self.projected
                .extend_from_slice(&self.rows[i * n..(i + 1) * n]);
        }
        for row in self.projected[known * n..].chunks_exact_mut(n) {
            self.along.clear();
            self.along
                .extend(equations.chunks_exact(n).map(|e| dot(e, row)));
            cholesky_solve(factor, m, &mut self.along);
            for (e, l) in equations.chunks_exact(n).zip(&self.along) {
                row.iter_mut().zip(e).for_each(|(r, e)| *r -= l * e);
            }
        }
        self.products.clear();
        for &i in &self.working {
            let row = &self.rows[i * n..(i + 1) * n];
            let products = self.projected.chunks_exact(n).map(|p| dot(row, p));
            self.products.extend(products);
        }
    }

    /// The multipliers of the working rows, from those that they had.
    fn sweep(&mut self) {
        let count = self.working.len();
        self.multiplier.resize(count, 0.0);
        for _ in 0..SWEEPS {
            let mut change: f64 = 0.0;
            let mut size: f64 = 0.0;
            for (i, &row) in self.working.iter().enumerate() {
                let products = &self.products[i * count..(i + 1) * count];
                let value = self.room[row] + dot(products, &self.multiplier);
                let before = self.multiplier[i];
                let after = (before - value / (products[i] + ELASTIC)).max(0.0);
                self.multiplier[i] = after;
                change = change.max((after - before).abs());
                size = size.max(after.abs());
            }
            if change <= SETTLED * size {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_gives_way_to_one_thing_stops_at_its_own_bound() {
        // 2 y₁ + y₂ ≥ 2 moves y₁ from 0, where it has room, past 0.5.
        let mut set = Inequalities::default();
        set.bound(0, 1.0, [-0.5, 0.5]);
        set.push(2, -2.0).copy_from_slice(&[2.0, 1.0]);
        let mut y = [0.0, 0.0];
        set.solve(2, 0, &[], &[], &mut y);
        assert!(
            (y[0] - 0.5).abs() < 1e-5 && (y[1] - 1.0).abs() < 1e-5,
            "{y:?}"
        );
    }
}
