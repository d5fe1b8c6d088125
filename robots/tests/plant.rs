//! The simulated arm: how well it follows, when it trips, how it rests.

use mrroc::prelude::*;
use mrroc::robot::{Driver, Measured};
use mrroc_robots::{Irp6, MotorData, Plant, Regulator, SimulatedIrp6, Six};
use nalgebra::{Point3, Translation3, Vector3};

use crate::support::engraving;

const PERIOD: f64 = 0.002;

/// Runs a path of the flange around a place on the engraving plate; returns the true positions of the tool's tip,
/// 0.25 m before the flange, relative to it.
fn execute(
    robot: &Irp6,
    place: &Vector3<f64>,
    path: impl Fn(f64) -> Option<Vector3<f64>>,
    settle: usize,
) -> Vec<Vector3<f64>> {
    let mut reference = Irp6::nominal().forward(&engraving());
    reference.translation.vector += place;
    let start = robot.inverse(&reference, &engraving()).expect("on the plate");
    let mut arm = SimulatedIrp6::new(robot.clone(), &start);
    let shaft = arm.shaft();
    let tool = Point3::new(0.0, 0.0, 0.25);
    let mut q = start;
    let mut executed = Vec::new();
    let mut rest = settle;
    for k in 1.. {
        if let Some(offset) = path(k as f64 * PERIOD) {
            let position = Translation3::from(reference.translation.vector + offset);
            q = robot.inverse(&Pose::from_parts(position, reference.rotation), &q).expect("on the plate");
        } else if rest > 0 {
            rest -= 1;
        } else {
            break;
        }
        arm.tick(&q).expect("an engraving stroke trips no drive");
        let executed_flange = robot.forward(&shaft.state().position);
        executed.push((executed_flange * tool).coords - (reference * tool).coords);
    }
    executed
}

/// Path length after time `t` with a quintic rise of the speed to `feed` within `ramp`, and such a fall at the end.
fn travelled(t: f64, length: f64, feed: f64, ramp: f64) -> Option<f64> {
    let total = length / feed + ramp;
    if t > total + 0.5 * PERIOD {
        return None;
    }
    // Integral of 10 x^3 - 15 x^4 + 6 x^5.
    let rise = |x: f64| x.powi(4) * (2.5 - 3.0 * x + x * x);
    let from_start = |t: f64| if t < ramp { feed * ramp * rise(t / ramp) } else { feed * (t - 0.5 * ramp) };
    Some(if t < total - ramp { from_start(t) } else { length - from_start((total - t).max(0.0)) })
}

/// Root mean square and largest of the distances.
fn summary(distances: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
    for distance in distances {
        sum += distance * distance;
        worst = worst.max(distance);
        count += 1.0;
    }
    (f64::sqrt(sum / count), worst)
}

/// The engraving reference and two corners of the plate, nominal and calibrated arm.
fn arms_and_places() -> [(Irp6, Vector3<f64>); 4] {
    [
        (Irp6::nominal(), Vector3::zeros()),
        (Irp6::calibrated(), Vector3::zeros()),
        (Irp6::nominal(), Vector3::new(0.065, 0.09, 0.0)),
        (Irp6::nominal(), Vector3::new(-0.055, -0.08, 0.05)),
    ]
}

#[test]
fn a_circle_is_followed_to_a_tenth_of_a_millimetre() {
    let (radius, feed) = (0.010, 0.020);
    let length = 3.0 * std::f64::consts::TAU * radius;
    let centre = Vector3::new(-radius, 0.0, 0.0);
    for (robot, place) in arms_and_places() {
        let circle = |t| {
            let s = travelled(t, length, feed, 0.1)? / radius;
            Some(centre + radius * Vector3::new(s.cos(), s.sin(), 0.0))
        };
        let executed = execute(&robot, &place, circle, 100);
        let (rms, worst) = summary(executed.iter().map(|p| {
            let from = p - centre;
            (from.xy().norm() - radius).hypot(from.z)
        }));
        println!("circle r 10 mm, 20 mm/s: rms {:.4} mm, worst {:.4} mm", rms * 1e3, worst * 1e3);
        assert!(rms < 1e-4 && worst < 3e-4, "{place}: {rms} {worst}");
    }
}

