//! Frames as files with their truth, for other tools to be scored on.
//!
//! | file | what is in it |
//! |---|---|
//! | `NAME_depth.png` | depth, mm |
//! | `NAME.pcd` | the same as an organised cloud in the optical frame |
//! | `NAME_gt.bin` | of every pixel its face (−1: none), `i16`, then its true depth (m), `f32` |
//! | `NAME_gt.json` | intrinsics, pose, faces (coplanar ones that touch are one) and boxes |

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Result;
use serde_json::json;

use crate::frames::{Frame, groups, write_pcd};

/// Writes all frames into a folder.
pub fn write(folder: &Path, frames: &[Frame]) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    (frames.iter()).try_for_each(|frame| write_frame(&folder.join(&frame.name), frame))
}

#[allow(non_snake_case)]
fn write_frame(stem: &Path, frame: &Frame) -> Result<()> {
    let Frame {
        truth,
        X_WV,
        scan: shot,
        ..
    } = frame;
    let path = |end: &str| PathBuf::from(format!("{}{end}", stem.display()));
    let file = |end: &str| std::fs::File::create(path(end)).map(std::io::BufWriter::new);
    std::fs::write(path("_depth.png"), shot.png()?)?;
    write_pcd(&path(".pcd"), shot, true)?;

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
