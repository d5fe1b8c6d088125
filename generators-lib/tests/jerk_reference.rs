//! Jerk-limited plans against Ruckig's durations.

mod common;

use common::rows;
use mrroc_generators::jerk::*;
use nalgebra::SVector;

struct Case {
    kind: String,
    axes: Vec<(AxisState, AxisTarget, AxisLimits)>,
    duration: f64,
}

fn cases() -> Vec<Case> {
    let axis = |x: &[f64]| {
        (
            AxisState { position: x[0], velocity: x[1], acceleration: x[2] },
            AxisTarget { position: x[3], velocity: x[4] },
            AxisLimits {
                max_velocity: x[5],
                min_velocity: x[6],
                max_acceleration: x[7],
                min_acceleration: x[8],
                jerk: x[9],
            },
        )
    };
    let case = |(label, numbers): (Vec<String>, Vec<f64>)| {
        let (duration, axes) = numbers.split_last().unwrap();
        Case { kind: label[0].clone(), axes: axes.chunks(10).map(axis).collect(), duration: *duration }
    };
    rows("ruckig.csv", 1).into_iter().map(case).collect()
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
    };
    SynchronisedMove::with_limits(&start, &target, |i| case.axes[i].2, None)
        .unwrap_or_else(|e| panic!("{e} {} {:?}", case.kind, case.axes))
}

#[test]
fn durations_equal_ruckigs() {
    for case in cases() {
        let duration = match case.axes.len() {
            1 => synchronised::<1>(&case).duration(),
            2 => synchronised::<2>(&case).duration(),
            3 => synchronised::<3>(&case).duration(),
            6 => synchronised::<6>(&case).duration(),
            other => panic!("{other} axes"),
        };
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
