//! What a URDF file says, word for word: no defaults filled in that it does not state.
//!
//! Read straight from the XML so that every complaint has its line, an absent element differs
//! from a zero one, and a number that is none is refused.

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::xml::{Source, child, children};
use crate::Error;

pub(super) struct Urdf {
    pub name: String,
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
}

pub(super) struct Link {
    pub name: String,
    pub inertial: Option<Inertial>,
    pub collisions: Vec<Collision>,
}

pub(super) struct Inertial {
    pub pose: Isometry3<f64>,
    pub mass_kg: f64,
    pub inertia: Matrix3<f64>,
}

pub(super) struct Collision {
    pub pose: Isometry3<f64>,
    pub geometry: Geometry,
}

/// A collision geometry in URDF's own measures: full sizes and lengths.
pub(super) enum Geometry {
    Box { size: [f64; 3] },
    Cylinder { radius: f64, length: f64 },
    Capsule { radius: f64, length: f64 },
    Sphere { radius: f64 },
    Mesh { filename: String, scale: [f64; 3] },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum JointType {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Floating,
}

pub(super) struct Joint {
    pub name: String,
    pub kind: JointType,
    pub parent: String,
    pub child: String,
    pub pose: Isometry3<f64>,
    pub axis: Vector3<f64>,
    pub limit: Option<Limit>,
    pub mimic: Option<Mimic>,
    /// Line of the joint's element.
    pub line: u32,
}

pub(super) struct Limit {
    pub lower: f64,
    pub upper: f64,
    pub effort: Option<f64>,
    pub velocity: Option<f64>,
}

pub(super) struct Mimic {
    pub joint: String,
    pub offset: f64,
}

/// Reads the text of a URDF.
///
/// # Errors
/// [`Error::Parse`] with the line; what the links and joints amount to is checked elsewhere.
pub(super) fn parse(file: &str, text: &str) -> Result<Urdf, Error> {
    let source = Source::parse(file, text)?;
    let robot = source.robot()?;
    let links = children(robot, "link")
        .map(|n| link(&source, n))
        .collect::<Result<Vec<_>, _>>()?;
    // Joints of <transmission> and <gazebo> elements lie deeper and are none.
    let joints = children(robot, "joint")
        .map(|n| joint(&source, n))
        .collect::<Result<Vec<_>, _>>()?;
    if links.is_empty() {
        let is_xacro = text.contains("xacro");
        let hint = if is_xacro {
            "; it is a xacro file: expand it first"
        } else {
            ""
        };
        return Err(source.refuse(robot, format!("there is no <link>{hint}")));
    }
    let name = robot.attribute("name").unwrap_or("robot").to_owned();
    Ok(Urdf {
        name,
        links,
        joints,
    })
}

fn link(source: &Source, node: Node) -> Result<Link, Error> {
    let name = source.text(node, "name")?.to_owned();
    let inertial = child(node, "inertial")
        .map(|n| inertial(source, n))
        .transpose()?;
    let collisions = children(node, "collision")
        .map(|n| collision(source, n))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Link {
        name,
        inertial,
        collisions,
    })
}

fn inertial(source: &Source, node: Node) -> Result<Inertial, Error> {
    let mass =
        child(node, "mass").ok_or_else(|| source.refuse(node, "<inertial> has no <mass>"))?;
    let mut inertia = Matrix3::zeros();
    // A point mass may leave its inertia out.
    if let Some(tensor) = child(node, "inertia") {
        let rows = [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2)];
        for (name, i, j) in rows
            .into_iter()
            .chain([("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)])
        {
            let value = source.optional_number(tensor, name)?.unwrap_or(0.0);
            inertia[(i, j)] = value;
            inertia[(j, i)] = value;
        }
    }
    Ok(Inertial {
        pose: origin(source, node)?,
        mass_kg: source.number(mass, "value")?,
        inertia,
    })
}

fn collision(source: &Source, node: Node) -> Result<Collision, Error> {
    let shape = child(node, "geometry")
        .and_then(|geometry| geometry.children().find(Node::is_element))
        .ok_or_else(|| source.refuse(node, "<collision> has no geometry"))?;
    let length = |name: &str| source.number(shape, name);
    let geometry = match shape.tag_name().name() {
        "box" => {
            let size = source.optional_triple(shape, "size")?;
            let size = size.ok_or_else(|| source.refuse(shape, "<box> has no \"size\""))?;
            Geometry::Box { size }
        }
        "cylinder" => Geometry::Cylinder {
            radius: length("radius")?,
            length: length("length")?,
        },
        "capsule" => Geometry::Capsule {
            radius: length("radius")?,
            length: length("length")?,
        },
        "sphere" => Geometry::Sphere {
            radius: length("radius")?,
        },
        "mesh" => Geometry::Mesh {
            filename: source.text(shape, "filename")?.to_owned(),
            scale: source.optional_triple(shape, "scale")?.unwrap_or([1.0; 3]),
        },
        other => return Err(source.refuse(shape, format!("unknown geometry <{other}>"))),
    };
    Ok(Collision {
        pose: origin(source, node)?,
        geometry,
    })
}

fn joint(source: &Source, node: Node) -> Result<Joint, Error> {
    let kind = match source.text(node, "type")? {
        "fixed" => JointType::Fixed,
        "revolute" => JointType::Revolute,
        "continuous" => JointType::Continuous,
        "prismatic" => JointType::Prismatic,
        "floating" => JointType::Floating,
        other => {
            let cause = format!("joints of type \"{other}\" are not supported");
            return Err(source.refuse(node, cause));
        }
    };
    let end = |tag: &'static str| {
        child(node, tag)
            .ok_or_else(|| source.refuse(node, format!("<joint> has no <{tag}>")))
            .and_then(|n| Ok(source.text(n, "link")?.to_owned()))
    };
    let axis = child(node, "axis")
        .map(|n| source.optional_triple(n, "xyz"))
        .transpose()?
        .flatten();
    let limit = child(node, "limit").map(|n| limit(source, n)).transpose()?;
    let mimic = child(node, "mimic")
        .map(|n| -> Result<_, Error> {
            let offset = source.optional_number(n, "offset")?.unwrap_or(0.0);
            Ok(Mimic {
                joint: source.text(n, "joint")?.to_owned(),
                offset,
            })
        })
        .transpose()?;
    Ok(Joint {
        name: source.text(node, "name")?.to_owned(),
        kind,
        parent: end("parent")?,
        child: end("child")?,
        pose: origin(source, node)?,
        axis: Vector3::from(axis.unwrap_or([1.0, 0.0, 0.0])),
        limit,
        mimic,
        line: source.document.text_pos_at(node.range().start).row,
    })
}

fn limit(source: &Source, node: Node) -> Result<Limit, Error> {
    Ok(Limit {
        lower: source.optional_number(node, "lower")?.unwrap_or(0.0),
        upper: source.optional_number(node, "upper")?.unwrap_or(0.0),
        effort: source.optional_number(node, "effort")?,
        velocity: source.optional_number(node, "velocity")?,
    })
}

/// The `<origin>` of a node: the identity where there is none.
fn origin(source: &Source, node: Node) -> Result<Isometry3<f64>, Error> {
    let Some(origin) = child(node, "origin") else {
        return Ok(Isometry3::identity());
    };
    let xyz = source.optional_triple(origin, "xyz")?.unwrap_or([0.0; 3]);
    let [roll, pitch, yaw] = source.optional_triple(origin, "rpy")?.unwrap_or([0.0; 3]);
    Ok(Isometry3::from_parts(
        Translation3::from(Vector3::from(xyz)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    ))
}
