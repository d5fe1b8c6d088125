//! The two-arm transfer with one arm on another machine: `cargo run -p mrroc-zenoh --example transfer -- --cell FOLDER/cell.toml
//! --processes`, while `.. --example transfer -- --cell FOLDER/cell.toml node b` runs on the other one. It is the task of
//! `tasks/transfer` without the bar, because each machine simulates its own arm.
//!
//! The first line of `main` is all that a program needs for this. With `MRROC_TRACE=FOLDER` each arm's process writes there
//! what was demanded in every servo period: the time [s] and the joints [rad], as numbers of 8 bytes.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use mrroc::prelude::*;
use mrroc_robots::{Polycrank, Rnt};

fn main() -> ExitCode {
    mrroc::launch::nodes_over(&mrroc_zenoh::Zenoh);
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let cell = transfer::cell(file, &transfer::plant::drives())?.program(coordinate);
    Ok(match std::env::var_os("MRROC_TRACE") {
        Some(folder) => traced(cell, folder.into()),
        None => cell,
    })
}

/// The task, and then where the arms have come to.
fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    transfer::mp::coordinate(mp)?;
    let (rnt, polycrank) = (mp.robot::<Rnt>("rnt")?, mp.robot::<Polycrank>("polycrank")?);
    println!("end of rnt {:.9?}", rnt.demanded().joints.as_slice());
    println!("end of polycrank {:.9?}", polycrank.demanded().joints.as_slice());
    Ok(())
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
