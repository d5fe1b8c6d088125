//! The two public schemas by which Foxglove's 3D panel shows frames and bodies, as JSON schemas.
//!
//! Names, fields and types are those of <https://docs.foxglove.dev/docs/sdk/schemas>; a viewer knows the messages by the
//! names. All fields of a scene entity are there, also of primitives that no recording has: readers may count on each list.

use serde_json::{Value, json};

use super::json::object;

/// Names of the schemas.
pub(super) const FRAME_TRANSFORMS: &str = "foxglove.FrameTransforms";
pub(super) const SCENE_UPDATE: &str = "foxglove.SceneUpdate";

fn number() -> Value {
    json!({"type": "number"})
}

fn text() -> Value {
    json!({"type": "string"})
}

fn truth() -> Value {
    json!({"type": "boolean"})
}

fn list(of: Value) -> Value {
    json!({"type": "array", "items": of})
}

fn numbers<const N: usize>(names: [&'static str; N]) -> Value {
    object(names.map(|name| (name, number())))
}

/// An object with the title by which its type is known.
fn titled<const N: usize>(title: &str, fields: [(&'static str, Value); N]) -> Value {
    let mut object = object(fields);
    object["title"] = json!(title);
    object
}

/// A time or a duration: whole seconds, and nanoseconds.
fn seconds(title: &str) -> Value {
    let nsec = json!({"type": "integer", "minimum": 0, "maximum": 999_999_999});
    let sec =
        if title == "time" { json!({"type": "integer", "minimum": 0}) } else { json!({"type": "integer"}) };
    titled(title, [("sec", sec), ("nsec", nsec)])
}

fn pose() -> Value {
    let (position, orientation) = (numbers(["x", "y", "z"]), numbers(["x", "y", "z", "w"]));
    titled("foxglove.Pose", [("position", position), ("orientation", orientation)])
}

fn vector() -> Value {
    numbers(["x", "y", "z"])
}

fn colour() -> Value {
    numbers(["r", "g", "b", "a"])
}

/// A choice that is sent as its number.
fn choice(title: &str, names: &[&str]) -> Value {
    let one = |(i, name): (usize, &&str)| json!({"title": name, "const": i});
    json!({"title": title, "oneOf": names.iter().enumerate().map(one).collect::<Vec<_>>()})
}

/// The schema of frames, each in its parent.
pub(super) fn frame_transforms() -> Value {
    let transform = titled(
        "foxglove.FrameTransform",
        [
            ("timestamp", seconds("time")),
            ("parent_frame_id", text()),
            ("child_frame_id", text()),
            ("translation", vector()),
            ("rotation", numbers(["x", "y", "z", "w"])),
        ],
    );
    titled(FRAME_TRANSFORMS, [("transforms", list(transform))])
}

/// The schema of bodies.
pub(super) fn scene_update() -> Value {
    let deletion = titled(
        "foxglove.SceneEntityDeletion",
        [
            ("timestamp", seconds("time")),
            ("type", choice("foxglove.SceneEntityDeletionType", &["MATCHING_ID", "ALL"])),
            ("id", text()),
        ],
    );
    titled(SCENE_UPDATE, [("deletions", list(deletion)), ("entities", list(entity()))])
}

fn entity() -> Value {
    let arrow = [
        ("pose", pose()),
        ("shaft_length", number()),
        ("shaft_diameter", number()),
        ("head_length", number()),
        ("head_diameter", number()),
        ("color", colour()),
    ];
    let solid = || [("pose", pose()), ("size", vector()), ("color", colour())];
    let cylinder = [
        ("pose", pose()),
        ("size", vector()),
        ("bottom_scale", number()),
        ("top_scale", number()),
        ("color", colour()),
    ];
    let indices = || list(json!({"type": "integer", "minimum": 0}));
    let line = [
        ("type", choice("foxglove.LineType", &["LINE_STRIP", "LINE_LOOP", "LINE_LIST"])),
        ("pose", pose()),
        ("thickness", number()),
        ("scale_invariant", truth()),
        ("points", list(vector())),
        ("color", colour()),
        ("colors", list(colour())),
        ("indices", indices()),
    ];
    let triangles = [
        ("pose", pose()),
        ("points", list(vector())),
        ("color", colour()),
        ("colors", list(colour())),
        ("indices", indices()),
    ];
    let words = [
        ("pose", pose()),
        ("billboard", truth()),
        ("font_size", number()),
        ("scale_invariant", truth()),
        ("color", colour()),
        ("text", text()),
    ];
    let model = [
        ("pose", pose()),
        ("scale", vector()),
        ("color", colour()),
        ("override_color", truth()),
        ("url", text()),
        ("media_type", text()),
        ("data", json!({"type": "string", "contentEncoding": "base64"})),
    ];
    titled(
        "foxglove.SceneEntity",
        [
            ("timestamp", seconds("time")),
            ("frame_id", text()),
            ("id", text()),
            ("lifetime", seconds("duration")),
            ("frame_locked", truth()),
            ("metadata", list(object([("key", text()), ("value", text())]))),
            ("arrows", list(titled("foxglove.ArrowPrimitive", arrow))),
            ("cubes", list(titled("foxglove.CubePrimitive", solid()))),
            ("spheres", list(titled("foxglove.SpherePrimitive", solid()))),
            ("cylinders", list(titled("foxglove.CylinderPrimitive", cylinder))),
            ("lines", list(titled("foxglove.LinePrimitive", line))),
            ("triangles", list(titled("foxglove.TriangleListPrimitive", triangles))),
            ("texts", list(titled("foxglove.TextPrimitive", words))),
            ("models", list(titled("foxglove.ModelPrimitive", model))),
        ],
    )
}
