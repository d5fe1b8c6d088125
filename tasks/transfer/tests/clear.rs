//! The arms keep clear of each other and of the table.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::{CellError, FaultKind};
use mrroc_robots::clearance::DryRun;
use transfer::clear::{EVERY, MARGIN, clearance, guard};
use transfer::{cell, file, mp, plant};

#[test]
fn a_dry_run_of_the_whole_program_finds_nothing_nearer_than_the_margin() {
    let file = file().expect("in order");
    let dry_run = Rc::new(RefCell::new(DryRun::new(clearance(&file).expect("in order"))));
    let watching = Rc::clone(&dry_run);
    let cell = cell(&file, &plant::drives()).expect("in order").program(mp::coordinate);
    cell.watch(move |robot| watching.borrow_mut().observe(robot)).run().expect("within all limits");
    let mut dry_run = dry_run.borrow_mut();
    let closest = dry_run.closest().expect("checked").expect("both arms were seen");
    let [a, b] = &closest.nearest.sides;
    println!("{a} and {b} are {:.3} m apart at {:.2} s", closest.nearest.distance, closest.time);
    assert!(closest.nearest.distance > MARGIN, "{closest:?}");
}

#[test]
fn arms_that_come_too_near_are_stopped_with_the_names_of_what_was_near() {
    let file = file().expect("in order");
    // The wrists come to less than 0.1 m from the table.
    let wide = guard(clearance(&file).expect("in order"), 0.1);
    let cell = cell(&file, &plant::drives()).expect("in order").program(mp::coordinate).guard(EVERY, wide);
    let Err(CellError::Fault(fault)) = cell.run() else { panic!("they come nearer than that") };
    assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
    assert!(fault.to_string().contains("wrist and table"), "{fault}");
}
