//! The command line of a task program: finds `cell.toml`, runs the cell and reports how the run ended.
//!
//! In: a function that makes a cell from a [`CellFile`], and a [`RunPicture`]. Out: a run, its picture, and an exit
//! status.

mod approach;
pub mod cell_file;
mod dry_run;
mod external;
pub mod files;
pub mod long_run;
pub mod network;
mod options;
pub mod outcome;
pub mod outcome_file;
mod own;
pub mod panel;
mod parts;
mod program;
mod running;
mod table;
mod telling;

use core::time::Duration;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use mrroc_core::cell::{Cell, CellError, RunPicture};
use mrroc_core::console::{refused, say};
use mrroc_core::link::Clock;
use mrroc_core::link::timeout::together_budget;
use mrroc_core::observe::NotRecorded;
use mrroc_core::observe::layout::{HardwareLayout, Layout};

use crate::cell_file::{CellFile, is_arm};
use crate::dry_run::{dry_run, dry_run_first};
use crate::files::{check_outputs, recorded};
use crate::options::{LaunchCommand, Options, nearest_cell, parse};
use crate::outcome::{answered, cell_refused, note, stand_ins};
use crate::outcome_file::check_outcome;
use crate::running::{run, watched};
use crate::table::Table;
use crate::telling::PartRequest;

pub use crate::options::Operating;
pub use crate::own::{own_number, own_option};
pub use crate::parts::{Launch, Panel, Parts, Processes, Ran, Replays, RunObserver};

