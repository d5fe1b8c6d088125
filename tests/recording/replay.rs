//! A replay demands what was demanded, or tells where it does not.

use std::path::Path;
use std::time::Duration;

use mrroc::cell::AfterFault;
use mrroc::operator::Latch;
use mrroc::prelude::*;
use mrroc::recording::{self, CutOff, Replay};
use mrroc::sensor::VspMode;
use mrroc_tests::{MS, gantry};

use crate::recording::cell::{Change, arms};
use crate::recording::recorded;
use crate::runtime::kit::{Counter, Counting, Smooth, Watch};

#[test]
fn the_same_programs_demand_the_same_to_the_bit() {
    let file = recorded("same.mcap");
    let compared = arms(Change::Nothing).replay(&file, CutOff::Refused).expect("a recording of this cell");
    assert!(compared.is_identical(), "{compared:?}");
    // The MP's first step is 1; both robots are compared in each.
    assert!(compared.steps > 1500 && compared.images >= 2 * compared.steps, "{compared:?}");
    assert_eq!(compared.end, Some(None));
}

#[test]
fn a_recording_changes_nothing_in_a_run() {
    let file = recorded("unchanged.mcap");
    let bare = arms(Change::Nothing).run().expect("keeps the limits");
    let recorded = arms(Change::Nothing).record(mrroc::recording::to(file)).run().expect("keeps the limits");
    assert_eq!(bare, recorded);
}

#[test]
fn a_changed_program_is_found_in_the_step_and_joint_where_it_differs() {
    let file = recorded("changed.mcap");
    let compared =
        arms(Change::Swing(0.25)).replay(&file, CutOff::Refused).expect("a recording of this cell");
    let found = compared.difference.expect("the swing is another one");
    assert_eq!((found.robot.as_str(), found.joint), ("right", 0));
    assert!(!compared.is_identical());
    // A billionth of the displacement of 2 mrad.
    let by = (found.replayed - found.recorded).abs();
    assert!(by > 0.0 && by < 3e-12, "{found}");
    // A later change is found so much later.
    let later = arms(Change::Swing(0.35)).replay(&file, CutOff::Refused).expect("a recording of this cell");
    let later = later.difference.expect("the swing is another one");
    assert_eq!(later.step - found.step, 50, "0.1 s of full speed in steps of 2 ms");
}

#[test]
fn a_protective_stop_of_the_operator_is_made_again_on_the_path() {
    const AT: u64 = 900;
    let file = recorded("stopped.mcap");
    let stopped = arms(Change::Nothing).on_step(|step, operator| {
        if step == AT {
            operator.protective_stop();
        }
    });
    stopped.record(mrroc::recording::to(&file)).run().expect_err("it is stopped");
    // Nobody stops it now but the recording.
    let again = arms(Change::Nothing).on_step(|_, _| {}).replay(&file, CutOff::Refused);
    let compared = again.expect("a recording of this cell");
    assert!(compared.is_identical() && compared.outside.is_none(), "{compared:?}");
    // The arms moved: their rate took steps to fall, which are compared, too.
    assert!(compared.steps > AT + 10, "{compared:?}");
    let end = compared.end.flatten().expect("it ended with the stop");
    assert!(end.contains("protective stop"), "{end}");
}

/// Drives with brakes are off after a stop, and begin at what encoders read; recorded drives have no power to lose.
#[test]
fn a_stop_and_a_reset_begin_again_where_they_did() {
    let file = recorded("reset.mcap");
    let cell = |stops: bool| {
        let mut times = 0;
        arms(Change::Nothing).after_fault(AfterFault::AwaitReset).on_step(move |step, operator| {
            if stops && step == 900 {
                operator.protective_stop();
            }
            if stops && times == 0 && operator.latch() == Latch::Latched {
                operator.acknowledge().expect("latched");
                operator.reset().expect("acknowledged");
                times += 1;
            }
        })
    };
    cell(true).record(mrroc::recording::to(&file)).run().expect("it goes on");
    let compared = cell(false).replay(&file, CutOff::Refused).expect("a recording of this cell");
    assert!(compared.is_identical(), "{compared:?}");
    assert!(compared.steps > 2000, "{compared:?}");
}

#[test]
fn a_program_that_ends_sooner_is_told() {
    let file = recorded("sooner.mcap");
    let compared = arms(Change::NoSwing).replay(&file, CutOff::Refused).expect("a recording of this cell");
    assert!(!compared.is_identical());
    assert!(compared.difference.is_some() || compared.longer.is_some(), "{compared:?}");
}

/// A sensor with delay is read, left alone for 0.3 s, and read again: the reading from before the pause is not too old.
#[test]
fn a_sensor_that_was_left_alone_is_read_again_as_it_was() {
    let cell = |latency: Duration| {
        let (robot, _) = gantry("g");
        let robot = robot.program(|ecp| {
            let mut counter = ecp.sensor::<Counter>("counter")?;
            ecp.move_robot((&mut counter,), Watch { steps: 30, ..Watch::default() })?;
            ecp.move_robot((), Smooth::to(0.1, 0.3))?;
            ecp.move_robot((&mut counter,), Watch { steps: 30, ..Watch::default() }).map(drop)
        });
        let sensor = SensorSetup::new("counter", Counting::default()).of("g").mode(VspMode::WithDelay);
        Cell::new(MS).robot(robot).sensor(sensor.latency(latency))
    };
    // One that answers in time, and one whose first reading is too old: that is found again.
    for (micros, fault) in [(3500, None), (30_500, Some("too old"))] {
        let latency = Duration::from_micros(micros);
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("left-alone-{micros}.mcap"));
        let ran = cell(latency).record(recording::to(&file)).run();
        assert_eq!(ran.is_err(), fault.is_some(), "{ran:?}");
        let compared = cell(latency).replay(&file, CutOff::Refused).expect("a recording of this cell");
        assert!(compared.is_identical(), "{compared:?}");
        assert_eq!(compared.end.as_ref().map(Option::is_some), Some(fault.is_some()), "{compared:?}");
        if let Some(fault) = fault {
            assert!(compared.fault.is_some_and(|told| told.contains(fault)), "{micros}");
        }
    }
}
