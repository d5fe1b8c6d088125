//! Moves a KUKA arm to and fro: `cargo run -p mrroc-examples --example kuka -- --cell robots/drivers/kuka/examples/cell.toml
//! --simulated`, and with `--processes` in its place where a controller is at the address of that file.
//!
//! `--times` behind a `--` says how often, once by default; each time takes two seconds. With `signals.toml` the arm grips something there, and
//! lets it go here.

use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc::robot::Input;
use mrroc_generators::generators::{JointMove, Tell};
use mrroc_kuka::with_rsi;
use mrroc_robots::{Serial, Six, simulated};

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    Ok(file.cell(&with_rsi(simulated()))?.program(to_and_fro))
}

/// Holds when the switch reads so.
struct Reads(Input<bool>, bool);

#[condition(mp)]
fn reads(c: &mut Reads, e: &State<(Serial<6>,)>) -> bool {
    e.0.value(c.0) == c.1
}

fn to_and_fro(mp: &mut Mp) -> Result<(), Fault> {
    let times = own_number("times", 1)?;
    let mut arm = mp.robot::<Serial<6>>("arm")?;
    let here = arm.demanded().joints;
    let there = here + Six::new(0.5, -0.2, 0.2, 0.0, 0.3, 0.0);
    for _ in 0..times {
        for (goal, grips) in [(there, true), (here, false)] {
            mp.move_robot(&mut arm, (), JointMove::to(goal, Six::repeat(1.0), Six::repeat(4.0)))?;
            if let (Ok(gripper), Ok(gripped)) = (arm.output::<bool>("gripper"), arm.input::<bool>("gripped"))
            {
                mp.move_robot(&mut arm, (), Tell::output(gripper, grips))?;
                mp.wait_at_most((&mut arm,), (), Reads(gripped, grips), 500)?;
            }
        }
    }
    Ok(())
}