/// The main function of a task program: `cell` makes a cell from `cell.toml`, and this function runs it with the
/// options of the command line.
///
/// With `--processes` the same executable is every process of the cell: each process calls `cell` again and runs its
/// own part of that cell. So `cell` must make the same cell at every call: it may read files, but it must not open
/// anything that only one process may have, and must not move anything. Real drives are opened by
/// [`Driver::open`](mrroc_core::robot::Driver::open), which only their EDP calls. The process `plant`, which has the
/// simulated robots, draws the picture when the run is over. For a cell without simulated robots no picture is drawn.
pub fn launch(
    cell: impl FnOnce(&CellFile) -> Result<Cell, CellError>,
    picture: impl RunPicture,
    parts: &'static Parts,
) -> ExitCode {
    let options = match parse(std::env::args_os().skip(1)) {
        Ok(options) => options,
        Err(answer) => return answered(&answer),
    };
    let path = options.cell.clone().unwrap_or_else(nearest_cell);
    match &options.word {
        Some(LaunchCommand::Doctor) => return parts.examine_with(&path),
        Some(LaunchCommand::Operating(word)) => {
            return word.read().map_or_else(
                |error| refused(&error),
                |operating| parts.operate(&path, options.of, operating),
            );
        }
        _ if options.of.is_some() => {
            return refused(
                &"--of names the cell that is asked\n help: it goes with status, suspend, reset and the like",
            );
        }
        Some(
            LaunchCommand::Replay { .. }
            | LaunchCommand::Calibration { .. }
            | LaunchCommand::ExportUrdf { .. }
            | LaunchCommand::External { .. }
            | LaunchCommand::Node { .. }
            | LaunchCommand::Certificates { .. }
            | LaunchCommand::Gateway { .. }
            | LaunchCommand::Panel { .. },
        )
        | None => {}
    }
    let assembled = CellFile::read(&path)
        .map_err(CellError::from)
        .and_then(|file| Ok((cell(&file)?, file)))
        .and_then(|(mut cell, file)| cell.check().map(|_| (parts.equip(cell), file)));
    let (mut cell, file) = match assembled {
        Ok(assembled) => assembled,
        Err(error) => return cell_refused(&error),
    };
    let asked = match &options.word {
        Some(LaunchCommand::Calibration { robot }) => Some((PartRequest::Calibration, robot)),
        Some(LaunchCommand::ExportUrdf { robot }) => Some((PartRequest::Urdf, robot)),
        Some(LaunchCommand::External { name }) => Some((PartRequest::Python, name)),
        Some(LaunchCommand::Certificates { folder }) => Some((PartRequest::Certificates, folder)),
        Some(LaunchCommand::Gateway { name }) => Some((PartRequest::Gateway, name)),
        Some(
            LaunchCommand::Node { .. }
            | LaunchCommand::Doctor
            | LaunchCommand::Operating(_)
            | LaunchCommand::Replay { .. }
            | LaunchCommand::Panel { .. },
        )
        | None => None,
    };
    if let Some(LaunchCommand::Panel { recording }) = &options.word {
        return parts.show(&cell, &path, recording.as_deref());
    }
    if let Some((asked, name)) = asked {
        return telling::tell(&mut cell, &path, name, asked);
    }
    // A plain run is under the virtual clock, which no hardware follows: where robots are simulated anyway, so are their sensors.
    let is_plain = options.is_plain() && has_real_sensors_alone(&cell.layout());
    if (options.simulates() || is_plain) && !options.check {
        cell = match cell.simulated() {
            Ok(cell) => cell,
            Err(error) => return cell_refused(&error),
        };
        if (options.simulated || is_plain) && options.part.is_none() && !options.quiet {
            stand_ins(&cell.layout()).for_each(|told| note(&told));
        }
    }
    if let Some(LaunchCommand::Node { name }) = &options.word {
        return node(cell, name, path, &options, parts);
    }
    if options.reduced {
        if options.clock() != Some(Clock::Real) {
            return refused(
                &"nobody can hold a key under the virtual clock\n help: --reduced goes with --processes",
            );
        }
        cell.operator().set_reduced(true);
    }
    if let Some(file) = &options.recording.file {
        cell = cell.record_to(file);
    }
    if let Some(folder) = options.recording.frames.as_ref().filter(|_| !options.dry_run) {
        if options.part.is_none()
            && let Err(error) = check_frames(folder, cell.recorder().is_some())
        {
            return refused(&error);
        }
        cell = cell.frames_to(folder);
    }
    let clock = options.clock();
    let writes =
        options.outcome.is_some() || options.recording.file.is_some() || options.recording.frames.is_some();
    if writes && options.part.is_none() && (options.check || options.dry_run && clock.is_none()) {
        return refused(
            &"a check and a dry run write no outcome, no recording and no frames\n help: leave those options out, or run the cell",
        );
    }
    let is_run = options.part.is_none() && options.word.is_none() && !options.dry_run;
    if is_run
        && let Err(error) = check_outputs(
            options.picture().into_iter().chain(recorded(&cell)).chain(options.outcome.as_deref()),
        )
    {
        return refused(&error);
    }
    if is_run
        && let Some(file) = &options.outcome
        && let Err(error) = check_outcome(file)
    {
        return refused(&error);
    }
    if options.check {
        let link = match clock {
            None => "memory, under the virtual clock",
            Some(Clock::Virtual) => "iceoryx2, under the virtual clock",
            Some(Clock::Real) => "iceoryx2, in real time",
        };
        let table = Table::of(&cell, link).to_string();
        let questions = questions(&file, &cell.layout());
        let well = format!("{}: nothing is wrong with the cell\n\n{table}{questions}", path.display());
        // No driver has been opened. Whether anything could stand in for those of real drives is known only if it is made.
        let well = match cell.simulated() {
            Ok(_) => well,
            Err(error) => format!("{well}\nneither a dry run nor `--simulated` is possible:\n{error}\n"),
        };
        return if options.quiet { ExitCode::SUCCESS } else { say(&well) };
    }
    if options.panel
        && let Err(status) = panel::check(parts, clock, options.dry_run)
    {
        return status;
    }
    if options.part.is_none() && clock.is_none() {
        return match &options.word {
            Some(LaunchCommand::Replay { file, partial }) => {
                parts.replay(cell, file, *partial, options.quiet)
            }
            _ if options.dry_run => dry_run(cell, options.quiet),
            _ => run(cell, picture, &options, parts),
        };
    }
    if options.part.is_none()
        && (options.dry_run || (cell.demands_dry_run() && clock == Some(Clock::Real)))
        && let Err(status) = dry_run_first(&path, options.quiet)
    {
        return status;
    }
    if options.part.is_none() && clock == Some(Clock::Real) && !options.quiet && lacks_priority(&cell) {
        note(&no_priority(cell.step_length()));
    }
    let is_shown = options.panel && options.part.is_none();
    let _panel =
        is_shown.then(|| panel::begin([OsString::from("panel"), "--cell".into(), path.clone().into()]));
    watched(cell, picture, path, options, parts)
}

