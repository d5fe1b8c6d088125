//! Bodies of one colour in a `foxglove.SceneUpdate`.
//!
//! In: boxes, balls, cylinders and capsules by their poses and sizes. Out: a `foxglove.SceneEntity`. Numbers are rounded to a
//! millionth.

use mrroc_core::link::Nanos;
use mrroc_core::nalgebra::{UnitQuaternion, Vector3};
use mrroc_core::pose::Pose;
use serde_json::{Value, json};

/// What is drawn in one colour.
pub(super) struct Entity {
    colour: Value,
    pub cubes: Vec<Value>,
    pub spheres: Vec<Value>,
    pub cylinders: Vec<Value>,
}

impl Entity {
    /// Nothing yet; red, green, blue, as shares.
    pub fn of_colour([r, g, b]: [f64; 3]) -> Self {
        let colour = json!({"r": r, "g": g, "b": b, "a": 1.0});
        Entity { colour, cubes: Vec::new(), spheres: Vec::new(), cylinders: Vec::new() }
    }

    /// The same, seen through: `share` of its colour, 0 to 1.
    pub fn pale(mut self, share: f64) -> Self {
        self.colour["a"] = json!(share);
        self
    }

    /// A box about the origin of a frame, by its edges \[m\].
    pub fn cube(&mut self, pose: &Pose, edges: [f64; 3]) {
        let size = vector(&Vector3::from(edges));
        self.cubes.push(json!({"pose": shown(pose), "size": size, "color": self.colour}));
    }

    /// A ball about the origin of a frame, by its radius \[m\].
    pub fn ball(&mut self, pose: &Pose, radius: f64) {
        let size = vector(&Vector3::repeat(2.0 * radius));
        self.spheres.push(json!({"pose": shown(pose), "size": size, "color": self.colour}));
    }

    /// A cylinder along z about the origin of a frame \[m\].
    pub fn cylinder(&mut self, pose: &Pose, radius: f64, length: f64) {
        self.cylinders.push(json!({
            "pose": shown(pose),
            "size": vector(&Vector3::new(2.0 * radius, 2.0 * radius, length)),
            "bottom_scale": 1.0,
            "top_scale": 1.0,
            "color": self.colour,
        }));
    }

    /// A cylinder with a ball at each end.
    pub fn capsule(&mut self, [a, b]: [Vector3<f64>; 2], radius: f64) {
        let axis = b - a;
        let along = UnitQuaternion::rotation_between(&Vector3::z(), &axis);
        // Opposite to z there is no single axis to turn about.
        let along = along
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI));
        let place = |at: Vector3<f64>| Pose::from_parts(at.into(), along);
        if axis.norm() > 1e-6 {
            self.cylinder(&place((a + b) * 0.5), radius, axis.norm());
            self.ball(&place(a), radius);
        }
        self.ball(&place(b), radius);
    }

    /// The entity of this name in a frame.
    pub fn json(self, date: Nanos, frame: &str, id: &str) -> Value {
        let nothing = || Value::Array(Vec::new());
        json!({
            "timestamp": seconds(date),
            "frame_id": frame,
            "id": id,
            // It stays until the next one replaces it, and moves with what it stands on.
            "lifetime": {"sec": 0, "nsec": 0},
            "frame_locked": true,
            "metadata": nothing(),
            "arrows": nothing(),
            "cubes": self.cubes,
            "spheres": self.spheres,
            "cylinders": self.cylinders,
            "lines": nothing(),
            "triangles": nothing(),
            "texts": nothing(),
            "models": nothing(),
        })
    }
}

/// A `foxglove.SceneUpdate` of these entities.
pub(super) fn update(entities: &[Value]) -> Value {
    json!({"deletions": [], "entities": entities})
}

pub(super) fn seconds(date: Nanos) -> Value {
    json!({"sec": date / 1_000_000_000, "nsec": date % 1_000_000_000})
}

/// A number to a millionth: a micrometre is more than a viewer shows, and short texts make small files.
fn rounded(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

fn vector(v: &Vector3<f64>) -> Value {
    json!({"x": rounded(v.x), "y": rounded(v.y), "z": rounded(v.z)})
}

pub(super) fn shown(pose: &Pose) -> Value {
    let q = pose.rotation.coords.map(rounded);
    json!({
        "position": vector(&pose.translation.vector),
        "orientation": {"x": q.x, "y": q.y, "z": q.z, "w": q.w},
    })
}
