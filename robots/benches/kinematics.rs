//! Prints how long kinematics and one servo period of the simulated arm take on this machine.
//! Run with `cargo bench -p mrroc-robots --bench kinematics`.

use std::hint::black_box;
use std::time::Instant;

use mrroc::{Driver, Robot};
use mrroc_robots::{Irp6, Kinematics, SimulatedIrp6, Six};

/// Calls per measurement.
const CALLS: u32 = 200_000;

/// Prints the best of ten means of the time of one call.
fn time(what: &str, mut call: impl FnMut(u32)) {
    let mut best = f64::INFINITY;
    for _ in 0..10 {
        let start = Instant::now();
        (0..CALLS).for_each(&mut call);
        best = best.min(start.elapsed().as_secs_f64() / f64::from(CALLS));
    }
    println!("{what:24} {:7.1} ns", best * 1e9);
}

fn main() {
    let robot = Irp6::nominal();
    let start = Six::new(0.1, -1.55, 0.1, -0.1, 4.6, 0.2);
    let at = |k: u32| start + Six::repeat(1e-6 * f64::from(k % 1000));
    let pose = robot.forward(&start);
    time("forward", |k| {
        black_box(robot.forward(black_box(&at(k))));
    });
    time("inverse", |k| {
        black_box(robot.inverse(black_box(&pose), black_box(&at(k))).is_ok());
    });
    time("jacobian", |k| {
        black_box(robot.jacobian(black_box(&at(k))));
    });
    time("motors from joints", |k| {
        black_box(robot.transmission().motors(black_box(&at(k))));
    });
    let mut arm = SimulatedIrp6::new(robot, &start);
    let mut faults = 0;
    time("servo period", |k| {
        let wave = (f64::from(k) * (std::f64::consts::TAU / f64::from(CALLS))).sin();
        faults += u32::from(arm.tick(black_box(&(start + Six::repeat(0.05 * wave)))).is_err());
    });
    println!("{faults} faults");
}
