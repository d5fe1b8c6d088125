//! Prints how long a clearance check takes on this machine.
//! Run with `cargo bench -p mrroc-robots --bench clearance`.

#![expect(clippy::disallowed_methods, reason = "a benchmark measures")]

use std::hint::black_box;
use std::time::{Duration, Instant};

use mrroc::fault::Name;
use mrroc::pose::Pose;
use mrroc::robot::RobotView;
use mrroc::sensor::EffectorState;
use mrroc_robots::clearance::{Capsule, Clearance, ClearanceBuilder, Obstacle, Stopping};
use mrroc_robots::{Irp6, Polycrank, Rnt};
use nalgebra::Vector3;

/// Calls per measurement, and measurements, of which the best counts.
const CALLS: u32 = 1_000;
const MEASUREMENTS: u32 = 300;

fn view(name: &str, joints: [f64; 8]) -> RobotView {
    let state = EffectorState { joints, velocity: [0.05; 8], pose: Pose::identity(), wrench: None };
    RobotView { name: Name::new(name).expect("a plain name"), measured: state, demanded: state }
}

fn measure(what: &str, build: ClearanceBuilder, states: &[RobotView]) {
    let mut clearance = build.build(Stopping::of_guard(Duration::from_millis(2), 5)).expect("all is valid");
    let mut best = [f64::INFINITY; 2];
    for _ in 0..MEASUREMENTS {
        let start = Instant::now();
        for _ in 0..CALLS {
            let _ = black_box(clearance.check(black_box(states)));
        }
        best[0] = best[0].min(start.elapsed().as_secs_f64() / f64::from(CALLS));
        let start = Instant::now();
        for _ in 0..CALLS {
            let _ = black_box(clearance.nearest(black_box(states)));
        }
        best[1] = best[1].min(start.elapsed().as_secs_f64() / f64::from(CALLS));
    }
    let [check, nearest] = best.map(|seconds| 1e6 * seconds);
    let pairs = clearance.pairs();
    println!("{what:30} {pairs:4} pairs: check {check:6.2} us, nearest {nearest:6.2} us");
}

/// One pair of capsules, of many.
fn gap() {
    let at = |k: f64| Vector3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k).sin());
    let capsules: Vec<Capsule> =
        (0..200).map(|k| Capsule::new(at(f64::from(k)), at(f64::from(k) + 0.5), 0.01)).collect();
    let mut best = f64::INFINITY;
    for _ in 0..MEASUREMENTS {
        let start = Instant::now();
        for one in &capsules {
            for other in &capsules {
                black_box(one.gap(other).distance);
            }
        }
        best = best.min(start.elapsed().as_secs_f64() / (200.0 * 200.0));
    }
    println!("{:30} {:6.1} ns", "gap of two capsules", 1e9 * best);
}

fn main() {
    gap();
    let rod = [Capsule::new(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.2), 0.02)];
    let arm = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0, 0.0, 0.0];
    let across = |x: f64| Pose::new(Vector3::new(x, 0.0, 0.8), Vector3::z() * core::f64::consts::PI);
    let two = || -> Result<ClearanceBuilder, mrroc_robots::clearance::ClearanceError> {
        Clearance::with_margin(0.03)
            .robot("left", Irp6::nominal().with_base(Pose::translation(0.0, 0.0, 0.8)))?
            .robot("right", Irp6::nominal().with_base(across(2.2)))?
            .tool("left", &rod)?
            .tool("right", &rod)?
            .obstacle("floor", Obstacle::table(0.0))
    };
    let both = || -> Result<ClearanceBuilder, mrroc_robots::clearance::ClearanceError> {
        Clearance::with_margin(0.03)
            .robot("rnt", Rnt::new())?
            .robot("polycrank", Polycrank::new().with_base(Pose::translation(1.8, 0.0, 0.0)))?
            .tool("rnt", &rod)?
            .tool("polycrank", &rod)?
            .obstacle("floor", Obstacle::table(-0.1))
    };
    measure("two IRp-6, tools, floor", two().expect("valid"), &[view("left", arm), view("right", arm)]);
    let states = [
        view("rnt", [0.0, 0.5, 0.55, 0.0, 1.3, 0.0, 0.0, 0.0]),
        view("polycrank", [0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2, 0.0]),
    ];
    measure("RNT, Polycrank, tools, floor", both().expect("valid"), &states);
}
