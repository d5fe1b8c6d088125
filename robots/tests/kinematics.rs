//! Direct and inverse kinematics of the IRp-6.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc::robot::NoInverse;
use mrroc_robots::{Irp6, Kinematics, Six};
use nalgebra::{Matrix3, Translation3, UnitQuaternion, Vector3};

use crate::support::{engraving, feasible};

const SEED: u64 = 20_061_973;

fn error_between(x: &Pose, y: &Pose) -> f64 {
    let rotation =
        x.rotation.to_rotation_matrix().into_inner() - y.rotation.to_rotation_matrix().into_inner();
    rotation.amax().max((x.translation.vector - y.translation.vector).amax())
}

fn models() -> [Irp6; 3] {
    let base = Pose::new(Vector3::new(0.3, -2.1, 0.95), Vector3::new(0.1, -0.4, 2.0));
    [Irp6::nominal(), Irp6::calibrated(), Irp6::calibrated().with_base(base)]
}

/// Expected values: `reference/irp6_product_of_exponentials.py` (numpy, scipy's matrix exponential).
#[test]
fn forward_agrees_with_a_product_of_exponentials() {
    let mut rows = 0;
    for line in include_str!("reference/irp6_poses.csv").lines().skip(1) {
        let (model, numbers) = line.split_once(',').expect("a model, then numbers");
        let numbers: Vec<f64> = numbers.split(',').map(|n| n.parse().expect("a number")).collect();
        let robot = if model == "nominal" { Irp6::nominal() } else { Irp6::calibrated() };
        let pose = robot.forward(&Six::from_column_slice(&numbers[..6]));
        let position = (pose.translation.vector - Vector3::from_column_slice(&numbers[6..9])).amax();
        let rotation =
            (pose.rotation.to_rotation_matrix().into_inner() - Matrix3::from_row_slice(&numbers[9..])).amax();
        assert!(position < 1e-12 && rotation < 1e-12, "{line}: {position} {rotation}");
        rows += 1;
    }
    assert_eq!(rows, 400);
}

/// n, o, a, p as the public facts of MRROC++ give them.
#[test]
fn forward_agrees_with_the_formulas_of_mrroc() {
    let mut random = Random::seeded(SEED);
    let robot = Irp6::nominal();
    for _ in 0..1000 {
        let q = feasible(&mut random, &robot);
        let (theta3, theta4) = (q[1] + q[2] + FRAC_PI_2, q[1] + q[2] + q[3] + FRAC_PI_2);
        let ((s1, c1), (s2, c2), (s3, c3)) = (q[0].sin_cos(), q[1].sin_cos(), theta3.sin_cos());
        let ((s4, c4), (s5, c5), (s6, c6)) = (theta4.sin_cos(), q[4].sin_cos(), q[5].sin_cos());
        let u = Vector3::new(c1 * s4 * c5 + s1 * s5, s1 * s4 * c5 - c1 * s5, c4 * c5);
        let w = Vector3::new(c1 * c4, s1 * c4, -s4);
        let a = Vector3::new(c1 * s4 * s5 - s1 * c5, s1 * s4 * s5 + c1 * c5, c4 * s5);
        let expected = Matrix3::from_columns(&[u * c6 + w * s6, w * c6 - u * s6, a]);
        let rho = 0.455 * c2 + 0.67 * c3 + 0.19 * c4;
        let p = Vector3::new(c1 * rho, s1 * rho, -0.455 * s2 - 0.67 * s3 - 0.19 * s4);
        let pose = robot.forward(&q);
        assert!((pose.rotation.to_rotation_matrix().into_inner() - expected).amax() < 3e-15, "{q}");
        assert!((pose.translation.vector - p).amax() < 1e-15, "{q}");
    }
}

