//! Cells of as many robots as there may be.

use std::fs;

use mrroc_tests::fixture::CROWD;

use crate::launch::{Launch, Place, wait_until};
use crate::operator::ask;
use crate::runs::{REAL, VIRTUAL};

/// A cell of so many grippers.
fn cell(robots: usize) -> String {
    let robot = |i: usize| format!("[robots.g{i}]\nkind = \"gripper\"\nstart = [0.07]\n");
    format!("step_ms = 20\n{}", (0..robots).map(robot).collect::<String>())
}

/// Lets the program end; returns how the launch has ended.
fn end(place: &Place, launch: &mut Launch, records: &str) -> Option<i32> {
    fs::write(place.base().parent().expect("a folder").join(records).join("end"), "").expect("written");
    launch.end().code()
}

#[test]
fn fault_65_a_crowd_of_robots_runs_as_processes_and_status_shows_them_all() {
    run_and_show(16);
}

#[test]
#[ignore = "takes a minute on two processors: `just crowd`"]
fn fault_65_sixty_four_robots_run_as_processes_and_status_shows_them_all() {
    run_and_show(64);
}

fn run_and_show(robots: usize) {
    let place = Place::of(43, CROWD, &cell(robots));
    let mut launch = place.start("virtual", VIRTUAL);
    let mut said = String::new();
    wait_until(|| {
        assert!(launch.end_if_over().is_none(), "{}", launch.said());
        let status;
        (status, said) = ask(&place, &["status"]);
        status == Some(0)
    });
    // Every process, and every robot's joints: demanded and measured.
    let processes = launch.processes();
    assert_eq!(processes.len(), 1 + robots + robots + 1);
    for process in &processes {
        assert!(said.contains(&format!("{:>8} {} ", process.pid, process.role)), "{process:?}: {said}");
    }
    wait_until(|| ask(&place, &["status"]).1.matches("  measured ").count() == robots);
    let status = end(&place, &mut launch, "virtual");
    assert_eq!(status, Some(0), "{}", launch.said());
    launch.assert_nothing_left(&processes);
}

#[test]
fn fault_65_a_cell_of_too_many_processes_is_refused_before_any_of_them_starts() {
    let place = Place::of(68, CROWD, &cell(96));
    for arguments in [&["--check"][..], REAL] {
        let mut launch = place.start("refused", arguments);
        assert_eq!(launch.end().code(), Some(2), "{arguments:?}");
        let said = launch.said();
        assert!(said.contains("the cell has 194 processes") && said.contains("there may be 192"), "{said}");
    }
}
