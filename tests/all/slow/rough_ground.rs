//! A quadruped on ground that is a mesh of triangles, none level with its neighbours and each hardly wider than a foot.

use serde_json::{Value, json};

use crate::support::program::{ends_with, json as read_json, number, succeeds};

const CELL_M: f64 = 0.1;

/// A floor that becomes rough after its first metre and a half.
fn rough_obj() -> String {
    let (along, across) = (35, 22);
    let vertices = (0..along).flat_map(|i| {
        (0..across).map(move |j| {
            let up_m = match i {
                0..15 => 0.0,
                _ => 0.01 * (((i * i + 3 * j * j + 5 * i * j) % 5) as f64 - 2.0),
            };
            let (x, y) = (CELL_M * i as f64 - 1.0, CELL_M * (j as f64 - 10.5));
            format!("v {x} {y} {up_m}\n")
        })
    });
    let faces = (0..along - 1).flat_map(|i| {
        (0..across - 1).map(move |j| {
            let [a, b] = [i * across + j + 1, (i + 1) * across + j + 1];
            format!("f {a} {b} {}\nf {a} {} {}\n", b + 1, b + 1, a + 1)
        })
    });
    vertices.chain(faces).collect()
}

#[test]
fn a_quadruped_walks_on_triangles_and_not_into_what_stands_between_them() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = folder.path().join("rough.obj");
    std::fs::write(&mesh, rough_obj()).expect("writable");
    let out = folder.path().join("out");
    let robot = "--robot builtin:quadruped";
    succeeds(
        &format!("plan --mesh @ --goal 1.6,0 {robot} -o @"),
        &[&mesh, &out],
    );
    let plan = read_json(out.join("plan.json"));
    let last = plan["stances"].as_array().and_then(|s| s.last());
    let contacts = last
        .and_then(|s| s["contacts"].as_array())
        .expect("contacts");
    let on_rough = |c: &&Value| number(&c["X_WC"]["p"][0]) > 0.6;
    let touched: Vec<&Value> = contacts.iter().filter(on_rough).collect();
    assert!(touched.len() >= 3, "{} feet on triangles", touched.len());
    // A post beside one of the feet is not ground that rises gently.
    let at = |axis: usize, by: f64| number(&touched[0]["X_WC"]["p"][axis]) + by;
    let corners = [0.03, 0.06].into_iter().flat_map(|x| {
        let of = move |y: f64| [-0.05, 0.05].map(|z| [at(0, x), at(1, y), at(2, z)]);
        [-0.02, 0.02].into_iter().flat_map(of)
    });
    let mut falsified = plan.clone();
    let post = json!({ "id": "post", "points_W": corners.collect::<Vec<_>>() });
    let obstacles = falsified["obstacles"]
        .as_array_mut()
        .expect("a mesh has bodies");
    obstacles.push(post);
    let file = out.join("falsified.json");
    std::fs::write(&file, falsified.to_string()).expect("writable");
    let words = ["obstacle post: clearance"];
    ends_with(&format!("verify @ {robot}"), &[&file], 1, &words);
}