#[test]
fn inverse_recovers_joints_and_pose_on_both_wrist_branches() {
    let mut random = Random::seeded(SEED);
    let (mut pose_error, mut joint_error) = (0.0_f64, 0.0_f64);
    for robot in models() {
        for _ in 0..10_000 {
            let q = feasible(&mut random, &robot);
            let pose = robot.forward(&q);
            let again = robot.inverse(&pose, &q).expect("the pose comes from feasible joints");
            pose_error = pose_error.max(error_between(&robot.forward(&again), &pose));
            // The pose determines theta4 and q6 only as well as z_F stands off the axis of T.
            joint_error = joint_error.max((again - q).amax() * q[4].sin().abs());
            let solutions = robot.all_solutions(&pose, &q);
            for (solution, sign) in solutions.into_iter().zip([1.0, -1.0]) {
                // The flipped wrist may put the wrist link out of the arm's reach; that is refused, not guessed.
                match solution {
                    Ok(q) => {
                        assert!(sign * q[4].sin() >= 0.0, "{q}");
                        pose_error = pose_error.max(error_between(&robot.forward(&q), &pose));
                    }
                    Err(why) => assert!(matches!(why, NoInverse::OutOfReach { .. }), "{why}"),
                }
            }
        }
    }
    println!("seed {SEED}: pose error {pose_error:.1e}, joint error {joint_error:.1e}");
    assert!(pose_error < 1e-12, "seed {SEED}: {pose_error}");
    assert!(joint_error < 1e-12, "seed {SEED}: {joint_error}");
}

/// MRROC++ lost 9 of 240 solutions for seeds on the wrong side of the singularity, and full turns.
#[test]
fn inverse_is_correct_for_a_near_that_is_far() {
    let mut random = Random::seeded(SEED);
    let robot = Irp6::calibrated();
    for _ in 0..10_000 {
        let q = feasible(&mut random, &robot);
        let pose = robot.forward(&q);
        let near = Six::from_fn(|i, _| q[i] + random.between(-20.0, 20.0));
        if let Ok(found) = robot.inverse(&pose, &near) {
            assert!(error_between(&robot.forward(&found), &pose) < 1e-12, "seed {SEED}: {q} {near}");
            assert!((found - near).amax() <= PI + 1e-9);
        }
    }
}

#[test]
fn inverse_takes_the_branch_and_the_turn_nearest_to_near() {
    let mut random = Random::seeded(SEED);
    let robot = Irp6::nominal();
    for _ in 0..10_000 {
        let mut q = feasible(&mut random, &robot);
        q[4] += TAU * random.between(-2.0, 3.0).floor();
        let near = Six::from_fn(|i, _| q[i] + random.between(-0.3, 0.3));
        let found = robot.inverse(&robot.forward(&q), &near).expect("the pose comes from feasible joints");
        if q[4].sin().abs() > 1e-3 {
            let other = robot.all_solutions(&robot.forward(&q), &near);
            let wrist = |q: &Six| {
                (q[1] + q[2] + q[3] - near[1] - near[2] - near[3]).powi(2)
                    + (q[4] - near[4]).powi(2)
                    + (q[5] - near[5]).powi(2)
            };
            for other in other.into_iter().flatten() {
                assert!(wrist(&found) <= wrist(&other) + 1e-9, "seed {SEED}: {q}");
            }
        }
    }
}

#[test]
fn jacobian_agrees_with_finite_differences_and_manipulability_with_its_determinant() {
    let mut random = Random::seeded(SEED);
    for robot in models() {
        for _ in 0..300 {
            let q = feasible(&mut random, &robot);
            let jacobian = robot.jacobian(&q);
            let h = 1e-5;
            for i in 0..6 {
                let mut step = Six::zeros();
                step[i] = h;
                let (after, before) = (robot.forward(&(q + step)), robot.forward(&(q - step)));
                let angular = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * h);
                let linear = (after.translation.vector - before.translation.vector) / (2.0 * h);
                let error = (jacobian.fixed_view::<3, 1>(3, i) - angular).amax();
                assert!(error < 1e-9, "seed {SEED}, column {i}: {error}");
                let error = (jacobian.fixed_view::<3, 1>(0, i) - linear).amax();
                assert!(error < 1e-9, "seed {SEED}, column {i}: {error}");
            }
            let error = jacobian.determinant().abs() - robot.manipulability(&q);
            assert!(error.abs() < 1e-14, "seed {SEED}: {error}");
        }
    }
}

