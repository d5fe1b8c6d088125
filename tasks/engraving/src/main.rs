//! Engraves a drawing with a simulated IRp-6: `cargo run --release -- --help`.

use std::cell::RefCell;
use std::error::Error;
use std::io;
use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Instant;

use engraving::chosen::{Chosen, Cutting, DEFAULT_DEPTH, DEFAULT_FEED, chosen};
use engraving::drawing::hershey::Font;
use engraving::drawing::{Import, Order, Reading, Vec2, read_file, read_str};
use engraving::feeds::greatest_feed;
use engraving::layout::{HEIGHT_ERROR, Layout};
use engraving::options::{Options, Source, Talk, parse};
use engraving::ordering::nearest_first;
use engraving::paths_svg::PathsSvg;
use engraving::picture::{Material, render};
use engraving::placement::{Placement, place};
use engraving::progress::{Display, Progress};
use engraving::run::{Outcome, Settings, Watch, cell, check_reach};
use engraving::sampling::Sampling;
use engraving::summary::{JointPeaks, PathDeviation, PlateHeight, Summary};
use engraving::{NAMEPLATE, error::DrawingError};
use mrroc::console::{complain, quoted, refused, say};
use mrroc::launch::files::check_outputs;
use mrroc::launch::{Launch, Ran};
use mrroc::prelude::*;

/// What a run writes into its folder: the picture of the plate, that of the paths, and what was measured.
const RESULTS: [&str; 3] = ["plate.png", "paths.svg", "summary.json"];
/// The demanded path may lie this far from the drawing \[mm\].
const DEMANDED_BOUND: f64 = 0.01;
/// The executed path may lie this far from the drawing \[mm\], at worst and as RMS.
const EXECUTED_BOUND: f64 = 0.3;
const EXECUTED_RMS_BOUND: f64 = 0.1;
/// The probe may miss the plate's height by this much \[mm\].
const HEIGHT_BOUND: f64 = 0.02;
/// Height of capitals in a text before it is fitted \[mm\].
const CAPITALS: f64 = 10.0;

