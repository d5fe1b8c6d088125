//! A step function without an end.

use std::process::Command;
use std::time::Duration;

use mrroc::prelude::*;
use mrroc_tests::{Gantry, MS};

use crate::safety::cells::gantry;

struct Endless;

#[generator(ecp)]
fn endless(_c: &mut Endless) -> Step<Gantry> {
    loop {
        if std::hint::black_box(false) {
            return Step::Next(Demand::hold());
        }
    }
}

/// Started by the other test in a process of its own, because it ends its process.
#[test]
#[ignore = "never ends by itself"]
fn loops_for_ever() {
    let arm = gantry("stubborn", MS).program(|ecp| ecp.move_robot((), Endless).map(drop));
    let cell = Cell::new(MS).robot(gantry("other", MS)).robot(arm);
    cell.end_when_stuck(Duration::from_millis(200)).run().expect("it never returns");
}

#[test]
fn fault_09_an_endless_loop_in_a_generator_is_named_and_ended() {
    let mut again = Command::new(std::env::current_exe().expect("this test"));
    let output =
        again.args(["--exact", "safety::endless::loops_for_ever", "--ignored", "--nocapture"]).output();
    let output = output.expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("error: ecp stubborn has computed for 0.2 s") && said.contains(" help: "),
        "{said}"
    );
}
