//! What a step costs: `cargo bench -p mrroc-tests --bench steps` (in `just bench`).
//!
//! Prints nanoseconds per step, the median and the range of several runs, with the machine and the clock's own
//! cost. Each comparison is made in the same run.

use std::hint::black_box;
use std::time::Instant;

use mrroc::generator::Generator;
use mrroc::prelude::*;
use mrroc::robot::{RobotImage, RobotState};
use mrroc_doubles::{Gantry, Q};
use mrroc_generators::generators::StraightLine;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Irp6, Six};
use nalgebra::{Translation3, Vector3};

use mrroc_benches::{down, start};

const RUNS: usize = 7;

/// Median and range of `RUNS` measurements of nanoseconds.
fn report(name: &str, mut measure: impl FnMut() -> f64) -> f64 {
    let mut figures: Vec<f64> = (0..RUNS).map(|_| measure()).collect();
    figures.sort_by(f64::total_cmp);
    let median = figures[RUNS / 2];
    println!("{name:<58} {median:>9.1} ns   ({:.1} .. {:.1})", figures[0], figures[RUNS - 1]);
    median
}

struct Idle(u64);

#[generator(ecp)]
fn idle(c: &mut Idle, t: Tick) -> Step<Gantry> {
    c.0 += u64::from(t.dt > 0.0);
    Step::Next(Demand::hold())
}

fn definition() {
    const CALLS: u32 = 2_000_000;
    let t = Tick { step: 0, dt: 1e-3, duration: 1e-3 };
    let per_call = |from: Instant| from.elapsed().as_nanos() as f64 / f64::from(CALLS);
    let bare = report("step function, bare call", || {
        let mut c = Idle(0);
        let from = Instant::now();
        for _ in 0..CALLS {
            black_box(idle(black_box(&mut c), black_box(t)));
        }
        per_call(from)
    });
    let state = RobotState::<Gantry> { joints: Q::zeros(), velocity: Q::zeros(), pose: Pose::identity() };
    let (e, v) = (State::<Gantry>::new(RobotImage::new(state, state)), Reading::<()>::new(()));
    let through = report("the same through its Generator", || {
        let mut c = Idle(0);
        let from = Instant::now();
        for _ in 0..CALLS {
            let _ = black_box(black_box(&mut c).next_step(&Order::new(()), black_box(&e), &v, black_box(t)));
        }
        per_call(from)
    });
    println!("{:<58} {:>9.1} ns   (goal: at most 10)", "  Generator over bare call", through - bare);
}

/// A demand of a straight line: profile, interpolation of position and orientation.
fn line() {
    const CALLS: u32 = 500_000;
    let limits = ProfileLimits { velocity: 1e-3, acceleration: 1e-3 };
    let pose = Pose::from_parts(Translation3::new(0.85, 0.0, 0.35), down());
    let state = RobotState::<Irp6> { joints: start(), velocity: Six::zeros(), pose };
    let (e, v) = (State::<Irp6>::new(RobotImage::new(state, state)), Reading::<()>::new(()));
    let t = Tick { step: 0, dt: 1e-5, duration: 1e-3 };
    report("a straight line's demand", || {
        let goal = pose * Pose::rotation(Vector3::z()) * Pose::translation(0.0, 0.0, 0.1);
        let mut line = StraightLine::<Irp6>::to(goal, ToolLimits { translation: limits, rotation: limits });
        let _ = line.first_step(&Order::new(()), &e, &v, t);
        let from = Instant::now();
        for _ in 0..CALLS {
            let _ =
                black_box(black_box(&mut line).next_step(&Order::new(()), black_box(&e), &v, black_box(t)));
        }
        from.elapsed().as_nanos() as f64 / f64::from(CALLS)
    });
}

fn main() {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or("unknown");
    println!("machine: {}", model.trim_start_matches([' ', '\t', ':']));
    report("the clock's own cost", || {
        let from = Instant::now();
        for _ in 0..100_000 {
            black_box(Instant::now());
        }
        from.elapsed().as_nanos() as f64 / 1e5
    });
    definition();
    line();
    chains::<1>();
    chains::<2>();
    chains::<4>();
    chains::<8>();
    chains::<16>();
    chains::<64>();
    plants::<1>();
    plants::<4>();
    plants::<16>();
}

/// Cells of four robots under one MP.
fn plants<const CELLS: usize>() {
    let steps = 5_000 / CELLS as u64 + 500;
    report(&format!("an MP over {CELLS} cells of 4 robots: joints held"), || {
        per_step(steps, mrroc_benches::cells_of_four::<CELLS>)
    });
}

/// The time of a step of a run of so many \[ns\].
fn per_step(steps: u64, run: fn(u64)) -> f64 {
    let time = |steps| {
        let from = Instant::now();
        run(steps);
        from.elapsed().as_nanos() as f64
    };
    // Twice the steps minus once: what it takes to put a cell together falls out.
    let (once, twice) = (time(steps), time(2 * steps));
    (twice - once) / steps as f64
}

fn chains<const N: usize>() {
    // As long a run for many robots as for one.
    let steps = 20_000 / N as u64 + 500;
    let per_step = |run: fn(u64)| per_step(steps, run);
    report(&format!("MP, {N} ECP, {N} EDP: joints held, no kinematics"), || {
        per_step(mrroc_benches::held::<N>)
    });
    report(&format!("MP, {N} ECP, {N} EDP: IRp-6 by poses, exact drives"), || {
        per_step(mrroc_benches::by_poses::<N>)
    });
    report(&format!("MP, {N} ECP, {N} EDP: IRp-6 by poses, simulated drives"), || {
        per_step(mrroc_benches::with_dynamics::<N>)
    });
}
