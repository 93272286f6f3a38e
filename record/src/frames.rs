//! Depth frames of known worlds, with the face that every pixel sees.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};
use nalgebra::{Isometry3, Point3, Rotation3, Vector3};
use scenes::simulator::{DepthNoise, Scan, XTION, scan};
use scenes::{Face, OrientedBox, SceneFile, Truth};
use surfaces::outline::Outline;

/// One frame.
pub struct Frame {
    /// `NOISE_WORLD_SEED`.
    pub name: String,
    /// What stands there.
    pub truth: Truth,
    /// The optical frame V (x right, y down, z forward) in W.
    pub X_WV: Isometry3<f64>,
    /// The image.
    pub scan: Scan,
}

/// The frames of the worlds `irregular-stairs`, `slope-and-hand` and `concave` (an L, a U and a table
/// with a box on it), each with white noise and with a real sensor's, for the seeds 1 … `seeds`.
pub fn frames(seeds: u64) -> Result<Vec<Frame>> {
    let real = DepthNoise::default();
    let white = DepthNoise {
        distortion: 0.0,
        correlation_px: 0.8,
        ..DepthNoise::default()
    };
    let mut frames = Vec::new();
    for (world, truth, pose) in worlds()? {
        for (kind, noise) in [("white", &white), ("real", &real)] {
            for seed in 1..=seeds {
                frames.push(Frame {
                    name: format!("{kind}_{world}_{seed}"),
                    truth: truth.clone(),
                    X_WV: pose,
                    scan: scan(&truth.world(), &XTION, &pose, noise, seed),
                });
            }
        }
    }
    Ok(frames)
}

/// A name, what stands there, and from where it is seen.
type World = (&'static str, Truth, Isometry3<f64>);

fn worlds() -> Result<Vec<World>> {
    let mut worlds = Vec::new();
    for name in ["irregular-stairs", "slope-and-hand"] {
        let scene = scenes::builtin(name).context("a scene that ships")?;
        let file = SceneFile::parse(scene.toml)?;
        let source = file.scan.first().context("a scan")?;
        worlds.push((name, (scene.truth)(), source.X_WV()));
    }
    let pose = worlds.first().context("a world")?.2;
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
pub fn groups(faces: &[Face]) -> Vec<usize> {
    let mut group: Vec<usize> = (0..faces.len()).collect();
    for (i, a) in faces.iter().enumerate() {
        for (j, b) in faces.iter().enumerate().skip(i + 1) {
            let coplanar = a.normal_W.dot(&b.normal_W) > 1.0 - 1e-9
                && (a.offset_m - b.offset_m).abs() < 1e-6
                && a.body != b.body;
            if coplanar && touch(a, b) {
                let (from, to) = (group[i].max(group[j]), group[i].min(group[j]));
                let joined = group.iter_mut().filter(|g| **g == from);
                joined.for_each(|g| *g = to);
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
        let sum: Vector3<f64> = face.vertices_W.iter().map(|p| p.coords).sum();
        let middle = sum / 4.0;
        let wide = |p: &Point3<f64>| p.coords + (p.coords - middle).normalize() * 1.5e-3;
        let corner = |p: &Point3<f64>| [x.dot(&wide(p)), y.dot(&wide(p))];
        Outline::from_rings(&[face.vertices_W.iter().map(corner).collect()])
    };
    flat(a).union(&flat(b)).parts().len() == 1
}

/// Writes the points in the optical frame: `organised` row by row as the image has them, NaN where
/// nothing was measured, else only those that were.
pub fn write_pcd(path: &Path, scan: &Scan, organised: bool) -> Result<()> {
    let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
    let points = (scan.depth_mm.iter().enumerate()).filter(|(_, mm)| organised || **mm > 0);
    let (width, height) = match organised {
        true => (scan.camera.width, scan.camera.height),
        false => (points.clone().count(), 1),
    };
    write!(
        file,
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {width}\n\
         HEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
        width * height
    )?;
    for (i, mm) in points {
        let p = match mm {
            0 => Vector3::repeat(f64::NAN),
            _ => ray(scan, i) * (f64::from(*mm) / 1000.0),
        };
        for c in p.iter() {
            file.write_all(&(*c as f32).to_le_bytes())?;
        }
    }
    Ok(())
}

/// Direction of the i-th pixel in V, its z component 1.
pub fn ray(scan: &Scan, i: usize) -> Vector3<f64> {
    let width = scan.camera.width;
    scan.camera.ray((i % width) as f64, (i / width) as f64)
}

/// A pose as the command line takes it.
pub fn pose(X_WV: &Isometry3<f64>) -> String {
    let (p, q) = (X_WV.translation.vector, X_WV.rotation);
    format!("{},{},{},{},{},{},{}", p.x, p.y, p.z, q.i, q.j, q.k, q.w)
}
