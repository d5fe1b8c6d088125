//! The transfer with both arms, both hands and the bar in MuJoCo: `cargo run -p mrroc-examples --example transfer_mujoco -- --cell
//! tasks/transfer/examples/mujoco.toml --virtual` while `transfer_mujoco.py` runs beside it; with `--simulated` in place of
//! `--virtual` in the task's own simulation. The programs are those of the task. With `-- --sensors` it is the one that reads the
//! wrists' forces: those that MuJoCo tells.

use std::process::ExitCode;

use mrroc::cell_file::{Kinds, RobotEntry};
use mrroc::launch::own_option;
use mrroc::prelude::*;
use mrroc_external::plant;
use mrroc_robots::grasp::{Fingers, SimulatedWrist};
use mrroc_robots::sensors::RobotWrench;
use mrroc_robots::{Gripper, Simulated};
use transfer::places::EDGES;
use transfer::plant::{Plant, hand};
use transfer::{cell, mp, sensed};

fn main() -> ExitCode {
    mrroc::launch(task, mrroc_pictures::Film::new())
}

fn task(file: &CellFile) -> Result<Cell, CellError> {
    let around = Plant::new(Pose::identity()).map_err(|bad| Fault::thrown(&bad.to_string()))?;
    let cell = cell(file, &kinds(&around).plants(plant))?;
    if own_option("sensors").is_none() {
        return Ok(cell.program(mp::coordinate));
    }
    let hands = ["rnt", "polycrank"].into_iter().filter_map(|arm| Some((arm, around.hand_of(arm)?)));
    let wrist = |hand| RobotWrench::new().or_simulated(SimulatedWrist::new(hand));
    let setup = |(arm, hand)| SensorSetup::new(&format!("{arm}-wrist"), wrist(hand)).of(arm);
    Ok(hands.map(setup).fold(cell, Cell::sensor).program(sensed::coordinate))
}

/// The kinds of the task. All robots of a simulator have one servo period, so hands have that of the arms.
fn kinds(around: &Plant) -> Kinds {
    let bar = around.clone();
    around.kinds().with("hand", move |entry: &RobotEntry| {
        let refused = |what: String| entry.refuse_start(what, "call it ARM-hand, below its arm".to_owned());
        let arm = entry.name().trim_end_matches("-hand");
        let on = bar.hand_of(arm).ok_or_else(|| refused(format!("`{}` is on no arm", entry.name())))?;
        let fingers =
            Fingers::new(Simulated::new(Gripper::new(), &entry.start(&Gripper::new())?), on, EDGES[1]);
        Ok(hand(fingers.map_err(|error| refused(error.to_string()))?))
    })
}
