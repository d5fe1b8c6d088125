//! Prints how long the kinematics of arms read from URDF take, as `what nanoseconds` per line, for the comparison with
//! other libraries by `just bench-peers`. Run alone with `cargo bench -p mrroc-robots --bench peers`.
//!
//! The joint positions are those of `tests/benches/peers/README.md`: SplitMix64 from a fixed seed, uniform within the limits.

#![expect(clippy::disallowed_methods, reason = "a benchmark measures")]

use std::hint::black_box;
use std::time::Instant;

use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc_robots::{Irp6, Kinematics, Serial};
use nalgebra::{SVector, Vector3};

/// Positions that are gone through in turn.
const POSITIONS: usize = 1000;

/// Positions in a row that are timed together: short enough that mostly nothing else runs meanwhile.
const WINDOW: usize = 100;

/// Rounds through all positions; of each window the least time counts.
const ROUNDS: usize = 200;

/// How far seeds lie from the solution, in either direction [rad or m].
const NEAR: f64 = 0.01;

/// Prints the mean time of a call.
fn time(arm: &str, what: &str, mut call: impl FnMut(usize)) {
    let mut best = [f64::INFINITY; POSITIONS / WINDOW];
    // A refusal after iteration takes long enough to be measured in a few rounds.
    for _ in 0..if what == "refusal" { 3 } else { ROUNDS } {
        for (window, best) in best.iter_mut().enumerate() {
            let start = Instant::now();
            (window * WINDOW..(window + 1) * WINDOW).for_each(&mut call);
            *best = best.min(start.elapsed().as_secs_f64());
        }
    }
    println!("{arm} {what} {:.1}", best.iter().sum::<f64>() / POSITIONS as f64 * 1e9);
}

/// Positions within the limits (of an endless joint: within a turn), their poses, and seeds nearby.
fn samples<const N: usize, R: Robot<Joints = SVector<f64, N>>>(
    robot: &R,
) -> Vec<(SVector<f64, N>, Pose, SVector<f64, N>)> {
    let mut random = Random::seeded(2014);
    (0..POSITIONS)
        .map(|_| {
            let limits = robot.limits();
            let q =
                SVector::from_fn(|i, _| random.between(limits.lower[i].max(-7.0), limits.upper[i].min(7.0)));
            let near = SVector::<f64, N>::from_fn(|i, _| q[i] + random.between(-NEAR, NEAR));
            (q, robot.forward(&q), near)
        })
        .collect()
}

fn measure<const N: usize, R: Robot<Joints = SVector<f64, N>>>(arm: &str, robot: &R) {
    let samples = samples(robot);
    let sum = samples.iter().fold(Vector3::zeros(), |sum, sample| sum + sample.1.translation.vector);
    println!("{arm} sum {:.9} {:.9} {:.9}", sum.x, sum.y, sum.z);
    time(arm, "forward", |i| {
        black_box(robot.forward(black_box(&samples[i].0)));
    });
    time(arm, "inverse_nearest", |i| {
        black_box(robot.inverse(black_box(&samples[i].1), black_box(&samples[i].2)).is_ok());
    });
}

fn urdf<const N: usize>(arm: &str, base: &str, tip: &str) {
    let path = format!("{}/tests/reference/urdf/{arm}.urdf", env!("CARGO_MANIFEST_DIR"));
    let robot: Serial<N> = match Serial::from_urdf_file(path, base, tip)
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
    {
        Ok(robot) => robot,
        Err(why) => return println!("# {arm}: {why}"),
    };
    measure(arm, &robot);
    let samples = samples(&robot);
    time(arm, "jacobian", |i| {
        black_box(robot.jacobian(black_box(&samples[i].0)));
    });
    // Half the reach aside, which few arms can do: what a refusal costs.
    let far = |i: usize| {
        let mut pose = samples[i].1;
        pose.translation.vector.x += 0.5 * robot.reach();
        pose
    };
    time(arm, "refusal", |i| {
        black_box(robot.inverse(black_box(&far(i)), black_box(&samples[i].2)).is_ok());
    });
    if robot.is_closed_form() {
        time(arm, "inverse_all", |i| {
            let mut sum = 0.0;
            let _ = robot.solutions(black_box(&samples[i].1), black_box(&samples[i].2), &mut |q| sum += q[0]);
            black_box(sum);
        });
    }
}

/// An arm of UR's form whose right angles are off by a milliradian, and which begins with the closed form of the exact one.
fn calibrated() {
    let path = format!("{}/tests/reference/urdf/three_parallel.urdf", env!("CARGO_MANIFEST_DIR"));
    let made = std::fs::read_to_string(path).map_err(|why| why.to_string()).and_then(|text| {
        let arm = |text: &str| {
            Serial::<6>::from_urdf(text, "base", "wrist_3")
                .and_then(|arm| arm.with_acceleration(SVector::repeat(10.0)))
        };
        let off = text.replace("1.5707963267948966", "1.5717963267948966");
        arm(&text).and_then(|nominal| arm(&off)?.calibrated_from(nominal)).map_err(|why| why.to_string())
    });
    match made {
        Ok(robot) => measure("three_parallel_calibrated", &robot),
        Err(why) => println!("# three_parallel_calibrated: {why}"),
    }
}

fn main() {
    urdf::<6>("ortho_parallel", "base_link", "tool0");
    urdf::<6>("offset_arm", "foot", "tool");
    urdf::<6>("three_parallel", "base", "wrist_3");
    urdf::<6>("three_parallel_beside", "foot", "tool");
    calibrated();
    urdf::<7>("seven_axes", "world_foot", "flange");
    urdf::<7>("offset_elbow", "foot", "tool");
    urdf::<7>("offset_wrist", "link0", "flange");
    urdf::<4>("scara", "base", "tool");
    urdf::<4>("gantry", "bed", "tool");
    urdf::<4>("palletiser", "base", "tool");
    measure("irp6", &Irp6::nominal());
}
