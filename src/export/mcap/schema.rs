//! What messages look like, as JSON schemas: the fields of Foxglove's that are written, and nothing beside.

use serde_json::{Value, json};

/// An object of exactly these fields.
fn object(title: &str, fields: Value) -> Value {
    let names: Vec<&String> = fields
        .as_object()
        .into_iter()
        .flat_map(|f| f.keys())
        .collect();
    json!({
        "title": title, "type": "object", "required": names, "properties": fields, "additionalProperties": false,
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
    object(title, json!({ "sec": index(), "nsec": nsec }))
}

fn xyz(title: &str) -> Value {
    object(
        title,
        json!({ "x": number(), "y": number(), "z": number() }),
    )
}

fn quaternion() -> Value {
    let fields = json!({ "x": number(), "y": number(), "z": number(), "w": number() });
    object("foxglove.Quaternion", fields)
}

fn pose() -> Value {
    let fields = json!({ "position": xyz("foxglove.Vector3"), "orientation": quaternion() });
    object("foxglove.Pose", fields)
}

fn color() -> Value {
    let fields = json!({ "r": number(), "g": number(), "b": number(), "a": number() });
    object("foxglove.Color", fields)
}

/// `foxglove.FrameTransforms`.
pub(super) fn frame_transforms() -> Value {
    let fields = json!({
        "timestamp": time("time"), "parent_frame_id": text(), "child_frame_id": text(),
        "translation": xyz("foxglove.Vector3"), "rotation": quaternion(),
    });
    let transform = object("foxglove.FrameTransform", fields);
    object(
        "foxglove.FrameTransforms",
        json!({ "transforms": list(transform) }),
    )
}

/// `foxglove.SceneUpdate`.
pub(super) fn scene_update() -> Value {
    let size = xyz("foxglove.Vector3");
    let sized = json!({ "pose": pose(), "size": size, "color": color() });
    let arrow = json!({
        "pose": pose(), "shaft_length": number(), "shaft_diameter": number(),
        "head_length": number(), "head_diameter": number(), "color": color(),
    });
    let cylinder = json!({
        "pose": pose(), "size": size, "bottom_scale": number(), "top_scale": number(), "color": color(),
    });
    let points = list(xyz("foxglove.Point3"));
    let line = json!({
        "type": index(), "pose": pose(), "thickness": number(), "scale_invariant": { "type": "boolean" },
        "points": points, "color": color(), "colors": list(color()), "indices": list(index()),
    });
    let triangles = json!({
        "pose": pose(), "points": points, "color": color(), "colors": list(color()), "indices": list(index()),
    });
    let primitives =
        |kind: &str, fields| list(object(&format!("foxglove.{kind}Primitive"), fields));
    let entity = json!({
        "timestamp": time("time"), "frame_id": text(), "id": text(), "lifetime": time("duration"),
        "frame_locked": { "type": "boolean" }, "metadata": empty(), "arrows": primitives("Arrow", arrow),
        "cubes": primitives("Cube", sized.clone()), "spheres": primitives("Sphere", sized),
        "cylinders": primitives("Cylinder", cylinder), "lines": primitives("Line", line),
        "triangles": primitives("TriangleList", triangles), "texts": empty(), "models": empty(),
    });
    let entities = list(object("foxglove.SceneEntity", entity));
    object(
        "foxglove.SceneUpdate",
        json!({ "deletions": empty(), "entities": entities }),
    )
}

/// The joints as ROS has them, which Foxglove's model of a robot follows.
pub(super) fn joint_state() -> Value {
    let header = json!({ "stamp": time("time"), "frame_id": text() });
    let fields = json!({
        "header": object("std_msgs/Header", header), "name": list(text()),
        "position": list(number()), "velocity": list(number()), "effort": list(number()),
    });
    object("sensor_msgs/JointState", fields)
}

/// A phase of the motion.
pub(super) fn phase() -> Value {
    let fields =
        json!({ "kind": text(), "swing": text(), "from_stance": index(), "to_stance": index() });
    object("scandent.Phase", fields)
}
