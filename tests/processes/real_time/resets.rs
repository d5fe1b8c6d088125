//! A cell that awaits its reset while one of its processes does not answer.

use mrroc_tests::fixture::SUSPENDED;
use rustix::process::Signal;

use crate::launch::{Place, wait_until};
use crate::operator::{ask, done};
use crate::runs::REAL;
use crate::sound::assert_sound;

#[test]
fn what_forbids_a_reset_is_told_by_status_by_the_refusal_and_by_the_launcher_as_long_as_it_does() {
    let place = Place::new(45);
    let cell = place.base().parent().expect("a folder").join("cell.toml");
    let text = format!("after_fault = \"await reset\"\n{}", include_str!("../cell.toml"));
    std::fs::write(cell, text).expect("written");
    let status = || ask(&place, &["status"]).1;
    // It is suspended at once, so that it is there as long as nobody stops it.
    let mut launch = place.start_with(&[(SUSPENDED, "1")], "operated", REAL);
    wait_until(|| ask(&place, &["stop"]).0 == Some(0) || status().starts_with("latched: "));
    wait_until(|| status().starts_with("latched: "));
    // The operator's stop, or that of a machine that was late before.
    let stopped = status().lines().find(|line| line.starts_with("last fault: ")).expect("a fault").to_owned();
    // A person at the launcher's terminal is told what has stopped, that it waits, and what to do: the launcher looks ten times a second.
    for words in ["the cell has stopped", "`acknowledge`, then `reset`", "`abort`"] {
        wait_until(|| launch.said().contains(words));
    }
    // A process that does not answer.
    let ecp = launch.processes().into_iter().find(|process| process.role == "ecp left").expect("it runs");
    ecp.signal(Signal::STOP);
    let gone = "ecp left: the process at the other end is gone";
    wait_until(|| status().contains(&format!("a reset failed or would be refused: {gone}")));
    // The first cause stays.
    assert!(status().contains(&stopped), "{}", status());
    done(&place, &["acknowledge"], "acknowledged: step ");
    wait_until(|| launch.said().contains("a reset would be refused: ecp left"));
    let (code, said) = ask(&place, &["reset"]);
    let told = format!("refused: the cause of the fault persists: {gone}");
    assert!(code == Some(1) && said.contains(&told), "{said}");
    ecp.signal(Signal::CONT);
    wait_until(|| !status().contains("a reset failed"));
    done(&place, &["abort"], "aborting: step ");
    let code = launch.end().code();
    let said = launch.said();
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("note: a reset would be refused: ecp left"), "{said}");
    assert_eq!(said.matches("the cell has stopped").count(), 1, "{said}");
    assert_sound(&launch, code, None, |kind, _| kind == "ProtectiveStop" || kind == "Aborted");
    launch.assert_nothing_left(&[]);
}
