//! Whole cells in real time, from their launch to their end.

use std::time::Duration;

use mrroc_tests::fixture::{COMPUTES, NOT_TOLD, OPENED, PLANS, REMOTE, STEPS, TAKES_NOTHING};
use rustix::process::Signal;

use crate::launch::{Place, demanded, has_moved, periods_at_rest, segments, wait_for_end, wait_until};
use crate::picture::WARNING;
use crate::runs::{MEMORY, REAL, ROBOTS, VIRTUAL};
use crate::sound::{Ended, assert_robots_stand, assert_sound, nothing, rests};

#[test]
fn a_cell_of_processes_ends_well_or_names_what_was_late_and_leaves_nothing() {
    let place = Place::new(1);
    let mut launch = place.start("real", REAL);
    let status = launch.end();
    let ended = assert_sound(&launch, status.code(), None, nothing);
    assert!(ended == Ended::Late || launch.said().is_empty(), "{}", launch.said());
    launch.assert_nothing_left(&[]);
    // The robots have been where they would have been, if they came so far.
    if ended == Ended::Well {
        let mut memory = place.start("memory", MEMORY);
        assert!(memory.end().success(), "{}", memory.said());
        for robot in ROBOTS {
            let last = |record: Vec<String>| record.last().map(|line| demanded(line).to_owned());
            assert_eq!(last(launch.record(robot)), last(memory.record(robot)), "{robot}");
        }
    }
    let outcome = launch.outcome();
    println!(
        "{ended:?}: {} steps left out, longest stall {} s",
        outcome["skipped"], outcome["longest_stall"]
    );
}

#[test]
fn fault_06_a_process_that_stood_still_for_longer_than_the_budget_moves_nothing_afterwards() {
    let place = Place::new(7);
    for role in ["mp", "ecp left"] {
        let mut launch = place.start("stopped", REAL);
        launch.comes_to(has_moved(100));
        let processes = launch.processes();
        let stopped = processes.iter().find(|process| process.role == role).cloned();
        stopped.iter().for_each(|process| process.signal(Signal::STOP));
        // Far more than the 22 ms after which its robots brake: they are seen to stand, or stood when their EDPs ended.
        let edps: Vec<_> = processes.iter().filter(|process| process.role.starts_with("edp")).collect();
        let stands = |robot| periods_at_rest(&launch.record(robot)) >= 200;
        wait_until(|| ROBOTS.into_iter().all(stands) || edps.iter().all(|edp| !edp.is_alive()));
        let stood = ROBOTS.map(|robot| launch.record(robot));
        launch.let_run(Duration::ZERO);
        stopped.iter().for_each(|process| process.signal(Signal::CONT));
        assert_eq!(launch.end().code(), Some(1), "{role}: {}", launch.said());
        for (robot, stood) in ROBOTS.into_iter().zip(stood) {
            let record = launch.record(robot);
            assert!(rests(&launch, robot), "{role}: {robot}");
            let Some(last) = stood.last() else { continue };
            let later = &record[stood.len()..];
            assert!(later.iter().all(|line| demanded(line) == demanded(last)), "{role}: {robot}");
        }
        assert_sound(&launch, Some(1), None, nothing);
        launch.assert_nothing_left(&processes);
    }
}

#[test]
fn fault_30_what_crashed_launches_left_is_removed_and_does_no_harm() {
    let place = Place::new(5);
    // Killed as soon as its robots move.
    let mut crashed = place.start("crashed", REAL);
    crashed.comes_to(has_moved(20));
    let processes = crashed.processes();
    crashed.signal(Signal::KILL);
    crashed.end();
    // Without their launcher all processes end, and the robots stand.
    wait_for_end(&processes);
    assert_robots_stand(&crashed, None);
    let left = place.sessions();
    // It had nothing else; all of it, unless it was over before.
    assert!(left.is_subset(crashed.had()) && (processes.is_empty() || &left == crashed.had()), "{left:?}");
    let left_segments: usize = left.iter().map(|session| segments(session).len()).sum();
    // A hundred more, in all stages of a start, and files that belong to others.
    for number in 0_u64..100 {
        let session = place.base().join(format!("0123abcd-{number:012x}"));
        std::fs::create_dir(&session).expect("a folder");
        if number % 2 == 0 {
            std::fs::write(session.join("lock"), "").expect("a file");
            std::fs::write(format!("/dev/shm/mrroc_{number:012x}_x.data"), "").expect("a segment");
        }
    }
    let foreign = place.base().join("notes-of-mine");
    std::fs::write(&foreign, "").expect("a file");
    let mut next = place.start("next", VIRTUAL);
    assert!(next.end().success(), "{}", next.said());
    let mut memory = place.start("memory", MEMORY);
    assert!(memory.end().success());
    assert!(ROBOTS.iter().all(|robot| memory.record(robot) == next.record(robot)));
    assert_eq!(place.sessions().into_iter().collect::<Vec<_>>(), ["notes-of-mine"]);
    for session in left.iter().cloned().chain((0..100).map(|number| format!("0123abcd-{number:012x}"))) {
        assert_eq!(segments(&session), Vec::<String>::new());
    }
    println!("a crashed launch left {left_segments} segments; the next one removed them, and 100 sessions");
}

