//! Meshes of boxes.

/// Boxes, each from x to x, from y to y and from z to z, m, as a mesh.
pub fn boxes_obj(boxes: &[[f64; 6]]) -> String {
    let faces = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    let mut text = String::new();
    for (number, &[x0, x1, y0, y1, z0, z1]) in boxes.iter().enumerate() {
        for (x, y) in [(x0, y0), (x0, y1), (x1, y0), (x1, y1)] {
            text += &format!("v {x} {y} {z0}\nv {x} {y} {z1}\n");
        }
        for face in faces {
            let corners = face.map(|i| (1 + i + 8 * number).to_string());
            text += &format!("f {}\n", corners.join(" "));
        }
    }
    text
}
