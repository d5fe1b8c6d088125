//! A replay demands what was demanded, or tells where it does not.

use mrroc::recording::{CutOff, Replay};

use crate::recording::cell::{Change, arms};
use crate::recording::recorded;

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
    // A billionth of the way of 2 mrad.
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

#[test]
fn a_program_that_ends_sooner_is_told() {
    let file = recorded("sooner.mcap");
    let compared = arms(Change::NoSwing).replay(&file, CutOff::Refused).expect("a recording of this cell");
    assert!(!compared.is_identical());
    assert!(compared.difference.is_some() || compared.longer.is_some(), "{compared:?}");
}