#[test]
fn a_pose_on_the_wrist_singularity_keeps_theta4() {
    let robot = Irp6::nominal();
    for q5 in [-PI, 0.0, PI, TAU] {
        let q = Six::new(0.4, -1.5, 0.1, 0.3, q5, -0.7);
        assert!(Irp6::wrist_singularity_distance(&q) < 1e-15);
        let pose = robot.forward(&q);
        let found = robot.inverse(&pose, &q).expect("reachable");
        assert!((found - q).amax() < 1e-9, "{found}");
        let near = q + Six::new(0.01, 0.01, -0.02, 0.05, 0.01, 0.02);
        let found = robot.inverse(&pose, &near).expect("reachable");
        let theta4 = |q: &Six| q[1] + q[2] + q[3];
        assert!((theta4(&found) - theta4(&near)).abs() < 1e-12);
        assert!(error_between(&robot.forward(&found), &pose) < 1e-9);
    }
}

/// The flange translates along a straight line and turns about one fixed axis, so that q5 runs through 0.
fn through_the_wrist_singularity(offset: f64, steps: usize) -> (f64, f64) {
    let robot = Irp6::nominal();
    let middle = Six::new(0.2, -1.6, 0.1, 0.2, 0.0, 0.1);
    let start = robot.forward(&middle);
    let axis_of_v = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.2)
        * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), middle[1] + middle[2] + middle[3] + FRAC_PI_2)
        * Vector3::x_axis();
    let aside = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.2) * Vector3::z_axis();
    let along = Vector3::new(0.04, -0.02, 0.03);
    let at = |s: f64| {
        let turn = UnitQuaternion::from_axis_angle(&aside, offset)
            * UnitQuaternion::from_axis_angle(&axis_of_v, 0.4 * s);
        Pose::from_parts(Translation3::from(start.translation.vector + along * s), turn * start.rotation)
    };
    let mut near = middle + Six::new(0.0, 0.0, 0.0, 0.0, -0.4, 0.0);
    near = robot.inverse(&at(-1.0), &near).expect("reachable");
    let (mut step, mut error) = (0.0_f64, 0.0_f64);
    for i in 1..=2 * steps {
        let pose = at(i as f64 / steps as f64 - 1.0);
        let q = robot.inverse(&pose, &near).expect("the line is within reach");
        step = step.max((q - near).amax());
        error = error.max(error_between(&robot.forward(&q), &pose));
        near = q;
    }
    (step, error)
}

#[test]
fn a_line_through_the_wrist_singularity_is_continuous() {
    let (step, error) = through_the_wrist_singularity(0.0, 1000);
    println!("through: largest joint step {step:.2e} rad, pose error {error:.1e}");
    assert!(error < 1e-9, "{error}");
    // 0.4 mrad of q5 per step; theta1..theta4 move less.
    assert!(step < 1e-3, "{step}");
}

/// Past the singularity at a small distance the wrist must swing: the joints follow without a jump as long
/// as the steps are short against the distance, and every pose is exact. How fast is the limits' matter.
#[test]
fn a_line_past_the_wrist_singularity_swings_the_wrist_without_a_flip() {
    let (coarse, error) = through_the_wrist_singularity(1e-2, 1000);
    let (fine, fine_error) = through_the_wrist_singularity(1e-2, 10_000);
    println!("past: largest joint step {coarse:.2e}, ten times finer {fine:.2e} rad");
    assert!(error < 1e-12 && fine_error < 1e-12);
    assert!(fine < 0.11 * coarse, "{fine} {coarse}: the joints are continuous");
    let limits = *Irp6::nominal().limits();
    assert!(coarse / 0.001 > limits.velocity[3], "in 1 ms steps this line is refused by the velocity limit");
}

