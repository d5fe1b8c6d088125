//! What the command line asks of the task with something over the belt.

use std::error::Error;
use std::fmt::Write as _;
use std::io::IsTerminal as _;
use std::path::Path;

use mrroc_sensors::aggregation::Vision;

use super::bound::Bound;
use super::charts::{confusion, filmed, scatter, time_line};
use super::kinds::classes;
use super::layout::camera;
use super::picture::{draw, read, write};
use super::run::{Outcome, network};
use super::settings::{Overhead, Settings};
use super::studio::{data_set, examine};
use super::summary::{Confusion, Line, Table, examination};
use crate::matrix::picture::{echoes, reliefs};
use crate::options::Options;
use crate::scopes::SensorKind;

/// So many parts are filmed, and so many images drawn.
const FILMED: usize = 4;
const IMAGES: usize = 6;
/// Two arms are filmed with parts that come at least so often \[s\].
const FILMED_EVERY: f64 = 4.6;
/// A sweep has so many parts in a run, each with a seed of its own.
const RUN: usize = 100;
/// The image of the empty belt, and what the names of those with rims begin with.
const EMPTY: &str = "empty.png";
const DRAWN: &str = "image-";
/// Shares of the cycle-time bound of a sweep.
const LOADS: [f64; 3] = [0.4, 0.6, 0.8];

/// What there is to say, and whether all is well: parts in their bins, none in a wrong one, no finger on a part.
pub type Said = Result<(String, bool), Box<dyn Error>>;

/// Writes a picture.
pub(crate) fn save(folder: &Path, name: &str, text: &str) -> Result<(), String> {
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
    let trials =
        examine(count, u64::from(options.seed) + 1_000_000, 10, Box::new(network()?), |image, found| {
            if images <= IMAGES {
                // The first one is of the empty belt.
                let name = if images == 0 { EMPTY.to_owned() } else { format!("raw-{images}.png") };
                let raw = write(&options.out.join(name), image, plane.camera.size);
                let drawn = draw(&options.out.join(format!("image-{images}.png")), image, found, &plane);
                failed = raw.err().or(drawn.err()).or(failed.take());
                images += 1;
            }
        })?;
    if let Some(error) = failed {
        return Err(error.into());
    }
    let counts = Confusion::of(&trials);
    save(&options.out, "confusion.svg", &confusion(&counts))?;
    let folder = options.out.display();
    let text = format!("{}see {folder}/confusion.svg, {folder}/image-1.png and more\n", examination(&trials));
    let strangers: u32 = counts.0[super::kinds::KINDS][..super::kinds::KINDS].iter().sum();
    let [right, misnamed, _] = counts.counts();
    Ok((text, right > 0 && misnamed == 0 && strangers == 0))
}

