//! The two-arm transfer with one arm on another machine: `cargo run -p mrroc-zenoh --example transfer -- --cell FOLDER/cell.toml
//! --processes`, while `.. --example transfer -- --cell FOLDER/cell.toml node b` runs on the other one. It is the task of
//! `tasks/transfer` without the bar, because each machine simulates its own arm.
//!
//! The first line of `main` is all that a program needs for this. Behind a `--`, with `--trace FOLDER` each robot's process writes there
//! what was demanded in every servo period: the time [s] and the joints [rad or m], as numbers of 8 bytes. With
//! `--loose N` the arms only turn to and fro, N times, each by itself (a loose motion, by joints).

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use mrroc::launch::own_option;
use mrroc::prelude::*;
use mrroc::robot::JointVector;
use mrroc_generators::generators::JointMove;
use mrroc_robots::{Polycrank, Rnt};
use transfer::generators::Trigger;
use transfer::orders::Phase;

fn main() -> ExitCode {
    mrroc::launch::nodes_over(&mrroc_zenoh::Zenoh);
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let kinds = transfer::plant::drives();
    let times = own_option("loose")
        .map(|times| times.parse::<u32>())
        .transpose()
        .map_err(|_| Fault::thrown("--loose needs a number"))?;
    let cell = match times {
        Some(times) => file
            .cell(&kinds)?
            .ecp("rnt", with_start(file, Rnt::new())?)
            .ecp("polycrank", with_start(file, Polycrank::new())?)
            .program(move |mp| loosely(mp, times)),
        None => transfer::cell(file, &kinds)?.program(transfer::mp::coordinate),
    };
    Ok(match own_option("trace") {
        Some(folder) => traced(cell, folder.into()),
        None => cell,
    })
}

/// The program of an arm that starts where the cell file says.
fn with_start<R: Robot>(
    file: &CellFile,
    arm: R,
) -> Result<impl FnMut(&mut Ecp<R>) -> Result<(), Fault> + 'static, CellError> {
    let entry = file.robots().iter().find(|entry| entry.kind() == R::KIND);
    let start = entry.ok_or(CellError::NoProgram)?.start(&arm)?;
    Ok(move |ecp: &mut Ecp<R>| to_and_fro(ecp, &start))
}

/// Both arms to and fro, each by itself.
fn loosely(mp: &mut Mp, times: u32) -> Result<(), Fault> {
    let (mut rnt, mut polycrank) = (mp.robot::<Rnt>("rnt")?, mp.robot::<Polycrank>("polycrank")?);
    for _ in 0..times {
        mp.move_robots((&mut rnt, &mut polycrank), (), Trigger::to(Phase::Approach))?;
        mp.move_robots((&mut rnt, &mut polycrank), (), Trigger::to(Phase::Withdraw))?;
    }
    Ok(())
}

/// The first joint by 0.1 rad in some seconds, and back to where the cell file starts it.
fn to_and_fro<R: Robot>(ecp: &mut Ecp<R>, start: &R::Joints) -> Result<(), Fault> {
    let each = |value: f64| R::Joints::from_joints(|_| value);
    ecp.serve_all(|ecp, phase: Phase| {
        let distance = phase.choose([(Phase::Approach, 0.1), (Phase::Withdraw, 0.0)])?;
        let goal = R::Joints::from_joints(|i| start[i] + if i == 0 { distance } else { 0.0 });
        ecp.move_robot((), JointMove::to(goal, each(0.05), each(0.04))).map(drop)
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
