//! Reads a URDF: our own pass over the XML, then urdf-rs.
//!
//! urdf-rs knows no line numbers, takes an absent limit for zero, skips the words of a vector that
//! are no numbers, and refuses a file for elements that planning has no use for. So our pass checks
//! every element that is needed (`LINK`, `JOINT` and what they hold), complains with the line, fills
//! in what a file may leave out, and hands a document of these elements alone to urdf-rs.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use roxmltree::Node;

use crate::Error;
use crate::xml::{Source, child, children};

/// What urdf-rs read, and where its joints stand in the file.
pub(super) struct Urdf {
    pub robot: urdf_rs::Robot,
    /// The line of each joint's element, in the order of `robot.joints`.
    pub joint_lines: Vec<u32>,
}

/// Reads the text of a URDF.
///
/// # Errors
/// [`Error::File`] with the line; [`Error::Part`] for a joint without the limits that its type
/// asks for. What the links and joints amount to is checked elsewhere.
pub(super) fn parse(file: &str, text: &str) -> Result<Urdf, Error> {
    let source = Source::parse(file, text)?;
    let root = source.robot()?;
    refuse_xacro(file, &source)?;
    let mut clean = String::from("<robot");
    let name = root.attribute("name").unwrap_or("robot");
    attribute("name", name, &mut clean);
    if let Some(version) = root.attribute("version") {
        attribute("version", version, &mut clean);
    }
    clean.push('>');
    if child(root, "link").is_none() {
        return Err(source.refuse(root, "there is no <link>"));
    }
    // What a robot shows stands for its shapes where no link of it has one.
    let of_links = |tag| children(root, "link").any(|link| child(link, tag).is_some());
    let element = if of_links("collision") {
        &LINK
    } else {
        &SHOWN_LINK
    };
    let mut refused = Vec::new();
    for link in children(root, "link") {
        refused.extend(copy(&source, link, element, &mut clean).err());
    }
    // Joints of <transmission> and <gazebo> elements lie deeper and are none.
    let mut joint_lines = Vec::new();
    for joint in children(root, "joint") {
        refused.extend(check_joint(&source, joint).err());
        refused.extend(copy(&source, joint, &JOINT, &mut clean).err());
        joint_lines.push(source.line(joint));
    }
    Error::all(refused)?;
    clean.push_str("</robot>");
    let robot = urdf_rs::read_from_string(&clean);
    let robot = robot.map_err(|error| Error::file(file, error.to_string()))?;
    Ok(Urdf { robot, joint_lines })
}

/// Refuses what is to be expanded first: macros, properties and values that stand for others. A file
/// that merely names the language, as expanded ones do, is fine.
fn refuse_xacro(file: &str, source: &Source) -> Result<(), Error> {
    let is_macro = |node: &Node| {
        let space = node.tag_name().namespace().unwrap_or_default();
        let stands_for = |a: roxmltree::Attribute| a.value().contains("${");
        node.is_element() && (space.contains("xacro") || node.attributes().any(stands_for))
    };
    let root = source.document.root_element();
    match root.descendants().find(is_macro) {
        None => Ok(()),
        Some(node) => {
            let plain = file.trim_end_matches(".xacro").trim_end_matches(".urdf");
            let cause = format!("this is xacro: expand it first, by `xacro {file} > {plain}.urdf`");
            Err(source.refuse(node, cause))
        }
    }
}