#[test]
fn a_step_of_a_process_in_any_role_allocates_nothing() {
    let place = Place::new(8);
    let roles = ["mp", "ecp", "edp left", "edp right", "plant left", "plant right", "vsp count", "vsp free"];
    for (counts, arguments) in [("virtual", VIRTUAL), ("real", REAL)] {
        let mut launch = place.count(counts, arguments);
        let status = launch.end().code();
        let is_real = arguments == REAL;
        assert!(status == Some(0) || is_real && status == Some(1), "{}", launch.said());
        let mut counted = 0;
        for role in roles {
            let text = launch.text(role);
            // A cell that was too late for its machine has not come so far.
            assert!(!text.is_empty() || status == Some(1), "{role} of {counts} has not been counted");
            assert!(text.is_empty() || text == "0", "{role} of {counts}: {text} allocations");
            counted += usize::from(!text.is_empty());
        }
        println!("{counts}: no allocations in {STEPS} steps of {counted} of {} roles", roles.len());
    }
}

#[test]
fn an_interrupt_aborts_and_ends_the_cell() {
    let place = Place::new(6);
    let mut launch = place.start("interrupted", REAL);
    launch.comes_to(has_moved(100));
    let processes = launch.processes();
    launch.signal(Signal::INT);
    let status = launch.end().code();
    assert_eq!(status, Some(1), "{}", launch.said());
    assert_sound(&launch, status, None, |kind, _| kind == "Aborted");
    launch.assert_nothing_left(&processes);
}

#[test]
fn fault_74_a_first_step_that_plans_for_too_long_is_told_to_plan_before_the_move() {
    let place = Place::new(37);
    let mut launch = place.start_with(&[(PLANS, "")], "plans", REAL);
    let status = launch.end().code();
    let said = launch.said();
    assert_eq!(status, Some(1), "half a second is beyond what a cell goes on without: {said}");
    assert_sound(&launch, status, None, nothing);
    // The first of it may be that the machine is late by as much before that step, which no plan is to blame for.
    if launch.outcome()["fault"]["kind"] == "PeerLost" {
        let told = "plan what takes longer before the Move, while the robots hold";
        assert!(said.contains("\n help: a process has ended, or ") && said.contains(told), "{said}");
    }
}

#[test]
fn an_interrupt_ends_a_cell_whose_program_computes_for_ever() {
    let place = Place::new(9);
    let mut launch = place.start_with(&[(COMPUTES, "")], "computes", REAL);
    // Its robots hold while the program computes.
    assert!(launch.comes_to(has_moved(1)), "{}", launch.said());
    let processes = launch.processes();
    launch.signal(Signal::INT);
    let status = launch.end().code();
    let said = launch.said();
    assert!(status == Some(1) && said.contains("did not end when the cell closed"), "{status:?}: {said}");
    launch.assert_nothing_left(&processes);
}

#[test]
fn fault_83_controllers_that_answer_late_and_break_off_when_told_nothing_begin_with_their_cell() {
    let robot = |name| format!("[robots.{name}]\nkind = \"remote\"\n");
    let camera = "[sensors.camera]\nmode = \"free running\"\nperiod_ms = 20\n";
    let cell = format!("step_ms = 2\nstop_ms = 2500\n{}{}{camera}", robot("soon"), robot("late"));
    let place = Place::of(94, REMOTE, &cell);
    let mut launch = place.start("real", REAL);
    let status = launch.end();
    let said = launch.said();
    assert!(!said.contains(NOT_TOLD), "{said}");
    assert_sound(&launch, status.code(), None, nothing);
    // One process alone has opened the camera, before the cell began: the first step read it.
    assert_eq!(launch.text(OPENED).lines().count(), 1, "{said}");
    launch.assert_nothing_left(&[]);
}

#[test]
fn a_picture_that_stands_still_stops_no_cell() {
    let place = Place::new(48);
    let mut launch = place.start_with(&[(TAKES_NOTHING, "")], "still", REAL);
    let status = launch.end().code();
    let ended = assert_sound(&launch, status, None, nothing);
    assert!(ended == Ended::Late || launch.said().contains(WARNING), "{}", launch.said());
    launch.assert_nothing_left(&[]);
}