#[test]
fn what_cannot_be_reached_is_refused_with_the_distance() {
    let robot = Irp6::nominal();
    let q = engraving();
    let mut pose = robot.forward(&q);
    pose.translation.vector.x = 1.5;
    let why = robot.inverse(&pose, &q).expect_err("too far");
    let NoInverse::OutOfReach { distance, max, .. } = why else { panic!("{why}") };
    assert!((distance - 1.31_f64.hypot(0.35)).abs() < 1e-12 && max == 1.125, "{why}");
    pose.translation.vector = Vector3::new(0.0, 0.0, 0.5);
    assert_eq!(robot.inverse(&pose, &q), Err(NoInverse::Singular { name: "shoulder" }));
    pose.translation.vector = Vector3::new(f64::NAN, 0.0, 0.5);
    assert!(robot.inverse(&pose, &q).is_err());
}

#[test]
fn an_engraving_plate_in_front_of_the_column_is_feasible_with_margins() {
    let margin = 20.0_f64.to_radians();
    for robot in [Irp6::nominal(), Irp6::calibrated()] {
        let reference = engraving();
        let down = Irp6::nominal().forward(&reference).rotation;
        for (x, y, z) in (0..27).map(|i| (i % 3 - 1, i / 3 % 3 - 1, i / 9)) {
            let position = Translation3::new(
                0.85 + 0.075 * f64::from(x),
                0.1 * f64::from(y),
                0.35 + 0.025 * f64::from(z),
            );
            let pose = Pose::from_parts(position, down);
            let q = robot.inverse(&pose, &reference).expect("reachable");
            assert!(robot.is_feasible(&q), "{q}");
            let motors = robot.transmission().motors(&q);
            for i in 0..6 {
                let gap = (q[i] - robot.limits().lower[i]).min(robot.limits().upper[i] - q[i]);
                assert!(gap > margin, "joint {i} at {position}: {gap}");
                let gap = (motors[i] - Irp6::MOTOR_LOWER[i]).min(Irp6::MOTOR_UPPER[i] - motors[i]);
                assert!(gap > 34.0, "motor {i} at {position}: {gap}");
            }
            assert!(Irp6::wrist_singularity_distance(&q) > 1.3);
        }
    }
}

/// The hard limit of a motor's speed bounds the speed of the joint that it moves alone.
#[test]
fn no_joint_moving_alone_overspeeds_a_motor() {
    let mut random = Random::seeded(SEED);
    for robot in [Irp6::nominal(), Irp6::calibrated()] {
        for _ in 0..10_000 {
            let q = feasible(&mut random, &robot);
            for i in 0..6 {
                let mut step = Six::zeros();
                step[i] = 1e-4 * robot.limits().velocity[i];
                let speeds =
                    (robot.transmission().motors(&(q + step)) - robot.transmission().motors(&q)) / 1e-4;
                assert!(speeds.amax() <= Irp6::MOTOR_SPEED, "seed {SEED}, joint {i}: {speeds}");
            }
        }
    }
}

#[test]
fn the_posture_to_begin_with_has_the_tool_down_and_is_far_from_limits_and_singularities() {
    // From the geometry: the lower arm upright (a2 = 0.455 m), the upper one (0.67 m) 0.16 rad below level, then d5 = 0.19 m.
    let arm = Irp6::nominal();
    let flange = arm.forward(&Irp6::READY);
    let expected = Vector3::new(0.67 * 0.16_f64.cos() + 0.19, 0.0, 0.455 - 0.67 * 0.16_f64.sin());
    assert!((flange.translation.vector - expected).norm() < 2e-3, "{}", flange.translation);
    for arm in models() {
        assert!(arm.is_feasible(&Irp6::READY));
        let limits = arm.limits();
        let margins = (Irp6::READY - limits.lower).inf(&(limits.upper - Irp6::READY));
        assert!(margins.min() > 0.5, "{margins}");
    }
    let down = (flange.rotation * Vector3::z()).angle(&-Vector3::z());
    assert!(down < 3e-3, "{down} rad");
    assert!(Irp6::wrist_singularity_distance(&Irp6::READY) > FRAC_PI_2 - 3e-3);
    // Lengths in units of the reach, so that rows are comparable.
    let mut jacobian = arm.jacobian(&Irp6::READY);
    jacobian.rows_mut(0, 3).scale_mut(1.0 / arm.reach());
    let values = jacobian.singular_values();
    assert!(values.max() / values.min() < 10.0, "{values}");
}
