//! Geoms as shapes of links.

use std::f64::consts::{PI, TAU};

use mujoco_rs::prelude::*;
use serde_json::{Value, json};

use super::{Writer, body_name, isometry, numbers, origin};

/// Turns of an ellipsoid's hull from pole to pole and around.
const TURNS: [usize; 2] = [12, 24];
/// What brings the hull of these points around the ellipsoid.
const AROUND: f64 = 1.02;

/// Whether no geom of these bodies collides with anything.
pub(super) fn none_collides(model: &MjModel, bodies: &[usize]) -> bool {
    let geoms = bodies.iter().flat_map(|&b| geoms_of(model, b));
    !geoms.into_iter().any(|g| collides(model, g))
}

fn geoms_of(model: &MjModel, body: usize) -> std::ops::Range<usize> {
    let (first, count) = (model.body_geomadr()[body], model.body_geomnum()[body]);
    let first = first.max(0) as usize;
    first..first + count as usize
}

fn collides(model: &MjModel, geom: usize) -> bool {
    let listed = |of: &[i32]| of.contains(&(geom as i32));
    model.geom_contype()[geom] != 0
        || model.geom_conaffinity()[geom] != 0
        || listed(model.pair_geom1())
        || listed(model.pair_geom2())
}

impl Writer<'_> {
    /// The shapes of a body that collide, or those that are `shown`.
    pub(super) fn shapes(&mut self, body: usize, shown: bool) -> Vec<Value> {
        let model = self.model;
        let geoms = geoms_of(model, body).filter(|&g| shown || collides(model, g));
        let geoms: Vec<usize> = geoms.collect();
        if geoms.is_empty() && model.body_geomnum()[body] > 0 {
            self.note(
                "links show shapes that collide with nothing and have none",
                body_name(model, body),
            );
        }
        let shapes = geoms.into_iter().filter_map(|geom| {
            let (kind, sizes) = self.form(geom, body)?;
            let X_BG = isometry(&model.geom_pos()[geom], &model.geom_quat()[geom]);
            let role = if shown { "visual" } else { "collision" };
            Some(json!({ "role": role, "kind": kind, "origin": origin(&X_BG), "sizes": sizes }))
        });
        shapes.collect()
    }

    /// The URDF's element for a geom, and its attributes.
    fn form(
        &mut self,
        geom: usize,
        body: usize,
    ) -> Option<(&'static str, Vec<(&'static str, String)>)> {
        let model = self.model;
        let size = model.geom_size()[geom];
        let round = || {
            vec![
                ("radius", size[0].to_string()),
                ("length", (2.0 * size[1]).to_string()),
            ]
        };
        let kind = model.geom_type()[geom];
        Some(match kind {
            MjtGeomBase::mjGEOM_SPHERE => ("sphere", vec![("radius", size[0].to_string())]),
            MjtGeomBase::mjGEOM_CAPSULE => ("capsule", round()),
            MjtGeomBase::mjGEOM_CYLINDER => ("cylinder", round()),
            MjtGeomBase::mjGEOM_BOX => {
                ("box", vec![("size", numbers(&size.map(|half| 2.0 * half)))])
            }
            MjtGeomBase::mjGEOM_ELLIPSOID => {
                self.note(
                    "ellipsoids are taken for hulls up to 2 % larger",
                    body_name(model, body),
                );
                let name = format!("ellipsoid {geom}.stl");
                self.meshes.insert(name.clone(), stl(&ellipsoid(&size)));
                ("mesh", vec![("filename", name)])
            }
            MjtGeomBase::mjGEOM_MESH | MjtGeomBase::mjGEOM_SDF => {
                let mesh = model.geom_dataid()[geom] as usize;
                let name = model.id_to_name(MjtObjBase::mjOBJ_MESH, mesh);
                let name = format!("{} (mesh {mesh}).stl", name.unwrap_or_default());
                let made = || stl(&triangles(model, mesh));
                self.meshes.entry(name.clone()).or_insert_with(made);
                ("mesh", vec![("filename", name)])
            }
            _ => {
                self.note(
                    "planes and height fields on the robot are left out",
                    body_name(model, body),
                );
                return None;
            }
        })
    }
}

/// The triangles of a mesh as MuJoCo has them, in the geom's frame.
fn triangles(model: &MjModel, mesh: usize) -> Vec<[[f32; 3]; 3]> {
    let first = model.mesh_vertadr()[mesh] as usize;
    let faces = model.mesh_faceadr()[mesh] as usize..;
    let faces = model.mesh_face()[faces]
        .iter()
        .take(model.mesh_facenum()[mesh] as usize);
    faces
        .map(|face| face.map(|v| model.mesh_vert()[first + v as usize]))
        .collect()
}

/// Triangles over points around an ellipsoid of these half axes; only their hull is of use.
fn ellipsoid(half_m: &[f64; 3]) -> Vec<[[f32; 3]; 3]> {
    let [down, around] = TURNS;
    let points = (0..=down).flat_map(|i| {
        (0..around).map(move |k| {
            let (polar, turn) = (PI * i as f64 / down as f64, TAU * k as f64 / around as f64);
            let on = [
                polar.sin() * turn.cos(),
                polar.sin() * turn.sin(),
                polar.cos(),
            ];
            std::array::from_fn(|axis| (AROUND * half_m[axis] * on[axis]) as f32)
        })
    });
    let points: Vec<[f32; 3]> = points.collect();
    points.windows(3).map(|w| [w[0], w[1], w[2]]).collect()
}

/// The bytes of a binary STL file.
fn stl(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}
