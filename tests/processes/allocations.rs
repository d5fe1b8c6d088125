//! Counts what a process allocates between two of its steps, in the thread that does them.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};

/// The variable that names the folder of the counts.
pub const COUNTS: &str = "MRROC_TEST_COUNTS";

/// Steps after which a process is warm, and those in which it is counted.
const WARM: u64 = 100;
pub const STEPS: u64 = 300;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

fn count() {
    // A thread that ends has nothing to count with any more.
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

/// Calls of a step function, an observer, a drive: one in each step.
pub struct Calls {
    path: Option<PathBuf>,
    calls: u64,
    before: u64,
}

impl Calls {
    /// Whether they are counted in this process.
    pub fn are_counted() -> bool {
        std::env::var_os(COUNTS).is_some()
    }

    /// Of what has this name.
    pub fn of(name: &str) -> Calls {
        let path = std::env::var_os(COUNTS).map(|folder| Path::new(&folder).join(name));
        Calls { path, calls: 0, before: 0 }
    }

    /// One call. The last that is counted writes how much was allocated since the first.
    pub fn note(&mut self) {
        self.calls += 1;
        let Some(path) = &self.path else { return };
        let allocations = ALLOCATIONS.get();
        if self.calls == WARM {
            self.before = allocations;
        } else if self.calls == WARM + STEPS {
            fs::write(path, (allocations - self.before).to_string()).expect("the folder can be written");
        }
    }
}
