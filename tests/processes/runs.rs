//! A cell of processes from its launch to its end: its demands, and the files that it leaves behind.

use mrroc_tests::fixture::{OPENED, REMOTE, SILENT, TIMES};
use rustix::process::Signal;

use crate::launch::{Place, has_moved};
use crate::sound::{Ended, assert_sound};

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
fn a_program_of_a_process_finds_nothing_on_its_standard_input() {
    let place = Place::new(97);
    let mut launch = place.start("input", VIRTUAL);
    assert!(launch.comes_to(has_moved(1)), "{}", launch.said());
    launch.freeze(PROCESSES.len());
    for process in launch.processes() {
        let input = std::fs::read_link(format!("/proc/{}/fd/0", process.pid));
        let found = input.expect("a descriptor").display().to_string();
        assert_eq!(found, "/dev/null", "{process:?}");
    }
    launch.thaw();
    assert!(launch.end().success(), "{}", launch.said());
}

#[test]
fn fault_28_a_second_launch_is_refused_with_the_number_of_the_first() {
    let place = Place::new(4);
    let mut first = place.start("first", VIRTUAL);
    first.freeze(PROCESSES.len());
    let mut second = place.start("second", REAL);
    assert_eq!(second.end().code(), Some(2));
    first.thaw();
    let said = second.said();
    assert!(said.contains(&format!("run by process {} already", first.pid())), "{said}");
    assert!(first.end().success(), "{}", first.said());
    // The first one is undisturbed.
    let mut alone = place.start("alone", MEMORY);
    assert!(alone.end().success());
    assert!(ROBOTS.iter().all(|robot| alone.record(robot) == first.record(robot)));
}

#[test]
fn fault_120_a_sensor_s_hardware_is_refused_under_the_virtual_clock_and_where_nothing_stands_in() {
    let robot = |name| format!("[robots.{name}]\nkind = \"remote\"\n");
    let cell = format!("step_ms = 2\nstop_ms = 2500\n{}{}[sensors.camera]\n", robot("soon"), robot("late"));
    let place = Place::of(96, REMOTE, &cell);
    for (arguments, refused) in [
        (["--no-picture"].as_slice(), "nothing to stand in for it"),
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

/// Wherever it comes: between a request and its answer, too.
#[test]
fn an_interrupt_aborts_a_cell_in_lock_step_on_its_paths() {
    let place = Place::new(99);
    for periods in [1, 20, 60, 100, 250, 400] {
        let arguments = ["--processes", "--virtual", "--quiet"];
        let mut launch = place.start_with(&[(TIMES, "1000")], "interrupted", &arguments);
        assert!(launch.comes_to(has_moved(periods)), "{}", launch.said());
        let processes = launch.processes();
        launch.signal(Signal::INT);
        let status = launch.end().code();
        assert_eq!(assert_sound(&launch, status, None, |kind, _| kind == "Aborted"), Ended::Stopped);
        launch.assert_nothing_left(&processes);
    }
}

#[test]
fn fault_251_ctrl_c_ends_a_launch_whose_robot_does_not_answer() {
    let cell = "step_ms = 2\nstop_ms = 2500\n[robots.soon]\nkind = \"remote\"\n[robots.late]\nkind = \"remote\"\n[sensors.camera]\n";
    let place = Place::of(98, REMOTE, cell);
    let mut launch = place.start_with(&[(SILENT, "")], "silent", REAL);
    assert!(launch.comes_to(|launch| !launch.text(SILENT).is_empty()), "{}", launch.said());
    let processes = launch.processes();
    launch.signal(Signal::INT);
    let (status, said) = (launch.end().code(), launch.said());
    // Whichever it waited for: that robot opens, and others may not be ready yet.
    let named =
        said.split_once("error: interrupted while ").and_then(|(_, rest)| rest.split_once(" started"));
    let named = named.map(|(process, _)| process).unwrap_or_default();
    assert!(status == Some(2) && processes.iter().any(|process| process.role == named), "{status:?}: {said}");
    launch.assert_nothing_left(&processes);
}
