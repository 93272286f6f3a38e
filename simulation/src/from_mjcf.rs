//! A robot out of MuJoCo's model text (MJCF): compiled by MuJoCo, and written as the URDF and SRDF that stand
//! for it.
//!
//! | of the model | becomes |
//! |---|---|
//! | the tree with the most joints | the robot; its root floats, whatever joins it to the world |
//! | bodies, sites | links of their names and frames |
//! | hinges and slides | joints of their names, whose values are the model's |
//! | joints that equalities tie to others | mimics |
//! | geoms that collide, in general or in listed pairs | collision shapes |
//! | excluded pairs of bodies, keyframes | disabled pairs and named postures |
//!
//! `from_mjcf/robot.urdf` and `from_mjcf/robot.srdf` are the templates of the texts.

mod drive;
mod geom;
mod joint;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use mujoco_rs::prelude::*;
use nalgebra::{Isometry3, Quaternion, UnitQuaternion};
use robot_model::load::Document;
use serde_json::{Value, json};

use crate::Error;
use drive::Drive;
use joint::fixed;

/// The robot of a model file.
///
/// # Errors
/// [`Error::MuJoCo`] where the file is no model; [`Error::Robot`] where it holds no robot, or several.
pub fn document(path: &Path) -> Result<Document, Error> {
    let model = MjModel::from_xml(path);
    let model = model.map_err(|e| Error::MuJoCo(format!("{}: {e}", path.display())))?;
    let (root, mut notes) =
        root(&model).map_err(|cause| Error::Robot(format!("{}: {cause}", path.display())))?;
    let mut writer = Writer {
        bodies: of_tree(&model, root),
        drives: drive::drives(&model),
        model: &model,
        links: Vec::new(),
        joints: Vec::new(),
        meshes: BTreeMap::new(),
        lists: BTreeMap::new(),
    };
    writer.tree(root);
    writer.loops();
    let name: Vec<u8> = model
        .names()
        .iter()
        .map(|&c| c as u8)
        .take_while(|&c| c != 0)
        .collect();
    let name = String::from_utf8_lossy(&name);
    let unnamed = name.is_empty() || name == "MuJoCo Model";
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = if unnamed { stem } else { name };
    let srdf =
        json!({ "name": name, "pairs": writer.excluded(), "postures": writer.keyframes(root) });
    let urdf = json!({ "name": name, "links": writer.links, "joints": writer.joints });
    let lists = writer.lists.iter();
    notes.extend(lists.map(|(what, of)| format!("{what}: {}", of.join(", "))));
    Ok(Document {
        urdf: render(include_str!("from_mjcf/robot.urdf"), urdf)?,
        srdf: render(include_str!("from_mjcf/robot.srdf"), srdf)?,
        meshes: writer.meshes,
        notes,
    })
}

/// The body whose tree has the most joints beside those of the body itself, and what is left out.
fn root(model: &MjModel) -> Result<(usize, Vec<String>), String> {
    let joints = |root: usize| -> usize {
        let below = of_tree(model, root).into_iter().filter(|&b| b != root);
        below.map(|b| model.body_jntnum()[b] as usize).sum()
    };
    let roots = (1..model.body_parentid().len()).filter(|&b| model.body_parentid()[b] == 0);
    let mut roots: Vec<(usize, usize)> = roots.map(|b| (joints(b), b)).collect();
    roots.sort_by_key(|&(joints, body)| (std::cmp::Reverse(joints), body));
    let named = |of: &[(usize, usize)]| -> String {
        let names: Vec<String> = of.iter().map(|r| body_name(model, r.1)).collect();
        names.join(", ")
    };
    match roots.as_slice() {
        [] | [(0, _), ..] => {
            Err("no body has joints to others: there is no robot in it".to_owned())
        }
        [(a, _), (b, _), ..] if a == b => {
            let named = named(&roots[..2]);
            Err(format!(
                "{named} have as many joints each: a file of the one robot is wanted"
            ))
        }
        [(_, root), others @ ..] => {
            let mut notes = vec!["read from MJCF, as MuJoCo compiles it".to_owned()];
            if !others.is_empty() {
                notes.push(format!(
                    "bodies beside the robot are left out: {}",
                    named(others)
                ));
            }
            Ok((*root, notes))
        }
    }
}

/// A body and all below it, as the model has them: depth first.
fn of_tree(model: &MjModel, root: usize) -> Vec<usize> {
    let mut inside = BTreeSet::from([root]);
    for (body, &parent) in model.body_parentid().iter().enumerate() {
        if body > root && inside.contains(&(parent as usize)) {
            inside.insert(body);
        }
    }
    inside.into_iter().collect()
}

fn body_name(model: &MjModel, body: usize) -> String {
    let name = model.id_to_name(MjtObjBase::mjOBJ_BODY, body);
    name.map_or_else(|| format!("body_{body}"), str::to_owned)
}

/// Writes links and joints.
struct Writer<'a> {
    model: &'a MjModel,
    bodies: Vec<usize>,
    drives: Vec<Drive>,
    links: Vec<Value>,
    joints: Vec<Value>,
    meshes: BTreeMap<String, Vec<u8>>,
    /// What was approximated of which things.
    lists: BTreeMap<&'static str, Vec<String>>,
}

