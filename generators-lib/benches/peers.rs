//! Prints how long lines, circles and plans take, as `what nanoseconds` per line, for the comparison with KDL and Ruckig by
//! `just bench-peers`. Run alone with `cargo bench -p mrroc-generators --bench peers`.
//!
//! The inputs are those of `tests/benches/peers/README.md`, and so are the sums that show it.

#![expect(clippy::disallowed_methods, reason = "a benchmark measures")]

use std::hint::black_box;
use std::time::Instant;

use mrroc::generator::Generator;
use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc::robot::{RobotImage, RobotState};
use mrroc_generators::bspline::{SpanLength, SpanStream, SplineSettings};
use mrroc_generators::curve::{Arc, Curve, TurnedCurve};
use mrroc_generators::generators::{JointOrder, ReachState};
use mrroc_generators::jerk::{JointLimits, JointState, JointTarget, MoveCursor, SynchronisedMove};
use mrroc_generators::line::LinePath;
use mrroc_generators::profile::{ProfileLimits, Trapezoid};
use mrroc_robots::{Irp6, Six};
use nalgebra::{SVector, UnitVector3, Vector3};

/// Inputs that are gone through in turn.
const INPUTS: usize = 1000;

/// Step of what is planned anew during the motion \[s\].
const DT: f64 = 1e-3;

/// Prints the mean time of a call: of each window of inputs in a row the least of all rounds counts.
fn time(what: &str, window: usize, rounds: usize, mut call: impl FnMut(usize)) {
    let mut best = vec![f64::INFINITY; INPUTS / window];
    for _ in 0..rounds {
        for (k, best) in best.iter_mut().enumerate() {
            let start = Instant::now();
            (k * window..(k + 1) * window).for_each(&mut call);
            *best = best.min(start.elapsed().as_secs_f64());
        }
    }
    println!("{what} {:.1}", best.iter().sum::<f64>() / INPUTS as f64 * 1e9);
}

fn sum(what: &str, positions: impl Iterator<Item = Vector3<f64>>) {
    let mean = positions.sum::<Vector3<f64>>() / INPUTS as f64;
    println!("{what} sum {:.9} {:.9} {:.9}", mean.x, mean.y, mean.z);
}

/// Instants over a duration.
fn instants(duration: f64) -> Vec<f64> {
    (0..INPUTS).map(|i| duration * (i as f64 + 0.5) / INPUTS as f64).collect()
}

fn paths() {
    let limits = ProfileLimits { velocity: 0.4, acceleration: 1.0 };
    let turned =
        |position, angle| Pose::new(position, Vector3::z() * 0.3) * Pose::rotation(Vector3::x() * angle);
    let line =
        LinePath::new(turned(Vector3::new(0.8, 0.1, 0.4), 0.0), turned(Vector3::new(1.1, -0.2, 0.6), 0.5));
    // Along a line of a length, `s` is a share of it.
    let unit = ProfileLimits { velocity: 0.4 / line.length(), acceleration: 1.0 / line.length() };
    let Ok(profile) = Trapezoid::new(1.0, unit) else { return };
    let at = instants(profile.duration());
    sum("line", at.iter().map(|t| line.pose(profile.at(*t).s).translation.vector));
    time("line pose", 100, 2000, |i| {
        black_box(line.pose(profile.at(black_box(at[i])).s));
    });
    time("line derivatives", 100, 2000, |i| {
        black_box(line.at(&profile.at(black_box(at[i]))));
    });
    let (centre, on) = (Vector3::new(0.8, 0.1, 0.2), Vector3::new(1.0, 0.1, 0.2));
    let axis = UnitVector3::new_normalize(Vector3::new(0.0, -0.8, 0.6));
    let Ok(arc) = Arc::about(on, centre, axis, 1.5 * std::f64::consts::PI) else { return };
    let Ok(circle) = TurnedCurve::new(arc, turned(on, 0.0), turned(on, 0.5)) else { return };
    let Ok(profile) = Trapezoid::new(arc.length(), limits) else { return };
    let at = instants(profile.duration());
    sum("circle", at.iter().map(|t| circle.pose(profile.at(*t).s).translation.vector));
    time("circle pose", 100, 2000, |i| {
        black_box(circle.pose(profile.at(black_box(at[i])).s));
    });
    time("circle derivatives", 100, 2000, |i| {
        black_box(circle.at(&profile.at(black_box(at[i]))));
    });
}

/// A state and a target.
type Case<J> = (JointState<J>, JointTarget<J>);

/// States and targets of `N` axes, of a size where they move.
fn plans<const N: usize>(moving: f64) -> Vec<Case<SVector<f64, N>>> {
    let mut random = Random::seeded(7);
    let mut draw = |size: f64| SVector::<f64, N>::from_fn(|_, _| random.between(-size, size));
    (0..INPUTS)
        .map(|_| {
            let start = JointState {
                position: draw(2.0),
                velocity: draw(0.6 * moving),
                acceleration: draw(2.0 * moving),
            };
            (
                start,
                JointTarget {
                    position: draw(2.0),
                    velocity: draw(0.6 * moving),
                    acceleration: SVector::zeros(),
                },
            )
        })
        .collect()
}

