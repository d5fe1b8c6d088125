//! Sensors that fail in every manner, in all three modes, with and without bounds on what they may read.

use core::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::sensor::{Plausible, VspMode};
use mrroc::testing::{FaultySensor, SensorFault, Sweep, SweepReport};

use crate::safety::cells::{At, Path, following};

const FAULTS: [(&str, SensorFault<At>); 9] = [
    ("ok", SensorFault::Ok),
    ("off", SensorFault::Off),
    ("stuck", SensorFault::Stuck),
    ("garbage", SensorFault::Garbage),
    ("wrong by 5 mm", SensorFault::Wrong(|at| At { x: at.x + 5e-3 })),
    ("wrong by 1 µm", SensorFault::Wrong(|at| At { x: at.x + 1e-6 })),
    ("slow", SensorFault::Slow(7)),
    ("delayed", SensorFault::Delayed(5)),
    ("intermittent", SensorFault::Intermittent),
];

pub const MODES: [VspMode; 3] =
    [VspMode::Interactive, VspMode::WithDelay, VspMode::NonInteractive(Duration::from_millis(1))];

/// The path is between 0 and 0.02 m at no more than 0.25 m/s.
fn plausible(sensor: FaultySensor<Path>) -> Plausible<FaultySensor<Path>, 1> {
    Plausible::new(sensor, |at| [at.x]).range([-1e-3], [0.021]).rate([2.6e-4])
}

/// One fault of a sensor after the other, in every `every`-th step; a fault that lasts.
pub fn failing(mode: VspMode, bounded: bool, every: u64) -> SweepReport {
    // Where it ends depends on what it read.
    let sweep = Sweep::new(move || following(Path, mode)).end_tolerance(1.0).every(every).threads(2);
    let sweep = FAULTS.into_iter().fold(sweep, |sweep, (name, fault)| {
        sweep.own(name, move |at| {
            let sensor = FaultySensor::new(Path, fault, at, 10_000);
            if bounded { following(plausible(sensor), mode) } else { following(sensor, mode) }
        })
    });
    sweep.run()
}

#[test]
fn fault_25_a_sensor_that_fails_in_any_way_moves_nothing_beyond_a_limit() {
    for mode in MODES {
        for bounded in [false, true] {
            let report = failing(mode, bounded, 13);
            assert!(report.is_clean(), "{mode:?} {report}");
            let row =
                |name: &str| report.rows().iter().find(|(row, _)| row == name).expect("a row").1.clone();
            // Runs survive with a sensor that works, and with one whose error is too small to be noticed.
            assert_eq!(row("ok").survived, row("ok").cases, "{report}");
            assert_eq!(row("off").stopped, row("off").cases, "{report}");
        }
    }
}

#[test]
fn fault_25_a_reading_out_of_its_bounds_is_named_and_never_moved_by() {
    let fault = |sensor: Plausible<FaultySensor<Path>, 1>| match following(sensor, VspMode::Interactive).run()
    {
        Err(CellError::Fault(fault)) => fault,
        other => panic!("{other:?}"),
    };
    let sensor = |fault| FaultySensor::new(Path, fault, 60, 100);
    for (wrong, says) in [
        (SensorFault::Wrong(|_| At { x: f64::NAN }), "is not finite"),
        (SensorFault::Wrong(|_| At { x: f64::INFINITY }), "is not finite"),
        (SensorFault::Wrong(|at| At { x: at.x + 1.0 }), "is above its range"),
        (SensorFault::Wrong(|at| At { x: at.x - 1.0 }), "is below its range"),
        (SensorFault::Wrong(|at| At { x: at.x + 3e-4 }), "jumps"),
    ] {
        let met = fault(plausible(sensor(wrong)));
        assert_eq!((met.kind(), met.step()), (FaultKind::SensorFailed, Some(60)), "{met}");
        assert!(met.to_string().starts_with("vsp place") && met.to_string().contains(says), "{met}");
    }
    // It has been the same since step 59; five steps are allowed.
    let stuck = fault(Plausible::new(sensor(SensorFault::Stuck), |at| [at.x]).stuck_after(5));
    // Before step 10 the path does not move either: the sensor may be the same for long there.
    assert!(stuck.to_string().contains("stuck"), "{stuck}");
}

#[test]
fn fault_04_a_sensor_that_says_nothing_more_stops_the_motion_that_reads_it() {
    for mode in MODES {
        let report =
            Sweep::new(move || following(Path, mode)).kills().end_tolerance(1.0).every(3).threads(2).run();
        let vsp = &report.rows().iter().find(|(row, _)| row == "kill vsp").expect("a row").1;
        // The motion reads it for 180 steps: all but the last ones need its answer.
        assert!(report.is_clean() && vsp.cases > 50 && vsp.stopped >= 50, "{mode:?} {report}");
    }
}

#[test]
fn fault_04_a_motion_that_does_not_read_a_dead_sensor_goes_on() {
    let cell = || -> Cell {
        let setup = mrroc::cell::SensorSetup::new("place", Path);
        crate::safety::cells::transparent().sensor(setup)
    };
    let report = Sweep::new(cell).kills().every(7).threads(2).run();
    let vsp = &report.rows().iter().find(|(row, _)| row == "kill vsp").expect("a row").1;
    assert!(report.is_clean(), "{report}");
    assert_eq!(vsp.stopped, 0, "{report}");
}
