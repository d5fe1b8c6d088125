//! `external NAME`: prints the Python module by which a program of another sends what a sensor reads, or simulates a robot.
//!
//! In: a cell, and the name of one of its sensors or robots. Out: the text of the module.

use std::process::ExitCode;

use mrroc_core::cell::Cell;
use mrroc_core::console::{refused, say};
use mrroc_core::suggestion::suggestion;

/// Prints the module of the sensor, or the robot, of this name. Nothing moves.
pub(super) fn tell(cell: &Cell, name: &str) -> ExitCode {
    let layout = cell.layout();
    let robots: Vec<&str> = layout.robots.iter().map(|robot| &*robot.name).collect();
    let mut known: Vec<&str> = layout.sensors.iter().map(|sensor| &*sensor.name).collect();
    if let Some(module) = cell.python(name) {
        return say(&module);
    }
    if known.contains(&name) {
        return refused(&format!(
            "the program of the cell computes sensor `{name}` itself\n help: for a program of another, give it a table \
             [sensors.{name}.external] in cell.toml, and `External` of mrroc-external in the program"
        ));
    }
    if robots.contains(&name) {
        return refused(&format!(
            "robot `{name}` is in no simulator of others\n help: give it plant = {{ port = \"{name}\" }} in cell.toml, and \
             `.plants(mrroc_external::plant)` for its kinds in the program"
        ));
    }
    known.extend(robots);
    refused(&format!("no sensor or robot `{name}`\n help: {}", suggestion(name, &known, "the cell has")))
}