#[test]
fn a_square_is_followed_to_a_tenth_of_a_millimetre() {
    let (side, feed, ramp) = (0.020, 0.020, 0.1);
    let corners = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side), (0.0, 0.0)]
        .map(|(x, y)| Vector3::new(x, y, 0.0));
    let per_side = side / feed + ramp;
    let square = |t: f64| {
        let i = ((t - 1e-9) / per_side).floor().max(0.0) as usize;
        let s = travelled(t - 1e-9 - i as f64 * per_side, side, feed, ramp)? / side;
        let (from, to) = (*corners.get(i)?, *corners.get(i + 1)?);
        Some(from + (to - from) * s)
    };
    let distance = |p: &Vector3<f64>| {
        let to_side = |i: usize| {
            let along = corners[i + 1] - corners[i];
            let s = ((p - corners[i]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (p - corners[i] - along * s).norm()
        };
        (0..4).map(to_side).fold(f64::INFINITY, f64::min)
    };
    for (robot, place) in arms_and_places() {
        let executed = execute(&robot, &place, square, 100);
        assert!(executed.len() > 2200, "all four sides were run");
        let (rms, worst) = summary(executed.iter().map(distance));
        println!("square 20 mm, 20 mm/s: rms {:.4} mm, worst {:.4} mm", rms * 1e3, worst * 1e3);
        assert!(rms < 1e-4 && worst < 3e-4, "{place}: {rms} {worst}");
    }
}

/// Half and twice the assumed inertia: the published gains must have margins.
#[test]
fn every_servo_loop_settles_with_half_and_twice_its_inertia() {
    for (i, data) in Irp6::MOTORS.iter().enumerate() {
        for share in [0.5, 1.0, 2.0] {
            let data = MotorData { inertia: share * data.inertia, ..*data };
            let mut plant = Plant::at_rest(&data, 0.0);
            let mut regulator = Regulator::holding(data.gains, 0.0);
            let (mut demanded, mut count, mut deviation) = (0.0, 0.0, 0.0);
            let mut late = 0.0_f64;
            for k in 0..1000 {
                // 5 rad in 0.2 s, then rest.
                let next = if k < 100 { 0.05 / data.encoder.pulse() } else { 0.0 };
                plant.run(regulator.step(deviation, next), 0.0);
                let increment = data.encoder.count(plant.angle()) - count;
                count += increment;
                demanded += next;
                deviation = next - increment;
                if k > 500 {
                    late = late.max((demanded - count).abs());
                }
            }
            assert!(late <= 12.0, "motor {i}, inertia {share}: {late} pulses off after 0.8 s of rest");
        }
    }
}

/// Expected values: scipy.signal.lfilter of (b0, -b1)(1.010, -0.990) over (1, -1)(1, -a)(1, -1).
#[test]
fn the_regulator_answers_an_impulse_as_its_transfer_function_does() {
    let mut regulator = Regulator::holding(Irp6::MOTORS[0].gains, 0.0);
    let expected = [
        6.90234,
        3.328063860000004,
        1.7992593959400107,
        1.1479622808582786,
        0.8731158184882206,
        0.7597666861314709,
        0.7156999083504305,
        0.7013552606823694,
    ];
    for (k, expected) in expected.into_iter().enumerate() {
        let output = regulator.step(if k == 0 { 1.0 } else { 0.0 }, 0.0);
        assert!((output - expected).abs() < 1e-12, "{k}: {output} {expected}");
    }
}

#[test]
fn an_arm_that_holds_rests_within_two_encoder_pulses() {
    let q = engraving();
    let mut arm = SimulatedIrp6::new(Irp6::nominal(), &q);
    assert!((arm.measured().expect("simulated").position - q).amax() < 3e-5);
    let shaft = arm.shaft();
    for _ in 0..30_000 {
        arm.tick(&q).expect("holding trips nothing");
        assert!((shaft.state().position - q).amax() < 5e-5, "{}", shaft.state().position - q);
    }
    println!("drift after a minute: {:.1e} rad", (shaft.state().position - q).amax());
}

#[test]
fn a_motion_at_the_limits_of_one_joint_at_a_time_is_followed() {
    let robot = Irp6::nominal();
    let limits = *robot.limits();
    for joint in 0..6 {
        let start = engraving();
        let mut arm = SimulatedIrp6::new(robot.clone(), &start);
        let (v, a) = (limits.velocity[joint], limits.acceleration[joint]);
        let (mut speed, mut q, mut worst) = (0.0_f64, start, 0.0_f64);
        let stretch = if joint == 2 { 60 } else { 120 };
        for k in 0..2 * stretch {
            speed = if k < stretch { (speed + a * PERIOD).min(v) } else { (speed - a * PERIOD).max(0.0) };
            q[joint] += speed * PERIOD;
            let measured = arm.tick(&q).unwrap_or_else(|fault| panic!("joint {joint}: {fault}"));
            worst = worst.max((measured.position - q).amax());
        }
        for _ in 0..500 {
            arm.tick(&q).expect("holding trips nothing");
        }
        let rest = (arm.shaft().state().position - q).amax();
        println!("joint {joint}: largest following error {worst:.1e} rad, at rest {rest:.1e} rad");
        assert!(worst < 0.01 && rest < 1e-4);
    }
}

#[test]
fn measured_velocity_follows_the_true_one() {
    let robot = Irp6::nominal();
    let mut q = engraving();
    let mut arm = SimulatedIrp6::new(robot, &q);
    let step = Six::new(0.1, 0.05, -0.05, 0.1, 0.2, 0.1) * PERIOD;
    let mut measured = arm.measured().expect("simulated");
    for _ in 0..500 {
        q += step;
        measured = arm.tick(&q).expect("slow");
    }
    let error = measured.velocity - step / PERIOD;
    assert!(error.amax() < 0.01, "{error}");
    assert!((arm.shaft().state().velocity - step / PERIOD).amax() < 0.01);
}

#[test]
fn a_blocked_joint_trips_its_drive_and_the_arm_stands_still() {
    for joint in 0..6 {
        let mut q = engraving();
        let mut arm = SimulatedIrp6::new(Irp6::nominal(), &q);
        arm.block(joint);
        let fault = (0..2000)
            .find_map(|_| {
                q[joint] += 0.1 * PERIOD;
                arm.tick(&q).err()
            })
            .expect("a jammed motor cannot follow");
        assert_eq!(fault.joint(), Some(joint), "{fault}");
        for _ in 0..200 {
            assert_eq!(arm.tick(&q), Err(fault), "the first cause stays");
        }
        let rest: Measured<Six> = arm.shaft().state();
        assert_eq!(rest.velocity.amax(), 0.0);
        arm.unblock(joint);
        arm.reset();
        let here = arm.measured().expect("simulated").position;
        for _ in 0..100 {
            arm.tick(&here).expect("it holds where it stands");
        }
    }
}

#[test]
fn a_moving_arm_without_demands_brakes_and_goes_on_after_a_reset() {
    let mut q = engraving();
    let mut arm = SimulatedIrp6::new(Irp6::nominal(), &q);
    for _ in 0..200 {
        q[0] += 0.2 * PERIOD;
        arm.tick(&q).expect("slow");
    }
    for _ in 0..50 {
        arm.brake();
    }
    let rest = arm.shaft().state();
    assert_eq!(rest.velocity.amax(), 0.0);
    assert!((rest.position - q).amax() < 0.01, "0.2 rad/s is 32 rad/s at the motor: 21 ms to stop");
    arm.reset();
    let here = arm.measured().expect("simulated").position;
    for _ in 0..500 {
        arm.tick(&here).expect("it holds where it stands");
    }
    assert!((arm.shaft().state().position - here).amax() < 1e-4);
}

#[test]
fn demands_that_no_drive_can_take_are_refused_by_name() {
    let start = engraving();
    let refused = |change: fn(&mut Six)| {
        let mut arm = SimulatedIrp6::new(Irp6::nominal(), &start);
        let mut q = start;
        change(&mut q);
        let fault = arm.tick(&q).expect_err("refused");
        assert!((arm.shaft().state().position - start).amax() < 1e-9, "nothing moved");
        (fault.joint().expect("a joint"), fault.what())
    };
    assert_eq!(refused(|q| q[0] += 0.01), (0, "demanded motor speed"));
    assert_eq!(refused(|q| q[1] = -2.3), (1, "demanded motor angle"));
    assert_eq!(refused(|q| q[4] = -1.5), (4, "demanded motor angle"));
    assert_eq!(refused(|q| q[5] = f64::NAN), (5, "demanded motor angle"));
}

#[test]
fn equal_demands_give_equal_motion_to_the_bit() {
    let run = || {
        let mut q = engraving();
        let mut arm = SimulatedIrp6::new(Irp6::calibrated(), &q);
        for k in 0..3000 {
            q[k % 6] += 1e-4 * (k as f64 * 0.01).sin();
            arm.tick(&q).expect("slow");
        }
        arm.shaft().state()
    };
    assert_eq!(run(), run());
}
