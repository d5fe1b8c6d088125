//! The closed linkages of the RNT, and its wrist.

use core::f64::consts::FRAC_PI_2;

use mrroc::prelude::*;
use mrroc::robot::NoInverse;
use mrroc_robots::{Kinematics, Rnt, Six};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// Upper arm upright, forearm level, tool straight down.
fn drawn() -> Six {
    Rnt::from_elevations(&Six::new(0.1, FRAC_PI_2, 0.0, 0.0, FRAC_PI_2, 0.3)).expect("the drawn posture")
}

fn error_between(x: &Pose, y: &Pose) -> f64 {
    let rotation =
        x.rotation.to_rotation_matrix().into_inner() - y.rotation.to_rotation_matrix().into_inner();
    rotation.amax().max((x.translation.vector - y.translation.vector).amax())
}

/// The three loop equations of the module's documentation, from the frames alone.
#[test]
fn every_posture_closes_its_three_loops() {
    let robot = Rnt::new();
    let start = drawn();
    for k in 0..200 {
        let q = start + Six::new(0.0, 0.05, 0.06, 0.0, 0.0, 0.0) * (f64::from(k) * 0.1).sin();
        assert!(robot.is_attainable(&q), "{q}");
        let mut points = Vec::new();
        robot.frames(&q, &mut |frame| points.push(frame.translation.vector));
        let (o, r, t, e, c) = (points[2], points[3], points[4], points[5], points[6]);
        let out = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q[0]) * Vector3::x();
        let foot = |distance: f64, degrees: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            o + distance * (cosine * out + sine * Vector3::z())
        };
        let crank = o + (e - o) * 0.5;
        let lengths = [
            ((foot(0.40, -20.0) - crank).norm(), q[1]),
            ((foot(0.55, 250.0) - r).norm(), q[2]),
            ((t - r).norm(), 0.52),
            ((r - o).norm(), 0.20),
            ((e - o).norm(), 0.50),
            ((e - t).norm(), 0.20),
            ((c - e).norm(), 0.60),
            ((c - t).norm(), 0.80),
        ];
        for (i, (found, expected)) in lengths.into_iter().enumerate() {
            assert!((found - expected).abs() < 1e-13, "length {i}: {found} {expected} at {q}");
        }
    }
}

/// No parallelogram: the upper arm's actuator turns the forearm, too.
#[test]
fn driving_the_upper_arm_alone_turns_the_forearm() {
    let low =
        Rnt::from_elevations(&Six::new(0.1, 1.0, -0.8, 0.0, FRAC_PI_2, 0.3)).expect("the arm bent forwards");
    let before = Rnt::elevations(&low).expect("closed");
    let mut q = low;
    q[1] += 0.02;
    let after = Rnt::elevations(&q).expect("closed");
    let (upper, forearm) = (after[0] - before[0], after[1] - before[1]);
    println!("20 mm of the shoulder's actuator: upper arm {upper:.4} rad, forearm {forearm:.4} rad");
    assert!(upper > 0.05 && forearm.abs() > 1e-3);
}

#[test]
fn the_linkages_refuse_the_neighbourhood_of_a_dead_centre() {
    let robot = Rnt::new();
    let limits = robot.limits();
    let mut q = drawn();
    (q[1], q[2]) = (limits.upper[1], limits.upper[2]);
    let why = robot.check_coupled(&drawn(), &q, 10.0).expect_err("rocker and rod in line");
    assert!(why.excess.actual < Rnt::TRANSMISSION && why.what.contains("transmission"), "{why:?}");
    assert!(robot.check_coupled(&drawn(), &drawn(), 1.0).is_ok());
    assert_eq!(Rnt::elevations(&Six::new(0.0, 0.9, 0.5, 0.0, 0.0, 0.0)), None, "an actuator too long");
}

#[test]
fn a_line_through_the_wrist_singularity_does_not_jump() {
    let robot = Rnt::new();
    let mut middle = drawn();
    middle[4] = 0.0;
    let at = |s: f64| {
        let mut q = middle;
        q[4] = 0.3 * s;
        let pose = robot.forward(&q);
        let along = Vector3::new(0.02, 0.01, 0.03) * s;
        Pose::from_parts(Translation3::from(pose.translation.vector + along), pose.rotation)
    };
    let mut first = middle;
    first[4] = -0.3;
    let mut near = robot.inverse(&at(-1.0), &first).expect("within reach");
    for i in -999..=1000 {
        let pose = at(f64::from(i) / 1000.0);
        let q = robot.inverse(&pose, &near).expect("within reach");
        // Off the singular point the line leaves the plane of q4 a little: the wrist swings, but never by a flip.
        assert!((q - near).amax() < 0.5, "{i}: {}", q - near);
        assert!(error_between(&robot.forward(&q), &pose) < 1e-9);
        near = q;
    }
}

#[test]
fn what_cannot_be_reached_is_refused_with_its_cause() {
    let robot = Rnt::new();
    let mut pose = robot.forward(&drawn());
    pose.translation.vector.x = 2.0;
    assert!(matches!(robot.inverse(&pose, &drawn()), Err(NoInverse::OutOfReach { .. })));
    let mut pose = robot.forward(&drawn());
    pose.translation.vector = Vector3::new(0.0, 0.0, 1.6);
    assert_eq!(robot.inverse(&pose, &drawn()), Err(NoInverse::Singular { name: "shoulder" }));
    // Within the arm's reach, but high up, with the arm all but stretched: rod and rocker do not bridge that.
    let mut pose = robot.forward(&Six::new(0.1, 0.5, 0.55, 0.2, 1.3, 0.3));
    pose.translation.vector.component_mul_assign(&Vector3::new(1.15, 1.15, 1.0));
    pose.translation.vector.z += 0.4;
    let why = robot.inverse(&pose, &drawn()).expect_err("beyond the dead centre");
    let NoInverse::NotAttainable { actual, tolerance, .. } = why else { panic!("{why}") };
    assert!(actual > tolerance, "{why}");
}
