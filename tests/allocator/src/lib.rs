//! The allocator of tests that promise how much memory is allocated.
//!
//! It passes everything on to the system's allocator and counts for each thread, so that tests of one executable can
//! run at the same time. A test executable installs it once, at its root:
//!
//! ```
//! use mrroc_counting_allocator::{Counting, count};
//!
//! #[global_allocator]
//! static ALLOCATOR: Counting = Counting;
//!
//! let (list, allocations) = count(|| vec![1, 2, 3]);
//! assert_eq!((list.len(), allocations), (3, 1));
//! ```
//!
//! Where a count spans calls that are not one closure, such as two calls of an observer, [`allocations`] and [`bytes`]
//! tell what this thread has counted so far. What another thread allocates is never counted for this one.
//!
//! Every function panics in an executable that has not installed the allocator, because all counts would be 0 there.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};

/// The system's allocator, which counts for each thread.
#[derive(Clone, Copy, Debug)]
pub struct Counting;

/// The counts of one thread.
#[derive(Clone, Copy)]
struct Counts {
    allocations: usize,
    bytes: usize,
    /// Bytes allocated and not freed; below 0 in a thread that frees what another one has allocated.
    held: isize,
    /// The most that `held` has been since [`peak`] was last called.
    most: isize,
}

thread_local! {
    static COUNTS: Cell<Counts> = const { Cell::new(Counts { allocations: 0, bytes: 0, held: 0, most: 0 }) };
}

/// Whether anything has been allocated by [`Counting`]: Rust allocates before `main`.
static INSTALLED: AtomicBool = AtomicBool::new(false);

impl Counts {
    fn take(&mut self, size: usize) {
        self.allocations += 1;
        self.bytes += size;
        self.held += size as isize;
        self.most = self.most.max(self.held);
    }

    fn give_back(&mut self, size: usize) {
        self.held -= size as isize;
    }
}

fn change(how: impl FnOnce(&mut Counts)) {
    INSTALLED.store(true, Ordering::Relaxed);
    // A thread that is ending may have no counts any more, and nobody asks for them.
    let _ = COUNTS.try_with(|counts| {
        let mut changed = counts.get();
        how(&mut changed);
        counts.set(changed);
    });
}

// SAFETY: every call goes to the system's allocator unchanged. The counts are a thread-local without a destructor, and
// are changed without allocating.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        change(|counts| counts.take(layout.size()));
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        change(|counts| counts.take(layout.size()));
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        change(|counts| counts.give_back(layout.size()));
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // The new memory is counted first: both may be held at once.
        change(|counts| counts.take(size));
        // SAFETY: as above.
        let moved = unsafe { System.realloc(pointer, layout, size) };
        change(|counts| counts.give_back(layout.size()));
        moved
    }
}

fn counts() -> Counts {
    assert!(
        INSTALLED.load(Ordering::Relaxed),
        "nothing is counted: install `mrroc_counting_allocator::Counting` as the global allocator"
    );
    COUNTS.get()
}

/// Allocations and reallocations of this thread since it began.
///
/// # Panics
///
/// In an executable whose global allocator is not [`Counting`].
#[must_use]
pub fn allocations() -> usize {
    counts().allocations
}

/// Bytes that this thread has allocated since it began, whether they have been freed or not; a reallocation counts with
/// its whole new size.
///
/// # Panics
///
/// In an executable whose global allocator is not [`Counting`].
#[must_use]
pub fn bytes() -> usize {
    counts().bytes
}

/// What `run` returns, and the number of its allocations and reallocations in this thread.
///
/// # Panics
///
/// In an executable whose global allocator is not [`Counting`]; and where `run` does.
pub fn count<T>(run: impl FnOnce() -> T) -> (T, usize) {
    let before = allocations();
    let outcome = run();
    (outcome, allocations() - before)
}

/// What `run` returns, and the most memory that this thread held at once meanwhile, beyond what it held before
/// \[bytes\]. May be nested.
///
/// # Panics
///
/// In an executable whose global allocator is not [`Counting`]; and where `run` does.
pub fn peak<T>(run: impl FnOnce() -> T) -> (T, usize) {
    let before = counts();
    COUNTS.set(Counts { most: before.held, ..before });
    let outcome = run();
    let after = counts();
    COUNTS.set(Counts { most: after.most.max(before.most), ..after });
    (outcome, (after.most - before.held) as usize)
}
