//! What a page is shown beside robots' links: what robots carry, inputs and outputs, readings, the frames and tools of the cell.
//!
//! In: the layout of the cell, and what is so at a moment. Out: JSON.

use mrroc_core::observe::layout::{Layout, RobotLayout, SensorLayout, SignalLayout};
use mrroc_core::pose::Pose;
use mrroc_core::robot::{Channel, Load, Signals, Tool};
use serde_json::{Value, json};

use crate::readings;
use crate::values::{finite, is_pose, numbers, rounded};

/// How far a tool in force may be from one of the cell's to be called by its name \[m\], and by the angle \[rad\].
const SAME: f64 = 1e-6;

/// What a robot carries, and its inputs and outputs, as far as it is known.
#[derive(Clone, Debug, Default)]
pub struct CarriedLoad {
    /// The tool in force, `X_FE` \[m\].
    pub tool: Option<Pose>,
    /// What its drives were told that the flange carries.
    pub load: Option<Load>,
    pub signals: Option<Signals>,
}

/// The newest reading of a sensor: its numbers, or `None` instead of a fault.
pub type ReadingNow = Option<Vec<Option<f64>>>;

/// What the cell has beside its robots' links.
pub struct Beside {
    frames: Vec<(String, Pose)>,
    tools: Vec<(String, Tool)>,
    sensors: Vec<SensorLayout>,
}

impl Beside {
    /// Of a cell of this layout.
    pub fn of(layout: &Layout) -> Beside {
        Beside { frames: layout.frames.clone(), tools: layout.tools.clone(), sensors: layout.sensors.clone() }
    }

    /// Adds what stays as it is.
    pub fn layout(&self, to: &mut Value) {
        to["frames"] = self.frames.iter().map(|(name, _)| name.as_str()).collect();
        to["places"] = self.frames.iter().map(|(_, pose)| json!(numbers(pose))).collect();
        let sensor = |sensor: &SensorLayout| {
            json!({
                "name": sensor.name,
                "kind": sensor.kind,
                "of": sensor.of,
                "numbers": readings::names(sensor.reading),
                "wrench": readings::is_wrench(sensor.reading),
            })
        };
        to["sensors"] = self.sensors.iter().map(sensor).collect();
    }

    /// The readings, in the order of the sensors; of one that has none `null`.
    pub fn readings(&self, now: &[ReadingNow]) -> Value {
        let reading = |place: usize| now.get(place).cloned().flatten();
        (0..self.sensors.len()).map(|place| json!(reading(place))).collect()
    }

    /// The names of its sensors, and what their readings' words say.
    pub fn sensors(&self) -> impl Iterator<Item = (&str, &'static mrroc_core::payload::Shape)> {
        self.sensors.iter().map(|sensor| (sensor.name.as_str(), sensor.reading))
    }

    /// The tool and the payload of a robot, by the name of the tool if the cell has one for it.
    #[allow(non_snake_case)]
    pub fn carried(&self, carried: &CarriedLoad) -> Value {
        let Some(X_FE) = carried.tool.filter(is_pose) else { return Value::Null };
        let is_same = |(_, tool): &&(String, Tool)| {
            let apart = tool.frame.inv_mul(&X_FE);
            apart.translation.vector.norm() < SAME && apart.rotation.angle() < SAME
        };
        // A part that is held gives the load another mass, but no other tool.
        let named = self.tools.iter().find(is_same);
        json!({
            "name": named.map(|(name, _)| name),
            "tcp": numbers(&X_FE),
            "mass": carried.load.and_then(|load| finite(rounded(load.mass))),
            "centre": carried.load.map(|load| [load.centre.x, load.centre.y, load.centre.z].map(rounded)),
        })
    }
}

/// The inputs and outputs of a robot that stay as they are: names, channels, whether one is an output.
pub fn signals(robot: &RobotLayout) -> Value {
    let signal = |of: &SignalLayout| {
        json!({
            "name": of.name,
            "channel": of.channel.to_string(),
            "output": of.is_output,
            "note": of.note,
        })
    };
    robot.signals.iter().map(signal).collect()
}

/// The values of them in the same order: true, false, or a number.
pub fn values(robot: &RobotLayout, now: Option<&Signals>) -> Value {
    let value = |of: &SignalLayout| {
        let values = now.map(|now| if of.is_output { now.outputs } else { now.inputs });
        match (of.channel, values) {
            (Channel::Digital(number), Some(values)) => json!(values.is_on(number)),
            (Channel::Analog(number), Some(values)) => json!(finite(values.analog(number))),
            (_, None) => Value::Null,
        }
    };
    robot.signals.iter().map(value).collect()
}
