//! Two cells of an arm each under one MP: there and back, loosely.

use std::path::PathBuf;
use std::process::ExitCode;

use mrroc::cell::LowerCell;
use mrroc::prelude::*;
use mrroc_generators::generators::JointMove;
use mrroc_robots::{Irp6, Six};
use mrroc_tests::fixture::{DISPENSABLE, RECORDS};

use crate::Nothing;

/// Runs it under the options of the command line.
pub fn main() -> ExitCode {
    mrroc::launch(line, Nothing)
}

/// What a cell is told.
#[derive(Clone, Copy, Payload)]
enum Job {
    /// By this angle of the column from where it began \[rad\].
    Turn { angle: f64 },
}

#[generator(mp)]
fn out() -> Always<(LowerCell, LowerCell), Job> {
    Always((Job::Turn { angle: 0.6 }, Job::Turn { angle: -0.4 }))
}

#[generator(mp)]
fn back() -> Always<(LowerCell, LowerCell), Job> {
    Always((Job::Turn { angle: 0.0 }, Job::Turn { angle: 0.0 }))
}

/// The MP's program of either cell.
fn arm(mp: &mut Mp) -> Result<(), Fault> {
    let mut arm = mp.robot::<Irp6>("arm")?;
    let rest = arm.demanded().joints;
    mp.obey_all(|mp, Job::Turn { angle }| {
        let there = JointMove::to(rest + Six::x() * angle, Six::repeat(0.4), Six::repeat(0.8));
        mp.move_robot(&mut arm, (), there).map(drop)
    })
}

fn line(file: &CellFile) -> Result<Cell, CellError> {
    let kinds = mrroc_robots::simulated();
    let left = file.lower("left")?.cell(&kinds)?.program(arm);
    let right = file.lower("right")?.cell(&kinds)?.program(arm);
    let cell = file.cell(&kinds)?.cell("left", left).cell("right", right).program(|mp| {
        let (mut left, mut right) = (mp.robot::<LowerCell>("left")?, mp.robot::<LowerCell>("right")?);
        if std::env::var_os(DISPENSABLE).is_some() {
            mp.go_on_without(&left)?;
        }
        mp.move_robots((&mut left, &mut right), (), out {})?;
        mp.move_robots((&mut left, &mut right), (), back {}).map(drop)
    });
    Ok(match std::env::var_os(RECORDS) {
        Some(folder) => cell.watch(crate::records::record(PathBuf::from(folder))),
        None => cell,
    })
}
