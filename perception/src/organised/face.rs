//! Connected parts of the eroded labels: the visible faces, run by run.

use super::labels::NONE;

/// Pixels of one face, connected by their sides.
pub(super) struct Face {
    /// Index of its plane.
    pub label: u16,
    /// Runs of pixels, row by row: row, first column, one past the last column.
    pub runs: Vec<(u32, u32, u32)>,
}

/// The faces of the labels, in the order of their first pixels.
///
/// Runs of adjacent rows that overlap in a column are joined (union–find).
pub(super) fn faces(labels: &[u16], width: usize) -> Vec<Face> {
    let mut runs: Vec<(u32, u32, u32, u16)> = Vec::new();
    let mut parent: Vec<usize> = Vec::new();
    let mut above = 0..0;
    for (v, line) in labels.chunks_exact(width.max(1)).enumerate() {
        let first = runs.len();
        let mut u = 0;
        while u < width {
            let label = line[u];
            let start = u;
            u += same(&line[u..]);
            if label != NONE {
                parent.push(runs.len());
                runs.push((v as u32, start as u32, u as u32, label));
            }
        }
        let mut over = above.clone();
        for here in first..runs.len() {
            let (_, a, b, label) = runs[here];
            // Runs above are sorted: skip those that end before this one begins.
            while over.start < over.end && runs[over.start].2 <= a {
                over.start += 1;
            }
            for (k, run) in runs.iter().enumerate().take(over.end).skip(over.start) {
                if run.1 >= b {
                    break;
                }
                if run.3 == label {
                    let (p, q) = (root(&mut parent, here), root(&mut parent, k));
                    // The earlier run is the root.
                    parent[p.max(q)] = p.min(q);
                }
            }
        }
        above = first..runs.len();
    }
    let mut index = vec![usize::MAX; runs.len()];
    let mut faces: Vec<Face> = Vec::new();
    for (k, &(v, a, b, label)) in runs.iter().enumerate() {
        let r = root(&mut parent, k);
        if index[r] == usize::MAX {
            index[r] = faces.len();
            faces.push(Face {
                label,
                runs: Vec::new(),
            });
        }
        faces[index[r]].runs.push((v, a, b));
    }
    faces
}

/// How many labels are as the first one.
fn same(line: &[u16]) -> usize {
    let Some(&first) = line.first() else { return 0 };
    // Sixteen at once as long as all agree.
    let agree = |chunk: &&[u16; 16]| chunk.iter().fold(0, |all, label| all | (label ^ first)) == 0;
    let whole = 16 * line.as_chunks().0.iter().take_while(agree).count();
    let rest = line[whole..].iter().take_while(|label| **label == first);
    whole + rest.count()
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_u_is_one_face_and_its_inside_another() {
        let picture = ["#.#.", "#.#.", "###.", "...#"];
        let labels: Vec<u16> = picture
            .iter()
            .flat_map(|row| row.bytes().map(|b| if b == b'#' { 0 } else { 1 }))
            .collect();
        let faces = faces(&labels, 4);
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
