//! A launcher that stands still, is stopped from its terminal, or cannot say anything.

use std::io::{ErrorKind, Write};
use std::os::fd::OwnedFd;
use std::os::unix::process::ExitStatusExt;
use std::time::Duration;

use rustix::process::Signal;

use mrroc_tests::fixture::{COMPUTES, TIMEOUT};

use crate::launch::{Launch, Place, Process, demanded, has_moved, wait_until};
use crate::operator::{ask, assert_ends_where_it_would_have};
use crate::runs::{REAL, ROBOTS};
use crate::sound::{Ended, assert_robots_stand, assert_sound, nothing, rests};

#[test]
fn fault_60_robots_whose_launcher_stands_still_stop_on_their_paths_and_consoles_are_told() {
    let place = Place::new(60);
    let mut launch = place.start("operated", REAL);
    let moved = launch.comes_to(has_moved(100));
    launch.signal(Signal::STOP);
    // A cell that its machine has ended by then leaves nobody to stop.
    let stopped = moved && launch.comes_to(|launch| launch.is_stopped());
    if stopped {
        let told = format!("its launcher, process {}, was stopped by a signal", launch.pid());
        let (status, said) = ask(&place, &["status"]);
        assert!(status == Some(1) && said.contains("has not answered for 5 s"), "{status:?}: {said}");
        assert!(said.contains(&told) && said.contains(&format!("kill -CONT {}", launch.pid())), "{said}");
        wait_until(|| ROBOTS.iter().all(|robot| rests(&launch, robot)));
        // 1750 periods make the whole run.
        assert!(launch.record("left").len() < 1750);
        launch.signal(Signal::CONT);
    }
    let status = launch.end().code();
    let unsupervised = |_: &str, text: &str| text.contains("protective stop: the launcher stands still");
    let ended = assert_sound(&launch, status, None, unsupervised);
    assert!(!stopped || ended != Ended::Well, "{}", launch.said());
    launch.assert_nothing_left(&[]);
    println!("stopped: {stopped}, {ended:?}");
}

#[test]
fn fault_60_a_stop_needs_no_launcher() {
    let place = Place::new(67);
    let mut launch = place.start("operated", REAL);
    let moved = launch.comes_to(has_moved(100));
    launch.signal(Signal::STOP);
    let stopped = moved && launch.comes_to(|launch| launch.is_stopped());
    // A cell that its machine has ended by then has nothing to stop.
    let mut told = (None, String::new());
    if stopped {
        told = ask(&place, &["stop"]);
        wait_until(|| ROBOTS.iter().all(|robot| rests(&launch, robot)));
        launch.signal(Signal::CONT);
    }
    let status = launch.end().code();
    let by_operator = |_: &str, text: &str| text.contains("protective stop: by the operator");
    let ended = assert_sound(&launch, status, None, by_operator);
    if stopped && ended != Ended::Late {
        let (status, said) = told;
        let carried_out =
            said.contains("stopping: step ") && said.contains(", but the cell has not answered for 5 s");
        assert!(status == Some(0) && carried_out, "{status:?}: {said}");
        assert_eq!(ended, Ended::Stopped, "{}", launch.said());
    }
    launch.assert_nothing_left(&[]);
    println!("stopped: {stopped}, {ended:?}");
}

#[test]
fn fault_60_a_launcher_that_is_stopped_from_its_terminal_suspends_the_cell_first() {
    let place = Place::new(61);
    let mut launch = place.start("operated", REAL);
    let moved = launch.comes_to(has_moved(100));
    launch.signal(Signal::TSTP);
    if moved && launch.comes_to(|launch| launch.is_stopped()) {
        assert!(ROBOTS.iter().all(|robot| rests(&launch, robot)), "it stops while robots move");
        let before = ROBOTS.map(|robot| launch.record(robot).last().cloned());
        // Much longer than an MP without a launcher goes on.
        launch.let_run(Duration::from_secs(3));
        let after = ROBOTS.map(|robot| launch.record(robot).last().cloned());
        let joints = |line: &Option<String>| line.as_ref().map(|line| demanded(line).to_owned());
        assert_eq!(before.each_ref().map(joints), after.each_ref().map(joints), "something moves meanwhile");
        launch.signal(Signal::CONT);
        // Until somebody resumes it, or its machine has been late.
        launch.comes_to(|_| ask(&place, &["resume"]).0 == Some(0));
    }
    let status = launch.end().code();
    let ended = assert_sound(&launch, status, None, nothing);
    let said = launch.said();
    if ended == Ended::Well {
        assert!(said.contains("the cell is suspended, and the launcher stops"), "{said}");
        assert_ends_where_it_would_have(&place, &launch, &[]);
    }
    launch.assert_nothing_left(&[]);
    println!("moved: {moved}, {ended:?}");
}

/// A pipe: whether nobody reads it and it is full, or nobody can read it.
pub fn pipe_without_reader(is_closed: bool) -> (Option<OwnedFd>, OwnedFd) {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    let (reader, writer) = (OwnedFd::from(reader), OwnedFd::from(writer));
    if is_closed {
        return (None, writer);
    }
    rustix::io::ioctl_fionbio(&writer, true).expect("set");
    let mut file = std::fs::File::from(writer);
    let full = loop {
        if let Err(error) = file.write(&[b'x'; 4096]) {
            break error;
        }
    };
    assert_eq!(full.kind(), ErrorKind::WouldBlock);
    let writer = OwnedFd::from(file);
    rustix::io::ioctl_fionbio(&writer, false).expect("set");
    (Some(reader), writer)
}

