//! Takes depth frames with their ground truth, to compare ways of finding surfaces by.
//!
//! ```sh
//! cargo run --release -p scenes --example make_frames FOLDER [SEEDS]
//! ```
//!
//! writes for the worlds `irregular-stairs`, `slope-and-hand` and `concave` (an L, a U and a table
//! with a box on it), each with white noise and with a real sensor's, and for every seed
//!
//! | file | what is in it |
//! |---|---|
//! | `NAME_depth.png` | depth, mm |
//! | `NAME.pcd` | the same as an organised cloud in the optical frame |
//! | `NAME_gt.bin` | of every pixel its face (−1: none), `i16`, then its true depth (m), `f32` |
//! | `NAME_gt.json` | intrinsics, pose, faces (coplanar ones that touch are one) and boxes |

use std::io::Write;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Point3, Rotation3, Vector3};
use scenes::simulator::{DepthNoise, Scan, XTION, scan};
use scenes::{Face, OrientedBox, SceneFile, Truth};
use serde_json::json;
use surfaces::outline::Outline;

type AnyError = Box<dyn std::error::Error>;

fn main() -> Result<(), AnyError> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let folder = PathBuf::from(args.first().ok_or("usage: make_frames FOLDER [SEEDS]")?);
    let seeds: u64 = args.get(1).map_or(Ok(3), |text| text.parse())?;
    std::fs::create_dir_all(&folder)?;
    let real = DepthNoise::default();
    let white = DepthNoise {
        distortion: 0.0,
        correlation_px: 0.8,
        ..DepthNoise::default()
    };
    for (world, truth, pose) in worlds()? {
        for (kind, noise) in [("white", &white), ("real", &real)] {
            for seed in 1..=seeds {
                let shot = scan(&truth.world(), &XTION, &pose, noise, seed);
                let name = format!("{kind}_{world}_{seed}");
                write(&folder.join(name), &truth, &pose, &shot)?;
            }
        }
    }
    Ok(())
}

/// A name, what stands there, and from where it is seen.
type World = (&'static str, Truth, Isometry3<f64>);

fn worlds() -> Result<Vec<World>, AnyError> {
    let mut worlds = Vec::new();
    for name in ["irregular-stairs", "slope-and-hand"] {
        let scene = scenes::builtin(name).ok_or("a scene that ships")?;
        let file = SceneFile::parse(scene.toml)?;
        let source = file.scan.first().ok_or("a scan")?;
        worlds.push((name, (scene.truth)(), source.X_WV()));
    }
    let pose = worlds.first().ok_or("a world")?.2;
    worlds.push(("concave", concave(), pose));
    Ok(worlds)
}

/// A floor with an L of two slabs, a U of three, and a table with a box on it.
fn concave() -> Truth {
    let slab = |name: &str, centre: [f64; 3], size: [f64; 3], yaw: f64| {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw);
        OrientedBox::new(name, turn * Vector3::from(centre), size, turn)
    };
    let boxes = vec![
        slab("floor", [3.0, 0.0, -0.05], [12.0, 12.0, 0.1], 0.0),
        slab("wall", [4.3, 0.0, 1.5], [0.1, 12.0, 3.0], 0.0),
        slab("l long", [1.5, 0.55, 0.1], [0.9, 0.35, 0.2], 0.1),
        slab("l short", [1.775, 0.175, 0.1], [0.35, 0.4, 0.2], 0.1),
        slab("u right", [1.5, -0.95, 0.15], [0.9, 0.25, 0.3], 0.0),
        slab("u far", [1.825, -0.625, 0.15], [0.25, 0.4, 0.3], 0.0),
        slab("u left", [1.5, -0.3, 0.15], [0.9, 0.25, 0.3], 0.0),
        slab("table", [2.8, 0.2, 0.6], [0.9, 1.6, 0.04], 0.0),
        slab("box on table", [2.8, 0.1, 0.72], [0.3, 0.3, 0.2], 0.05),
    ];
    Truth {
        scene: "concave".into(),
        boxes,
    }
}

/// The group of every face: the first of the coplanar ones that it touches.
fn groups(faces: &[Face]) -> Vec<usize> {
    let mut group: Vec<usize> = (0..faces.len()).collect();
    for (i, a) in faces.iter().enumerate() {
        for (j, b) in faces.iter().enumerate().skip(i + 1) {
            let coplanar = a.normal_W.dot(&b.normal_W) > 1.0 - 1e-9
                && (a.offset_m - b.offset_m).abs() < 1e-6
                && a.body != b.body;
            if coplanar && touch(a, b) {
                let (from, to) = (group[i].max(group[j]), group[i].min(group[j]));
                group
                    .iter_mut()
                    .filter(|g| **g == from)
                    .for_each(|g| *g = to);
            }
        }
    }
    group
}

