//! Shows a drawing as it would be engraved, without the arm: `cargo run --release -p mrroc-examples --example preview -- FILE`.

use engraving::chosen::{DEFAULT_DEPTH, DEFAULT_FEED};
use engraving::deviation::{Corners, Deviation};
use engraving::drawing::hershey::Font;
use engraving::drawing::{Limits, NaturalSpline, Vec2, read_file, read_str};
use engraving::options::{Options, Source, parse};
use engraving::paths_svg::PathsSvg;
use engraving::picture::{Material, render};
use engraving::placement::place;
use engraving::plate::{HeightMap, Tip};
use engraving::sampling::{Mark, Sampling};
use engraving::trace::Trace;
use engraving::{NAMEPLATE, ordering};
use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    let options = parse(std::env::args_os().skip(1)).unwrap_or_else(|answer| answer.exit());
    match preview(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn preview(options: &Options) -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let import = match &options.source {
        Source::Nameplate => read_str("nameplate.svg", NAMEPLATE, Limits::default())?,
        Source::File(path) => read_file(path, options.reading)?,
        Source::Text { text, font } => Font::open(font)?.write(text, 10.0)?,
    };
    for warning in &import.warnings {
        println!("warning: {warning}");
    }
    let placed = place(&import.drawing, &options.plate, options.sizing)?;
    let drawing =
        ordering::nearest_first(placed.drawing, Vec2::zeros()).sunk(options.depth.unwrap_or(DEFAULT_DEPTH));
    let read = start.elapsed();
    let sampling = Sampling::default();
    let mut deviation = Deviation::new(&drawing, &sampling, Corners::Counted);
    let mut map = HeightMap::new(&options.plate, 0.05, options.cutter);
    let mut trace = Trace::new(5e-4);
    let (mut run, mut samples, mut steps) = (Vec::new(), 0u64, 0u64);
    let carving = Instant::now();
    for sample in sampling.samples(&drawing) {
        samples += 1;
        run.push(sample.position);
        if sample.mark == Mark::Start {
            let lifted = Tip::new(sample.position.x, sample.position.y, 2.0);
            map.move_to(lifted);
            trace.move_to(lifted);
            deviation.begin_stroke(sample.stroke, 0.0);
        }
        if !matches!(sample.mark, Mark::Corner | Mark::End) {
            continue;
        }
        if let Some(spline) = NaturalSpline::new(std::mem::take(&mut run)) {
            for span in 0..spline.spans() {
                let length = (spline.point(span, 1.0) - spline.point(span, 0.0)).norm();
                let parts =
                    (length / (options.feed.unwrap_or(DEFAULT_FEED) * options.step)).ceil().max(1.0) as u32;
                for part in 0..=parts {
                    let p = spline.point(span, f64::from(part) / f64::from(parts));
                    steps += 1;
                    map.move_to(p);
                    trace.move_to(p);
                    deviation.observe(p);
                }
            }
        }
        run.push(sample.position);
        if sample.mark == Mark::End {
            run.clear();
            let lifted = Tip::new(sample.position.x, sample.position.y, 2.0);
            map.move_to(lifted);
            trace.move_to(lifted);
        }
    }
    map.finish();
    let carved = carving.elapsed();
    let report = deviation.report();
    let results = ["plate.png", "paths.svg"].map(|name| options.out.join(name));
    mrroc::launch::files::check_outputs(results.iter().map(|path| &**path))?;
    std::fs::create_dir_all(&options.out)?;
    let parts = trace.parts();
    let caption =
        format!("{:.0} mm engraved {:.2} mm deep", drawing.length(), options.depth.unwrap_or(DEFAULT_DEPTH));
    let drawn = Instant::now();
    render(&map, &options.plate, Material::Brass, &caption).write_png(&options.out.join("plate.png"))?;
    let paths = PathsSvg {
        plate: &options.plate,
        drawing: &drawing,
        executed: &parts,
        deviation: &report,
        title: "Preview",
    };
    paths.write(&options.out.join("paths.svg"))?;
    println!(
        "{} strokes, {} pieces, {:.0} mm, {samples} samples, {steps} steps; max {:.4} mm rms {:.5} mm; read {read:.2?}, executed {carved:.2?} ({:.0} ns a step), pictures {:.2?}",
        drawing.strokes.len(),
        drawing.piece_count(),
        drawing.length(),
        report.max,
        report.rms,
        carved.as_nanos() as f64 / steps as f64,
        drawn.elapsed()
    );
    Ok(())
}
