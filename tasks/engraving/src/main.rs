//! Engraves a drawing with a simulated IRp-6.
use engraving::*;
fn main() {
    let plate = placement::Plate::default();
    let import = drawing::read_file(std::path::Path::new(&std::env::args().nth(1).unwrap()), drawing::Limits::default()).unwrap();
    let placed = placement::place(&import.drawing, &plate, placement::Sizing::Fill).unwrap();
    let drawing = ordering::nearest_first(placed.drawing, nalgebra::Vector2::zeros());
    let bench = bench::Bench::new(&plate).unwrap();
    let sampling = sampling::Sampling::default();
    let n = run::check_reach(&bench, &plate, &drawing, &sampling, 0.3).unwrap();
    println!("{n} samples, {} strokes", drawing.strokes.len());
    let from = std::time::Instant::now();
    let settings = run::Settings { step: 2e-3, feed: 15.0, depth: 0.3, cutter: plate::Cutter::default() };
    let out = run::engrave(&bench, &plate, &drawing, sampling, settings, |_, _| {}).unwrap();
    let wall = from.elapsed().as_secs_f64();
    println!("{:?} wall {wall} speedup {}", out.report, out.report.time.as_secs_f64() / wall);
    println!("demanded {:?}", out.execution.demanded.report());
    println!("executed {:?}", out.execution.executed.report());
    println!("height {:?} {:?}", out.height_found, out.execution.shares(mrroc::Robot::limits(&bench.arm)));
}