impl Writer<'_> {
    fn note(&mut self, what: &'static str, thing: String) {
        self.lists.entry(what).or_default().push(thing);
    }

    fn joint_name(&self, joint: usize) -> String {
        let name = self.model.id_to_name(MjtObjBase::mjOBJ_JOINT, joint);
        name.map_or_else(|| format!("joint_{joint}"), str::to_owned)
    }

    fn tree(&mut self, root: usize) {
        let mut names = BTreeSet::new();
        let shown = geom::none_collides(self.model, &self.bodies);
        for body in self.bodies.clone() {
            let name = body_name(self.model, body);
            if body == root {
                self.base(root);
            } else {
                self.chain(body, &name);
            }
            let shapes = self.shapes(body, shown);
            let inertial = self.inertial(body);
            self.links
                .push(json!({ "name": name, "inertial": inertial, "shapes": shapes }));
            names.insert(name);
        }
        // Frames that others name: those of sites.
        for (site, &body) in self.model.site_bodyid().iter().enumerate() {
            let name = self.model.id_to_name(MjtObjBase::mjOBJ_SITE, site);
            let (true, Some(name)) = (self.bodies.contains(&(body as usize)), name) else {
                continue;
            };
            if names.insert(name.to_owned()) {
                self.links.push(json!({ "name": name }));
                let X_BS = isometry(&self.model.site_pos()[site], &self.model.site_quat()[site]);
                let body = body_name(self.model, body as usize);
                self.joints.push(fixed(&body, name, &X_BS));
            }
        }
    }

    /// Notes what joins the base to the world, and is no joint of the robot's.
    fn base(&mut self, root: usize) {
        for joint in self.joints_of(root) {
            if self.model.jnt_type()[joint] != MjtJoint::mjJNT_FREE {
                let name = self.joint_name(joint);
                self.note(
                    "joints between base and world are dropped, the base floats",
                    name,
                );
            }
        }
        let q = self.model.body_quat()[root];
        let tilted = 2.0 * (q[1] * q[1] + q[2] * q[2]) > 1e-6;
        if tilted {
            let what =
                "the base is turned in the model; its own axes are taken for x ahead and z up";
            self.note(what, body_name(self.model, root));
        }
    }

    fn joints_of(&self, body: usize) -> std::ops::Range<usize> {
        let (first, count) = (
            self.model.body_jntadr()[body],
            self.model.body_jntnum()[body],
        );
        let first = first.max(0) as usize;
        first..first + count as usize
    }

    fn inertial(&self, body: usize) -> Option<Value> {
        let model = self.model;
        let mass = model.body_mass()[body];
        let X_BI = isometry(&model.body_ipos()[body], &model.body_iquat()[body]);
        let moments = model.body_inertia()[body].map(|m| m.to_string());
        (mass > 0.0).then(
            || json!({ "origin": origin(&X_BI), "mass": mass.to_string(), "moments": moments }),
        )
    }

    /// Notes constraints that a tree of joints does not keep.
    fn loops(&mut self) {
        let model = self.model;
        for (k, kind) in model.eq_type().iter().enumerate() {
            if *kind != MjtEq::mjEQ_JOINT && model.eq_active0()[k] {
                let name = model.id_to_name(MjtObjBase::mjOBJ_EQUALITY, k);
                let name = name.map_or_else(|| format!("equality {k}"), str::to_owned);
                self.note("constraints between bodies or tendons are not kept", name);
            }
        }
    }

    fn excluded(&self) -> Vec<[String; 2]> {
        let pairs = self
            .model
            .exclude_signature()
            .iter()
            .map(|&s| [s >> 16, s & 0xffff]);
        let inside = pairs.filter(|pair| pair.iter().all(|&b| self.bodies.contains(&(b as usize))));
        inside
            .map(|pair| pair.map(|b| body_name(self.model, b as usize)))
            .collect()
    }

    /// Name and joint values of each keyframe.
    fn keyframes(&self, root: usize) -> Vec<(String, Vec<(String, String)>)> {
        let model = self.model;
        let bodies = self.bodies.iter().filter(|&&b| b != root);
        let joints: Vec<usize> = bodies.flat_map(|&b| self.joints_of(b)).collect();
        let joints = joints.into_iter().filter(|&j| {
            let moves =
                [MjtJoint::mjJNT_HINGE, MjtJoint::mjJNT_SLIDE].contains(&model.jnt_type()[j]);
            moves && self.drives[j] != Drive::None && drive::leader(model, j).is_none()
        });
        let joints: Vec<usize> = joints.collect();
        let nq = model.qpos0().len();
        let keys = model
            .key_qpos()
            .chunks(nq.max(1))
            .enumerate()
            .map(|(k, q)| {
                let name = model.id_to_name(MjtObjBase::mjOBJ_KEY, k);
                let name = name.map_or_else(|| format!("key_{k}"), str::to_owned);
                let value = |&j: &usize| {
                    (
                        self.joint_name(j),
                        q[model.jnt_qposadr()[j] as usize].to_string(),
                    )
                };
                (name, joints.iter().map(value).collect())
            });
        keys.collect()
    }
}

fn isometry(p: &[f64; 3], q: &[f64; 4]) -> Isometry3<f64> {
    let q = UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3]));
    Isometry3::from_parts((*p).into(), q)
}

/// Position, m, and roll, pitch, yaw, rad.
fn origin(X: &Isometry3<f64>) -> [String; 2] {
    let (roll, pitch, yaw) = X.rotation.euler_angles();
    [
        numbers(X.translation.vector.as_slice()),
        numbers(&[roll, pitch, yaw]),
    ]
}

fn numbers(values: &[f64]) -> String {
    let words: Vec<String> = values.iter().map(f64::to_string).collect();
    words.join(" ")
}

/// Fills a template of XML in.
fn render(template: &str, said: Value) -> Result<String, Error> {
    let said = minijinja::value::Serde(said);
    let text = minijinja::Environment::new().render_named_str("robot.xml", template, said);
    text.map_err(|e| Error::Robot(e.to_string()))
}
