//! Parts on a moving belt are sensed, acquired and sorted: `cargo run --release -p sorting -- --help`.

use std::error::Error;
use std::io;
use std::path::Path;
use std::process::ExitCode;
use std::time::SystemTime;

use mrroc::console::{complain, refused, say};
use mrroc::launch::Launch;
use sorting::camera::command;
use sorting::left;
use sorting::matrix;
use sorting::options::{Options, parse};
use sorting::pictures::{filmed, scatter, time_line};
use sorting::run::{Sensing, Settings};
use sorting::scopes::SensorKind;
use sorting::summary::{Row, Summary};

/// So many parts are filmed.
const FILMED: usize = 3;

fn main() -> ExitCode {
    let options = match parse(std::env::args_os().skip(1)) {
        Ok(options) => options,
        Err(answer) => return Launch::answer(&answer),
    };
    // A data set has its own file.
    if options.data_set.is_none()
        && let Err(error) = std::fs::create_dir_all(&options.out)
    {
        return refused(&unwritable(&options.out, &error));
    }
    let began = SystemTime::now();
    if options.sensor != SensorKind::Infrared {
        return overhead(&options, began);
    }
    let ran = match options.sweep {
        Some(seeds) => sweep(&options, seeds.into()),
        None => sort(&options),
    };
    match ran {
        Ok((all, text)) => answer(&options, &text, all.is_well(), began),
        Err(error) => ended(&options, &error.to_string(), began),
    }
}

/// Says what ended it, and which pictures in its folder are of an earlier run.
fn ended(options: &Options, error: &str, began: SystemTime) -> ExitCode {
    complain(&format!("error: {error}"));
    let left = named_left(options, began);
    if !left.is_empty() {
        complain(left.trim_end());
    }
    ExitCode::FAILURE
}

/// A line that names pictures of an earlier run in the folder of this one; nothing where there are none.
fn named_left(options: &Options, began: SystemTime) -> String {
    // A data set has no folder.
    if options.data_set.is_none() { left::named(&options.out, began) } else { String::new() }
}

/// Says what came of it, and which pictures in its folder are of an earlier run.
fn answer(options: &Options, text: &str, is_well: bool, began: SystemTime) -> ExitCode {
    let left = named_left(options, began);
    let said = if options.quiet { ExitCode::SUCCESS } else { say(&format!("{text}{left}")) };
    if is_well { said } else { ExitCode::FAILURE }
}

/// What the sensor over the belt is asked for.
fn overhead(options: &Options, began: SystemTime) -> ExitCode {
    let is_matrix = options.sensor == SensorKind::Ultrasonic;
    let ran = if let Some(file) = options.data_set.as_ref().filter(|_| is_matrix) {
        matrix::command::collect(options, file)
    } else if let Some(count) = options.examine.filter(|_| is_matrix) {
        matrix::command::test_recognition(options, count as usize)
    } else if let Some(file) = &options.data_set {
        command::collect(options, file)
    } else if let Some(folder) = &options.images {
        command::evaluate(options, folder)
    } else if let Some(count) = options.examine {
        command::test_recognition(options, count as usize)
    } else if let Some(parts) = options.sweep {
        command::sweep(options, parts as usize)
    } else {
        command::sort(options)
    };
    match ran {
        Ok((text, is_well)) => answer(options, &text, is_well, began),
        Err(error) => ended(options, &error.to_string(), began),
    }
}

/// One run of many parts, a time line of it, and a film of a short one.
fn sort(options: &Options) -> Result<(Row, String), Box<dyn Error>> {
    let sensing = if options.first_edge { Sensing::FirstEdge } else { Sensing::Reactive };
    let parts = options.parts as usize;
    let profile = options.lasting_profile();
    let settings = Settings { parts, sensing, profile, ..Settings::one(options.belt, options.seed.into()) };
    let ready = settings.ready()?;
    let arrivals = ready.parts.clone();
    let outcome = ready.run();
    let mut row = Row { speed: options.belt, ..Row::default() };
    row.add(&outcome);
    write(&options.out.join("time-line.svg"), &time_line(&outcome, &arrivals))?;
    let film = options.out.join("belt.svg");
    let short = Settings { parts: parts.min(FILMED), ..settings };
    filmed(short.ready()?, &film).map_err(|error| unwritable(&film, &error))?;
    if let Err(error) = &outcome.report {
        return Err(error.to_string().into());
    }
    let folder = options.out.display();
    let text = format!("{}see {folder}/belt.svg, {folder}/time-line.svg\n", Summary(vec![row.clone()]));
    Ok((row, text))
}

/// Many seeds over all speeds, led by all sensors, and by the first edge alone.
fn sweep(options: &Options, seeds: u64) -> Result<(Row, String), Box<dyn Error>> {
    let reactive = Summary::sweep(seeds, Sensing::Reactive)?;
    let open = Summary::sweep(seeds.div_ceil(4), Sensing::FirstEdge)?;
    write(&options.out.join("scatter.svg"), &scatter(&reactive, &open))?;
    let folder = options.out.display();
    let text = format!("all sensors\n{reactive}\nthe first edge alone\n{open}\nsee {folder}/scatter.svg\n");
    // Open loop is there to be compared with, and misses parts; a fault ends its run as it does any other.
    let faults = open.all().faults;
    let mut all = reactive.all();
    all.faults += faults;
    Ok((all, text))
}

fn write(file: &Path, text: &str) -> Result<(), String> {
    std::fs::write(file, text).map_err(|error| unwritable(file, &error))
}

fn unwritable(path: &Path, error: &io::Error) -> String {
    format!(
        "{}: cannot be written: {error}\n help: give a folder that can be written by --out",
        path.display()
    )
}
