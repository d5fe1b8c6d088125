//! Kinematics of an arm read from URDF allocate nothing, whatever they are asked.

mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use mrroc::Robot;
use mrroc_robots::{Kinematics, Serial};
use nalgebra::SVector;
use support::Random;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator, counting.
struct Counting;

// SAFETY: every call is handed on to the system's allocator unchanged; the counter is a thread-local without destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promise is the system's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is the system's.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocates_nothing<const N: usize>(arm: &str, base: &str, tip: &str) {
    let path = format!("{}/tests/reference/urdf/{arm}.urdf", env!("CARGO_MANIFEST_DIR"));
    let robot: Serial<N> = Serial::from_urdf_file(path, base, tip)
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
        .expect("the URDF is sound");
    let mut random = Random(1);
    let before = ALLOCATIONS.with(Cell::get);
    assert!(before > 0, "reading a file allocates, and that is counted");
    for _ in 0..100 {
        let limits = robot.limits();
        let q = SVector::<f64, N>::from_fn(|i, _| {
            random.between(limits.lower[i].max(-7.0), limits.upper[i].min(7.0))
        });
        let mut pose = robot.forward(&q);
        black_box(robot.jacobian(&q));
        black_box(robot.near_singularity(&q));
        robot.frames(&q, &mut |frame| _ = black_box(frame));
        for away in [0.0, 100.0, f64::NAN] {
            pose.translation.vector.x += away;
            black_box(robot.inverse(&pose, &q).is_ok());
            black_box(robot.solutions(&pose, &q, &mut |q| _ = black_box(q)).is_ok());
        }
    }
    assert_eq!(ALLOCATIONS.with(Cell::get), before, "{arm}");
}

#[test]
fn arms_of_every_kind_are_moved_without_allocation() {
    allocates_nothing::<6>("ortho_parallel", "base_link", "tool0");
    allocates_nothing::<6>("three_parallel", "base", "wrist_3");
    allocates_nothing::<7>("seven_axes", "world_foot", "flange");
    allocates_nothing::<4>("palletiser", "base", "tool");
}
