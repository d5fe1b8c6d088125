//! Two simulated arms carry a bar: `cargo run --release -p transfer -- --help`.

use std::error::Error;
use std::io;
use std::path::Path;
use std::process::ExitCode;

use mrroc::cell::{RunPicture, RunReport};
use mrroc::cell_file::CellFileError;
use mrroc::console::{complain, refused, say};
use mrroc::launch::files::check_outputs;
use mrroc::launch::{Launch, Ran};
use mrroc::prelude::*;
use mrroc_pictures::Film;
use transfer::options::{Options, Talk, parse};
use transfer::pictures::{film, filmed, plot};
use transfer::summary::Summary;
use transfer::touching::touches;
use transfer::variant::Variant;

fn main() -> ExitCode {
    let launch = mrroc::launch::program(std::env::args_os().skip(1));
    if let Some(status) = launch.operate() {
        return status;
    }
    let options = match parse(launch.arguments().iter().cloned()) {
        Ok(options) => options,
        Err(answer) => return Launch::answer(&answer),
    };
    if let Some(path) = &options.touches {
        return touched(path);
    }
    let file = match &options.cell {
        Some(path) => CellFile::read(path),
        None => transfer::file(),
    };
    let results = ["arms.svg", "stress.svg"].map(|name| options.out.join(name));
    if !launch.is_part()
        && let Err(error) = check_outputs(results.iter().map(|path| &**path))
    {
        return refused(&error);
    }
    // As processes, for a recording, or as one recorded.
    if options.processes.is_some() || !launch.is_here() {
        return run_drawn(launch, &options, file);
    }
    let file = match file.map_err(Into::into).and_then(|file| {
        Summary::check(&file)?;
        // Found out now, not after all runs.
        std::fs::create_dir_all(&options.out).map_err(|error| unwritable(&options.out, &error))?;
        Ok::<_, Box<dyn Error>>(file)
    }) {
        Ok(file) => file,
        Err(error) => return refused(&*error),
    };
    match carry_out(&options, &file) {
        Ok(summary) => {
            let missed = summary.missed();
            missed.iter().for_each(|missed| complain(&format!("bound missed: {missed}")));
            let said = match options.talk {
                Talk::Normal => {
                    say(&format!("{summary}see {0}/arms.svg, {0}/stress.svg\n", options.out.display()))
                }
                Talk::Quiet => ExitCode::SUCCESS,
            };
            if missed.is_empty() { said } else { ExitCode::FAILURE }
        }
        Err(error) if is_refusal(&*error) => refused(&*error),
        Err(error) => {
            complain(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Writes what the arms' controllers say where both touch the same points.
fn touched(path: &Path) -> ExitCode {
    let mut text = String::from("point,arm,x_mm,y_mm,z_mm\n");
    for (point, arm, at) in touches(1) {
        text += &format!("{point},{arm},{:.4},{:.4},{:.4}\n", 1e3 * at.x, 1e3 * at.y, 1e3 * at.z);
    }
    match std::fs::write(path, text) {
        Ok(()) => say(&format!("see {}\n", path.display())),
        Err(error) => refused(&unwritable(path, &error)),
    }
}

/// Runs the cell of the run that is drawn as processes, or the one of them that this is; records it, or replays it.
fn run_drawn(mut launch: Launch, options: &Options, file: Result<CellFile, CellFileError>) -> ExitCode {
    let variant = Variant::Bar { bases: options.bases, sensors: options.sensors };
    if let Some(clock) = options.processes {
        launch = launch.processes(clock);
    }
    if let Some(file) = &options.cell {
        launch = launch.cell_file(file);
    }
    if options.talk == Talk::Quiet {
        launch = launch.quiet();
    }
    // The plant has the arms and the bar.
    let launch = launch.watching();
    if !launch.is_part()
        && options.processes.is_some()
        && let Err(error) = std::fs::create_dir_all(&options.out)
    {
        return refused(&unwritable(&options.out, &error));
    }
    let ready = file.map_err(CellError::from).and_then(|file| variant.ready(&file));
    let ran = ready.and_then(|ready| {
        if launch.is_here() {
            let (film, cell) = filmed(ready);
            return launch.run(cell).map(|ran| (ran, Some(film)));
        }
        launch.run(ready.cell).map(|ran| (ran, None))
    });
    match ran {
        Ok((Ran::Part(status), _)) => status,
        Ok((Ran::Here(report) | Ran::Processes(report), film)) => carried(&report, film, options),
        Err(error) if is_refusal(&error) => refused(&error),
        Err(error) => {
            complain(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Draws the film, if this is where the arms are, and says how long it took.
fn carried(report: &RunReport, film: Option<Film>, options: &Options) -> ExitCode {
    let path = options.out.join("arms.svg");
    if let Some(Err(error)) = film.as_ref().map(|film| std::fs::write(&path, film.svg())) {
        complain(&format!("error: {}", unwritable(&path, &error)));
        return ExitCode::FAILURE;
    }
    if options.talk == Talk::Quiet {
        return ExitCode::SUCCESS;
    }
    let see = film.map_or_else(String::new, |_| format!(": see {}", path.display()));
    let seconds = report.time.as_secs_f64();
    say(&format!("carried the bar for {seconds:.1} s in {} steps{see}\n", report.steps))
}

/// Whether a cell did not begin to run. What is wrong with one variant's set-up is so with the first one's, too.
fn is_refusal(error: &(dyn Error + 'static)) -> bool {
    let cell = error.downcast_ref::<CellError>();
    cell.is_some_and(|error| !matches!(error, CellError::Fault(_) | CellError::Stuck(_)))
}

/// Measures all variants and draws.
fn carry_out(options: &Options, file: &CellFile) -> Result<Summary, Box<dyn Error>> {
    let summary = Summary::measure(file)?;
    let path = options.out.join("stress.svg");
    plot(&summary).save(&path).map_err(|error| unwritable(&path, &error))?;
    let drawn = Variant::Bar { bases: options.bases, sensors: options.sensors };
    let path = options.out.join("arms.svg");
    film(drawn, file)?.save(&path).map_err(|error| unwritable(&path, &error))?;
    Ok(summary)
}

fn unwritable(path: &Path, error: &io::Error) -> String {
    format!(
        "{}: cannot be written: {error}\n help: give a folder that can be written by --out",
        path.display()
    )
}
