//! Times of time-optimal planning: `cargo bench -p mrroc-generators --bench timing`. `tests/benches/peers/timing` measures
//! TOPPRA on the same paths and grids in the same run.

#![expect(clippy::disallowed_methods, reason = "a benchmark measures")]

use mrroc_generators::curve::{CubicSpline, SplineEnds};
use mrroc_generators::profile::Profile;
use mrroc_generators::timing::{PathLimits, TimeOptimal};
use nalgebra::SVector;
use std::hint::black_box;
use std::time::Instant;

type Six = SVector<f64, 6>;

/// Point `i` of path `k`, joint `j`: as in `tests/benches/peers/toppra_time.py`.
fn waypoint(k: usize, i: usize, j: usize) -> f64 {
    ((k * 7 + i * 13 + j * 29) as f64 * 0.618_033_988_749_894_9).fract() * 2.0 - 1.0
}

fn main() {
    let limits =
        PathLimits { velocity: Six::repeat(1.0), acceleration: Six::repeat(4.0), speed: f64::INFINITY };
    let paths: Vec<_> = (0..20)
        .map(|k| {
            let points = (0..6).map(|i| Six::from_fn(|j, _| waypoint(k, i, j))).collect();
            let knots = (0..6).map(|i| f64::from(i) * 0.2).collect();
            CubicSpline::new(knots, points, SplineEnds::Natural).expect("points that differ")
        })
        .collect();
    for points in [101, 201, 1001_usize] {
        let grid: Vec<_> = (0..points).map(|i| i as f64 / (points - 1) as f64).collect();
        let plan =
            |path| TimeOptimal::plan(path, &grid, &limits, [0.0; 2]).expect("a path that can be passed");
        let round = |_| {
            let start = Instant::now();
            paths.iter().for_each(|path| drop(black_box(plan(path))));
            start.elapsed().as_secs_f64() * 1e6 / paths.len() as f64
        };
        let least = (0..20).map(round).fold(f64::INFINITY, f64::min);
        let sum: f64 = paths.iter().map(|path| plan(path).duration()).sum();
        println!("time_optimal {points} {least:.1} {sum:.6}");
    }
}
