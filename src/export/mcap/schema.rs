//! What messages look like, as JSON schemas: the fields of Foxglove's that are written, and nothing beside.

use serde_json::{Map, Value, json};

/// An object of exactly these fields.
fn object<const N: usize>(title: &str, fields: [(&str, Value); N]) -> Value {
    let names = fields.each_ref().map(|(name, _)| *name);
    let all: Map<String, Value> = fields
        .iter()
        .map(|(n, v)| ((*n).to_owned(), v.clone()))
        .collect();
    json!({
        "title": title, "type": "object", "properties": all, "required": &names[..], "additionalProperties": false,
    })
}

fn list(of: Value) -> Value {
    json!({ "type": "array", "items": of })
}

fn empty() -> Value {
    json!({ "type": "array", "maxItems": 0 })
}

fn number() -> Value {
    json!({ "type": "number" })
}

fn text() -> Value {
    json!({ "type": "string" })
}

fn index() -> Value {
    json!({ "type": "integer", "minimum": 0 })
}

fn time(title: &str) -> Value {
    let nsec = json!({ "type": "integer", "minimum": 0, "maximum": 999_999_999 });
    object(title, [("sec", index()), ("nsec", nsec)])
}

fn xyz(title: &str) -> Value {
    object(title, ["x", "y", "z"].map(|axis| (axis, number())))
}

fn quaternion() -> Value {
    object(
        "foxglove.Quaternion",
        ["x", "y", "z", "w"].map(|axis| (axis, number())),
    )
}

fn pose() -> Value {
    let position = xyz("foxglove.Vector3");
    object(
        "foxglove.Pose",
        [("position", position), ("orientation", quaternion())],
    )
}

fn color() -> Value {
    object(
        "foxglove.Color",
        ["r", "g", "b", "a"].map(|part| (part, number())),
    )
}

/// `foxglove.FrameTransforms`.
pub(super) fn frame_transforms() -> Value {
    let transform = object(
        "foxglove.FrameTransform",
        [
            ("timestamp", time("time")),
            ("parent_frame_id", text()),
            ("child_frame_id", text()),
            ("translation", xyz("foxglove.Vector3")),
            ("rotation", quaternion()),
        ],
    );
    object(
        "foxglove.FrameTransforms",
        [("transforms", list(transform))],
    )
}

/// `foxglove.SceneUpdate`.
pub(super) fn scene_update() -> Value {
    let sized = |title| {
        let size = xyz("foxglove.Vector3");
        object(
            title,
            [("pose", pose()), ("size", size), ("color", color())],
        )
    };
    let arrow = object(
        "foxglove.ArrowPrimitive",
        [
            ("pose", pose()),
            ("shaft_length", number()),
            ("shaft_diameter", number()),
            ("head_length", number()),
            ("head_diameter", number()),
            ("color", color()),
        ],
    );
    let cylinder = object(
        "foxglove.CylinderPrimitive",
        [
            ("pose", pose()),
            ("size", xyz("foxglove.Vector3")),
            ("bottom_scale", number()),
            ("top_scale", number()),
            ("color", color()),
        ],
    );
    let points = || list(xyz("foxglove.Point3"));
    let line = object(
        "foxglove.LinePrimitive",
        [
            ("type", index()),
            ("pose", pose()),
            ("thickness", number()),
            ("scale_invariant", json!({ "type": "boolean" })),
            ("points", points()),
            ("color", color()),
            ("colors", list(color())),
            ("indices", list(index())),
        ],
    );
    let triangles = object(
        "foxglove.TriangleListPrimitive",
        [
            ("pose", pose()),
            ("points", points()),
            ("color", color()),
            ("colors", list(color())),
            ("indices", list(index())),
        ],
    );
    let entity = object(
        "foxglove.SceneEntity",
        [
            ("timestamp", time("time")),
            ("frame_id", text()),
            ("id", text()),
            ("lifetime", time("duration")),
            ("frame_locked", json!({ "type": "boolean" })),
            ("metadata", empty()),
            ("arrows", list(arrow)),
            ("cubes", list(sized("foxglove.CubePrimitive"))),
            ("spheres", list(sized("foxglove.SpherePrimitive"))),
            ("cylinders", list(cylinder)),
            ("lines", list(line)),
            ("triangles", list(triangles)),
            ("texts", empty()),
            ("models", empty()),
        ],
    );
    object(
        "foxglove.SceneUpdate",
        [("deletions", empty()), ("entities", list(entity))],
    )
}

/// The joints as ROS has them, which Foxglove's model of a robot follows.
pub(super) fn joint_state() -> Value {
    let header = object(
        "std_msgs/Header",
        [("stamp", time("time")), ("frame_id", text())],
    );
    object(
        "sensor_msgs/JointState",
        [
            ("header", header),
            ("name", list(text())),
            ("position", list(number())),
            ("velocity", list(number())),
            ("effort", list(number())),
        ],
    )
}

/// A phase of the motion.
pub(super) fn phase() -> Value {
    object(
        "scandent.Phase",
        [
            ("kind", text()),
            ("swing", text()),
            ("from_stance", index()),
            ("to_stance", index()),
        ],
    )
}
