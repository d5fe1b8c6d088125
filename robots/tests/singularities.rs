//! Straight lines through the axis of the column: a robot either goes on without a jump or says why it stops.

mod support;

use mrroc::{Pose, Robot};
use mrroc_robots::{Five, Irp6, Irp6FiveDof, Irp6Track, Kinematics, Polycrank, Rnt, Seven};
use nalgebra::{SVector, Translation3, UnitQuaternion, Vector3};
use support::{Random, engraving};

const SEED: u64 = 3;

/// Step of a line \[m\].
const STEP: f64 = 5e-4;

/// Walks from `start` along `way`; returns how far the robot went and why it stopped, if it did. Fails on a jump.
fn walk<const N: usize, R: Kinematics<N>>(
    robot: &R,
    start: SVector<f64, N>,
    way: Vector3<f64>,
) -> (f64, Option<String>) {
    let from = robot.forward(&start);
    let steps = (way.norm() / STEP) as u32;
    let mut near = start;
    for k in 1..=steps {
        let part = f64::from(k) / f64::from(steps);
        let pose = Pose::from_parts(Translation3::from(from.translation.vector + way * part), from.rotation);
        let gone = part * way.norm();
        let q = match robot.inverse(&pose, &near) {
            Ok(q) => q,
            Err(why) => return (gone, Some(why.to_string())),
        };
        let limits = robot.limits();
        for i in 0..N {
            if !(limits.lower[i]..=limits.upper[i]).contains(&q[i]) {
                return (gone, Some(format!("joint {i} at its limit")));
            }
        }
        if let Err(why) = robot.check_coupled(&near, &q, 1.0) {
            return (gone, Some(format!("{} of joint {}: {}", why.what, why.joint, why.actual)));
        }
        let step = (q - near).amax();
        assert!(step < 0.05, "{}: a jump of {step} rad after {gone} m", R::KIND);
        near = q;
    }
    (way.norm(), None)
}

#[test]
fn lines_through_the_axis_of_the_column_stop_with_a_reason_before_any_jump() {
    let arm = engraving();
    let over = Vector3::new(-1.6, 0.0, 0.0);
    let track = Seven::from_fn(|i, _| if i == 0 { 0.5 } else { arm[i - 1] });
    let rnt = Rnt::from_elevations(&SVector::<f64, 6>::new(0.0, 1.6, 0.0, 0.0, 1.5, 0.3)).expect("assembled");
    for (robot, (gone, why)) in [
        ("irp6", walk(&Irp6::nominal(), arm, over)),
        ("irp6-5dof", walk(&Irp6FiveDof::nominal(), Five::new(0.0, -1.6, 0.1, 0.6, 1.0), over)),
        ("irp6-track", walk(&Irp6Track::nominal(), track, over)),
        ("rnt", walk(&Rnt::new(), rnt, over)),
    ] {
        let why = why.expect("no arm goes through its own column");
        println!("{robot} stops after {gone:.3} m: {why}");
        assert!(gone < 1.5);
    }
}

/// The tool's heading, not the place of the flange, turns Polycrank's upright arm: it goes over its own column.
#[test]
fn polycrank_goes_over_its_column() {
    let start = Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]);
    let from = Polycrank::new().forward(&start).translation.vector;
    let over = Vector3::new(-2.0 * from.x, -2.0 * from.y, 0.0);
    assert_eq!(walk(&Polycrank::new(), start, over).1, None);
}

/// Lines of up to 0.4 m that turn by up to 0.5 rad, in 1000 steps, from random attainable joints. A step of the joints
/// above 0.3 rad is a jump, unless the robot names the singularity that it passes; the runtime's limits then refuse it.
fn no_jumps<const N: usize, R: Kinematics<N>>(
    robot: &R,
    lines: usize,
    lower: SVector<f64, N>,
    upper: SVector<f64, N>,
) {
    let mut random = Random(SEED);
    let (mut stopped, mut swings) = (0, 0);
    for _ in 0..lines {
        let start = loop {
            let q = SVector::<f64, N>::from_fn(|i, _| random.between(lower[i], upper[i]));
            if robot.is_attainable(&q) {
                break q;
            }
        };
        let from = robot.forward(&start);
        let mut draw = |size: f64| Vector3::from_fn(|_, _| random.between(-size, size));
        let (way, turn) = (draw(0.2), draw(0.3));
        let mut near = start;
        for k in 1..=1000 {
            let part = f64::from(k) / 1000.0;
            let rotation = UnitQuaternion::from_scaled_axis(turn * part) * from.rotation;
            let pose = Pose::from_parts(Translation3::from(from.translation.vector + way * part), rotation);
            // Its cause is told, or it is a limit's.
            let reached = robot.inverse(&pose, &near).ok().filter(|q| robot.is_attainable(q));
            let Some(q) = reached else {
                stopped += 1;
                break;
            };
            if (q - near).amax() > 0.3 {
                let named = robot.near_singularity(&near).or(robot.near_singularity(&q));
                assert!(named.is_some(), "{}, seed {SEED}: from {near} to {q}", R::KIND);
                swings += 1;
            }
            near = q;
        }
    }
    println!(
        "{}, seed {SEED}: {lines} lines, {stopped} stopped with a cause, {swings} swings at a named singularity",
        R::KIND
    );
    assert!(stopped < lines);
}

#[test]
fn random_lines_never_jump_without_a_name() {
    let six = *Irp6::nominal().limits();
    no_jumps(&Irp6::nominal(), 300, six.lower, six.upper);
    let track = *Irp6Track::nominal().limits();
    no_jumps(&Irp6Track::nominal(), 300, track.lower, track.upper);
    let rnt = *Rnt::new().limits();
    no_jumps(&Rnt::new(), 300, rnt.lower, rnt.upper);
    no_jumps(&Polycrank::new(), 500, Seven::repeat(-3.0), Seven::repeat(3.0));
}
