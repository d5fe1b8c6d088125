//! Chapter 2 of the tutorial: a Wait for a condition with a state, its time-out, and a sensor without a VSP.

// As it stands in a newcomer's project.
#![allow(missing_docs)]

mod support;

#[path = "../../template/src/touch.rs"]
mod touch;

use mrroc::{Cell, Reading, condition};
use mrroc_robots::{Irp6 as Arm, simulated};
use support::{ONE, file, shows};
use touch::{Table, Touch};

// ANCHOR: clear
#[derive(Default)]
pub struct Clear {
    steps: u32,
}

#[condition(mp)]
pub fn clear(c: &mut Clear, v: &Reading<(Touch,)>) -> bool {
    let now = v.0.reading().is_some_and(|contact| !contact.made);
    c.steps = if now { c.steps + 1 } else { 0 };
    c.steps >= 250
}
// ANCHOR_END: clear

const SENSOR: &str = "[sensors.touch]\nof = \"arm\"\n";

fn cell() -> Cell {
    let file = file(&format!("{ONE}{SENSOR}"));
    let cell = file.cell(&simulated()).expect("known");
    cell.sensor(file.sensor("touch", Table).expect("it is in the file"))
}

#[test]
fn the_wait_takes_half_a_second() {
    let report = cell().program(|mp| {
        let mut arm = mp.robot::<Arm>("arm")?;
        let mut touch = mp.sensor::<Touch>("touch")?;
        mp.wait_until((&mut arm,), (&mut touch,), Clear::default()).map(drop)
    });
    let steps = report.run().expect("it is clear").steps;
    assert!((250..255).contains(&steps), "{steps}");
}

#[test]
fn the_wait_times_out_as_the_page_says() {
    let fault = cell().program(|mp| {
        let mut arm = mp.robot::<Arm>("arm")?;
        let mut touch = mp.sensor::<Touch>("touch")?;
        mp.wait_at_most((&mut arm,), (&mut touch,), Clear::default(), 200).map(drop)
    });
    shows("2-sensor.md", &format!("error: {}", fault.run().expect_err("too short")));
}

#[test]
fn a_sensor_without_a_vsp_is_refused_as_the_page_says() {
    let cell = file(&format!("{ONE}{SENSOR}")).cell(&simulated()).expect("known");
    shows("2-sensor.md", &format!("error: {}", cell.program(|_| Ok(())).run().expect_err("no VSP")));
}