/// Whether two coplanar faces touch: their union, each wider by a millimetre, is one part.
fn touch(a: &Face, b: &Face) -> bool {
    let Some(x) = (a.vertices_W[1] - a.vertices_W[0]).try_normalize(1e-9) else {
        return false;
    };
    let y = a.normal_W.cross(&x);
    let flat = |face: &Face| {
        let middle = face
            .vertices_W
            .iter()
            .map(|p| p.coords)
            .sum::<Vector3<f64>>()
            / 4.0;
        let wide = |p: &Point3<f64>| p.coords + (p.coords - middle).normalize() * 1.5e-3;
        let corner = |p: &Point3<f64>| [x.dot(&wide(p)), y.dot(&wide(p))];
        Outline::from_rings(&[face.vertices_W.iter().map(corner).collect()])
    };
    flat(a).union(&flat(b)).parts().len() == 1
}

#[allow(non_snake_case)]
fn write(stem: &Path, truth: &Truth, X_WV: &Isometry3<f64>, shot: &Scan) -> Result<(), AnyError> {
    let file = |end: &str| {
        let path = format!("{}{end}", stem.display());
        std::fs::File::create(path).map(std::io::BufWriter::new)
    };
    let (width, height) = (shot.camera.width, shot.camera.height);

    let mut png = png::Encoder::new(file("_depth.png")?, width as u32, height as u32);
    png.set_color(png::ColorType::Grayscale);
    png.set_depth(png::BitDepth::Sixteen);
    let bytes: Vec<u8> = shot.depth_mm.iter().flat_map(|v| v.to_be_bytes()).collect();
    png.write_header()?.write_image_data(&bytes)?;

    let mut pcd = file(".pcd")?;
    write!(
        pcd,
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {width}\n\
         HEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
        width * height
    )?;
    for (i, mm) in shot.depth_mm.iter().enumerate() {
        let z = f64::from(*mm) / 1000.0;
        let ray = shot.camera.ray((i % width) as f64, (i / width) as f64);
        let p = if *mm > 0 {
            ray * z
        } else {
            Vector3::repeat(f64::NAN)
        };
        for c in p.iter() {
            pcd.write_all(&(*c as f32).to_le_bytes())?;
        }
    }

    let faces = truth.faces();
    let groups = groups(&faces);
    let mut pixels = file("_gt.bin")?;
    for face in &shot.face {
        let label = face.map_or(-1, |face| groups[face] as i16);
        pixels.write_all(&label.to_le_bytes())?;
    }
    for z in &shot.true_depth_m {
        pixels.write_all(&(*z as f32).to_le_bytes())?;
    }

    let X_VW = X_WV.inverse();
    let surfaces: Vec<serde_json::Value> = (0..faces.len())
        .filter(|&g| groups[g] == g)
        .map(|g| {
            let face = &faces[g];
            let members = || (0..faces.len()).filter(|&i| groups[i] == g);
            let n_V = X_VW.rotation * face.normal_W;
            let on_V = X_VW * face.vertices_W[0];
            let corners = |i: usize| -> Vec<[f64; 3]> {
                faces[i].vertices_W.iter().map(|p| (*p).into()).collect()
            };
            let body = |i: usize| truth.boxes.iter().position(|b| b.name == faces[i].body);
            json!({
                "id": g,
                "name": face.name,
                "normal_w": <[f64; 3]>::from(face.normal_W),
                "point_w": <[f64; 3]>::from(face.vertices_W[0]),
                "plane_cam": [n_V.x, n_V.y, n_V.z, -n_V.dot(&on_V.coords)],
                "quads_w": members().map(corners).collect::<Vec<_>>(),
                "boxes": members().filter_map(body).collect::<Vec<_>>(),
            })
        })
        .collect();
    let rows = |m: nalgebra::Matrix3<f64>| [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]));
    let boxes: Vec<serde_json::Value> = (truth.boxes.iter())
        .map(|b| {
            let X_WO = b.X_WO();
            json!({
                "name": b.name,
                "c": b.position_m,
                "h": b.size_m.map(|s| s / 2.0),
                "R": rows(X_WO.rotation.to_rotation_matrix().into_inner()),
            })
        })
        .collect();
    let camera = &shot.camera;
    let all = json!({
        "K": [camera.fx, camera.fy, camera.cx, camera.cy],
        "R_wc": rows(X_WV.rotation.to_rotation_matrix().into_inner()),
        "t_wc": <[f64; 3]>::from(X_WV.translation.vector),
        "surfaces": surfaces,
        "boxes": boxes,
    });
    serde_json::to_writer(file("_gt.json")?, &all)?;
    Ok(())
}
