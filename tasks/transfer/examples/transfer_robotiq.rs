//! The transfer with a Robotiq gripper as the hand of one arm: `cargo run -p mrroc-examples --example transfer_robotiq -- --cell
//! tasks/transfer/examples/robotiq.toml --processes`, where a gripper is at the address of that file; with `--simulated` in
//! place of `--processes` a simulated one stands in. The arms are simulated, and the programs are those of the task.

use std::process::ExitCode;

use mrroc::prelude::*;
use mrroc_robotiq::{Openings, PORT, Robotiq, RobotiqSettings};
use mrroc_robots::{Gripper, Simulated};
use transfer::plant::{drives, hand};
use transfer::{cell, mp};

/// Fingertips whose stroke is that of the task's hands: 91 mm to 53 mm.
const OPENINGS: Openings = Openings { widest: (0.091, 3), narrowest: (0.053, 230) };

fn main() -> ExitCode {
    mrroc::launch(task, mrroc_pictures::Film::new())
}

fn task(file: &CellFile) -> Result<Cell, CellError> {
    let kinds = drives().with("robotiq hand", |entry| {
        let settings =
            RobotiqSettings { openings: OPENINGS, ..RobotiqSettings::new(entry.address_and_port(PORT)?) };
        let stand_in = Simulated::new(Gripper::new(), &entry.start(&Gripper::new())?);
        Ok(hand(Robotiq::new(settings)).stand_in(stand_in))
    });
    Ok(cell(file, &kinds)?.program(mp::coordinate))
}
