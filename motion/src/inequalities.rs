//! The inequalities of a small quadratic program in dual form.
//!
//!   min ½‖y − y₀‖²  s.t.  E (y − y₀) = 0,  g_i·y ≥ b_i
//!   y = y₀ + P Gᵀ μ,   P = 1 − Eᵀ (E Eᵀ)⁻¹ E,   μ ≥ 0,   μ ⊥ G P Gᵀ μ + ε μ + room ≥ 0
//!
//! solved by an active set over the few rows that are near (C. L. Lawson and R. J. Hanson, *Solving Least
//! Squares Problems*, 1974, ch. 23).

use crate::dense::{backward_solve, cholesky, cholesky_solve, dot, forward_solve};

/// A row that is violated by less is not worked with, m and rad.
const VIOLATED: f64 = 1e-9;
/// ε: rows that contradict each other, or the equations, share what is violated.
const ELASTIC: f64 = 1e-6;
/// Rows that leave or join the active set for each that is worked with, at most.
const CHANGES: usize = 4;

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
    /// L⁻¹ E gᵀ of each of them, where L Lᵀ = E Eᵀ.
    shares: Vec<f64>,
    /// Lower triangle of G P Gᵀ + ε, row by row.
    products: Vec<f64>,
    multiplier: Vec<f64>,
    /// Which of the working rows are held with equality.
    active: Vec<usize>,
    A: Vec<f64>,
    wanted: Vec<f64>,
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
        self.shares.clear();
        self.products.clear();
        self.multiplier.clear();
        self.active.clear();
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
            self.join(n, m, equations, factor, known);
            self.settle();
            self.apply(n, m, equations, factor, y);
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

    /// Makes the working rows from number `known` on active.
    fn join(&mut self, n: usize, m: usize, equations: &[f64], factor: &[f64], known: usize) {
        for number in known..self.working.len() {
            let row = &self.rows[self.working[number] * n..][..n];
            let begin = self.shares.len();
            let along = equations.chunks_exact(n).map(|e| dot(e, row));
            self.shares.extend(along);
            forward_solve(factor, m, &mut self.shares[begin..]);
            let share = &self.shares[begin..];
            for (k, &other) in self.working[..=number].iter().enumerate() {
                let along = dot(share, &self.shares[k * m..(k + 1) * m]);
                let product = dot(row, &self.rows[other * n..(other + 1) * n]) - along;
                let elastic = if k == number { ELASTIC } else { 0.0 };
                self.products.push(product + elastic);
            }
            self.multiplier.push(0.0);
            self.active.push(number);
        }
    }

    fn product(&self, i: usize, k: usize) -> f64 {
        let (i, k) = (i.max(k), i.min(k));
        self.products[i * (i + 1) / 2 + k]
    }

    /// The multipliers of the working rows, from those that they had.
    fn settle(&mut self) {
        for _ in 0..CHANGES * self.working.len() {
            let m = self.active.len();
            let mut A = std::mem::take(&mut self.A);
            A.clear();
            for &i in &self.active {
                A.extend(self.active.iter().map(|&k| self.product(i, k)));
            }
            let is_definite = cholesky(&mut A, m);
            self.A = A;
            if !is_definite {
                return;
            }
            self.wanted.clear();
            let room = self.active.iter().map(|&i| -self.room[self.working[i]]);
            self.wanted.extend(room);
            cholesky_solve(&self.A, m, &mut self.wanted);
            // Toward them until one would pull.
            let (mut part, mut leaves) = (1.0, None);
            for (at, (&i, wanted)) in self.active.iter().zip(&self.wanted).enumerate() {
                let now = self.multiplier[i];
                if *wanted <= 0.0 {
                    let until = if now > 0.0 { now / (now - wanted) } else { 0.0 };
                    if until < part {
                        (part, leaves) = (until, Some(at));
                    }
                }
            }
            for (&i, wanted) in self.active.iter().zip(&self.wanted) {
                self.multiplier[i] += part * (wanted - self.multiplier[i]);
            }
            if let Some(at) = leaves {
                self.multiplier[self.active[at]] = 0.0;
                self.active.remove(at);
                continue;
            }
            let idle = (0..self.working.len()).filter(|i| !self.active.contains(i));
            let room = idle.map(|i| {
                let pushed = self
                    .active
                    .iter()
                    .map(|&k| self.product(i, k) * self.multiplier[k]);
                (i, self.room[self.working[i]] + pushed.sum::<f64>())
            });
            match room.min_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((i, room)) if room < -VIOLATED => self.active.push(i),
                _ => return,
            }
        }
    }

    /// y = y₀ + P Gᵀ μ.
    fn apply(&mut self, n: usize, m: usize, equations: &[f64], factor: &[f64], y: &mut [f64]) {
        y.copy_from_slice(&self.before);
        self.along.clear();
        self.along.resize(m, 0.0);
        for &i in &self.active {
            let mu = self.multiplier[i];
            let row = &self.rows[self.working[i] * n..][..n];
            y.iter_mut().zip(row).for_each(|(y, g)| *y += mu * g);
            let share = &self.shares[i * m..(i + 1) * m];
            let along = self.along.iter_mut().zip(share);
            along.for_each(|(along, share)| *along += mu * share);
        }
        backward_solve(factor, m, &mut self.along);
        for (e, l) in equations.chunks_exact(n).zip(&self.along) {
            y.iter_mut().zip(e).for_each(|(y, e)| *y -= l * e);
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

    #[test]
    fn rows_that_contradict_each_other_share_what_is_violated() {
        // y₁ ≥ 1 and y₁ ≤ −1 beside y₂ ≥ 1, on y₁ + y₂ + y₃ = 0.
        let mut set = Inequalities::default();
        set.push(3, -1.0).copy_from_slice(&[1.0, 0.0, 0.0]);
        set.push(3, -1.0).copy_from_slice(&[-1.0, 0.0, 0.0]);
        set.push(3, -1.0).copy_from_slice(&[0.0, 1.0, 0.0]);
        let mut y = [0.0; 3];
        let equation = [1.0, 1.0, 1.0];
        set.solve(3, 1, &equation, &[3f64.sqrt()], &mut y);
        assert!(y[0].abs() < 1e-5, "{y:?}");
        assert!(
            (y[1] - 1.0).abs() < 1e-5 && (y[2] + 1.0).abs() < 1e-5,
            "{y:?}"
        );
    }

    #[test]
    fn rows_that_no_longer_push_are_let_go() {
        // y₁ ≥ 1 alone would do; y₁ + y₂ ≥ 3 moves y₁ past it.
        let mut set = Inequalities::default();
        set.push(2, -1.0).copy_from_slice(&[1.0, 0.0]);
        set.push(2, -3.0).copy_from_slice(&[1.0, 1.0]);
        let mut y = [0.0, 0.0];
        set.solve(2, 0, &[], &[], &mut y);
        assert!(
            (y[0] - 1.5).abs() < 1e-5 && (y[1] - 1.5).abs() < 1e-5,
            "{y:?}"
        );
    }
}
