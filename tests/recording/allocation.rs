//! No step allocates because it is recorded: counted for the thread of the cell alone, not for the recorder's.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;
use std::rc::Rc;

use crate::cell::{Change, arms};

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // A thread that ends has no counter any more, and nobody who asks for it.
    let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_recorded_step_allocates_nothing() {
    let counts = Rc::new(Cell::new((0, 0)));
    let seen = Rc::clone(&counts);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("allocation.mcap");
    let now = || ALLOCATIONS.with(Cell::get);
    // Within one Move: what begins and ends instructions is the programs' own.
    let cell = arms(Change::Nothing).on_step(move |step, _| match step {
        20 => seen.set((now(), 0)),
        420 => seen.set((seen.get().0, now())),
        _ => {}
    });
    cell.record(mrroc::recording::to(file)).run().expect("keeps the limits");
    let (warm, end) = counts.get();
    assert!(warm > 0, "nothing was counted");
    assert_eq!(end - warm, 0, "allocations in 400 steps");
}
