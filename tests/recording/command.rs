//! Recording and replaying from the command line of a task program: what it prints, and its exit status.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use mrroc_tests::fixture::{CHANGE, PROGRAM, RECORDED};

/// The program.
pub fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cell"));
    command.env(PROGRAM, RECORDED);
    command
}

/// A folder of its own for one test, with the cell and what is added to it.
pub fn folder(name: &str, more: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join("cell.toml"), format!("{}\n{more}", include_str!("cell.toml"))).expect("a file");
    folder
}

pub fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = program();
    command.current_dir(folder).arg("--no-picture").args(arguments);
    command.output().expect("the program starts")
}

pub fn said(output: &Output, status: i32) -> String {
    let both = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert_eq!(output.status.code(), Some(status), "{both:?}");
    both.concat()
}

#[test]
fn a_recorded_run_is_replayed_identically() {
    let folder = folder("command", "");
    assert!(said(&run(&folder, &["--record", "a.mcap"]), 0).starts_with("ran "));
    let told = said(&run(&folder, &["replay", "a.mcap"]), 0);
    assert!(told.ends_with(" steps: identical\n"), "{told}");
    assert!(said(&run(&folder, &["replay", "a.mcap", "--quiet"]), 0).is_empty());
}

#[test]
fn a_changed_program_is_told_with_both_values() {
    let folder = folder("command-changed", "[recording]\nfile = \"b.mcap\"\n");
    said(&run(&folder, &[]), 0);
    let mut command = program();
    let changed = command.current_dir(&folder).env(CHANGE, "0.25").args(["replay", "b.mcap"]);
    let told = said(&changed.output().expect("the program starts"), 1);
    assert!(told.starts_with("error: b.mcap: step "), "{told}");
    assert!(told.contains(", right joint 1: recorded ") && told.contains(", replayed "), "{told}");
}

#[test]
fn what_cannot_be_replayed_or_recorded_is_refused_with_status_2() {
    let folder = folder("command-refused", "");
    fs::write(folder.join("c.mcap"), "not at all, and not for long").expect("a file");
    assert!(said(&run(&folder, &["replay", "c.mcap"]), 2).contains("is no MCAP file"));
    assert!(said(&run(&folder, &["--record", "no/such/d.mcap"]), 2).contains("cannot be written"));
    assert!(said(&run(&folder, &["replay"]), 2).contains("<FILE>"));
}

#[test]
fn a_full_disk_is_told_once() {
    let told = said(&run(&folder("command-full", ""), &["--record", "/dev/full"]), 0);
    assert_eq!(told.matches("the run goes on unrecorded").count(), 1, "{told}");
    assert!(told.contains("records are lost"), "{told}");
}
