//! The moments of small cells from their pixels.

use wide::bytemuck::cast;
use wide::{f32x4, f32x8, f64x2};

use super::moments::Moments;

/// Side of the small cells, px; large cells are 2 × 2 of them.
pub(super) const CELL_PX: usize = 4;

/// What the moments of a cell without holes owe to its first column of pixels: Σ u and Σ u².
pub(super) struct Column {
    pub x0: f64,
    u: f64,
    uu: f64,
}

/// Of the 16 pixels of a cell without holes: Σ 1, Σ k, Σ k², Σ j k.
const WHOLE: [f64; 4] = [16.0, 24.0, 56.0, 36.0];

impl Column {
    pub fn new(x0: f64) -> Self {
        let [n, one, two, _] = WHOLE;
        Self {
            x0,
            u: one + n * x0,
            uu: two + x0 * (2.0 * one + n * x0),
        }
    }
}

/// The moments of a row of cells from their rows of pixels, of which y0 is the first.
pub(super) fn of_row(
    lines: [&[f32]; CELL_PX],
    columns: &[Column],
    y0: f64,
    moments: &mut [Moments],
) {
    let (columns, last) = columns.as_chunks();
    let first = moments.len() - last.len();
    let (fours, rest) = moments.as_chunks_mut();
    let [a, b, c, d] = lines.map(|line| line.as_chunks().0.iter());
    for ((lines, columns), four) in a.zip(b).zip(c.zip(d)).zip(columns).zip(fours) {
        let ((a, b), (c, d)) = lines;
        of_four([a, b, c, d], columns, y0, four);
    }
    // Fewer than four are left.
    for ((cell, column), i) in rest.iter_mut().zip(last).zip(first..) {
        *cell = holed(lines.map(|line| line.as_chunks().0[i]), column.x0, y0);
    }
}

/// The moments of four cells side by side from their rows of pixels, of which y0 is the first.
#[inline]
fn of_four(
    lines: [&[f32; 4 * CELL_PX]; CELL_PX],
    columns: &[Column; 4],
    y0: f64,
    moments: &mut [Moments; 4],
) {
    // Of two cells the least, and down the columns of their differences to each one's first pixel (small
    // numbers, for which 32 bits do) the sums, those of squares, and those of each times its row.
    let down = |k: usize| {
        let row = |r: usize| f32x8::from(lines[r].as_chunks::<{ 2 * CELL_PX }>().0[k]);
        let [a, b, c, d] = [row(0), row(1), row(2), row(3)];
        let least = a.fast_min(b).fast_min(c.fast_min(d));
        let first = |cell: usize| f32x4::splat(lines[0][(2 * k + cell) * CELL_PX]);
        let base: f32x8 = cast([first(0), first(1)]);
        let [e, f, g, h] = [a - base, b - base, c - base, d - base];
        let squares = (e * e + f * f) + (g * g + h * h);
        let weighted = f + g * 2.0 + h * 3.0;
        [least, (e + f) + (g + h), squares, weighted].map(cast::<_, [f32x4; 2]>)
    };
    let (left, right) = (down(0), down(1));
    let of_each = |i: usize| [left[i][0], left[i][1], right[i][0], right[i][1]];
    let [least, sums, squares, weighted] = [of_each(0), of_each(1), of_each(2), of_each(3)];
    // Along the rows, one cell a lane.
    let across = |columns| {
        let [a, b, c, d] = f32x4::transpose(columns);
        twos((a + b) + (c + d))
    };
    let square = across(squares);
    let down = across(weighted);
    let [a, b, c, d] = f32x4::transpose(sums);
    let sum = twos((a + b) + (c + d));
    let along = twos(b + f32x4::splat(2.0) * c + f32x4::splat(3.0) * d);
    let line = lines[0];
    let base = twos(f32x4::new([line[0], line[4], line[8], line[12]]));
    // About the image's centre, two cells at once.
    let [n, one, two, both] = WHOLE;
    let (v, vv) = (one + n * y0, two + y0 * (2.0 * one + n * y0));
    let (uv, uv_x) = (both + one * y0, one + n * y0);
    let (all, ones, y) = (f64x2::splat(n), f64x2::splat(one), f64x2::splat(y0));
    for k in 0..2 {
        let (w0, sum) = (base[k], sum[k]);
        let columns = [&columns[2 * k], &columns[2 * k + 1]];
        let x = f64x2::from([columns[0].x0, columns[1].x0]);
        let w = sum + all * w0;
        let uw = (along[k] + ones * w0 + w * x).to_array();
        let vw = (down[k] + ones * w0 + w * y).to_array();
        let ww = (square[k] + w0 * (f64x2::splat(2.0) * sum + all * w0)).to_array();
        let w = w.to_array();
        for i in 0..2 {
            moments[2 * k + i] = Moments {
                n,
                u: columns[i].u,
                v,
                uu: columns[i].uu,
                uv: uv + columns[i].x0 * uv_x,
                vv,
                w: w[i],
                uw: uw[i],
                vw: vw[i],
                ww: ww[i],
            };
        }
    }
    // Those with holes on their own.
    let [a, b, c, d] = least;
    let least_of_all = a.fast_min(b).fast_min(c.fast_min(d));
    if least_of_all.simd_le(f32x4::ZERO).any() {
        for (k, least) in least.iter().enumerate() {
            if least.simd_le(f32x4::ZERO).any() {
                let lines = lines.map(|line| line.as_chunks().0[k]);
                moments[k] = holed(lines, columns[k].x0, y0);
            }
        }
    }
}

