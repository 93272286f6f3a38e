//! Connected parts of the eroded labels: the visible faces, run by run.

use super::bits::Bits;
use super::label_boundaries::LabelBoundaries;

/// Pixels of one face, connected by their sides.
pub(super) struct Face {
    /// Index of its plane.
    pub label: u16,
    /// Runs of pixels, row by row: row, first column, one past the last column.
    pub runs: Vec<(u32, u32, u32)>,
}

/// The faces of the pixels that are in `sure`, in the order of their first pixels; `cuts` are those
/// of the labels.
///
/// Runs of adjacent rows that overlap in a column are joined (union–find).
pub(super) fn faces(labels: &[u16], sure: &Bits, cuts: &LabelBoundaries) -> Vec<Face> {
    let mut runs: Vec<(u32, u32, u32, u16)> = Vec::with_capacity(8 * sure.height);
    cuts.for_runs(sure, |v, a, b| {
        let label = labels[v * sure.width + a];
        runs.push((v as u32, a as u32, b as u32, label));
    });
    let mut parent: Vec<usize> = (0..runs.len()).collect();
    // The first run that is one row above, and ends after this one begins.
    let mut above = 0;
    for here in 0..runs.len() {
        let (v, a, b, label) = runs[here];
        while runs[above].0 + 1 < v || (runs[above].0 + 1 == v && runs[above].2 <= a) {
            above += 1;
        }
        let over = |run: &&(u32, u32, u32, u16)| run.0 < v && run.1 < b;
        let mut own = here;
        for (k, run) in (above..).zip(runs[above..here].iter().take_while(over)) {
            if run.3 == label {
                // The earlier run is the root of both.
                let other = root(&mut parent, k);
                parent[own.max(other)] = own.min(other);
                own = own.min(other);
            }
        }
    }
    // The parents of all are before them: from the first on, each run's is its root.
    let mut counts = vec![0; runs.len()];
    for k in 0..runs.len() {
        parent[k] = parent[parent[k]];
        counts[parent[k]] += 1;
    }
    let mut faces: Vec<Face> = Vec::new();
    let mut index = vec![0; runs.len()];
    for (k, &(v, a, b, label)) in runs.iter().enumerate() {
        let r = parent[k];
        if r == k {
            index[r] = faces.len();
            let runs = Vec::with_capacity(counts[r]);
            faces.push(Face { label, runs });
        }
        faces[index[r]].runs.push((v, a, b));
    }
    faces
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::segmentation::NONE;

    /// The faces of all pixels with a label, in rows of `width`.
    pub fn of_labels(labels: &[u16], width: usize) -> Vec<Face> {
        let height = labels.len() / width;
        let sure = Bits::of(labels, width, |label| label != NONE);
        faces(labels, &sure, &LabelBoundaries::new(labels, width, height))
    }

    #[test]
    fn a_u_is_one_face_and_its_inside_another() {
        let picture = ["#.#.", "#.#.", "###.", "...#"];
        let labels: Vec<u16> = picture
            .iter()
            .flat_map(|row| row.bytes().map(|b| if b == b'#' { 0 } else { 1 }))
            .collect();
        let faces = of_labels(&labels, 4);
        let sizes: Vec<(u16, usize)> = faces
            .iter()
            .map(|f| {
                (
                    f.label,
                    f.runs.iter().map(|(_, a, b)| (b - a) as usize).sum(),
                )
            })
            .collect();
        // The U; its inside; the column on the right; the bottom; the lone corner.
        assert_eq!(sizes, [(0, 7), (1, 2), (1, 3), (1, 3), (0, 1)]);
    }
}
