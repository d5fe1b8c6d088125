//! Two cells as processes under one MP: the same to the bit in lock-step, and in real time whatever is killed.

use mrroc_tests::fixture::{DISPENSABLE, LINE};

use crate::launch::{Launch, Place, demanded, periods_at_rest, start_until, wait_until};
use crate::operator::{ATTEMPTS, ask, done, in_time};
use crate::runs::{MEMORY, REAL, VIRTUAL, is_late};

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
    assert!(
        status == Some(0) || status == Some(1) && is_late(&launch.said()),
        "{status:?}: {}",
        launch.said()
    );
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
    // The cell closes when its uppermost MP is gone: EDPs brake.
    kill_until_at_rest(&place(102), "mp");
}

/// Kills a process; its cell ends with a fault that names it, and each arm was demanded to stand at last. An EDP that this machine
/// keeps waiting meanwhile leaves the periods out in which it would have been seen to stand: it is tried again.
fn kill_until_at_rest(place: &Place, role: &str) {
    for attempt in 1..=ATTEMPTS {
        let (launch, status) = kill(place, role, &[]);
        assert_eq!(status, Some(1), "{}", launch.said());
        assert!(launch.said().contains(role) || is_late(&launch.said()), "{}", launch.said());
        if ARMS.iter().all(|arm| periods_at_rest(&launch.record(arm)) >= 2) {
            return;
        }
        assert!(attempt < ATTEMPTS, "{}", launch.said());
    }
}

#[test]
fn fault_166_a_lower_mp_that_is_killed_as_a_process_stops_all_cells_or_is_gone_on_without() {
    let place = place(103);
    kill_until_at_rest(&place, "mp left");
    let (launch, status) = kill(&place, "mp left", &[(DISPENSABLE, "1")]);
    let said = launch.said();
    assert!(status == Some(0) || status == Some(1) && is_late(&said), "{status:?}: {said}");
    assert!(said.contains("note: mp left: "), "{said}");
}

/// Whether an arm has had some demands; that of a latched cell has none.
fn one_has_moved(launch: &mut Launch) -> bool {
    ARMS.iter().any(|arm| launch.record(arm).len() >= 100)
}

/// Runs the line, under what `operate` does as soon as its arms move, until the machine is in time; how it ended.
fn operated(place: &Place, variables: &[(&str, &str)], operate: impl Fn(&mut Launch)) -> Option<Launch> {
    let start = || start_until(|| place.start_with(variables, "operated", REAL), one_has_moved);
    let (launch, status, ()) = in_time(start, operate)?;
    assert_eq!(status, Some(0), "{}", launch.said());
    Some(launch)
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

#[test]
fn fault_163_a_console_suspends_and_resumes_all_cells_of_a_plant_of_processes() {
    let place = place(104);
    let operate = |launch: &mut Launch| {
        if launch.end_if_over().is_some() || ask(&place, &["suspend"]).0 != Some(0) {
            // Late: it has ended.
            return;
        }
        wait_until(|| {
            let stand = ARMS.iter().all(|arm| periods_at_rest(&launch.record(arm)) >= 50);
            stand || launch.end_if_over().is_some()
        });
        if launch.end_if_over().is_none() {
            done(&place, &["resume"], "resumed: step ");
        }
    };
    if let Some(launch) = operated(&place, &[], operate) {
        assert_ends_where_it_would_have(&place, &launch, &[]);
    }
}

#[test]
fn fault_210_a_console_of_a_lower_cell_resets_it_and_slows_down_no_other() {
    let place = place(106);
    let variables = [(DISPENSABLE, "operated")];
    let operate = |launch: &mut Launch| {
        let latched = |launch: &mut Launch| {
            launch.end_if_over().is_some()
                || ask(&place, &["status", "--of", "left"]).1.starts_with("latched: ")
        };
        wait_until(|| latched(launch));
        if launch.end_if_over().is_some() {
            // Late: it has ended.
            return;
        }
        let (status, said) = ask(&place, &["status"]);
        assert!(status == Some(0) && said.contains("\ncell left: latched: "), "{said}");
        assert!(said.contains("there is no part") && said.contains("\ncell right: "), "{said}");
        let (_, said) = ask(&place, &["--of", "left", "status"]);
        assert!(
            said.contains("edp left.arm") && !said.contains("right") && !said.contains("plant"),
            "{said}"
        );
        let (status, said) = ask(&place, &["reset", "--of", "middle"]);
        assert!(
            status == Some(1) && said.contains("no lower cell `middle`: there are left, right"),
            "{said}"
        );
        // That of the plant has nothing to reset, and that of the right cell neither.
        for of in [&["reset"][..], &["reset", "--of", "right"]] {
            assert_eq!(ask(&place, of).0, Some(1), "{of:?}");
        }
        assert!(latched(launch));
        done(&place, &["speed", "50%", "--of", "right"], "speed 50%: step ");
        let (_, said) = ask(&place, &["status"]);
        let speeds: Vec<_> = said.lines().filter(|line| line.trim_start().starts_with("speed ")).collect();
        assert!(speeds.len() == 3 && speeds[2].contains("speed 50 %"), "{said}");
        assert!(speeds[..2].iter().all(|line| line.contains("speed 100 %")), "{said}");
        done(&place, &["speed", "100%", "--of", "right"], "speed 100%: step ");
        done(&place, &["acknowledge", "--of", "left"], "acknowledged: step ");
        done(&place, &["reset", "--of", "left"], "resetting: step ");
    };
    if let Some(launch) = operated(&place, &variables, operate) {
        let said = launch.said();
        assert!(
            said.contains("error: left: the cell has stopped: ") && said.contains("`reset --of left`"),
            "{said}"
        );
        assert!(!said.contains("error: right: "), "{said}");
        assert_ends_where_it_would_have(&place, &launch, &[(DISPENSABLE, "resets")]);
    }
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
    if let Some(launch) = operated(&place, &variables, |_| ()) {
        assert_ends_where_it_would_have(&place, &launch, &variables);
    }
}