#[test]
fn fault_61_a_launcher_whose_cell_is_over_is_stopped_and_ended_as_any_program() {
    let place = Place::new(93);
    let (_reader, unread) = pipe_without_reader(false);
    // It has the last words itself, and waits for their reader.
    let words = ["--processes", "--no-picture"];
    let output = unread.try_clone().expect("a descriptor");
    let mut launch = place.start_writing([Some(output.into()), None], &[], "unread", &words);
    // After a fault it has nothing to say on its standard output, and ends.
    let is_over = launch.comes_to(|launch| {
        !launch.record("left").is_empty() && place.sessions().is_empty() && launch.end_if_over().is_none()
    });
    if is_over {
        launch.signal(Signal::TSTP);
        wait_until(|| launch.is_stopped() || launch.end_if_over().is_some());
    }
    let waits = is_over && launch.end_if_over().is_none();
    if waits {
        launch.signal(Signal::CONT);
        launch.signal(Signal::INT);
    }
    let status = launch.end();
    match waits {
        true => assert_eq!(status.signal(), Some(2), "{status}: {}", launch.said()),
        false => drop(assert_sound(&launch, status.code(), None, nothing)),
    }
    assert_robots_stand(&launch, None);
}

#[test]
fn fault_61_a_launcher_whose_messages_nobody_reads_supervises_all_the_same() {
    let place = Place::new(62);
    for is_closed in [false, true] {
        let (reader, writer) = pipe_without_reader(is_closed);
        let mut launch = place.start_writing([None, Some(writer.into())], &[], "unread", REAL);
        launch.comes_to(has_moved(100));
        // The launcher has something to say: a process has died that nobody needs.
        let processes = launch.processes();
        processes.iter().filter(|process| process.role == "vsp slow").for_each(|process| process.kill());
        let (status, said) = ask(&place, &["stop"]);
        // On a machine that is late the cell may have ended by then.
        assert!(
            said.contains("stopping: step ") || status != Some(0) && !said.contains("not answered"),
            "{said}"
        );
        let status = launch.end().code();
        assert!(matches!(status, Some(0 | 1)), "{status:?}");
        assert_robots_stand(&launch, None);
        launch.assert_nothing_left(&processes);
        drop(reader);
    }
}

/// The MP of a cell that has just been started.
fn mp(launch: &mut Launch) -> Process {
    let mut mp = None;
    while mp.is_none() {
        assert!(launch.end_if_over().is_none(), "{}", launch.said());
        launch.let_run(Duration::from_millis(1));
        mp = launch.processes().into_iter().find(|process| process.role == "mp");
    }
    mp.expect("it is there")
}

#[test]
fn fault_64_an_mp_that_stands_still_is_told_and_the_cell_ended() {
    // Side by side, because each waits for seconds and hardly computes.
    std::thread::scope(|scope| {
        scope.spawn(|| is_told_and_ended(65, true, "its program computes"));
        scope.spawn(|| is_told_and_ended(91, false, "it was stopped by a signal"));
    });
}

/// A cell whose MP computes for ever, or is stopped, is told why and ended.
fn is_told_and_ended(test: u32, computes: bool, why: &str) {
    let place = Place::new(test);
    let variables: Vec<_> = [(TIMEOUT, "6")].into_iter().chain(computes.then_some((COMPUTES, ""))).collect();
    let mut launch = place.start_with(&variables, "still", REAL);
    if !computes && !launch.comes_to(has_moved(100)) {
        // Its machine was late before.
        let status = launch.end().code();
        assert_sound(&launch, status, None, nothing);
        return;
    }
    let mp = mp(&mut launch);
    if !computes {
        mp.signal(Signal::STOP);
    }
    wait_until(|| launch.said().contains("note: mp: it has begun no step for 1"));
    assert!(launch.end_if_over().is_none(), "it is told before the cell is ended");
    let processes = launch.processes();
    let status = launch.end().code();
    let said = launch.said();
    let ended = "the MP has begun no step for 6";
    assert!(status == Some(1) && said.contains(why) && said.contains(ended), "{status:?}: {said}");
    assert_robots_stand(&launch, None);
    launch.assert_nothing_left(&processes);
}

#[test]
fn fault_64_a_stop_ends_a_cell_whose_mp_does_not_carry_it_out() {
    // Side by side, because each waits for seconds and hardly computes.
    std::thread::scope(|scope| {
        scope.spawn(|| is_ended_by_a_stop(66, true));
        scope.spawn(|| is_ended_by_a_stop(92, false));
    });
}

/// A stop ends a cell whose MP computes for ever, or is stopped.
fn is_ended_by_a_stop(test: u32, computes: bool) {
    let place = Place::new(test);
    let variables: &[_] = if computes { &[(COMPUTES, "")] } else { &[] };
    let mut launch = place.start_with(variables, "still", REAL);
    if !computes && !launch.comes_to(has_moved(100)) {
        // Its machine was late before.
        let status = launch.end().code();
        assert_sound(&launch, status, None, nothing);
        return;
    }
    let mp = mp(&mut launch);
    if !computes {
        mp.signal(Signal::STOP);
    }
    // As soon as the console server is there.
    let mut told = (None, String::new());
    wait_until(|| {
        told = ask(&place, &["stop"]);
        told.0 != Some(2)
    });
    let (status, said) = told;
    let pending =
        said.contains("its robots stop by themselves") && said.contains("or in 5 s, when the cell is ended");
    assert!(status == Some(3) && pending, "{status:?}: {said}");
    let status = launch.end().code();
    let said = launch.said();
    assert!(status == Some(1) && said.contains("protective stop: by the operator"), "{status:?}: {said}");
    assert_robots_stand(&launch, None);
    launch.assert_nothing_left(&[]);
}
