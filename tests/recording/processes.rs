//! Recordings of cells that run as processes.

use std::fs;
use std::process::{Child, Command};
use std::time::Duration;

use crate::recording::command::{folder, program, run, said};

#[test]
fn processes_in_lock_step_record_what_a_replay_demands() {
    let folder = folder("lock-step", "");
    said(&run(&folder, &["--processes", "--virtual", "--record", "a.mcap"]), 0);
    let told = said(&run(&folder, &["replay", "a.mcap"]), 0);
    assert!(told.ends_with(" steps: identical\n"), "{told}");
}

/// The process of a launcher that has these arguments.
fn child(launcher: &Child, arguments: &str) -> Option<String> {
    let children = format!("/proc/{0}/task/{0}/children", launcher.id());
    let children = fs::read_to_string(children).unwrap_or_default();
    let found = children.split_whitespace().find(|child| {
        let line = fs::read_to_string(format!("/proc/{child}/cmdline")).unwrap_or_default();
        line.replace('\0', " ").contains(arguments)
    });
    found.map(str::to_owned)
}

#[test]
fn a_process_that_is_killed_leaves_a_file_that_is_whole() {
    let folder = folder("killed", "");
    let mut launcher = program(&["--virtual", "--record", "b.mcap", "--quiet"]);
    let launcher = launcher.current_dir(&folder).spawn().expect("the program starts");
    // In lock-step, so that a busy machine changes nothing; soon after the first chunk of the file.
    let killed = (0..20_000).any(|_| {
        std::thread::sleep(Duration::from_millis(1));
        let grown = fs::metadata(folder.join("b.mcap")).is_ok_and(|file| file.len() > 100_000);
        let edp = child(&launcher, "edp right").filter(|_| grown);
        edp.is_some_and(|edp| Command::new("kill").args(["-KILL", &edp]).status().is_ok_and(|s| s.success()))
    });
    let ended = launcher.wait_with_output().expect("it ends");
    assert!(killed && ended.status.code() == Some(1), "{ended:?}");
    let told = said(&run(&folder, &["replay", "b.mcap"]), 0);
    assert!(told.contains(": identical, up to what came from outside"), "{told}");
}

/// A demand that was late was bridged, and is bridged again: all that was demanded comes again, to the bit, up to the fault
/// of a machine that is late for too long.
#[test]
fn demands_that_were_late_in_real_time_are_late_again() {
    let folder = folder("late", "");
    for pauses in [0, 4] {
        let mut launcher = program(&["--processes", "--record", "c.mcap", "--quiet"]);
        let launcher = launcher.current_dir(&folder).spawn().expect("the program starts");
        let signal = |name: &str, pid: &str| {
            let _ = Command::new("kill").args([name, pid]).status();
        };
        for pause in 0..pauses {
            std::thread::sleep(Duration::from_millis(300));
            let role = ["ecp left", "ecp right"][pause % 2];
            if let Some(ecp) = child(&launcher, role) {
                signal("-STOP", &ecp);
                std::thread::sleep(Duration::from_millis(6));
                signal("-CONT", &ecp);
            }
        }
        let ended = launcher.wait_with_output().expect("it ends");
        assert!(matches!(ended.status.code(), Some(0 | 1)), "{ended:?}");
        let replayed = run(&folder, &["replay", "c.mcap"]);
        let told = said(&replayed, replayed.status.code().unwrap_or(-1));
        // A machine may be late before anything ran.
        assert!(told.contains(" steps: identical") || told.contains("nothing ran"), "{told}");
        println!("{pauses} pauses: {told}");
    }
}
