//! Drives that fail: blocked or stiff joints, drives that trip, encoders with wrong values.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::testing::{DriveTrouble, FaultyDrive, Sweep};
use mrroc_tests::{ExactDrive, Gantry, MS, Q};

use crate::safety::cells::{back_and_forth, gantry};

/// Two gantries of which the first one's drive fails in a servo period; 1 mm of following error.
fn failing(trouble: DriveTrouble, at: u64) -> Cell {
    let drives = FaultyDrive::<Gantry, _>::new(ExactDrive::<3>::at_origin(), trouble, 0, at.max(1));
    let a = RobotSetup::new("a", Gantry::default(), drives).following_error(Q::<3>::repeat(1e-3));
    Cell::new(MS).robot(a).robot(gantry("b", MS)).program(back_and_forth)
}

#[test]
fn fault_26_a_drive_that_fails_in_any_way_in_any_step_stops_both_robots() {
    let sweep = Sweep::new(|| failing(DriveTrouble::Friction(1.0), 1));
    let report = sweep
        .own("blocked", |at| failing(DriveTrouble::Blocked, at))
        .own("stiff", |at| failing(DriveTrouble::Friction(0.05), at))
        .own("trips", |at| failing(DriveTrouble::Trip, at))
        .own("encoder gives no number", |at| failing(DriveTrouble::EncoderNan, at))
        .own("encoder is stuck", |at| failing(DriveTrouble::EncoderStuck, at))
        .every(3)
        .threads(2)
        .run();
    assert!(report.is_clean(), "{report}");
    for name in ["trips", "encoder gives no number"] {
        let row = &report.rows().iter().find(|(row, _)| row == name).expect("a row").1;
        assert_eq!(row.stopped, row.cases, "{report}");
    }
}

#[test]
fn fault_27_tools_that_drift_apart_are_no_farther_apart_than_the_free_arm_needs_to_stop() {
    // Limits of the gantry, its following error, the step; the twin's fastest is 15/8 of its mean velocity.
    let (a, tolerance, ts) = (10.0, 1e-3, 1e-3);
    let v: f64 = 1.875 * 0.02 / 0.12;
    let bound = tolerance + v * 2.0 * ts + v * v / (2.0 * a);
    for at in (1..240).step_by(3) {
        let worst = Rc::new(RefCell::new(0.0_f64));
        let positions = Rc::new(RefCell::new([0.0; 2]));
        let seen = Rc::clone(&worst);
        let cell = failing(DriveTrouble::Blocked, at).watch(move |robot| {
            let mut positions = positions.borrow_mut();
            positions[usize::from(robot.robot == "b")] = robot.measured[0];
            // Both have ended the servo period: mirrored, so that their sum is how far they are apart.
            if robot.robot == "b" {
                let mut seen = seen.borrow_mut();
                *seen = seen.max((positions[0] + positions[1]).abs());
            }
        });
        // A joint that is blocked within the tolerance of the motion's end causes no fault.
        match cell.run() {
            Err(CellError::Fault(fault)) => {
                assert_eq!(fault.kind(), FaultKind::FollowingError, "at {at}: {fault}")
            }
            other => assert!(other.is_ok() && *worst.borrow() <= tolerance, "at {at}: {other:?}"),
        }
        let worst = *worst.borrow();
        assert!(worst <= bound, "blocked at {at}: {worst} m apart, bound {bound} m");
    }
}
