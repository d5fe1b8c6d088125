//! The Python module of a simulator: the port of the robots in it.

use mrroc::robot::MAX_JOINTS;

use super::ORDERS;
use super::message::{LAYOUT, VERSION};

/// The module without what differs from cell to cell.
const MODULE: &str = include_str!("../python/plant.py");

/// What it has in common with that of a sensor.
const ENDS: &str = include_str!("../python/ends.py");

/// The module of the simulator at a port that has these robots.
pub(super) fn module(port: &str, robots: &[String]) -> String {
    let names: Vec<_> = robots.iter().map(|robot| format!("\"{robot}\"")).collect();
    MODULE
        .replace("@ENDS@", ENDS.trim_end())
        .replace("@NAME@", robots.first().map_or("", String::as_str))
        .replace("@PORT@", port)
        .replace("@ROBOTS@", &names.join(", "))
        .replace("@VERSION@", &VERSION.to_string())
        .replace("@LAYOUT@", &format!("0x{LAYOUT:016X}"))
        .replace("@ORDERS@", &ORDERS.to_string())
        .replace("@MAX_JOINTS@", &MAX_JOINTS.to_string())
}
