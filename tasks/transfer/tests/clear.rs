//! The arms keep clear of each other and of the table.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::{CellError, FaultKind};
use mrroc_robots::clearance::DryRun;
use transfer::clear::{Around, EVERY, MARGINS, Margins, clearance, guard};
use transfer::{cell, file, mp, plant};

#[test]
fn a_dry_run_of_the_whole_program_finds_nothing_nearer_than_the_margins() {
    let file = file().expect("in order");
    for (around, margin) in [(Around::Nothing, MARGINS.arms), (Around::Table, MARGINS.table)] {
        let dry_run = Rc::new(RefCell::new(DryRun::new(clearance(&file, around).expect("in order"))));
        let watching = Rc::clone(&dry_run);
        let cell = cell(&file, &plant::drives()).expect("in order").program(mp::coordinate);
        cell.watch(move |robot| watching.borrow_mut().observe(robot)).run().expect("within all limits");
        let mut dry_run = dry_run.borrow_mut();
        let closest = dry_run.closest().expect("checked").expect("both arms were seen");
        let [a, b] = &closest.nearest.sides;
        println!("{a} and {b} are {:.3} m apart at {:.2} s", closest.nearest.distance, closest.time);
        assert!(closest.nearest.distance > margin, "{closest:?}");
    }
}

#[test]
fn arms_that_come_too_near_are_stopped_with_the_names_of_what_was_near() {
    let file = file().expect("in order");
    // They come to less than 0.1 m from the table, and to less than 0.4 m from each other.
    for (margins, near) in [
        (Margins { table: 0.1, ..MARGINS }, "wrist and table"),
        (Margins { arms: 0.4, ..MARGINS }, "rnt tool and polycrank tool"),
    ] {
        let wide = guard(&file, margins).expect("in order");
        let cell =
            cell(&file, &plant::drives()).expect("in order").program(mp::coordinate).guard(EVERY, wide);
        let Err(CellError::Fault(fault)) = cell.run() else { panic!("they come nearer than {margins:?}") };
        assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
        assert!(fault.to_string().contains(near), "{fault}");
    }
}
