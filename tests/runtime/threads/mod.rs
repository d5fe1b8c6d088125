//! Another scheduler than that of the memory link gives the same demands to the bit: one without coroutines, and without turns that are
//! taken on the stack of another process.

mod link;

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::prelude::*;
use mrroc::sensor::VspMode;
use mrroc_tests::{MS, Trace, gantry};

use crate::runtime::kit::{Counter, Counting, Smooth, Watch};
use link::Threads;

/// What a robot's program saw of its sensor: each count, with its age in steps.
type Seen = Rc<RefCell<Vec<Option<(u64, u32)>>>>;

/// Two robots by programs of their own, of which one watches a sensor of this mode and latency \[µs\] meanwhile; with an operator who suspends
/// the cell, resumes it and stops it, or without.
fn cell(mode: VspMode, latency: u64, operated: bool) -> (Cell, [Trace<3>; 2], Seen) {
    let ((one, first), (two, second)) = (gantry("one"), gantry("two"));
    let seen = Seen::default();
    let kept = Rc::clone(&seen);
    let one = one.program(move |ecp| {
        ecp.move_robot((), Smooth::to(0.25, 0.5))?;
        let mut counter = ecp.sensor::<Counter>("counter")?;
        let watched = ecp.move_robot((&mut counter,), Watch { steps: 40, ..Watch::default() })?;
        *kept.borrow_mut() = watched.seen;
        ecp.move_robot((), Smooth::to(-0.1, 0.7)).map(drop)
    });
    let two = two.program(|ecp| {
        ecp.move_robot((), Smooth::to(-0.3, 0.6))?;
        ecp.move_robot((), Smooth::to(0.0, 0.6)).map(drop)
    });
    let sensor = SensorSetup::new("counter", Counting::default()).of("one").mode(mode);
    let cell = Cell::new(MS).robot(one).robot(two).sensor(sensor.latency(Duration::from_micros(latency)));
    let cell = cell.on_step(move |step, operator| match (operated, step) {
        (true, 200) => operator.suspend(),
        (true, 400) => operator.resume(),
        (true, 900) => operator.protective_stop(),
        _ => {}
    });
    (cell, [first, second], seen)
}

fn bits(trace: &Trace<3>) -> Vec<u64> {
    trace.borrow().iter().flat_map(|demand| demand.iter().map(|q| q.to_bits()).collect::<Vec<_>>()).collect()
}

#[test]
fn processes_on_threads_of_their_own_demand_the_same_to_the_bit_as_on_the_memory_link() {
    let modes = [
        (VspMode::Interactive, 0),
        (VspMode::WithDelay, 3500),
        (VspMode::WithDelay, 0),
        (VspMode::NonInteractive(Duration::from_millis(3)), 0),
    ];
    for (mode, latency) in modes {
        for operated in [false, true] {
            let (on_memory, of_memory, seen) = cell(mode, latency, operated);
            let outcome = on_memory.run();
            let (on_threads, of_threads, seen_on_threads) = cell(mode, latency, operated);
            let mut threads = Threads::default();
            let assembly = on_threads.put_on(&mut threads).expect("nothing is wrong with the cell");
            let ended = threads.run();
            let stopped = assembly.outcomes.borrow().iter().any(|(_, outcome)| outcome.is_err());
            assert_eq!(stopped, operated && outcome.is_err(), "{mode:?}: {outcome:?}");
            if let Ok(report) = outcome {
                assert_eq!(u128::from(ended), report.time.as_nanos(), "{mode:?}");
            }
            for (memory, threads) in of_memory.iter().zip(&of_threads) {
                assert!(memory.borrow().len() > 900, "{mode:?}: {}", memory.borrow().len());
                assert_eq!(bits(memory), bits(threads), "{mode:?}, {operated}");
            }
            assert_eq!(*seen.borrow(), *seen_on_threads.borrow(), "{mode:?}, {operated}");
        }
    }
}
