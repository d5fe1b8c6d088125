//! Two cells as processes under one MP, in lock-step: the same to the bit, whatever is killed or operated.

use mrroc_tests::fixture::{DISPENSABLE, LINE, SUSPENDED};

use crate::launch::{Launch, Place, demanded, periods_at_rest};
use crate::operator::{ask, done};
use crate::runs::{MEMORY, VIRTUAL};
use crate::sound::assert_comes_to_rest;

const ARMS: [&str; 2] = ["left.arm", "right.arm"];

/// The processes of the line.
const PROCESSES: [&str; 8] =
    ["mp", "plant", "mp left", "ecp left.arm", "edp left.arm", "mp right", "ecp right.arm", "edp right.arm"];

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
fn two_cells_in_lock_step_have_their_processes_and_leave_nothing() {
    let place = place(101);
    let mut launch = place.start("virtual", VIRTUAL);
    launch.freeze(PROCESSES.len());
    let processes = launch.processes();
    let mut roles: Vec<_> = processes.iter().map(|process| process.role.as_str()).collect();
    roles.sort_unstable();
    let mut known = PROCESSES.to_vec();
    known.sort_unstable();
    assert_eq!(roles, known);
    launch.thaw();
    assert!(launch.end().success(), "{}", launch.said());
    launch.assert_nothing_left(&processes);
}

/// Kills a process in the first motion; the launch, and its status.
fn kill(place: &Place, role: &str, options: &[(&str, &str)]) -> (Launch, Option<i32>) {
    let mut launch = place.start_with(options, "killed", VIRTUAL);
    assert!(launch.comes_to(have_moved(150)), "{}", launch.said());
    let processes = launch.processes();
    let process = processes.iter().find(|process| process.role == role).expect("it runs");
    process.kill();
    let status = launch.end().code();
    launch.assert_nothing_left(&processes);
    (launch, status)
}

#[test]
fn fault_162_lower_cells_whose_upper_mp_is_killed_come_to_a_standstill_as_processes() {
    // The cell closes when its uppermost MP is gone: EDPs brake.
    assert_rests_without(&place(102), "mp");
}

/// Kills a process; its cell ends with a fault that names it, and each arm was demanded to stand at last.
fn assert_rests_without(place: &Place, role: &str) {
    let (launch, status) = kill(place, role, &[]);
    let said = launch.said();
    assert!(status == Some(1) && said.contains(role), "{status:?}: {said}");
    for arm in ARMS {
        assert_comes_to_rest(&launch, arm);
    }
}

#[test]
fn fault_166_a_lower_mp_that_is_killed_as_a_process_stops_all_cells_or_is_gone_on_without() {
    let place = place(103);
    assert_rests_without(&place, "mp left");
    let (launch, status) = kill(&place, "mp left", &[(DISPENSABLE, "1")]);
    let said = launch.said();
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("note: mp left: "), "{said}");
}

/// Asserts that both arms end where they do on the memory link, to 1e-9 rad.
fn assert_ends_where_it_would_have(place: &Place, launch: &Launch, variables: &[(&str, &str)]) {
    let mut reference = place.start_with(variables, "reference", MEMORY);
    assert!(reference.end().success(), "{}", reference.said());
    let last = |launch: &Launch, arm| -> Vec<f64> {
        let record = launch.record(arm);
        let bits = demanded(record.last().expect("it moved")).split(' ');
        bits.map(|bits| f64::from_bits(u64::from_str_radix(bits, 16).expect("bits"))).collect()
    };
    for arm in ARMS {
        let off = last(launch, arm)
            .iter()
            .zip(last(&reference, arm))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(off <= 1e-9, "{arm}: {off:e} rad");
    }
}

/// Whether both arms have stood for a while on their paths.
fn stand(launch: &Launch) -> bool {
    ARMS.iter().all(|arm| periods_at_rest(&launch.record(arm)) >= 50)
}

#[test]
fn fault_163_a_console_suspends_and_resumes_all_cells_of_a_plant_of_processes() {
    let place = place(104);
    let mut launch = place.start_with(&[(SUSPENDED, "150")], "operated", VIRTUAL);
    assert!(launch.comes_to(|launch| stand(launch)), "{}", launch.said());
    let (_, said) = ask(&place, &["status"]);
    assert!(said.starts_with("suspended: step "), "{said}");
    done(&place, &["resume"], "resumed: step ");
    let status = launch.end().code();
    assert_eq!(status, Some(0), "{}", launch.said());
    assert_ends_where_it_would_have(&place, &launch, &[]);
}

#[test]
fn fault_210_a_console_of_a_lower_cell_resets_it_and_slows_down_no_other() {
    let place = place(106);
    let variables = [(DISPENSABLE, "operated")];
    let mut launch = place.start_with(&variables, "operated", VIRTUAL);
    let latched = || ask(&place, &["status", "--of", "left"]).1.starts_with("latched: ");
    assert!(launch.comes_to(|_| latched()), "{}", launch.said());
    let (status, said) = ask(&place, &["status"]);
    assert!(status == Some(0) && said.contains("\ncell left: latched: "), "{said}");
    assert!(said.contains("there is no part") && said.contains("\ncell right: "), "{said}");
    let (_, said) = ask(&place, &["--of", "left", "status"]);
    assert!(said.contains("edp left.arm") && !said.contains("right") && !said.contains("plant"), "{said}");
    let (status, said) = ask(&place, &["reset", "--of", "middle"]);
    assert!(status == Some(1) && said.contains("no lower cell `middle`: there are left, right"), "{said}");
    // That of the plant has nothing to reset, and that of the right cell neither.
    for of in [&["reset"][..], &["reset", "--of", "right"]] {
        assert_eq!(ask(&place, of).0, Some(1), "{of:?}");
    }
    assert!(latched());
    done(&place, &["speed", "50%", "--of", "right"], "speed 50%: step ");
    let (_, said) = ask(&place, &["status"]);
    let speeds: Vec<_> = said.lines().filter(|line| line.trim_start().starts_with("speed ")).collect();
    assert!(speeds.len() == 3 && speeds[2].contains("speed 50 %"), "{said}");
    assert!(speeds[..2].iter().all(|line| line.contains("speed 100 %")), "{said}");
    done(&place, &["speed", "100%", "--of", "right"], "speed 100%: step ");
    done(&place, &["acknowledge", "--of", "left"], "acknowledged: step ");
    done(&place, &["reset", "--of", "left"], "resetting: step ");
    let status = launch.end().code();
    assert_eq!(status, Some(0), "{}", launch.said());
    assert_ends_where_it_would_have(&place, &launch, &[(DISPENSABLE, "resets")]);
}

#[test]
fn fault_161_a_lower_cell_of_processes_that_is_latched_and_reset_is_ordered_again() {
    let place = place(105);
    let variables = [(DISPENSABLE, "resets")];
    let mut memory = place.start_with(&variables, "memory", MEMORY);
    assert!(memory.end().success(), "{}", memory.said());
    let mut processes = place.start_with(&variables, "virtual", VIRTUAL);
    assert!(processes.end().success(), "{}", processes.said());
    for arm in ARMS {
        assert_eq!(memory.record(arm), processes.record(arm), "{arm}");
    }
}
