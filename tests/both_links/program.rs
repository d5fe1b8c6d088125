//! The tasks as the test runs them: the cells of the task programs, and a record of what each robot was demanded.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use engraving::NAMEPLATE;
use engraving::drawing::hershey::Font;
use engraving::drawing::{Limits, Vec2, read_str};
use engraving::layout::Layout;
use engraving::ordering::nearest_first;
use engraving::placement::{Plate, Sizing, place};
use engraving::plate::Cutter;
use engraving::run::Settings;
use engraving::sampling::Sampling;
use mrroc::{Cell, Clock, Launch, Ran};
use transfer::variant::{Bases, Sensors, Variant};

pub use crate::records::RECORDS;
use crate::records::record;

/// Runs the task that the command line names: `--cell FILE transfer LINK`, `--cell FILE engraving DRAWING LINK`.
pub fn main() -> ExitCode {
    match run() {
        Ok(status) => status,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<ExitCode, Box<dyn Error>> {
    let launch = Launch::new(std::env::args_os().skip(1)).quiet();
    let words: Vec<_> =
        launch.arguments().iter().skip(2).map(|word| word.to_string_lossy().into_owned()).collect();
    let (cell, link) = match &words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["transfer", link] => (carrying()?, *link == "processes"),
        ["engraving", drawing, link] => (engraving(drawing)?, *link == "processes"),
        _ => return Err(format!("no task: {words:?}").into()),
    };
    let folder = std::env::var_os(RECORDS).ok_or("no folder for records")?;
    let launch = if link { launch.processes(Clock::Virtual) } else { launch };
    Ok(match launch.run(cell.watch(record(PathBuf::from(folder))))? {
        Ran::Part(status) => status,
        Ran::Here(_) | Ran::Processes(_) => ExitCode::SUCCESS,
    })
}

/// Two arms, two hands, a bar between them, a base that is off, and the force sensors that make up for it.
fn carrying() -> Result<Cell, Box<dyn Error>> {
    let file = transfer::file()?;
    Ok(Variant::Bar { bases: Bases::Off, sensors: Sensors::Used }.ready(&file)?.cell)
}

/// An arm that finds the plate by its probe and engraves a text, or the nameplate.
fn engraving(drawing: &str) -> Result<Cell, Box<dyn Error>> {
    let import = match drawing {
        "nameplate" => read_str("nameplate.svg", NAMEPLATE, Limits::default())?,
        text => Font::open("futural")?.write(text, 10.0)?,
    };
    let plate = Plate::default();
    let placed = place(&import.drawing, &plate, Sizing::Natural)?;
    let drawing = nearest_first(placed.drawing, Vec2::zeros());
    let layout = Layout::new(&plate)?;
    let settings = Settings { step: 0.002, feed: 20.0, depth: 0.3, cutter: Cutter::default() };
    Ok(engraving::run::cell(&layout, &plate, &drawing, Sampling::default(), settings))
}
