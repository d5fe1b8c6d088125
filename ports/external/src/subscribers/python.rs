//! The Python module of a subscriber.

use mrroc::observe::layout::Layout;
use mrroc::observe::step_observer::IMAGE_WORDS;
use mrroc::robot::MAX_JOINTS;

use super::KEPT;
use super::message::{TEXT, VERSION};

/// The module without what differs from cell to cell.
const MODULE: &str = include_str!("../python/subscriber.py");

/// What it has in common with that of a sensor.
const ENDS: &str = include_str!("../python/ends.py");

/// The module for a port at which a cell of this layout is shown.
pub(super) fn module(port: &str, layout: &Layout) -> String {
    let robots: Vec<_> = layout.robots.iter().map(|robot| format!("\"{}\"", robot.name)).collect();
    MODULE
        .replace("@ENDS@", ENDS.trim_end())
        .replace("@PORT@", port)
        .replace("@ROBOTS@", &robots.join(", "))
        .replace("@VERSION@", &VERSION.to_string())
        .replace("@KEPT@", &KEPT.to_string())
        .replace("@WORDS@", &IMAGE_WORDS.to_string())
        .replace("@TEXT@", &TEXT.to_string())
        .replace("@MAX_JOINTS@", &MAX_JOINTS.to_string())
}
