//! Straight lines through and past the singularities of the column and of the wrist: a robot either goes on without a jump
//! or says why it stops.

use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc_robots::{Five, Irp6, Irp6FiveDof, Irp6Track, Kinematics, Polycrank, Rnt, Serial, Seven, Six};
use nalgebra::{SVector, Translation3, UnitQuaternion, Vector3};

use crate::support::engraving;

const SEED: u64 = 3;

/// Step of a line \[m\].
const STEP: f64 = 5e-4;

/// Walks from `start` along `displacement`; returns how far the robot went and why it stopped, if it did. Fails on a jump.
fn walk<const N: usize, R: Kinematics<N>>(
    robot: &R,
    start: SVector<f64, N>,
    displacement: Vector3<f64>,
) -> (f64, Option<String>) {
    let from = robot.forward(&start);
    let steps = (displacement.norm() / STEP) as u32;
    let mut near = start;
    for k in 1..=steps {
        let part = f64::from(k) / f64::from(steps);
        let pose = Pose::from_parts(
            Translation3::from(from.translation.vector + displacement * part),
            from.rotation,
        );
        let gone = part * displacement.norm();
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
            return (gone, Some(format!("{} of joint {}: {}", why.what, why.joint, why.excess.actual)));
        }
        let step = (q - near).amax();
        assert!(step < 0.05, "{}: a jump of {step} rad after {gone} m from {near} to {q}", R::KIND);
        near = q;
    }
    (displacement.norm(), None)
}

/// An arm read from a URDF of the reference data.
fn serial<const N: usize>(text: &str, base: &str, tip: &str) -> Serial<N> {
    Serial::from_urdf(text, base, tip)
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
        .expect("the URDF is sound")
}

fn ortho_parallel() -> Serial<6> {
    serial(include_str!("reference/urdf/ortho_parallel.urdf"), "base_link", "tool0")
}

fn three_parallel() -> Serial<6> {
    serial(include_str!("reference/urdf/three_parallel.urdf"), "base", "wrist_3")
}

fn seven_axes() -> Serial<7> {
    serial(include_str!("reference/urdf/seven_axes.urdf"), "world_foot", "flange")
}

/// Follows a line through the pose at `singular`, where the flange turns about the axis of joint `turned`, from 0.3 rad
/// before it to 0.3 rad after it in twice `steps`, passing it by `beside` \[rad\]; returns the largest step of a joint \[rad\] and
/// why the robot stopped, if it did.
fn through<const N: usize, R: Kinematics<N>>(
    robot: &R,
    singular: SVector<f64, N>,
    turned: usize,
    beside: f64,
    steps: i32,
) -> (f64, Option<String>) {
    let mut turn = singular;
    turn[turned] += 0.3;
    let middle = robot.forward(&singular).rotation;
    // z_F, which the joint turns, is tilted towards the joint's axis.
    let axis = (robot.forward(&turn).rotation * middle.inverse()).scaled_axis().normalize();
    let tilt = UnitQuaternion::from_scaled_axis(beside * (middle * Vector3::z()).cross(&axis));
    let at = |s: f64| {
        let mut q = singular;
        q[turned] += 0.3 * s;
        let turn = robot.forward(&q).rotation;
        let p = robot.forward(&singular).translation.vector + Vector3::new(0.02, -0.01, 0.015) * s;
        Pose::from_parts(Translation3::from(p), tilt * turn)
    };
    let mut near = singular;
    near[turned] -= 0.3;
    near = robot.inverse(&at(-1.0), &near).expect("the line begins within reach");
    let mut largest = 0.0_f64;
    for i in 1 - steps..=steps {
        let pose = at(f64::from(i) / f64::from(steps));
        let q = match robot.inverse(&pose, &near) {
            Ok(q) => q,
            Err(why) => return (largest, Some(why.to_string())),
        };
        let off = robot.forward(&q).inverse() * pose;
        assert!(off.translation.vector.norm() + off.rotation.angle() < 1e-7, "{}: {off}", R::KIND);
        largest = largest.max((q - near).amax());
        near = q;
    }
    (largest, None)
}

/// Exactly through, the joints go on at the line's pace: 0.3 mrad and 27 um a step. 10 mrad past it the wrist has to swing
/// by up to half a turn, but never at once: steps a tenth as long on the line are a tenth as long in the joints.
#[test]
fn lines_through_and_past_the_wrist_s_singularity_do_not_flip_it() {
    fn check<const N: usize, R: Kinematics<N>>(
        name: &str,
        robot: &R,
        singular: SVector<f64, N>,
        joint: usize,
    ) {
        let (step, why) = through(robot, singular, joint, 0.0, 1000);
        println!("{name}: through, largest step {step:.1e} rad, stopped: {why:?}");
        assert!(step < 2e-3, "{name}: {step}");
        let (coarse, why) = through(robot, singular, joint, 0.01, 1000);
        let (fine, _) = through(robot, singular, joint, 0.01, 10_000);
        println!("{name}: past, largest step {coarse:.1e}, ten times finer {fine:.1e} rad, stopped: {why:?}");
        assert!(coarse < 0.3 && fine < 0.12 * coarse, "{name}: {coarse} {fine}");
    }
    let six = Six::new(0.2, -1.6, 0.1, 0.2, 0.0, 0.1);
    check("irp6", &Irp6::nominal(), six, 4);
    check(
        "irp6-track",
        &Irp6Track::nominal(),
        Seven::from_fn(|i, _| if i == 0 { 0.5 } else { six[i - 1] }),
        5,
    );
    check("rnt", &Rnt::new(), Six::new(0.2, 0.5, 0.55, 0.2, 0.0, 0.3), 4);
    check("polycrank", &Polycrank::new(), Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -1.6, 0.2]), 5);
    check("ortho-parallel", &ortho_parallel(), Six::new(0.2, 0.3, 0.1, 0.4, 0.0, 0.3), 4);
    check("three parallel axes", &three_parallel(), Six::new(0.2, -1.1, 1.3, 0.4, 0.0, 0.3), 4);
    check("seven axes", &seven_axes(), Seven::from([0.2, 0.4, 0.3, -1.2, 0.2, 0.0, 0.3]), 5);
}

/// With the wrist centre over axis 1 an arm goes on, its shoulder turned over.
#[test]
fn arms_read_from_urdf_cross_the_axis_of_their_column_or_say_why_not() {
    let over = Vector3::new(-0.4, 0.0, 0.0);
    for (name, (gone, why)) in [
        ("ortho-parallel", walk(&ortho_parallel(), Six::new(0.0, -1.0, 1.0, 0.0, 0.9, 0.0), over)),
        ("three parallel axes", walk(&three_parallel(), Six::new(0.0, -1.6, 1.2, 0.4, 1.2, 0.3), over)),
        ("seven axes", walk(&seven_axes(), Seven::from([0.0, 0.2, 0.0, -1.8, 0.0, 1.2, 0.3]), over)),
    ] {
        println!("{name}: {gone:.3} m, stopped: {why:?}");
        assert!(gone == over.norm() || why.is_some());
    }
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
    let mut random = Random::seeded(SEED);
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
        let (shift, turn) = (draw(0.2), draw(0.3));
        let mut near = start;
        for k in 1..=1000 {
            let part = f64::from(k) / 1000.0;
            let rotation = UnitQuaternion::from_scaled_axis(turn * part) * from.rotation;
            let pose = Pose::from_parts(Translation3::from(from.translation.vector + shift * part), rotation);
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