/// Four numbers with more digits, two and two.
#[inline]
fn twos(four: f32x4) -> [f64x2; 2] {
    let [a, b, c, d] = four.to_array();
    let two = |a: f32, b: f32| f64x2::from([a.into(), b.into()]);
    [two(a, b), two(c, d)]
}

/// The moments of those of a cell's pixels that were measured; the first is at (x0, y0).
#[inline(always)]
pub(super) fn holed(lines: [[f32; CELL_PX]; CELL_PX], x0: f64, y0: f64) -> Moments {
    let [a, b, c, d] = lines.map(f32x4::from);
    // About the largest, so that the sums are of small numbers, for which 32 bits do.
    let [e, f, g, h] = a.fast_max(b).fast_max(c.fast_max(d)).to_array();
    let base = e.max(f).max(g.max(h));
    if base <= 0.0 {
        return Moments::default();
    }
    // One where there is a measurement, and its difference.
    let one = |line: f32x4| line.simd_gt(f32x4::ZERO) & f32x4::ONE;
    let (p, q, r, s) = (one(a), one(b), one(c), one(d));
    let rest = f32x4::splat(base);
    let (a, b, c, d) = (
        (a - rest) * p,
        (b - rest) * q,
        (c - rest) * r,
        (d - rest) * s,
    );
    // Down the columns, k the row: Σ 1, Σ k, Σ k², Σ w, Σ k w and Σ w²; then along the row of sums.
    let (two, three) = (f32x4::splat(2.0), f32x4::splat(3.0));
    let n = ((p + q) + (r + s)).to_array();
    let down = (q + two * r + three * s).to_array();
    let downs = (q + f32x4::splat(4.0) * r + f32x4::splat(9.0) * s).to_array();
    let w = ((a + b) + (c + d)).to_array();
    let down_w = (b + two * c + three * d).to_array();
    let square = ((a * a + b * b) + (c * c + d * d)).to_array();
    let (count, u, v) = (across(n), along(n), across(down));
    let (sum, base) = (across(w), f64::from(base));
    let local = Moments {
        n: count,
        u,
        v,
        uu: f64::from(n[1] + 4.0 * n[2] + 9.0 * n[3]),
        uv: along(down),
        vv: across(downs),
        w: sum + count * base,
        uw: along(w) + u * base,
        vw: across(down_w) + v * base,
        ww: across(square) + base * (2.0 * sum + count * base),
    };
    local.moved(x0, y0)
}

/// Sum of a row.
fn across([a, b, c, d]: [f32; CELL_PX]) -> f64 {
    f64::from((a + b) + (c + d))
}

/// Sum of a row, each times its column.
fn along([_, b, c, d]: [f32; CELL_PX]) -> f64 {
    f64::from(b + 2.0 * c + 3.0 * d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_the_moments_of_its_pixels() {
        let mut lines = [[0.0_f32; CELL_PX]; CELL_PX];
        for (k, j) in (0..CELL_PX).flat_map(|k| (0..CELL_PX).map(move |j| (k, j))) {
            lines[k][j] = 0.4 + 0.003 * j as f32 - 0.001 * (k * k) as f32;
        }
        let mut other = lines;
        (other[1][2], other[3][0]) = (0.0, 0.0);
        for lines in [lines, other] {
            let (x0, y0) = (-120.0, 76.0);
            let mut sums = Moments::default();
            for (k, line) in lines.iter().enumerate() {
                for (j, &w) in line.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                    sums.push(x0 + j as f64, y0 + k as f64, w.into());
                }
            }
            let four = lines.map(|line| std::array::from_fn(|i| line[i % CELL_PX]));
            let columns = [0.0, 4.0, 8.0, 12.0].map(|x| Column::new(x0 + x));
            let mut got = [Moments::default(); 4];
            of_four(four.each_ref(), &columns, y0, &mut got);
            for got in [got[2].moved(-8.0, 0.0), holed(lines, x0, y0)] {
                for (a, b) in [
                    (got.n, sums.n),
                    (got.u, sums.u),
                    (got.v, sums.v),
                    (got.uu, sums.uu),
                    (got.uv, sums.uv),
                    (got.vv, sums.vv),
                    (got.w, sums.w),
                    (got.uw, sums.uw),
                    (got.vw, sums.vw),
                    (got.ww, sums.ww),
                ] {
                    // Differences of 0.01 in 32 bits.
                    assert!((a - b).abs() <= 1e-9 * b.abs(), "{got:?} {sums:?}");
                }
            }
        }
    }
}
