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
use engraving::run::{Settings, Watch};
use engraving::sampling::Sampling;
use mrroc::cell::{Cell, RunPicture, RunReport};
use mrroc::launch::{Clock, Ran, own_option};
use mrroc_pictures::Film;
use mrroc_tests::fixture::{RECORDS, SEEN};
use transfer::pictures::filmed;
use transfer::variant::{Bases, Sensors, Variant};

use crate::records::record;

/// What observers have seen, as a text, once the run is over; none where they see nothing.
type Seen = Option<Box<dyn FnOnce(RunReport) -> String>>;

/// Runs the task that the command line names: `--cell FILE transfer LINK`, `--cell FILE engraving DRAWING LINK`, `--cell FILE
/// belt LINK`, `--cell FILE readers LINK`.
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
    // Each test has a folder with a cell file of its own: without it, the cell would be that of the executable.
    let launch = mrroc::launch::program(std::env::args_os().skip(1)).quiet().cell_file("cell.toml");
    let words = launch.arguments().iter().map(|word| word.to_string_lossy().into_owned());
    let words: Vec<_> = words.skip(2).take_while(|word| word != "--").collect();
    let named = words.last().is_some_and(|link| link == "processes");
    let launch = if named { launch.processes(Clock::Virtual) } else { launch }.watching();
    let (cell, seen) = match &words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["transfer", _] => carrying(launch.is_here())?,
        ["belt", _] => pictured(crate::belt::cell(), launch.is_here()),
        ["readers", _] => pictured(crate::readers::cell(), launch.is_here()),
        ["engraving", drawing, _] => engraving(drawing, launch.is_here())?,
        _ => return Err(format!("no task: {words:?}").into()),
    };
    let folder = own_option(RECORDS).ok_or("no folder for records")?;
    let folder = PathBuf::from(folder);
    // Demands are recorded where they are made, and not a second time in the plant.
    let is_plant = launch.is_part() && launch.is_here();
    let cell = if is_plant { cell } else { cell.watch(record(folder.clone())) };
    Ok(match (launch.run(cell)?, seen) {
        (Ran::Part(status), _) => status,
        (Ran::Here(report), Some(seen)) => {
            std::fs::write(folder.join(SEEN), seen(report))?;
            ExitCode::SUCCESS
        }
        (Ran::Here(_) | Ran::Processes(_), _) => return Err("nobody has seen the robots".into()),
    })
}

/// How long the run took, and its picture.
fn pictured(cell: Cell, here: bool) -> (Cell, Seen) {
    if !here {
        return (cell, None);
    }
    let mut film = Film::new();
    let cell = film.watch(cell);
    (cell, Some(Box::new(move |report| format!("{:?}\n{}", report.time, film.svg()))))
}

/// Two arms, two hands, a bar between them, a base that is off, and the force sensors that make up for it; its film.
fn carrying(here: bool) -> Result<(Cell, Seen), Box<dyn Error>> {
    let file = transfer::file()?;
    let ready = Variant::Bar { bases: Bases::Off, sensors: Sensors::Used }.ready(&file)?;
    if !here {
        return Ok((ready.cell, None));
    }
    let (film, cell) = filmed(ready);
    Ok((cell, Some(Box::new(move |_| film.svg()))))
}

/// An arm that finds the plate by its probe and engraves a text, or the nameplate; what was measured of it.
fn engraving(drawing: &str, here: bool) -> Result<(Cell, Seen), Box<dyn Error>> {
    let import = match drawing {
        "nameplate" => read_str("nameplate.svg", NAMEPLATE, Limits::default())?,
        text => Font::open("futural")?.write(text, 10.0)?,
    };
    let plate = Plate::default();
    let placed = place(&import.drawing, &plate, Sizing::Natural)?;
    let drawing = nearest_first(placed.drawing, Vec2::zeros());
    let layout = Layout::new(&plate)?;
    let settings = Settings { step: 0.002, feed: 20.0, depth: 0.3, cutter: Cutter::default() };
    if !here {
        return Ok((engraving::run::cell(&layout, &plate, &drawing, Sampling::default(), settings), None));
    }
    let (cell, watch) = Watch::over(&layout, &plate, &drawing, Sampling::default(), settings);
    let measured = |report| {
        let outcome = watch.outcome(report);
        let (execution, height) = (&outcome.execution, outcome.height_found);
        let [demanded, executed] = [&execution.demanded, &execution.executed].map(|path| path.report());
        let lengths = [execution.cut_length, execution.travel_length];
        format!("{:?} {height:?} {lengths:?} {demanded:?} {executed:?}\n", outcome.report)
    };
    Ok((cell, Some(Box::new(measured))))
}
