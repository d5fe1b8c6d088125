//! A clearance check allocates nothing, not even when it fails.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use mrroc::{EffectorState, Name, Pose, RobotView};
use mrroc_robots::clearance::{Capsule, Clearance, Obstacle, Stopping};
use mrroc_robots::{Irp6Track, Polycrank, Rnt};
use nalgebra::Vector3;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator, counting this thread's allocations.
struct Counting;

// SAFETY: every call is passed on unchanged to the system's allocator, which keeps the contract.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn view(name: &str, joints: [f64; 8]) -> RobotView {
    let demanded = EffectorState { joints, velocity: [0.02; 8], pose: Pose::identity() };
    RobotView { name: Name::new(name).unwrap(), measured: demanded, demanded }
}

#[test]
fn checks_that_pass_and_checks_that_fail_allocate_nothing() {
    let rod = [Capsule::new(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.2), 0.02)];
    let build = |margin| {
        Clearance::with_margin(margin)
            .robot("rnt", Rnt::new())
            .unwrap()
            .robot("polycrank", Polycrank::new().with_base(Pose::translation(1.8, 0.0, 0.0)))
            .unwrap()
            .robot("irp6", Irp6Track::nominal().with_base(Pose::translation(-3.0, 0.0, 0.8)))
            .unwrap()
            .tool("rnt", &rod)
            .unwrap()
            .obstacle("floor", Obstacle::table(-0.3))
            .unwrap()
            .build(Stopping::of_guard(std::time::Duration::from_millis(2), 5))
            .unwrap()
    };
    let states = [
        view("rnt", [0.0, 0.5, 0.55, 0.0, 1.3, 0.0, 0.0, 0.0]),
        view("polycrank", [0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2, 0.0]),
        view("irp6", [0.5, 0.0, -1.57, 0.16, -0.16, 4.71, 0.0, 0.0]),
    ];
    for (margin, passes) in [(0.0, true), (5.0, false)] {
        let mut clearance = build(margin);
        let before = COUNT.with(Cell::get);
        for _ in 0..100 {
            let checked = clearance.check(&states);
            assert!(checked.is_ok() == passes, "{checked:?}");
            assert!(clearance.nearest(&states).is_ok());
        }
        assert_eq!(COUNT.with(Cell::get) - before, 0);
    }
}
