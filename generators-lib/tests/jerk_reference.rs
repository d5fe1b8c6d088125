//! Jerk-limited plans against Ruckig's durations.

use crate::usage::reference::rows;
use mrroc_generators::jerk::*;
use nalgebra::SVector;

struct Case {
    kind: String,
    axes: Vec<(AxisState, AxisTarget, AxisLimits)>,
    duration: f64,
}

/// Rows of a file whose axes have so many numbers each: with 10 of them, targets have no acceleration.
fn cases(file: &str, size: usize) -> Vec<Case> {
    let axis = |x: &[f64]| {
        let (to, rest) = x[3..].split_at(size - 8);
        (
            AxisState { position: x[0], velocity: x[1], acceleration: x[2] },
            AxisTarget { position: to[0], velocity: to[1], acceleration: to.get(2).copied().unwrap_or(0.0) },
            AxisLimits {
                max_velocity: rest[0],
                min_velocity: rest[1],
                max_acceleration: rest[2],
                min_acceleration: rest[3],
                jerk: rest[4],
            },
        )
    };
    let case = |(label, numbers): (Vec<String>, Vec<f64>)| {
        let (duration, axes) = numbers.split_last().unwrap();
        Case { kind: label[0].clone(), axes: axes.chunks(size).map(axis).collect(), duration: *duration }
    };
    rows(file, 1).into_iter().map(case).collect()
}

fn synchronised<const N: usize>(case: &Case) -> SynchronisedMove<SVector<f64, N>> {
    let start = JointState {
        position: SVector::from_fn(|i, _| case.axes[i].0.position),
        velocity: SVector::from_fn(|i, _| case.axes[i].0.velocity),
        acceleration: SVector::from_fn(|i, _| case.axes[i].0.acceleration),
    };
    let target = JointTarget {
        position: SVector::from_fn(|i, _| case.axes[i].1.position),
        velocity: SVector::from_fn(|i, _| case.axes[i].1.velocity),
        acceleration: SVector::from_fn(|i, _| case.axes[i].1.acceleration),
    };
    SynchronisedMove::with_limits(&start, &target, |i| case.axes[i].2, MoveDuration::default())
        .unwrap_or_else(|e| panic!("{e} {} {:?}", case.kind, case.axes))
}

fn duration(case: &Case) -> f64 {
    match case.axes.len() {
        1 => synchronised::<1>(case).duration(),
        2 => synchronised::<2>(case).duration(),
        3 => synchronised::<3>(case).duration(),
        6 => synchronised::<6>(case).duration(),
        other => panic!("{other} axes"),
    }
}

fn equal_durations(cases: &[Case]) {
    for case in cases {
        let duration = duration(case);
        let error = (duration - case.duration) / case.duration;
        assert!(
            error.abs() < 1e-8,
            "{}: {duration} instead of {}: {:?}",
            case.kind,
            case.duration,
            case.axes
        );
    }
}

#[test]
fn durations_equal_ruckigs() {
    equal_durations(&cases("ruckig.csv", 10));
}

#[test]
fn durations_to_moving_targets_and_from_starts_outside_the_limits_equal_ruckigs() {
    equal_durations(&cases("ruckig_states.csv", 11));
}
