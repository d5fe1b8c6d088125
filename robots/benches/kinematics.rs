//! Prints how long kinematics and one servo period of the simulated robots take on this machine.
//! Run with `cargo bench -p mrroc-robots --bench kinematics`.

#![expect(clippy::disallowed_methods, reason = "a benchmark measures")]

mod stopwatch;

use std::hint::black_box;

use mrroc::robot::Driver;
use mrroc_robots::{
    Driven, Five, Irp6, Irp6FiveDof, Irp6Track, Kinematics, Polycrank, Rnt, Seven, Simulated, Six,
};
use nalgebra::SVector;

/// Calls per measurement: short, so that some measurements are not interrupted.
const CALLS: u32 = 5_000;
/// Measurements, of which the best counts.
const MEASUREMENTS: u32 = 300;

fn time(call: impl FnMut(u32)) -> f64 {
    stopwatch::best_mean(MEASUREMENTS, CALLS, call)
}

/// Prints a line per operation of one robot around the joints `start`.
fn robot<const N: usize, R: Driven<N> + Kinematics<N>>(robot: &R, start: SVector<f64, N>) {
    let print = |what: &str, nanoseconds: f64| println!("{:10} {what:28} {nanoseconds:8.1} ns", R::KIND);
    let at = |k: u32| start + SVector::repeat(1e-6 * f64::from(k % 1000));
    let pose = robot.forward(&start);
    print(
        "forward",
        time(|k| {
            black_box(robot.forward(black_box(&at(k))));
        }),
    );
    print(
        "inverse, nearest",
        time(|k| {
            black_box(robot.inverse(black_box(&pose), black_box(&at(k))).is_ok());
        }),
    );
    // A step of 1 ms along a path: every pose is near the last joints.
    let mut poses = Vec::new();
    poses.extend((0..1000).map(|k| robot.forward(&(start + SVector::repeat(1e-4 * f64::from(k))))));
    let mut near = start;
    print(
        "inverse, along a path",
        time(|k| {
            // There and back.
            let i = (k % 2000) as usize;
            if let Ok(q) = robot.inverse(black_box(&poses[i.min(1999 - i)]), &near) {
                near = q;
            }
        }),
    );
    let mut count = 0;
    print(
        "all solutions",
        time(|k| {
            black_box(robot.solutions(black_box(&pose), &at(k), &mut |_| count += 1).is_ok());
        }),
    );
    print(
        "jacobian",
        time(|k| {
            black_box(robot.jacobian(black_box(&at(k))));
        }),
    );
    print(
        "singularity distance",
        time(|k| {
            black_box(robot.singularity_distance(black_box(&at(k))));
        }),
    );
    print(
        "motors from joints",
        time(|k| {
            black_box(robot.motors(black_box(&at(k))));
        }),
    );
    let mut driver = Simulated::new(robot.clone(), &start);
    let mut faults = 0;
    print(
        "servo period",
        time(|k| {
            let wave = 1.0 - (f64::from(k) * (std::f64::consts::TAU / f64::from(CALLS))).cos();
            let demanded =
                SVector::<f64, N>::from_fn(|i, _| start[i] + 0.02 * wave * robot.limits().velocity[i]);
            faults += u32::from(driver.tick(black_box(&demanded)).is_err());
        }),
    );
    assert_eq!(faults, 0, "a simulated robot follows a slow wave");
}

fn main() {
    let arm = Six::new(0.1, -1.55, 0.1, -0.1, 4.6, 0.2);
    robot(&Irp6::nominal(), arm);
    robot(&Irp6FiveDof::nominal(), Five::new(0.3, -1.6, 0.1, 0.2, 1.0));
    robot(&Irp6Track::nominal(), Seven::from([0.5, arm[0], arm[1], arm[2], arm[3], arm[4], arm[5]]));
    robot(&Rnt::new(), Six::new(0.1, 0.5, 0.55, 0.2, 1.3, 0.3));
    robot(&Polycrank::new(), Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]));
}
