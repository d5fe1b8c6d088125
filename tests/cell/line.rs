//! Two cells of an arm each under one MP: there and back, loosely.

use std::path::PathBuf;
use std::process::ExitCode;

use mrroc::cell::LowerCell;
use mrroc::launch::own_option;
use mrroc::operator::Latch;
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
    /// What it cannot.
    Fetch,
}

#[generator(mp)]
fn out() -> Always<(LowerCell, LowerCell), Job> {
    Always((Job::Turn { angle: 0.6 }, Job::Turn { angle: -0.4 }))
}

#[generator(mp)]
fn back() -> Always<(LowerCell, LowerCell), Job> {
    Always((Job::Turn { angle: 0.0 }, Job::Turn { angle: 0.0 }))
}

/// The left cell cannot do this.
#[generator(mp)]
fn fetch() -> Always<(LowerCell, LowerCell), Job> {
    Always((Job::Fetch, Job::Turn { angle: -0.4 }))
}

#[condition(mp)]
fn is_back(e: &State<(LowerCell,)>) -> bool {
    e.0.is_ready()
}

/// The MP's program of either cell.
fn arm(mp: &mut Mp) -> Result<(), Fault> {
    let mut arm = mp.robot::<Irp6>("arm")?;
    let rest = arm.demanded().joints;
    mp.serve_all(|mp, job: Job| match job {
        Job::Turn { angle } => {
            let there = JointMove::to(rest + Six::x() * angle, Six::repeat(0.4), Six::repeat(0.8));
            mp.move_robot(&mut arm, (), there).map(drop)
        }
        Job::Fetch => Err(Fault::thrown("there is no part")),
    })
}

fn line(file: &CellFile) -> Result<Cell, CellError> {
    let kinds = mrroc_robots::simulated();
    let dispensable = own_option(DISPENSABLE);
    // Whether a console resets the left cell, or its own program.
    let is_operated = dispensable.as_deref() == Some("operated");
    let mut latched = 0;
    let left = file.lower("left")?.cell(&kinds)?.program(arm).on_step(move |_, operator| {
        // Its operator comes after 200 steps.
        latched += u32::from(operator.latch() == Latch::Latched);
        if latched == 200 && !is_operated {
            let _ = operator.acknowledge().and_then(|()| operator.reset());
        }
    });
    let right = file.lower("right")?.cell(&kinds)?.program(arm);
    let cell = file.cell(&kinds)?.cell("left", left).cell("right", right).program(move |mp| {
        let (mut left, mut right) = (mp.robot::<LowerCell>("left")?, mp.robot::<LowerCell>("right")?);
        if dispensable.is_some() {
            mp.go_on_without(&left)?;
        }
        if matches!(dispensable.as_deref(), Some("resets" | "operated")) {
            mp.move_robots((&mut left, &mut right), (), fetch {})?;
            mp.left_out(&left).ok_or(Fault::thrown("the left cell took part"))?;
            mp.wait_until((&mut left,), (), is_back {})?;
        }
        mp.move_robots((&mut left, &mut right), (), out {})?;
        mp.move_robots((&mut left, &mut right), (), back {}).map(drop)
    });
    let cell = crate::suspended(cell);
    Ok(match own_option(RECORDS) {
        Some(folder) => cell.watch(crate::records::record(PathBuf::from(folder))),
        None => cell,
    })
}
