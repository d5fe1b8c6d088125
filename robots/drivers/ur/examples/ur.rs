//! Moves an arm of Universal Robots to and fro: `cargo run -p mrroc-examples --example ur -- --cell
//! robots/drivers/ur/examples/cell.toml --simulated`, and with `--processes` in its place where a controller is at the address of
//! that file: `cargo run -p mrroc-ur-controller` is one.
//!
//! Behind a `--`, `--times` says how often, once by default; each time takes one and a half seconds. With `--wrench` it prints at its end
//! what the robot feels at its flange: force and torque, in the axes of the flange. `--external-control` is where a program node of the
//! pendant asks for the script, such as `127.0.0.1:50002`.

use core::time::Duration;

use mrroc::launch::{own_number, own_option};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc_generators::generators::JointMove;
use mrroc_robots::sensors::{RobotWrench, WristForce};
use mrroc_robots::{Serial, Six, simulated};
use mrroc_ur::{UrSettings, with_ur_as};

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let wrist = SensorSetup::new("wrist", RobotWrench::new()).of("arm").readers([]);
    Ok(file.cell(&with_ur_as(simulated(), settings))?.sensor(wrist).program(to_and_fro))
}

/// A machine without a real-time kernel is late now and then: its script waits for longer than 20 ms, unless
/// `--read-timeout` says something else \[ms\].
fn settings(settings: UrSettings) -> UrSettings {
    let ms =
        own_option("read-timeout").map_or(200, |ms| ms.parse().expect("--read-timeout needs milliseconds"));
    let external_control = own_option("external-control")
        .map(|at| at.parse().expect("--external-control needs an address and port"));
    UrSettings { read_timeout: Duration::from_millis(ms), external_control, ..settings }
}

/// What was felt last, and how often something was.
#[derive(Default)]
struct Felt(Wrench, u32);

#[condition(mp)]
fn felt(c: &mut Felt, v: &Reading<(WristForce,)>) -> bool {
    let Some(reading) = v.0.reading() else { return false };
    *c = Felt(reading, c.1 + 1);
    // A second, in which the arm comes to rest.
    c.1 == 250
}

fn to_and_fro(mp: &mut Mp) -> Result<(), Fault> {
    let times = own_number("times", 1)?;
    let mut arm = mp.robot::<Serial<6>>("arm")?;
    let here = arm.demanded().joints;
    let there = here + Six::new(0.5, -0.2, 0.2, 0.0, 0.3, 0.0);
    for _ in 0..times {
        for goal in [there, here] {
            mp.move_robot(&mut arm, (), JointMove::to(goal, Six::repeat(1.0), Six::repeat(4.0)))?;
        }
    }
    if own_option("wrench").is_some() {
        let mut wrist = mp.sensor::<WristForce>("wrist")?;
        let Felt(Wrench { force: f, torque: t }, _) =
            mp.wait_until((&mut arm,), (&mut wrist,), Felt::default())?;
        println!("wrench {} {} {} {} {} {}", f.x, f.y, f.z, t.x, t.y, t.z);
    }
    Ok(())
}
