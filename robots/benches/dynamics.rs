//! Prints how long the terms of the equation of motion take on this machine, and a servo period of simulated drives that their
//! links couple, beside that of the same drives alone. Run with `cargo bench -p mrroc-robots --bench dynamics`.

#![expect(clippy::disallowed_methods, reason = "a benchmark measures")]

mod stopwatch;

use std::hint::black_box;

use mrroc::robot::Driver;
use mrroc_robots::{Driven, Irp6, Irp6Track, Polycrank, Rnt, Serial, Simulated};
use nalgebra::SVector;

/// Calls per measurement: short, so that some measurements are not interrupted.
const CALLS: u32 = 1_000;
/// Measurements, of which the best counts.
const MEASUREMENTS: u32 = 200;

fn time(call: impl FnMut(u32)) -> f64 {
    stopwatch::best_mean(MEASUREMENTS, CALLS, call)
}

fn robot<const N: usize, R: Driven<N>>(name: &str, robot: &R, start: [f64; N]) {
    let start = SVector::<f64, N>::from(start);
    let print = |what: &str, nanoseconds: f64| println!("{name:12} {what:28} {nanoseconds:8.1} ns");
    let at = |k: u32| start + SVector::repeat(1e-6 * f64::from(k % 1000));
    let speed = SVector::<f64, N>::repeat(0.3);
    if let Some(tree) = robot.tree() {
        print(
            "inverse dynamics",
            time(|k| {
                black_box(tree.inverse_dynamics(&at(k), &speed, &speed, None));
            }),
        );
        print(
            "mass matrix",
            time(|k| {
                black_box(tree.mass_matrix(&at(k)));
            }),
        );
        print(
            "forward dynamics",
            time(|k| {
                black_box(tree.forward_dynamics(&at(k), &speed, &speed, None));
            }),
        );
    }
    if let Some(links) = robot.dynamics() {
        print(
            "M and h",
            time(|k| {
                black_box(links.equation(&at(k), &speed));
            }),
        );
    }
    let speeds = robot.limits().velocity * 0.05;
    let demanded = |k: u32| start + speeds * (0.002 * f64::from(k)).sin();
    let period = |what: &str, mut arm: Simulated<R, N>| {
        let mut k = 0;
        print(
            what,
            time(|_| {
                k += 1;
                let _ = black_box(arm.tick(&demanded(k)));
            }),
        );
        assert!(arm.tick(&demanded(k + 1)).is_ok(), "{name} tripped");
    };
    period("servo period, alone", Simulated::new(robot.clone(), &start));
    if let Some(arm) = Simulated::coupled(robot.clone(), &start) {
        period("servo period, coupled", arm);
    }
}

fn main() {
    robot("irp6", &Irp6::nominal(), Irp6::READY.data.0[0]);
    robot("irp6-track", &Irp6Track::nominal(), [0.5, 0.0, -1.57, 0.16, -0.16, 4.71, 0.0]);
    robot("rnt", &Rnt::new(), [0.0, 0.5, 0.55, 0.0, 1.3, 0.0]);
    robot("polycrank", &Polycrank::new(), [0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]);
    let weighted = Serial::<6>::from_urdf(
        include_str!("../tests/reference/urdf/weighted_arm.urdf"),
        "base_link",
        "tool0",
    );
    let weighted = weighted.and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)));
    robot("urdf", &weighted.expect("the URDF is sound"), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
}