/// The pose that an `<origin>` states.
pub(super) fn pose(origin: &urdf_rs::Pose) -> Isometry3<f64> {
    let ([x, y, z], [roll, pitch, yaw]) = (*origin.xyz, *origin.rpy);
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

/// What an attribute holds: a name, or that many numbers.
#[derive(Clone, Copy)]
enum Value {
    Text,
    Numbers(usize),
}

/// What becomes of an attribute or element that the file does not have.
#[derive(Clone, Copy)]
enum Absent {
    /// The file is refused.
    Refused,
    /// It stays absent; urdf-rs supplies the default of the format.
    Left,
    /// This takes its place.
    Filled(&'static str),
}

use Absent::{Filled, Left, Refused};
use Value::{Numbers, Text};

type Attribute = (&'static str, Value, Absent);

/// An element that is handed on: its tag, attributes and, first of each tag, child elements.
struct Element {
    tag: &'static str,
    absent: Absent,
    attributes: &'static [Attribute],
    children: &'static [Element],
}

const fn leaf(tag: &'static str, absent: Absent, attributes: &'static [Attribute]) -> Element {
    Element {
        tag,
        absent,
        attributes,
        children: &[],
    }
}

const LINK: Element = Element {
    tag: "link",
    absent: Left,
    attributes: &[("name", Text, Refused)],
    children: &[INERTIAL, COLLISION],
};

const SHOWN_LINK: Element = Element {
    children: &[INERTIAL, VISUAL],
    ..LINK
};

const VISUAL: Element = Element {
    tag: "visual",
    ..COLLISION
};

const INERTIAL: Element = Element {
    tag: "inertial",
    absent: Left,
    attributes: &[],
    children: &[
        ORIGIN,
        leaf("mass", Refused, &[("value", Numbers(1), Refused)]),
        INERTIA,
    ],
};

/// A point mass may leave it out.
const INERTIA: Element = leaf(
    "inertia",
    Filled(r#"<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>"#),
    &[
        ("ixx", Numbers(1), Filled("0")),
        ("ixy", Numbers(1), Filled("0")),
        ("ixz", Numbers(1), Filled("0")),
        ("iyy", Numbers(1), Filled("0")),
        ("iyz", Numbers(1), Filled("0")),
        ("izz", Numbers(1), Filled("0")),
    ],
);

const COLLISION: Element = Element {
    tag: "collision",
    absent: Left,
    attributes: &[],
    children: &[ORIGIN, leaf("geometry", Refused, &[])],
};

const GEOMETRIES: [Element; 5] = [
    leaf("box", Left, &[("size", Numbers(3), Refused)]),
    leaf("cylinder", Left, ROUND),
    leaf("capsule", Left, ROUND),
    leaf("sphere", Left, &[("radius", Numbers(1), Refused)]),
    leaf(
        "mesh",
        Left,
        &[("filename", Text, Refused), ("scale", Numbers(3), Left)],
    ),
];

const ROUND: &[Attribute] = &[
    ("radius", Numbers(1), Refused),
    ("length", Numbers(1), Refused),
];

const ORIGIN: Element = leaf(
    "origin",
    Left,
    &[
        ("xyz", Numbers(3), Left),
        ("rpy", Numbers(3), Left),
        ("quat_xyzw", Numbers(4), Left),
    ],
);

const JOINT: Element = Element {
    tag: "joint",
    absent: Left,
    attributes: &[("name", Text, Refused), ("type", Text, Refused)],
    children: &[
        ORIGIN,
        leaf("parent", Refused, &[("link", Text, Refused)]),
        leaf("child", Refused, &[("link", Text, Refused)]),
        leaf("axis", Left, &[("xyz", Numbers(3), Filled("1 0 0"))]),
        // An effort or velocity that is not stated is not limited; urdf-rs would say 0.
        leaf(
            "limit",
            Left,
            &[
                ("lower", Numbers(1), Left),
                ("upper", Numbers(1), Left),
                ("effort", Numbers(1), Filled("inf")),
                ("velocity", Numbers(1), Filled("inf")),
            ],
        ),
        leaf(
            "mimic",
            Left,
            &[
                ("joint", Text, Refused),
                ("multiplier", Numbers(1), Left),
                ("offset", Numbers(1), Left),
            ],
        ),
    ],
};

/// Refuses types of joints that are not supported, and absent limits, which urdf-rs takes for 0.
fn check_joint(source: &Source, joint: Node) -> Result<(), Error> {
    let kind = source.text(joint, "type")?;
    // A mimic joint moves as another one does and has no use for limits of its own.
    let limited = child(joint, "limit").is_some() || child(joint, "mimic").is_some();
    match kind {
        "fixed" | "continuous" | "floating" => Ok(()),
        "revolute" | "prismatic" if limited => Ok(()),
        "revolute" | "prismatic" => {
            let cause = format!("line {}: it has no <limit>", source.line(joint));
            let name = source.text(joint, "name")?;
            Err(Error::part(source.name, "joint", name, cause))
        }
        other => {
            let cause = format!("joints of type \"{other}\" are not supported");
            Err(source.refuse(joint, cause))
        }
    }
}

/// Whether a revolute joint has a `<limit>` that states no angle, and moves no other's way: by the letter its
/// range is 0 to 0, but nobody states the torque of a joint that does not turn.
fn is_endless(joint: Node) -> bool {
    let states = |limit: Node| ["lower", "upper"].iter().any(|of| limit.has_attribute(*of));
    let limit = child(joint, "limit");
    child(joint, "mimic").is_none() && limit.is_some_and(|limit| !states(limit))
}

/// Writes what `element` says of a node to the clean document.
fn copy(source: &Source, node: Node, element: &Element, clean: &mut String) -> Result<(), Error> {
    let tag = element.tag;
    clean.extend(["<", tag]);
    for &(name, value, absent) in element.attributes {
        let stated = match value {
            Text => (node.attribute(name).map(str::trim)).filter(|t| !t.is_empty()),
            Numbers(count) => source.numbers(node, name, count)?,
        };
        match (stated, absent) {
            (Some("revolute"), _) if name == "type" && is_endless(node) => {
                attribute(name, "continuous", clean);
            }
            (Some(text), _) | (None, Filled(text)) => attribute(name, text, clean),
            (None, Left) => {}
            (None, Refused) => {
                return Err(source.refuse(node, format!("<{tag}> has no attribute \"{name}\"")));
            }
        }
    }
    clean.push('>');
    for wanted in element.children {
        // Only shapes stand several times in one element.
        let repeats = [COLLISION.tag, VISUAL.tag].contains(&wanted.tag);
        let most = if repeats { usize::MAX } else { 1 };
        for found in children(node, wanted.tag).take(most) {
            copy(source, found, wanted, clean)?;
        }
        if child(node, wanted.tag).is_none() {
            match wanted.absent {
                Left => {}
                Filled(text) => clean.push_str(text),
                Refused => {
                    return Err(source.refuse(node, format!("<{tag}> has no <{}>", wanted.tag)));
                }
            }
        }
    }
    if tag == "geometry" {
        let shape = node.children().find(Node::is_element);
        let shape = shape.ok_or_else(|| source.refuse(node, "<geometry> is empty"))?;
        let name = shape.tag_name().name();
        let known = GEOMETRIES.iter().find(|known| known.tag == name);
        let unknown = || source.refuse(shape, format!("unknown geometry <{name}>"));
        let known = known.ok_or_else(unknown)?;
        copy(source, shape, known, clean)?;
    }
    clean.extend(["</", tag, ">"]);
    Ok(())
}

/// Writes one attribute, its value escaped.
fn attribute(name: &str, value: &str, clean: &mut String) {
    clean.extend([" ", name, "=\""]);
    for c in value.chars() {
        match c {
            '&' => clean.push_str("&amp;"),
            '<' => clean.push_str("&lt;"),
            '>' => clean.push_str("&gt;"),
            '"' => clean.push_str("&quot;"),
            '\'' => clean.push_str("&apos;"),
            other => clean.push(other),
        }
    }
    clean.push('"');
}