fn main() -> ExitCode {
    let launch = mrroc::launch::program(std::env::args_os().skip(1));
    if let Some(status) = launch.operate() {
        return status;
    }
    let options = match parse(launch.arguments().iter().cloned()) {
        Ok(options) => options,
        Err(answer) => return Launch::answer(&answer),
    };
    let launch = match options.processes {
        Some(clock) => launch.processes(clock).watching(),
        None => launch.watching(),
    };
    let talk = if launch.is_part() { Talk::Quiet } else { options.talk };
    let plan = match Plan::new(&options, talk) {
        Ok(plan) => plan,
        Err(error) => return refused(&*error),
    };
    let results = RESULTS.map(|name| options.out.join(name));
    if !launch.is_part()
        && let Err(error) = check_outputs(results.iter().map(|path| &**path))
    {
        return refused(&error);
    }
    let launch = if options.talk == Talk::Quiet { launch.quiet() } else { launch };
    // Found out now, not after minutes of engraving.
    let draws = launch.is_here() || options.processes.is_some();
    if draws
        && !launch.is_part()
        && let Err(error) = std::fs::create_dir_all(&options.out)
    {
        return refused(&unwritable(&options.out, &error));
    }
    if !launch.is_here() {
        return run_elsewhere(launch, plan.cell(&options), options.talk);
    }
    match plan.carry_out(launch, &options) {
        Ok(Carried::Out(summary)) => {
            let said = match options.talk {
                Talk::Normal => say(&format!(
                    "{}  see {}\n",
                    summary.table(),
                    RESULTS.map(|name| format!("{}/{name}", options.out.display())).join(", ")
                )),
                Talk::Quiet => ExitCode::SUCCESS,
            };
            if summary.passed { said } else { broken(&summary) }
        }
        Ok(Carried::Elsewhere(status)) => status,
        Err(error) => {
            complain(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Runs the cell as processes, or the one of them that this is: the plant, which has the arm, tells what came of it. Or runs
/// it for a recording.
fn run_elsewhere(launch: Launch, cell: Cell, talk: Talk) -> ExitCode {
    match (launch.run(cell), talk) {
        (Ok(Ran::Part(status)), _) => status,
        (Ok(Ran::Here(_) | Ran::Processes(_)), Talk::Quiet) => ExitCode::SUCCESS,
        (Ok(Ran::Here(report) | Ran::Processes(report)), Talk::Normal) => {
            let seconds = report.time.as_secs_f64();
            say(&format!("engraved for {seconds:.1} s in {} steps\n", report.steps))
        }
        (Err(error @ CellError::Fault(_)), _) => {
            complain(&format!("error: {error}"));
            ExitCode::FAILURE
        }
        (Err(error), _) => refused(&error),
    }
}

fn broken(summary: &Summary) -> ExitCode {
    for broken in &summary.broken {
        complain(&format!("bound missed: {broken}"));
    }
    ExitCode::FAILURE
}

/// What became of a run.
enum Carried {
    Out(Box<Summary>),
    /// Another process has it: this one ends with this status.
    Elsewhere(ExitCode),
}

/// Everything that is known before anything moves.
struct Plan {
    source: String,
    layout: Layout,
    placement: Placement,
    sampling: Sampling,
    samples: u64,
    cutting: Cutting,
}

impl Plan {
    fn new(options: &Options, talk: Talk) -> Result<Plan, Box<dyn Error>> {
        let (source, import) = read(&options.source, options.reading)?;
        if talk == Talk::Normal {
            for warning in &import.warnings {
                complain(&format!("warning: {}", quoted(warning, 300)));
            }
        }
        let mut placement = place(&import.drawing, &options.plate, options.sizing)?;
        let drawing = match import.order {
            Order::Free => nearest_first(placement.drawing, Vec2::zeros()),
            Order::AsGiven => placement.drawing,
        };
        let layout = Layout::new(&options.plate)?;
        let (drawing, cutting) = chosen(drawing, options, |stroke| greatest_feed(&layout, stroke))?;
        placement.drawing = drawing;
        let sampling = Sampling::default();
        let samples = check_reach(&layout, &options.plate, &placement.drawing, &sampling)?;
        Ok(Plan { source, layout, placement, sampling, samples, cutting })
    }

    fn settings(options: &Options) -> Settings {
        let Options { step, cutter, .. } = *options;
        // What holds for a stroke stands in it.
        Settings { step, feed: DEFAULT_FEED, depth: DEFAULT_DEPTH, cutter }
    }

    fn cell(&self, options: &Options) -> Cell {
        let drawing = &self.placement.drawing;
        cell(&self.layout, &options.plate, drawing, self.sampling, Plan::settings(options))
    }

    fn carry_out(&self, launch: Launch, options: &Options) -> Result<Carried, Box<dyn Error>> {
        // As processes, the steps are another one's.
        let silent = options.talk == Talk::Quiet || launch.is_part();
        let display = if silent { Display::Silent } else { Display::for_stderr() };
        let drawing = &self.placement.drawing;
        let progress = Rc::new(RefCell::new(Progress::new(display, drawing.length())));
        let shown = Rc::clone(&progress);
        let settings = Plan::settings(options);
        let began = Instant::now();
        let (cell, watch) = Watch::over(&self.layout, &options.plate, drawing, self.sampling, settings);
        let path = watch.progress();
        let report = match launch.run(cell.on_step(move |step, _| shown.borrow_mut().at(step, path())))? {
            Ran::Here(report) | Ran::Processes(report) => report,
            Ran::Part(status) => return Ok(Carried::Elsewhere(status)),
        };
        let outcome = watch.outcome(report);
        let wall_s = began.elapsed().as_secs_f64();
        if let Some(progress) = Rc::into_inner(progress) {
            progress.into_inner().finish(outcome.report.steps);
        }
        let summary = self.summary(options, &outcome, wall_s);
        self.draw(options, outcome, &summary)?;
        let path = options.out.join(RESULTS[2]);
        summary.write_json(&path).map_err(|error| unwritable(&path, &error))?;
        Ok(Carried::Out(Box::new(summary)))
    }

    fn summary(&self, options: &Options, outcome: &Outcome, wall_s: f64) -> Summary {
        let execution = &outcome.execution;
        let size = self.placement.bounds.size();
        let shares = execution.shares(self.layout.arm.limits());
        let peaks = shares.iter().enumerate().map(|(i, &(velocity_share, acceleration_share))| JointPeaks {
            joint: (i + 1).to_string(),
            velocity_share,
            acceleration_share,
        });
        Summary {
            source: self.source.clone(),
            strokes: self.placement.drawing.strokes.len(),
            cut_length_mm: execution.cut_length,
            travel_length_mm: execution.travel_length,
            drawing_size_mm: [size.x, size.y],
            depth_mm: self.cutting.depth,
            feed_mm_per_s: self.cutting.feed,
            travel_height_mm: self.cutting.travel,
            samples: self.samples,
            steps: outcome.report.steps,
            step_s: options.step,
            simulated_s: outcome.report.time.as_secs_f64(),
            wall_s,
            demanded: PathDeviation::new(&execution.demanded.report(), DEMANDED_BOUND, DEMANDED_BOUND),
            executed: PathDeviation::new(&execution.executed.report(), EXECUTED_BOUND, EXECUTED_RMS_BOUND),
            joints: peaks.collect(),
            plate_height: outcome.height_found.map(|found| PlateHeight {
                found_mm: found * 1e3,
                true_mm: HEIGHT_ERROR * 1e3,
                limit_mm: HEIGHT_BOUND,
            }),
            broken: Vec::new(),
            passed: true,
        }
        .checked()
    }

    fn draw(&self, options: &Options, outcome: Outcome, summary: &Summary) -> Result<(), String> {
        let caption = format!(
            "{}: {:.0} mm engraved {} mm deep in {:.0} s",
            self.source,
            summary.cut_length_mm,
            deep(&self.cutting.depth),
            summary.simulated_s
        );
        let picture = render(&outcome.execution.surface, &options.plate, Material::Brass, &caption);
        let path = options.out.join(RESULTS[0]);
        picture.write_png(&path).map_err(|error| unwritable(&path, &error))?;
        let paths = PathsSvg {
            plate: &options.plate,
            drawing: &self.placement.drawing,
            executed: &outcome.execution.trace.parts(),
            deviation: &outcome.execution.executed.report(),
            title: &self.source,
        };
        let path = options.out.join(RESULTS[1]);
        paths.write(&path).map_err(|error| unwritable(&path, &error))
    }
}

fn unwritable(path: &Path, error: &io::Error) -> String {
    format!(
        "{}: cannot be written: {error}\n help: give a folder that can be written by --out",
        path.display()
    )
}

/// How deep, for a caption.
fn deep(depth: &Chosen) -> String {
    let Chosen { least, greatest, .. } = *depth;
    if greatest - least < 0.005 { format!("{greatest:.2}") } else { format!("{least:.2} to {greatest:.2}") }
}

/// The drawing and what to call it.
fn read(source: &Source, reading: Reading) -> Result<(String, Import), DrawingError> {
    match source {
        Source::Nameplate => Ok(("nameplate".to_owned(), read_str("nameplate.svg", NAMEPLATE, reading)?)),
        Source::File(path) => {
            let name = path
                .file_name()
                .map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into());
            Ok((name, read_file(path, reading)?))
        }
        Source::Text { text, font } => Ok((format!("\"{text}\""), Font::open(font)?.write(text, CAPITALS)?)),
    }
}
