//! Straight lines through the axis of the column: a robot either goes on without a jump or says why it stops.

mod support;

use mrroc::{Pose, Robot};
use mrroc_robots::{Five, Irp6, Irp6FiveDof, Irp6Track, Kinematics, Polycrank, Rnt, Seven};
use nalgebra::{SVector, Translation3, Vector3};
use support::engraving;

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
