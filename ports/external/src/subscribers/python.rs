//! The Python module of a subscriber.

use core::fmt::Write;

use mrroc::fault::MAX_NAME;
use mrroc::observe::layout::Layout;
use mrroc::observe::step_observer::IMAGE_WORDS;
use mrroc::payload::WORDS;
use mrroc::robot::MAX_JOINTS;

use super::KEPT;
use super::message::{TEXT, VERSION};
use crate::python::{VALUES, camel, own, reading_class};

/// The module without what differs from cell to cell.
const MODULE: &str = include_str!("../python/subscriber.py");

/// What it has in common with that of a sensor, besides how words are read.
const ENDS: &str = include_str!("../python/ends.py");

/// The module for a port at which a cell of this layout is shown.
pub(super) fn module(port: &str, layout: &Layout) -> String {
    let robots: Vec<_> = layout.robots.iter().map(|robot| format!("\"{}\"", robot.name)).collect();
    let (mut classes, mut sensors) = (String::new(), String::new());
    let mut named: Vec<String> = Vec::new();
    for sensor in &layout.sensors {
        let class = class_of(&sensor.name, &mut named);
        let read = reading_class(&class, &sensor.name, sensor.reading, &mut classes);
        let _ = writeln!(sensors, "    \"{}\": (0x{:016X}, {read}),", sensor.name, sensor.reading_layout);
    }
    MODULE
        .replace("@ENDS@", ENDS.trim_end())
        .replace("@VALUES@", VALUES.trim_end())
        .replace("@CLASSES@", classes.trim_end())
        .replace("@SENSORS@\n", &sensors)
        .replace("@PORT@", port)
        .replace("@ROBOTS@", &robots.join(", "))
        .replace("@VERSION@", &VERSION.to_string())
        .replace("@KEPT@", &KEPT.to_string())
        .replace("@WORDS@", &IMAGE_WORDS.to_string())
        .replace("@TEXT@", &TEXT.to_string())
        .replace("@NAME@", &MAX_NAME.to_string())
        .replace("@READING_WORDS@", &WORDS.to_string())
        .replace("@MAX_JOINTS@", &MAX_JOINTS.to_string())
}

/// The name of the class of a sensor's readings, which none before it has: `a-b` and `a_b` would have the same one.
fn class_of(sensor: &str, named: &mut Vec<String>) -> String {
    let plain = own(&camel(&format!("{}_reading", sensor.replace('-', "_"))));
    let numbered = (2..).map(|number| format!("{plain}{number}"));
    let is_new = |name: &String| !named.contains(name);
    let name = core::iter::once(plain.clone()).chain(numbered).find(is_new).unwrap_or(plain);
    named.push(name.clone());
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_whose_names_differ_by_a_hyphen_alone_have_classes_of_their_own() {
        let mut named = Vec::new();
        let made = ["a-b", "a_b", "AB", "gauge", "class"].map(|sensor| class_of(sensor, &mut named));
        assert_eq!(made, ["ABReading", "ABReading2", "ABReading3", "GaugeReading", "ClassReading"]);
    }
}
