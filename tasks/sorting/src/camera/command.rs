//! What the command line asks of the task with the camera.

use std::error::Error;
use std::io::IsTerminal as _;
use std::path::Path;

use super::charts::{confusion, filmed, scatter, time_line};
use super::layout::camera;
use super::picture::draw;
use super::run::{Outcome, Settings, network};
use super::studio::{data_set, examine};
use super::summary::{Confusion, Line, Table, examination};
use crate::options::Options;

/// So many parts are filmed, and so many images drawn.
const FILMED: usize = 4;
const IMAGES: usize = 6;
/// Speeds [m/s] and shares of the arm's capacity of a sweep.
const SPEEDS: [f64; 3] = [0.05, 0.1, 0.15];
const LOADS: [f64; 3] = [0.4, 0.6, 0.8];

/// What there is to say, and whether all is well: no part in a wrong bin, no finger on a part.
pub type Said = Result<(String, bool), Box<dyn Error>>;

fn save(folder: &Path, name: &str, text: &str) -> Result<(), String> {
    let file = folder.join(name);
    std::fs::write(&file, text).map_err(|error| format!("{}: cannot be written: {error}", file.display()))
}

/// A table for the training script.
///
/// # Errors
/// The file cannot be written.
pub fn collect(options: &Options, file: &Path) -> Said {
    let table = data_set(options.parts as usize, options.seed.into())?;
    std::fs::write(file, table).map_err(|error| format!("{}: cannot be written: {error}", file.display()))?;
    Ok((format!("{} parts in {}\n", options.parts, file.display()), true))
}

/// Recognition of parts that it has never seen, one in ten a stranger.
///
/// # Errors
/// A picture cannot be written.
pub fn test_recognition(options: &Options, count: usize) -> Said {
    let plane = camera();
    let mut images = 0;
    let mut failed = None;
    let trials = examine(count, u64::from(options.seed) + 1_000_000, 10, Box::new(network()?), |image, found| {
        if images < IMAGES {
            let file = options.out.join(format!("image-{images}.png"));
            failed = draw(&file, image, found, &plane).err().or(failed.take());
            images += 1;
        }
    })?;
    if let Some(error) = failed {
        return Err(error.into());
    }
    let counts = Confusion::of(&trials);
    save(&options.out, "confusion.svg", &confusion(&counts))?;
    let folder = options.out.display();
    let text = format!("{}see {folder}/confusion.svg, {folder}/image-0.png and more\n", examination(&trials));
    let strangers: u32 = counts.0[super::kinds::KINDS][..super::kinds::KINDS].iter().sum();
    Ok((text, counts.counts()[1] == 0 && strangers == 0))
}

fn run(settings: &Settings, quiet: bool, keep: usize) -> Result<(Outcome, Kept), Box<dyn Error>> {
    let ready = settings.ready()?;
    ready.looks.borrow_mut().keep = keep;
    let progress = ready.progress.clone();
    if !quiet && std::io::stderr().is_terminal() {
        progress.show();
    }
    let kept = Kept {
        looks: ready.looks.clone(),
        parts: ready.parts.iter().map(|part| (part.time, part.kind)).collect(),
    };
    let outcome = ready.run();
    progress.end();
    Ok((outcome, kept))
}

struct Kept {
    looks: std::rc::Rc<std::cell::RefCell<super::run::Looks>>,
    parts: Vec<(f64, usize)>,
}

/// One run of many parts, its pictures, and a film of a short one.
///
/// # Errors
/// The run ended with a fault, or a picture cannot be written.
pub fn sort(options: &Options) -> Said {
    let (parts, seed) = (options.parts as usize, options.seed.into());
    let every = options.every.unwrap_or(Settings::CYCLE / 0.6);
    let settings = Settings::of(options.belt, parts, every, seed);
    let (outcome, kept) = run(&settings, options.quiet, IMAGES)?;
    let folder = options.out.as_path();
    let plane = camera();
    for (number, (image, found)) in kept.looks.borrow().images.iter().enumerate() {
        draw(&folder.join(format!("image-{number}.png")), image, found, &plane)?;
    }
    let mut counts = Confusion::default();
    outcome.looks.iter().for_each(|look| counts.add(Some(kept.parts[look.part].1), look.taken));
    save(folder, "confusion.svg", &confusion(&counts))?;
    save(folder, "time-line.svg", &time_line(&outcome, &kept.parts))?;
    let short = Settings { parts: parts.min(FILMED), ..settings };
    let film = folder.join("belt.svg");
    filmed(short.ready()?, &film).map_err(|error| format!("{}: cannot be written: {error}", film.display()))?;
    if let Err(error) = &outcome.report {
        return Err(error.to_string().into());
    }
    let line = Line::of(&settings, &outcome);
    let table = Table(vec![line.clone()]);
    save(folder, "scatter.svg", &scatter(&table))?;
    let out = folder.display();
    let text = format!(
        "{table}see {out}/belt.svg, {out}/image-0.png, {out}/confusion.svg, {out}/scatter.svg, {out}/time-line.svg\n"
    );
    Ok((text, line.wrong == 0 && line.crashes == 0))
}

/// Runs at several speeds and arrival rates.
///
/// # Errors
/// A run ended with a fault, or a picture cannot be written.
pub fn sweep(options: &Options, parts: usize) -> Said {
    let mut table = Table::default();
    for speed in SPEEDS {
        for load in LOADS {
            let settings = Settings::of(speed, parts, Settings::CYCLE / load, options.seed.into());
            let (outcome, _) = run(&settings, options.quiet, 0)?;
            if let Err(error) = &outcome.report {
                return Err(error.to_string().into());
            }
            table.0.push(Line::of(&settings, &outcome));
        }
    }
    save(&options.out, "scatter.svg", &scatter(&table))?;
    let well = table.0.iter().all(|line| line.wrong == 0 && line.crashes == 0);
    Ok((format!("{table}see {}/scatter.svg\n", options.out.display()), well))
}
