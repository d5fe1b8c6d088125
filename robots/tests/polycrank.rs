//! What Polycrank's redundancy and its endless joints do.

use mrroc::prelude::*;
use mrroc::robot::NoInverse;
use mrroc_robots::{Kinematics, Polycrank, Seven};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

fn bent() -> Seven {
    Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2])
}

fn error_between(x: &Pose, y: &Pose) -> f64 {
    let rotation =
        x.rotation.to_rotation_matrix().into_inner() - y.rotation.to_rotation_matrix().into_inner();
    rotation.amax().max((x.translation.vector - y.translation.vector).amax())
}

/// Follows poses from `start`; returns the largest joint step, the largest change of a step, and the last joints.
fn follow(start: &Seven, poses: impl Iterator<Item = Pose>) -> (f64, f64, Seven) {
    let robot = Polycrank::new();
    let (mut near, mut before) = (*start, None);
    let (mut step, mut bend) = (0.0_f64, 0.0_f64);
    for pose in poses {
        let q = robot.inverse(&pose, &near).expect("within reach");
        assert!(error_between(&robot.forward(&q), &pose) < 1e-9);
        let moved = q - near;
        step = step.max(moved.amax());
        if let Some(before) = before {
            bend = bend.max((moved - before as Seven).amax());
        }
        (near, before) = (q, Some(moved));
    }
    (step, bend, near)
}

/// Facts: p = (0.183, -0.296, 1.589), R = diag(1, -1, -1) at q = 0 (GraspIt!'s rows multiplied by hand).
#[test]
fn the_zero_position_is_that_of_the_published_model() {
    let pose = Polycrank::new().forward(&Seven::zeros());
    assert!((pose.translation.vector - Vector3::new(0.183, -0.296, 1.589)).amax() < 1e-15);
    let expected = nalgebra::Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
    assert!((pose.rotation.to_rotation_matrix().into_inner() - expected).amax() < 1e-15);
}

#[test]
fn a_straight_line_is_continuous_and_its_joint_steps_shrink_with_the_line_s() {
    let start = Polycrank::new().forward(&bent());
    let along = Vector3::new(0.15, -0.25, 0.05);
    let line = |steps: u32| {
        follow(
            &bent(),
            (1..=steps).map(move |i| {
                let s = f64::from(i) / f64::from(steps);
                Pose::from_parts(Translation3::from(start.translation.vector + along * s), start.rotation)
            }),
        )
    };
    let ((coarse, _, end), (fine, bend, fine_end)) = (line(500), line(5000));
    println!("largest step {coarse:.2e}, ten times finer {fine:.2e}, its largest change {bend:.1e} rad");
    assert!(fine < 0.12 * coarse, "{fine} {coarse}");
    assert!(bend < 0.02 * fine, "{bend} {fine}: the speeds are continuous, too");
    assert!((end - fine_end).amax() < 1e-2, "{end}{fine_end}: the path hardly depends on the step");
}

/// With its stretch of 0.128 m the arm with level axes would be straight after 5 cm (v from 0.223 to 0.273 m): the stretch
/// yields before, and the speeds stay continuous while it begins to.
#[test]
fn a_line_that_the_kept_stretch_does_not_reach_goes_on_with_another() {
    let start = Polycrank::new().forward(&bent());
    let line = |steps: u32| {
        follow(
            &bent(),
            (1..=steps).map(move |i| {
                let up = Vector3::new(0.0, 0.0, 0.065 * f64::from(i) / f64::from(steps));
                Pose::from_parts(Translation3::from(start.translation.vector + up), start.rotation)
            }),
        )
    };
    let ((coarse, _, _), (fine, bend, end)) = (line(300), line(3000));
    println!("largest step {coarse:.2e}, ten times finer {fine:.2e}, its largest change {bend:.1e} rad");
    assert!(Polycrank::stretch(&end) < 0.105, "the arm reaches 0.302 m: {}", Polycrank::stretch(&end));
    assert!(fine < 0.12 * coarse, "{fine} {coarse}");
    assert!(bend < 0.03 * fine, "{bend} {fine}: the speeds are continuous, too");
}

/// Where the published range of 3600 deg would not matter: ten turns of the tool about the vertical.
#[test]
fn turning_the_pose_unwraps_the_joints() {
    let start = Polycrank::new().forward(&bent());
    let turns = 9.0 * std::f64::consts::TAU;
    let (step, _, end) = follow(
        &bent(),
        (1..=9000).map(|i| {
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turns * f64::from(i) / 9000.0) * start
        }),
    );
    println!("largest step {step:.2e} rad, at the end\n{end}");
    assert!((end[0] + end[1] + end[2] - bent()[0] - bent()[1] - bent()[2] - turns).abs() < 1e-9);
    assert!(step < 0.02, "{step}");
}

#[test]
fn a_line_through_the_vertical_tool_does_not_jump() {
    let mut middle = bent();
    middle[5] = -middle[3] - middle[4];
    let robot = Polycrank::new();
    let at = |s: f64| {
        let mut q = middle;
        q[5] += 0.3 * s;
        let pose = robot.forward(&q);
        Pose::from_parts(
            Translation3::from(pose.translation.vector + Vector3::new(0.02, 0.01, 0.0) * s),
            pose.rotation,
        )
    };
    let mut near = robot.inverse(&at(-1.0), &middle).expect("within reach");
    for i in -999..=1000 {
        let pose = at(f64::from(i) / 1000.0);
        let q = robot.inverse(&pose, &near).expect("within reach");
        assert!((q - near).amax() < 1e-3, "{i}: {}", q - near);
        assert!(error_between(&robot.forward(&q), &pose) < 1e-9);
        near = q;
    }
}

#[test]
fn the_stretch_can_be_given_and_what_cannot_be_reached_is_refused() {
    let robot = Polycrank::new();
    let pose = robot.forward(&bent());
    let stretch = Polycrank::stretch(&bent());
    let found = robot.inverse_at(&pose, stretch, &bent()).expect("its own stretch");
    assert!((found - bent()).amax() < 1e-9);
    let other = robot.inverse_at(&pose, stretch - 0.02, &bent()).expect("a little less");
    assert!((Polycrank::stretch(&other) - stretch + 0.02).abs() < 1e-12);
    assert!(error_between(&robot.forward(&other), &pose) < 1e-12);
    let mut far = pose;
    far.translation.vector.z += 0.4;
    assert!(matches!(robot.inverse(&far, &bent()), Err(NoInverse::OutOfReach { .. })));
    far.translation.vector.x = 3.0;
    assert!(matches!(robot.inverse(&far, &bent()), Err(NoInverse::OutOfReach { .. })));
    assert!(robot.singularity_distance(&bent()) > 0.05);
}
