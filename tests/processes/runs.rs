//! A cell of processes from its launch to its end: its demands, and the files that it leaves behind.

use std::time::Duration;

use mrroc_tests::fixture::{COMPUTES, NOT_TOLD, OPENED, PLANS, REMOTE, STEPS};
pub use mrroc_tests::late::is_late;
use rustix::process::Signal;

use crate::launch::{
    Launch, Period, Place, Process, demanded, has_moved, periods_at_rest, segments, start_until,
    wait_for_end, wait_until,
};
use crate::operator::ATTEMPTS;

pub const REAL: &[&str] = &["--processes", "--quiet"];
pub const VIRTUAL: &[&str] = &["--virtual", "--quiet"];
pub const MEMORY: &[&str] = &["--no-picture", "--quiet"];
pub const ROBOTS: [&str; 2] = ["left", "right"];

/// The processes of the cell.
pub const PROCESSES: [&str; 10] = [
    "mp",
    "ecp left",
    "ecp right",
    "edp left",
    "edp right",
    "plant",
    "vsp count",
    "vsp slow",
    "vsp free",
    "vsp shaft",
];

/// Steps that an EDP or the drives bridge, `L` at 2 ms.
pub const L: usize = 10;

#[test]
fn processes_under_the_virtual_clock_demand_the_same_to_the_bit_as_the_memory_link() {
    let place = Place::new(0);
    let mut memory = place.start("memory", MEMORY);
    assert!(memory.end().success(), "{}", memory.said());
    let mut processes = place.start("virtual", VIRTUAL);
    assert!(processes.end().success(), "{}", processes.said());
    for robot in ROBOTS {
        let record = memory.record(robot);
        // 1 s out, 1.5 s back and 1 s of tight motion, in periods of 2 ms.
        assert!(record.len() > 1750, "{}", record.len());
        assert_eq!(record, processes.record(robot), "{robot}");
        // So did the drives, until their demands stopped.
        let (own, apart) = (memory.drives(robot), processes.drives(robot));
        assert!(own.len() >= record.len() && apart.starts_with(&own), "{robot}");
        assert!(apart.len() - own.len() <= L + 1, "{robot}");
    }
    processes.assert_nothing_left(&[]);
}

#[test]
fn a_cell_of_processes_runs_in_real_time_and_leaves_nothing() {
    let place = Place::new(1);
    let mut launch = place.start("real", REAL);
    let status = launch.end();
    assert_ended_well_or_late(&launch, status.code());
    assert_robots_stand(&launch, None);
    launch.assert_nothing_left(&[]);
}

#[test]
fn a_program_of_a_process_finds_nothing_on_its_standard_input() {
    let place = Place::new(97);
    let mut launch = start_until(|| place.start("input", VIRTUAL), has_moved(1));
    for process in launch.processes() {
        let input = std::fs::read_link(format!("/proc/{}/fd/0", process.pid));
        // A process may have ended meanwhile.
        let found = input.map_or_else(|_| "/dev/null".into(), |input| input.display().to_string());
        assert!(found == "/dev/null" || !process.is_alive(), "{process:?}: {found}");
    }
    launch.end();
}

/// A machine without a real-time scheduler may be late by more than `L` steps: this causes a fault of one of a few
/// kinds, and nothing else may be wrong.
fn assert_ended_well_or_late(launch: &Launch, status: Option<i32>) {
    let said = launch.said();
    match status {
        Some(0) => assert_eq!(said, ""),
        Some(1) => assert!(is_late(&said), "{said}"),
        _ => panic!("status {status:?}: {said}"),
    }
}

/// A robot stands when its EDP ends; and its drives stand when the plant ends, whatever was killed. A robot whose EDP
/// was killed gets no further demands, and without the plant there is no robot.
pub fn assert_robots_stand(launch: &Launch, killed: Option<&Process>) {
    let is_killed = |role: &str| killed.is_some_and(|killed| killed.role == role);
    if is_killed("plant") {
        return;
    }
    for robot in ROBOTS {
        let record = launch.record(robot);
        assert!(
            is_killed(&format!("edp {robot}")) || rests(launch, robot),
            "{robot}, {killed:?}: {:?}: {}",
            &record[record.len().saturating_sub(8)..],
            launch.said()
        );
        let drives = launch.drives(robot);
        let stands = |last: &Period| last.stands() || last.switched_off;
        assert!(drives.last().is_none_or(stands), "{robot}: {:?}", drives.last());
    }
}

/// Whether a robot's demands do not change, or its drives have no power: they were switched off by their EDP, or their
/// brakes were applied because demands were missing. If the machine stood still, a robot may have had only one period:
/// it has not been demanded to move.
pub fn rests(launch: &Launch, robot: &str) -> bool {
    let record = launch.record(robot);
    periods_at_rest(&record) >= record.len().min(2)
        || launch.drives(robot).last().is_some_and(|last| !last.powered)
}

