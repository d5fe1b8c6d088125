//! No step allocates because it is recorded: counted for the thread of the cell alone, not for the recorder's.

use std::cell::Cell;
use std::path::Path;
use std::rc::Rc;

use mrroc_counting_allocator::allocations;

use crate::recording::cell::{Change, arms};

#[test]
fn a_recorded_step_allocates_nothing() {
    let counts = Rc::new(Cell::new((0, 0)));
    let seen = Rc::clone(&counts);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("allocation.mcap");
    // Within one Move: what begins and ends instructions is the programs' own.
    let cell = arms(Change::Nothing).on_step(move |step, _| match step {
        20 => seen.set((allocations(), 0)),
        420 => seen.set((seen.get().0, allocations())),
        _ => {}
    });
    cell.record(mrroc::recording::to(file)).run().expect("keeps the limits");
    let (warm, end) = counts.get();
    assert!(warm > 0, "nothing was counted");
    assert_eq!(end - warm, 0, "allocations in 400 steps");
}
