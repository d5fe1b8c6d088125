//! Closes a gripper on a part, carries it by a simulated arm and opens it: `cargo run -p mrroc-examples --example robotiq --
//! --cell robots/drivers/robotiq/examples/cell.toml --simulated`, and with `--processes` in its place where a gripper is at
//! the address of that file.
//!
//! `--times` behind a `--` says how often, once by default.

use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc_generators::conditions::elapsed;
use mrroc_generators::generators::JointMove;
use mrroc_robotiq::with_robotiq;
use mrroc_robots::{Irp6, One, Six, TwoFingers, simulated};

/// Openings around the part and, pressing on it, beyond it \[m\].
const OPEN: f64 = 0.08;
const CLOSED: f64 = 0.01;

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    Ok(file.cell(&with_robotiq(simulated()))?.program(carry))
}

fn carry(mp: &mut Mp) -> Result<(), Fault> {
    let times = own_number("times", 1)?;
    let (mut arm, mut hand) = (mp.robot::<Irp6>("arm")?, mp.robot::<TwoFingers>("hand")?);
    let here = arm.demanded().joints;
    let there = here + Six::x() * 0.3;
    let to = |opening| JointMove::to(One::new(opening), One::new(0.05), One::new(0.2));
    for _ in 0..times {
        mp.move_robot(&mut hand, (), to(OPEN))?;
        mp.move_robot(&mut hand, (), to(CLOSED))?;
        mp.wait_until((&mut hand,), (), elapsed(0.5))?;
        // Fingers that have come as far as they were told hold nothing.
        if hand.measured().joints[0] > CLOSED + 2e-3 {
            for goal in [there, here] {
                mp.move_robot(&mut arm, (), JointMove::to(goal, Six::repeat(0.4), Six::repeat(0.8)))?;
            }
        }
        mp.move_robot(&mut hand, (), to(OPEN))?;
    }
    Ok(())
}
