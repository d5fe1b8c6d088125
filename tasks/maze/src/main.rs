//! A robot finds its way out of a maze by touch: `cargo run --release -p maze -- --help`.

use std::error::Error;
use std::fs;
use std::io;
use std::path::Path;
use std::process::ExitCode;

use maze::camera;
use maze::mazes::Seeded;
use maze::options::{Means, Options, parse};
use maze::pictures::film;
use maze::run::{solve, told};
use maze::summary::{Row, Summary};
use mrroc::console::{complain, refused, say};
use mrroc::launch::Launch;
use mrroc_map::Walls;

fn main() -> ExitCode {
    let options = match parse(std::env::args_os().skip(1)) {
        Ok(options) => options,
        Err(answer) => return Launch::answer(&answer),
    };
    let mazes = match mazes(&options) {
        Ok(mazes) => mazes,
        Err(message) => return refused(&message),
    };
    let many = options.sweep.is_some() || options.random.is_some();
    let ran = match options.means() {
        None => camera::shown::runs(&mazes, many, &options),
        Some(means) if many => {
            let summary = Summary::sweep(means, &mazes);
            Ok((summary.faults(), summary.to_string()))
        }
        Some(means) => one(means, &options.out, &mazes[0]),
    };
    match ran {
        Ok((faults, text)) => {
            let said = if options.quiet { ExitCode::SUCCESS } else { say(&text) };
            if faults == 0 { said } else { ExitCode::FAILURE }
        }
        Err(error) => {
            complain(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// The mazes that are asked for, at least one.
fn mazes(options: &Options) -> Result<Vec<Seeded>, String> {
    let seed = u64::from(options.seed);
    if let Some(count) = options.random {
        return Ok((seed..seed + u64::from(count)).map(Seeded::by_chance).collect());
    }
    if let Some(folder) = &options.sweep {
        let unread = |error: io::Error| {
            format!("{}: cannot be read: {error}\n help: name a folder with mazes", folder.display())
        };
        let mut files: Vec<_> =
            fs::read_dir(folder).map_err(unread)?.filter_map(|entry| Some(entry.ok()?.path())).collect();
        files.retain(|file| {
            file.is_file() && file.extension().is_some_and(|end| end == "txt" || end == "maz")
        });
        files.sort();
        if files.is_empty() {
            return Err(format!(
                "{}: no file *.txt or *.maz\n help: name a folder with mazes",
                folder.display()
            ));
        }
        let mut mazes = vec![];
        for file in &files {
            match read(file, seed) {
                Ok(Seeded { name, layout, .. }) if layout.cells_to_goal().is_none() => {
                    complain(&format!("{name}: left out: it has no path to its goal"));
                }
                Ok(read) => mazes.push(read),
                Err(message) => {
                    complain(&format!("{}: left out", message.lines().next().unwrap_or(&message)))
                }
            }
        }
        if mazes.is_empty() {
            return Err(format!("{}: no maze\n help: name a folder with mazes", folder.display()));
        }
        return Ok(mazes);
    }
    match &options.file {
        Some(file) => Ok(vec![read(file, seed)?]),
        None => {
            let [islands, _] = Seeded::shipped(seed).map_err(|error| format!("islands.txt: {error}"))?;
            Ok(vec![islands])
        }
    }
}

fn read(file: &Path, seed: u64) -> Result<Seeded, String> {
    let shown = file.display();
    let text = fs::read_to_string(file).map_err(|error| {
        format!(
            "{shown}: cannot be read: {error}\n help: name a maze in the text format of micromouse contests"
        )
    })?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    Seeded::read(&name, &text, seed).map_err(|error| format!("{shown}: {error}"))
}

/// One run, and its film.
fn one(means: Means, out: &Path, maze: &Seeded) -> Result<(usize, String), Box<dyn Error>> {
    let layout = &maze.layout;
    let outcome = solve(means, layout, maze.seed)?;
    let walls = Walls::of(layout, outcome.sizes.pitch, outcome.sizes.thickness);
    let file = out.join("maze.svg");
    let drawn = film(&outcome, &walls, &told(layout, &outcome.sizes));
    fs::create_dir_all(out).and_then(|()| fs::write(&file, drawn)).map_err(|error| {
        format!(
            "{}: cannot be written: {error}\n help: give a folder that can be written by --out",
            file.display()
        )
    })?;
    if let Err(error) = outcome.report {
        return Err(error.to_string().into());
    }
    let summary = Summary(vec![Row::of(&maze.name, layout, &outcome)]);
    Ok((summary.faults(), format!("{summary}see {}\n", file.display())))
}
