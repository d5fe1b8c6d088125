//! Two cells as processes under one MP: the same to the bit in lock-step, and in real time whatever is killed.

use mrroc_tests::fixture::{DISPENSABLE, LINE};

use crate::launch::{Launch, Place, periods_at_rest, start_until};
use crate::runs::{MEMORY, REAL, VIRTUAL, is_late};

const ARMS: [&str; 2] = ["left.arm", "right.arm"];

/// The processes of the line.
const PROCESSES: [&str; 8] = [
    "mp",
    "plant",
    "mp left",
    "ecp left.arm",
    "edp left.arm",
    "mp right",
    "ecp right.arm",
    "edp right.arm",
];

fn place(test: u32) -> Place {
    let place = Place::of(test, LINE, include_str!("line.toml"));
    for cell in ["left.toml", "right.toml"] {
        place.write(cell, include_str!("line_cell.toml"));
    }
    place
}

/// Whether both arms have had so many demands.
fn have_moved(periods: usize) -> impl Fn(&mut Launch) -> bool {
    move |launch| ARMS.iter().all(|arm| launch.record(arm).len() >= periods)
}

#[test]
fn two_cells_as_processes_under_the_virtual_clock_demand_the_same_to_the_bit_as_on_the_memory_link() {
    let place = place(100);
    let mut memory = place.start("memory", MEMORY);
    assert!(memory.end().success(), "{}", memory.said());
    let mut processes = place.start("virtual", VIRTUAL);
    assert!(processes.end().success(), "{}", processes.said());
    for arm in ARMS {
        let record = memory.record(arm);
        assert!(record.len() > 1000, "{arm}: {}", record.len());
        assert_eq!(record, processes.record(arm), "{arm}");
    }
    processes.assert_nothing_left(&[]);
}

#[test]
fn two_cells_run_in_real_time_as_processes_and_leave_nothing() {
    let place = place(101);
    let mut launch = start_until(|| place.start("real", REAL), have_moved(100));
    let processes = launch.processes();
    let mut roles: Vec<_> = processes.iter().map(|process| process.role.as_str()).collect();
    roles.sort_unstable();
    let mut known = PROCESSES.to_vec();
    known.sort_unstable();
    assert_eq!(roles, known);
    let status = launch.end().code();
    assert!(status == Some(0) || status == Some(1) && is_late(&launch.said()), "{status:?}: {}", launch.said());
    launch.assert_nothing_left(&processes);
}

/// Kills a process in the first motion; what the launcher said, and its status.
fn kill(place: &Place, role: &str, variables: &[(&str, &str)]) -> (Launch, Option<i32>) {
    let mut launch = start_until(|| place.start_with(variables, "killed", REAL), have_moved(150));
    let processes = launch.processes();
    let process = processes.iter().find(|process| process.role == role).expect("it runs");
    process.kill();
    let status = launch.end().code();
    launch.assert_nothing_left(&processes);
    (launch, status)
}

#[test]
fn fault_162_lower_cells_whose_upper_mp_is_killed_come_to_a_standstill_as_processes() {
    let place = place(102);
    let (launch, status) = kill(&place, "mp", &[]);
    assert_eq!(status, Some(1), "{}", launch.said());
    for arm in ARMS {
        // The cell closes when its uppermost MP is gone: EDPs brake.
        assert!(periods_at_rest(&launch.record(arm)) >= 2, "{arm}: {}", launch.said());
    }
}

#[test]
fn fault_166_a_lower_mp_that_is_killed_as_a_process_stops_all_cells_or_is_gone_on_without() {
    let place = place(103);
    let (launch, status) = kill(&place, "mp left", &[]);
    assert_eq!(status, Some(1), "{}", launch.said());
    assert!(launch.said().contains("mp left") || is_late(&launch.said()), "{}", launch.said());
    for arm in ARMS {
        assert!(periods_at_rest(&launch.record(arm)) >= 2, "{arm}: {}", launch.said());
    }
    let (launch, status) = kill(&place, "mp left", &[(DISPENSABLE, "1")]);
    let said = launch.said();
    assert!(status == Some(0) || status == Some(1) && is_late(&said), "{status:?}: {said}");
    assert!(said.contains("note: mp left: "), "{said}");
}
