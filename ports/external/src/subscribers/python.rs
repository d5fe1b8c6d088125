//! The Python module of a subscriber.

use core::fmt::Write;

use mrroc::fault::{MAX_NAME, Name};
use mrroc::observe::layout::Layout;
use mrroc::observe::step_observer::IMAGE_WORDS;
use mrroc::payload::WORDS;
use mrroc::robot::MAX_JOINTS;

use super::KEPT;
use super::message::{TEXT, VERSION};
use crate::python::{VALUES, reading_class};

/// The module without what differs from cell to cell.
const MODULE: &str = include_str!("../python/subscriber.py");

/// What it has in common with that of a sensor, besides how words are read.
const ENDS: &str = include_str!("../python/ends.py");

/// The module for a port at which a cell of this layout is shown.
pub(super) fn module(port: &str, layout: &Layout) -> String {
    let robots: Vec<_> = layout.robots.iter().map(|robot| format!("\"{}\"", robot.name)).collect();
    let (mut classes, mut sensors) = (String::new(), String::new());
    // Readings of lower cells are not shown.
    for sensor in layout.sensors.iter().filter(|sensor| Name::new(&sensor.name).is_ok()) {
        let read = reading_class(&sensor.name, sensor.reading, &mut classes);
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
