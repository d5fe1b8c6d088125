//! Recordings of cells that run as processes.

use std::fs;
use std::process::{Child, Command};
use std::time::Duration;

use crate::command::{folder, program, run, said};

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
    let mut launcher = Command::new(program());
    launcher.current_dir(&folder).args(["--processes", "--record", "b.mcap", "--quiet"]);
    let launcher = launcher.spawn().expect("the program starts");
    let killed = (0..500).any(|_| {
        std::thread::sleep(Duration::from_millis(20));
        let grown = fs::metadata(folder.join("b.mcap")).is_ok_and(|file| file.len() > 100_000);
        let edp = child(&launcher, "edp right").filter(|_| grown);
        edp.is_some_and(|edp| Command::new("kill").args(["-KILL", &edp]).status().is_ok_and(|s| s.success()))
    });
    let ended = launcher.wait_with_output().expect("it ends");
    assert!(killed && ended.status.code() == Some(1), "{ended:?}");
    let told = said(&run(&folder, &["replay", "b.mcap"]), 0);
    assert!(told.contains(": identical, up to what came from outside"), "{told}");
}
