//! How dense points lie in the cells of a raster.

/// Cells of a raster are made larger, by twos, until those with points have this many such neighbours (of four) on
/// average.
const NEIGHBOURS_MIN: f64 = 3.2;

/// Whether points lie so dense in cells, in rows of `cols`, that gaps between them are none by chance.
pub(crate) fn is_dense<T>(cells: &[T], cols: usize, has_point: impl Fn(&T) -> bool) -> bool {
    let (mut count, mut pairs) = (0_usize, 0_usize);
    for (y, line) in cells.chunks_exact(cols.max(1)).enumerate() {
        let below = cells.get((y + 1) * cols..(y + 2) * cols);
        for x in (0..cols).filter(|&x| has_point(&line[x])) {
            count += 1;
            pairs += usize::from(x + 1 < cols && has_point(&line[x + 1]));
            pairs += usize::from(below.is_some_and(|below| has_point(&below[x])));
        }
    }
    2.0 * pairs as f64 / count.max(1) as f64 >= NEIGHBOURS_MIN
}