/// Whether some sensors of a cell read hardware, and no robot has any.
fn has_real_sensors_alone(layout: &Layout) -> bool {
    let is_real = |hardware: &HardwareLayout| match hardware {
        HardwareLayout::Real(_) | HardwareLayout::Simulator(_) => true,
        HardwareLayout::Nothing | HardwareLayout::StandIn(_) => false,
    };
    layout.sensors.iter().any(|sensor| is_real(&sensor.hardware))
        && !layout.robots.iter().any(|robot| is_real(&robot.drives))
}

/// What is said of a cell with several arms that asks for no priority, in steps of so long.
fn no_priority(step: Duration) -> String {
    format!(
        "no priority is asked of this machine: arms that one Move leads by poses stop together when it is late by more than {} steps\n help: write [realtime] into cell.toml, with priority = 50 and permission = \"best effort\"",
        together_budget(step)
    )
}

/// Whether a cell has several arms, and asks for no priority.
fn lacks_priority(cell: &Cell) -> bool {
    cell.realtime().is_none() && cell.layout().robots.iter().filter(is_arm).count() > 1
}

/// What is improbable in a cell, as `--check` asks about it.
fn questions(file: &CellFile, layout: &Layout) -> String {
    let of_file = file
        .questions()
        .map(|asked| format!("\nquestion: {}\n", asked.to_string().replace("\nerror: ", "\nquestion: ")));
    let in_one_place = file.arms_in_one_place(layout).into_iter().map(|[a, b]| {
        format!("\nquestion: robots `{a}` and `{b}` stand in one place\n help: give each a `base` of its own, where it stands in the world\n")
    });
    of_file.into_iter().chain(in_one_place).collect()
}

/// Has the processes of a node.
fn node(cell: Cell, name: &str, path: PathBuf, options: &Options, parts: &'static Parts) -> ExitCode {
    let mut arguments: Vec<_> = std::env::args_os().skip(1).collect();
    // Its processes are started with the other arguments.
    if let Some(at) =
        arguments.iter().zip(arguments.iter().skip(1)).position(|(word, of)| word == "node" && of == name)
    {
        arguments.drain(at..at + 2);
    }
    let launch = Launch { arguments, cell: Some(path), quiet: options.quiet, ..Launch::new([], parts) };
    parts.node(cell, name, launch)
}

/// Refuses a folder for frames that has anything in it, before the run: no image is written over another one.
fn check_frames(folder: &Path, can_record: bool) -> Result<(), String> {
    let folder_name = folder.display();
    if !can_record {
        return Err(NotRecorded::NoFeature.to_string());
    }
    let is_empty =
        std::fs::create_dir_all(folder).and_then(|()| Ok(std::fs::read_dir(folder)?.next().is_none()));
    match is_empty {
        Ok(true) => Ok(()),
        Ok(false) => {
            Err(format!("{folder_name}: has files already\n help: give an empty folder by --frames"))
        }
        Err(error) => {
            Err(format!("{folder_name}: cannot be written: {error}\n help: give another folder by --frames"))
        }
    }
}