fn limits<const N: usize>() -> JointLimits<SVector<f64, N>> {
    let all = SVector::repeat;
    JointLimits { velocity: all(1.0), acceleration: all(4.0), jerk: all(20.0) }
}

fn calculate<const N: usize>(what: &str, moving: f64) {
    let (cases, limits) = (plans::<N>(moving), limits::<N>());
    let plan = |i: usize| SynchronisedMove::new(&cases[i].0, &cases[i].1, &limits);
    let sum: f64 = (0..INPUTS).map(|i| plan(i).map_or(f64::NAN, |plan| plan.duration())).sum();
    println!("{what} sum {:.9}", sum / INPUTS as f64);
    time(what, 50, 200, |i| {
        let _ = black_box(plan(i));
    });
    if let (6, true, Ok(motion)) = (N, moving > 0.0, plan(0)) {
        let at = instants(motion.duration());
        time("at_6", 100, 2000, |i| {
            black_box(motion.at(black_box(at[i])));
        });
    }
}

/// Where the target is after `i` steps in which it drifts.
fn drifted(target: &Six, drift: f64, i: usize) -> Six {
    Six::from_fn(|k, _| target[k] + drift * (i + 1) as f64 * if k % 2 == 0 { 1.0 } else { -1.0 })
}

/// A step of six axes in motion, to a target that stays or that moves in every step.
fn update(what: &str, drift: f64) {
    let ((start, target), limits) = (plans::<6>(0.0)[3], limits::<6>());
    let begin = || SynchronisedMove::new(&start, &target, &limits).map(MoveCursor::new);
    let Ok(mut cursor) = begin() else { return };
    time(what, 50, 200, |i| {
        if i == 0
            && let Ok(begun) = begin()
        {
            cursor = begun;
        }
        let to = JointTarget::rest(drifted(&target.position, drift, i));
        let _ = black_box(cursor.turn_to(&to, &limits));
        black_box(cursor.advance(DT));
    });
}

/// The same as a generator's step.
fn reach(what: &str, drift: f64) {
    let ((start, target), limits) = (plans::<6>(0.0)[3], limits::<6>());
    let state = RobotState { joints: start.position, velocity: Six::zeros(), pose: Pose::identity() };
    let (e, v) = (State::<Irp6>::new(RobotImage::new(state, state)), Reading::new(()));
    let t = Tick { step: 0, dt: DT, duration: DT };
    let order = |i: usize| {
        let mut joints = [0.0; mrroc::robot::MAX_JOINTS];
        joints[..6].copy_from_slice(drifted(&target.position, drift, i).as_slice());
        Order::new(JointOrder { joints })
    };
    let mut generator = ReachState::<Irp6>::within(limits);
    time(what, 50, 200, |i| {
        if i == 0 {
            generator = ReachState::within(limits);
            let _ = black_box(generator.first_step(&order(i), &e, &v, t));
        } else {
            let _ = black_box(generator.next_step(&order(i), &e, &v, t));
        }
    });
}

/// A point every 25th of a span of the moving-segment B-spline, by the length: windows, lengths and points together.
fn spline(what: &str) {
    const PER_SPAN: usize = 25;
    let points: Vec<Vector3<f64>> = (0..=INPUTS)
        .map(|i| f64::from(i as u32) * 0.13)
        .map(|a| Vector3::new(a.cos() + 0.1 * (3.0 * a).cos(), a.sin(), 0.05 * a) * 0.05)
        .collect();
    let mut best = f64::INFINITY;
    let mut count = 0;
    for _ in 0..200 {
        let Ok(spans) = SpanStream::new(SplineSettings::default(), points.iter().copied()) else { return };
        let start = Instant::now();
        count = 0;
        for span in spans.flatten() {
            let Some(table) = SpanLength::new(&span.span) else { continue };
            let (step, mut u) = (table.to(span.span.knot_span()) / PER_SPAN as f64, 0.0);
            for k in 0..PER_SPAN {
                u = table.parameter_at(k as f64 * step, u);
                black_box(span.span.position(u));
            }
            count += PER_SPAN;
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    println!("{what} points {count}");
    println!("{what} {:.1}", best / count as f64 * 1e9);
}

fn main() {
    paths();
    calculate::<6>("rest_6", 0.0);
    calculate::<6>("random_6", 1.0);
    calculate::<7>("random_7", 1.0);
    update("update_same", 0.0);
    update("update_changed", 1e-4);
    reach("reach_same", 0.0);
    reach("reach_changed", 1e-4);
    spline("spline_point");
}
