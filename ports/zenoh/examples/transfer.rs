//! The two-arm transfer with one arm on another machine: `cargo run -p mrroc-zenoh --example transfer -- --cell FOLDER/cell.toml
//! --processes`, while `.. --example transfer -- --cell FOLDER/cell.toml node b` runs on the other one. It is the task of
//! `tasks/transfer` without the bar, because each machine simulates its own arm.
//!
//! The first line of `main` is all that a program needs for this. With `MRROC_TRACE=FOLDER` each robot's process writes there
//! what was demanded in every servo period: the time [s] and the joints [rad or m], as numbers of 8 bytes. With
//! `MRROC_LOOSE=N` the arms only go to their grasps and back, N times, each by itself.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use mrroc::prelude::*;
use mrroc_generators::generators::StraightLine;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Polycrank, Rnt};
use transfer::generators::Nudge;
use transfer::orders::Phase;

fn main() -> ExitCode {
    mrroc::launch::nodes_over(&mrroc_zenoh::Zenoh);
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let kinds = transfer::plant::drives();
    let times = std::env::var("MRROC_LOOSE").ok().and_then(|times| times.parse::<u32>().ok());
    let cell = match times {
        Some(times) => file
            .cell(&kinds)?
            .ecp("rnt", |ecp: &mut Ecp<Rnt>| to_and_fro(ecp))
            .ecp("polycrank", |ecp: &mut Ecp<Polycrank>| to_and_fro(ecp))
            .program(move |mp| loosely(mp, times)),
        None => transfer::cell(file, &kinds)?.program(transfer::mp::coordinate),
    };
    Ok(match std::env::var_os("MRROC_TRACE") {
        Some(folder) => traced(cell, folder.into()),
        None => cell,
    })
}

/// Both arms up and down, each by itself.
fn loosely(mp: &mut Mp, times: u32) -> Result<(), Fault> {
    let (mut rnt, mut polycrank) = (mp.robot::<Rnt>("rnt")?, mp.robot::<Polycrank>("polycrank")?);
    for _ in 0..times {
        mp.move_robots((&mut rnt, &mut polycrank), (), Nudge::to(Phase::Approach))?;
        mp.move_robots((&mut rnt, &mut polycrank), (), Nudge::to(Phase::Withdraw))?;
    }
    Ok(())
}

/// 0.1 m along the axis of the tool, or back, in two seconds.
fn to_and_fro<R: Robot>(ecp: &mut Ecp<R>) -> Result<(), Fault> {
    let motion = ProfileLimits { velocity: 0.1, acceleration: 0.2 };
    let limits = ToolLimits { translation: motion, rotation: motion };
    ecp.obey_all(|ecp, phase: Phase| {
        let z = phase.choose([(Phase::Approach, -0.1), (Phase::Withdraw, 0.1)])?;
        ecp.move_robot((), StraightLine::by(Pose::translation(0.0, 0.0, z), limits)).map(drop)
    })
}

/// The cell, whose arms write what is demanded of them into files of this folder.
fn traced(cell: Cell, folder: PathBuf) -> Cell {
    let files = RefCell::new(BTreeMap::new());
    cell.watch(move |seen| {
        let mut files = files.borrow_mut();
        let file = files.entry(seen.robot.to_owned()).or_insert_with(|| {
            File::create(folder.join(format!("{}.trace", seen.robot))).map(BufWriter::new).ok()
        });
        if let Some(file) = file {
            for number in std::iter::once(&seen.time).chain(seen.demanded) {
                // A disk that is full ends the trace and nothing else.
                let _ = file.write_all(&number.to_le_bytes());
            }
        }
    })
}
