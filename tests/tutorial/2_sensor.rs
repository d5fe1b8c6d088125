//! Chapter 2 of the tutorial: a Wait for a condition with a state, its time-out, and a sensor without a VSP.

// As it stands in a newcomer's project.
#![allow(missing_docs)]

#[path = "../../template/src/touch.rs"]
mod touch;

use mrroc::generator::RobotHandle;
use mrroc::prelude::*;
use touch::{Table, Touch};

use super::point_to_point::PointToPoint;
use super::support::{ONE, file, printed, shows};
use crate::arm::{Arm, kinds};

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
    let cell = file.cell(&kinds()).expect("known");
    cell.sensor(file.sensor("touch", Table).expect("it is in the file"))
}

/// The motions of the template's program.
fn up_and_down(mp: &mut Mp, arm: &mut RobotHandle<Arm>) -> Result<(), Fault> {
    for z in [0.1, -0.1] {
        mp.move_robots((&mut *arm,), (), PointToPoint::by(0.0, 0.0, z))?;
    }
    Ok(())
}

#[test]
fn the_condition_with_a_state_takes_half_a_second_more() {
    let without = cell().program(|mp| {
        let mut arm = mp.robot::<Arm>("arm")?;
        let mut touch = mp.sensor::<Touch>("touch")?;
        mp.wait_until((&mut arm,), (&mut touch,), touch::clear {})?;
        up_and_down(mp, &mut arm)
    });
    let with = cell().program(|mp| {
        let mut arm = mp.robot::<Arm>("arm")?;
        let mut touch = mp.sensor::<Touch>("touch")?;
        mp.wait_until((&mut arm,), (&mut touch,), Clear::default())?;
        up_and_down(mp, &mut arm)
    });
    let [without, with] = [without, with].map(|cell| cell.run().expect("it is clear"));
    // 250 steps instead of the first one.
    assert_eq!(with.steps, without.steps + 249);
    shows("2-sensor.md", &printed(&without));
    shows("2-sensor.md", &printed(&with));
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
    let cell = file(&format!("{ONE}{SENSOR}")).cell(&kinds()).expect("known");
    shows("2-sensor.md", &format!("error: {}", cell.program(|_| Ok(())).run().expect_err("no VSP")));
}