#[test]
fn fault_06_a_process_that_stood_still_for_longer_than_the_budget_moves_nothing_afterwards() {
    let place = Place::new(7);
    for role in ["mp", "ecp left"] {
        let mut launch = start_until(|| place.start("stopped", REAL), has_moved(100));
        let processes = launch.processes();
        let stopped = processes.iter().find(|process| process.role == role).expect("it runs").clone();
        stopped.signal(Signal::STOP);
        // Far more than the 22 ms after which its robots brake: they are seen to stand, or stood when their EDPs ended.
        let edps: Vec<_> = processes.iter().filter(|process| process.role.starts_with("edp")).collect();
        let stands = |robot| periods_at_rest(&launch.record(robot)) >= 200;
        wait_until(|| ROBOTS.into_iter().all(stands) || edps.iter().all(|edp| !edp.is_alive()));
        let stood = ROBOTS.map(|robot| launch.record(robot));
        launch.let_run(Duration::ZERO);
        stopped.signal(Signal::CONT);
        assert_eq!(launch.end().code(), Some(1), "{role}: {}", launch.said());
        for (robot, stood) in ROBOTS.into_iter().zip(stood) {
            let (record, last) = (launch.record(robot), stood.last().expect("it moved"));
            assert!(rests(&launch, robot), "{role}: {robot}");
            assert!(
                record[stood.len()..].iter().all(|line| demanded(line) == demanded(last)),
                "{role}: {robot}"
            );
        }
        launch.assert_nothing_left(&processes);
    }
}

#[test]
fn fault_28_a_second_launch_is_refused_with_the_number_of_the_first() {
    let place = Place::new(4);
    let mut first = place.start("first", VIRTUAL);
    while first.processes().len() < PROCESSES.len() {
        first.let_run(Duration::from_millis(1));
    }
    let mut second = place.start("second", REAL);
    assert_eq!(second.end().code(), Some(2));
    let said = second.said();
    assert!(said.contains(&format!("run by process {} already", first.pid())), "{said}");
    assert!(first.end().success(), "{}", first.said());
    // The first one is undisturbed.
    let mut alone = place.start("alone", MEMORY);
    assert!(alone.end().success());
    assert!(ROBOTS.iter().all(|robot| alone.record(robot) == first.record(robot)));
}

#[test]
fn fault_30_what_crashed_launches_left_is_removed_and_does_no_harm() {
    let place = Place::new(5);
    // Killed as soon as its robots move.
    let mut crashed = start_until(|| place.start("crashed", REAL), has_moved(20));
    let processes = crashed.processes();
    assert_eq!(processes.len(), PROCESSES.len(), "{processes:?}");
    crashed.signal(Signal::KILL);
    crashed.end();
    // Without their launcher all processes end, and the robots stand.
    wait_for_end(&processes);
    assert_robots_stand(&crashed, None);
    let left = place.sessions();
    assert_eq!(&left, crashed.had());
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
        assert_ended_well_or_late(&launch, status);
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
    let mut launch = start_until(|| place.start("interrupted", REAL), has_moved(100));
    let processes = launch.processes();
    launch.signal(Signal::INT);
    let status = launch.end().code();
    let said = launch.said();
    assert!(status == Some(1) && (said.contains("abort") || is_late(&said)), "{status:?}: {said}");
    assert_robots_stand(&launch, None);
    assert!(launch.record("left").last().map(|line| demanded(line).to_owned()).is_some());
    launch.assert_nothing_left(&processes);
}

#[test]
fn fault_74_a_first_step_that_plans_for_too_long_is_told_to_plan_before_the_move() {
    let place = Place::new(37);
    for _ in 0..ATTEMPTS {
        let mut launch = place.start_for(PLANS, "plans", REAL);
        let status = launch.end().code();
        let said = launch.said();
        // The machine itself was late before the step that plans.
        if is_late(&said) && !said.contains("the process at the other end is gone") {
            continue;
        }
        assert!(
            status == Some(1) && said.contains("the process at the other end is gone"),
            "{status:?}: {said}"
        );
        let told = "plan what takes longer before the Move, while the robots hold";
        assert!(said.contains("\n help: a process has ended, or ") && said.contains(told), "{said}");
        return;
    }
    println!("skipped: this machine was late {ATTEMPTS} times");
}

#[test]
fn an_interrupt_ends_a_cell_whose_program_computes_for_ever() {
    let place = Place::new(9);
    let are_there = |launch: &mut Launch| launch.processes().len() == PROCESSES.len();
    let mut launch = start_until(|| place.start_for(COMPUTES, "computes", REAL), are_there);
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
    assert_ended_well_or_late(&launch, status.code());
    // One process alone has opened the camera, before the cell began: the first step read it.
    assert_eq!(launch.text(OPENED).lines().count(), 1, "{said}");
    launch.assert_nothing_left(&[]);
}

#[test]
fn fault_120_a_sensor_s_hardware_is_refused_under_the_virtual_clock_and_where_nothing_stands_in() {
    let robot = |name| format!("[robots.{name}]\nkind = \"remote\"\n");
    let cell = format!("step_ms = 2\nstop_ms = 2500\n{}{}[sensors.camera]\n", robot("soon"), robot("late"));
    let place = Place::of(96, REMOTE, &cell);
    for (arguments, refused) in [
        (["--no-picture"].as_slice(), "which cannot follow the virtual clock"),
        (&["--processes", "--virtual", "--no-picture"], "which cannot follow the virtual clock"),
        (&["--dry-run"], "nothing to stand in for it"),
    ] {
        let mut launch = place.start("refused", arguments);
        let (status, said) = (launch.end().code(), launch.said());
        assert!(status == Some(2) && said.contains("sensor `camera` has hardware, camera /"), "{said}");
        assert!(said.contains(refused), "{arguments:?}: {said}");
        assert!(launch.text(OPENED).is_empty(), "{arguments:?}");
    }
}