/// What is in images of others, `raw-*.png` and whatever else a folder has beside `empty.png`, that of the empty belt.
///
/// # Errors
/// A file cannot be read.
pub fn evaluate(options: &Options, folder: &Path) -> Said {
    let plane = camera();
    let size = plane.camera.size;
    let readable = |file: &Path| read(file, size).map_err(|error| format!("{}: {error}", file.display()));
    let mut vision = Vision::new(plane.clone(), classes(), Box::new(network()?));
    vision.teach(&readable(&folder.join(EMPTY))?)?;
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.sort();
    let is_image = |file: &&std::path::PathBuf| {
        let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        name.ends_with(".png") && name != EMPTY && !name.starts_with(DRAWN)
    };
    let mut text = String::from(
        "image            kind            score    fit   along [mm]  across [mm]  angle [deg]\n",
    );
    files.retain(|file| is_image(&file));
    if files.is_empty() {
        return Err(format!("{}: no PNG file is there but {EMPTY}", folder.display()).into());
    }
    for file in &files {
        let image = readable(file)?;
        let found = vision.look(&image)?;
        let name = file.file_stem().and_then(|name| name.to_str()).unwrap_or_default();
        for thing in &found {
            let kind = thing.class.map_or("none of them", |class| vision.classes()[class].name);
            let [x, y] = [thing.place.x, thing.place.y].map(|at| 1e3 * at);
            let (score, fit, angle) = (thing.score, thing.fit, thing.angle.to_degrees());
            let _ =
                writeln!(text, "{name:16} {kind:15} {score:5.2} {fit:6.3} {x:12.2} {y:12.2} {angle:12.2}");
        }
        draw(&options.out.join(format!("{DRAWN}{name}.png")), &image, &found, &plane)?;
    }
    Ok((text, true))
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

/// What is over the belt.
const fn overhead(options: &Options) -> Overhead {
    match options.sensor {
        SensorKind::Ultrasonic => Overhead::Matrix,
        SensorKind::Camera | SensorKind::Infrared => Overhead::Camera,
    }
}

/// What 95 % of the grasps may be off the middle \[mm\]; nothing is asked of the matrix.
const fn asked(options: &Options) -> Option<f64> {
    match overhead(options) {
        Overhead::Camera => Some(1.0),
        Overhead::Matrix => None,
    }
}

fn regular(options: &Options) -> f64 {
    if options.poisson { 0.0 } else { Settings::REGULAR }
}

struct Kept {
    looks: std::rc::Rc<std::cell::RefCell<super::looks::Looks>>,
    parts: Vec<(f64, usize)>,
}

/// One run of many parts, its pictures, and a film of a short one.
///
/// # Errors
/// The run ended with a fault, or a picture cannot be written.
pub fn sort(options: &Options) -> Said {
    let (parts, seed) = (options.parts as usize, options.seed.into());
    let every = options.mean_time();
    let settings = Settings {
        regular: regular(options),
        strangers: each(options.strangers),
        touching: each(options.touching),
        profile: options.lasting_profile(),
        ..Settings::of(options.belt, parts, every, seed).below(overhead(options)).by(options.arms as usize)
    };
    let (outcome, kept) = run(&settings, options.quiet, IMAGES)?;
    let folder = options.out.as_path();
    let plane = camera();
    for (number, (image, found)) in kept.looks.borrow().images.iter().enumerate() {
        draw(&folder.join(format!("image-{number}.png")), image, found, &plane)?;
    }
    let drawn = match settings.overhead {
        Overhead::Camera => "image-0.png",
        Overhead::Matrix => {
            save(folder, "reliefs.svg", &reliefs(&kept.looks.borrow().reliefs))?;
            save(folder, "echoes.svg", &echoes(&kept.looks.borrow().traces))?;
            "reliefs.svg"
        }
    };
    let mut counts = Confusion::default();
    outcome.looks.iter().for_each(|look| counts.add(Some(kept.parts[look.part].1), look.taken));
    save(folder, "confusion.svg", &confusion(&counts))?;
    save(folder, "time-line.svg", &time_line(&outcome, &kept.parts))?;
    // Two arms are filmed where both have work: parts come as fast as they can take them.
    let every = if options.arms > 1 { every.min(FILMED_EVERY) } else { every };
    let short = Settings { parts: parts.min(FILMED), every, ..settings };
    let film = folder.join("belt.svg");
    filmed(short.ready()?, &film)
        .map_err(|error| format!("{}: cannot be written: {error}", film.display()))?;
    if let Err(error) = &outcome.report {
        return Err(error.to_string().into());
    }
    let line = Line::of(&settings, &outcome);
    let table = Table(vec![line.clone()]);
    save(folder, "scatter.svg", &scatter(&table, asked(options)))?;
    let out = folder.display();
    let text = format!(
        "{table}see {out}/belt.svg, {out}/{drawn}, {out}/confusion.svg, {out}/scatter.svg, {out}/time-line.svg\n"
    );
    Ok((text, line.is_well()))
}

/// One part in so many; 0 is none.
fn each(count: Option<u32>) -> usize {
    count.map_or(0, |count| count as usize)
}

/// Runs at several speeds and arrival rates, which are shares of the cycle-time bound at each speed.
///
/// # Errors
/// A run ended with a fault, or a picture cannot be written.
pub fn sweep(options: &Options, parts: usize) -> Said {
    let (mut table, mut bounds) = (Table::default(), String::new());
    let (arms, profile) = (options.arms as usize, options.lasting_profile());
    for &speed in &options.speeds {
        let of =
            |parts, every, seed| Settings::of(speed, parts, every, seed).below(overhead(options)).by(arms);
        let bound = Bound::measured(&of(0, 0.0, options.seed.into()))?;
        let _ = writeln!(bounds, "{bound}");
        for load in LOADS {
            let every = bound.every() / load;
            let mut line = Line { speed, every, load: Some(load), ..Line::default() };
            for first in (0..parts).step_by(RUN) {
                let seed = u64::from(options.seed) + (first / RUN) as u64;
                let settings = of(RUN.min(parts - first), every, seed);
                let settings = Settings {
                    regular: regular(options),
                    strangers: each(options.strangers),
                    touching: each(options.touching),
                    profile,
                    ..settings
                };
                let (outcome, _) = run(&settings, options.quiet, 0)?;
                if let Err(error) = &outcome.report {
                    return Err(error.to_string().into());
                }
                line.join(Line::of(&settings, &outcome));
            }
            table.0.push(line);
        }
    }
    save(&options.out, "scatter.svg", &scatter(&table, asked(options)))?;
    let well = table.0.iter().all(Line::is_well);
    Ok((format!("{bounds}{table}see {}/scatter.svg\n", options.out.display()), well))
}
