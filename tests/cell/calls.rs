//! Counts what a process allocates between two of its steps, in the thread that does them.

use std::fs;
use std::path::{Path, PathBuf};

use mrroc::launch::own_option;
use mrroc_counting_allocator::allocations;
use mrroc_tests::fixture::{COUNTS, STEPS};

/// Steps after which a process is warm.
const WARM: u64 = 100;

/// Steps after those that are counted, in which whatever else is counted in the process has been counted too: then the count is written.
const LATER: u64 = 50;

/// Calls of a step function, an observer, a drive: one in each step.
pub struct Calls {
    path: Option<PathBuf>,
    calls: u64,
    before: usize,
    within: usize,
}

impl Calls {
    /// Whether they are counted in this process.
    pub fn are_counted() -> bool {
        own_option(COUNTS).is_some()
    }

    /// Of what has this name.
    pub fn of(name: &str) -> Calls {
        let path = own_option(COUNTS).map(|folder| Path::new(&folder).join(name));
        Calls { path, calls: 0, before: 0, within: 0 }
    }

    /// One call.
    pub fn note(&mut self) {
        self.calls += 1;
        let Some(path) = &self.path else { return };
        let allocations = allocations();
        if self.calls == WARM {
            self.before = allocations;
        } else if self.calls == WARM + STEPS {
            self.within = allocations - self.before;
        } else if self.calls == WARM + STEPS + LATER {
            fs::write(path, self.within.to_string()).expect("the folder can be written");
        }
    }
}
