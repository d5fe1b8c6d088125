//! A step function that calls itself without an end.

use core::time::Duration;
use std::os::unix::process::ExitStatusExt;
use std::process::Command;

use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, Measured};
use mrroc_tests::{Gantry, MS, Q};

use crate::safety::cells::gantry;

struct Recursive;

/// Uses up any stack, however it is optimised.
fn deeper(depth: u64) -> u64 {
    let here = std::hint::black_box([depth; 32]);
    if depth == u64::MAX { 0 } else { deeper(depth + 1) + here[7] }
}

#[generator(ecp)]
fn recursive(_c: &mut Recursive) -> Step<Gantry> {
    std::hint::black_box(deeper(0));
    Step::Next(Demand::hold())
}

struct Holding;

#[generator(ecp)]
fn holding(_c: &mut Holding) -> Step<Gantry> {
    Step::Next(Demand::hold())
}

/// Drives that call themselves without an end in their first servo period, on the stack of whichever process waits then.
struct Bottomless;

impl Driver<Gantry> for Bottomless {
    fn period(&self) -> Duration {
        MS
    }

    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Ok(Measured { position: Q::zeros(), velocity: Q::zeros() })
    }

    fn tick(&mut self, _: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        std::hint::black_box(deeper(0));
        self.measured()
    }
}

fn run(overflows: bool) {
    let arm = gantry("deep", MS).program(move |ecp| {
        if overflows {
            return ecp.move_robot((), Recursive).map(drop);
        }
        write_where_nothing_is();
        Ok(())
    });
    let ran = Cell::new(MS).robot(gantry("other", MS)).robot(arm).run();
    ran.expect("it never returns");
}

/// No overflow, but as fatal.
fn write_where_nothing_is() {
    // SAFETY: none: the first pages are never mapped, and the write is to end this process.
    unsafe { std::hint::black_box(4096 as *mut u8).write_volatile(1) };
}

/// Started by the other tests in a process of its own, because it ends its process.
#[test]
#[ignore = "ends its process"]
fn overflows() {
    run(true);
}

/// As above.
#[test]
#[ignore = "ends its process"]
fn drives_overflow() {
    let arm = RobotSetup::new("deep", Gantry::default(), Bottomless);
    let arm = arm.program(|ecp| ecp.move_robot((), Holding).map(drop));
    let ran = Cell::new(MS).robot(gantry("other", MS)).robot(arm).run();
    ran.expect("it never returns");
}

/// As above.
#[test]
#[ignore = "ends its process"]
fn writes_where_nothing_is() {
    run(false);
}

/// How a test of this file ends its process, and what it says.
fn ended(test: &str) -> (Option<i32>, String) {
    let mut again = Command::new(std::env::current_exe().expect("this test"));
    let name = format!("safety::overflow::{test}");
    let output = again.args(["--exact", &name, "--ignored", "--nocapture"]).output().expect("it starts");
    (output.status.signal(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn fault_77_a_stack_overflow_on_the_memory_link_names_the_process() {
    let (signal, said) = ended("overflows");
    assert_eq!(signal, Some(11), "{said}");
    let told = "error: ecp deep has overflowed its stack of 1024 kB, and with it the cell has ended\n help: ";
    assert!(said.contains(told), "{said}");
    let (signal, said) = ended("drives_overflow");
    let told = "error: edp deep has overflowed its stack of 1024 kB, and with it the cell has ended\n help: ";
    assert!(signal == Some(11) && said.contains(told), "{signal:?} {said}");
    // Whatever else ends the executable by that signal ends it as before, and names nobody.
    let (signal, said) = ended("writes_where_nothing_is");
    assert!(signal == Some(11) && !said.contains("overflowed"), "{signal:?} {said}");
}
