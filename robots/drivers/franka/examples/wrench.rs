//! Says what an FR3 feels at its tool, five times a second, without moving it: `cargo run -p mrroc-examples --example wrench -- --cell
//! robots/drivers/franka/examples/wrench.toml --processes`, where a robot is at the address of that file. Push the tool by hand.
//!
//! `--times` behind a `--` says how often, 50 times by default.

use std::time::Duration;

use mrroc::launch::own_number;
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc_franka::{FciSettings, Fr3, with_franka_as};
use mrroc_generators::conditions::elapsed;
use mrroc_robots::sensors::{RobotWrench, WristForce};
use mrroc_robots::simulated;

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    // A simulator may be late for longer than a robot, whose settings are those of `with_franka`.
    let settings = |robot| FciSettings { silence: Duration::from_millis(100), ..FciSettings::new(robot) };
    let wrist = file.sensor("wrist", RobotWrench::new())?;
    Ok(file.cell(&with_franka_as(simulated(), settings))?.sensor(wrist).program(feel))
}

/// The newest reading.
#[derive(Clone, Copy, Default)]
struct Felt(Wrench);

#[condition(mp)]
fn felt(c: &mut Felt, v: &Reading<(WristForce,)>) -> bool {
    let reading = v.0.reading();
    c.0 = reading.unwrap_or(c.0);
    reading.is_some()
}

fn feel(mp: &mut Mp) -> Result<(), Fault> {
    let times = own_number("times", 50)?;
    let (mut arm, mut wrist) = (mp.robot::<Fr3>("arm")?, mp.sensor::<WristForce>("wrist")?);
    for _ in 0..times {
        mp.wait_until((&mut arm,), (), elapsed(0.2))?;
        let Felt(Wrench { force, torque }) = mp.wait_until((&mut arm,), (&mut wrist,), Felt::default())?;
        let [fx, fy, fz]: [f64; 3] = force.into();
        let [tx, ty, tz]: [f64; 3] = torque.into();
        println!("on the tool: {fx:.4} {fy:.4} {fz:.4} N, {tx:.5} {ty:.5} {tz:.5} N m");
    }
    Ok(())
}
