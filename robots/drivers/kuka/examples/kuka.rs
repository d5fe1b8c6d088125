//! Moves a KUKA arm to and fro: `cargo run -p mrroc-kuka --example kuka -- --cell robots/drivers/kuka/examples/cell.toml
//! --simulated`, and with `--processes` in its place where a controller is at the address of that file.
//!
//! `MRROC_TIMES` says how often, once by default; each time takes two seconds.

use mrroc_generators::generators::JointMove;
use mrroc_kuka::with_rsi;
use mrroc_robots::{Serial, Six, simulated};
use mrroc_runtime::prelude::*;

fn main() -> std::process::ExitCode {
    mrroc_runtime::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    Ok(file.cell(&with_rsi(simulated()))?.program(to_and_fro))
}

fn to_and_fro(mp: &mut Mp) -> Result<(), Fault> {
    let times = std::env::var("MRROC_TIMES").ok().and_then(|times| times.parse().ok()).unwrap_or(1);
    let mut arm = mp.robot::<Serial<6>>("arm")?;
    let here = arm.demanded().joints;
    let there = here + Six::new(0.5, -0.2, 0.2, 0.0, 0.3, 0.0);
    for _ in 0..times {
        for goal in [there, here] {
            mp.move_robot(&mut arm, (), JointMove::to(goal, Six::repeat(1.0), Six::repeat(4.0)))?;
        }
    }
    Ok(())
}
