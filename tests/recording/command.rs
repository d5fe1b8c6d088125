//! Recording and replaying from the command line of a task program: what it prints, and its exit status.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use mrroc_tests::fixture::{CHANGE, PROGRAM, RECORDED};

/// The program with these arguments. What is added to this command is an option of the test program.
pub fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cell"));
    command.args(arguments).args(["--", &format!("--{PROGRAM}"), RECORDED]);
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
    let mut command = program(&[&["--no-picture"], arguments].concat());
    command.current_dir(folder).output().expect("the program starts")
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
    let mut command = program(&["replay", "b.mcap"]);
    let changed = command.current_dir(&folder).args([&format!("--{CHANGE}"), "0.25"]);
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

#[test]
fn fault_70_nothing_that_a_run_reads_is_overwritten_under_any_of_its_names() {
    let kept = folder("command-kept", "");
    let whole = kept.join("cell.toml").display().to_string();
    let before = fs::read(&whole).expect("a file");
    fs::hard_link(&whole, kept.join("hard.mcap")).expect("a link");
    std::os::unix::fs::symlink("cell.toml", kept.join("soft.svg")).expect("a link");
    for name in ["cell.toml", "./cell.toml", &whole, "hard.mcap", "soft.svg"] {
        for option in ["--record", "--picture"] {
            for more in [&[][..], &["--virtual"], &["--processes"]] {
                let told = said(&run(&kept, &[&[option, name], more].concat()), 2);
                assert!(told.contains("which this run reads: it is not overwritten\n help: "), "{told}");
                assert_eq!(fs::read(&whole).expect("a file"), before, "{option} {name} {more:?}");
            }
        }
    }
    // What writes nothing is asked for nothing that is written.
    for more in ["--check", "--dry-run"] {
        let told = said(&run(&kept, &["--record", "a.mcap", more]), 2);
        assert!(told.contains("write no outcome, no recording and no frames"), "{told}");
    }
    let told = said(&run(&kept, &["--record", "a.svg", "--picture", "./a.svg"]), 2);
    assert!(told.contains("two results are to be written there"), "{told}");
    // The cell file itself asks for it.
    let asked = folder("command-kept-asked", "[recording]\nfile = \"cell.toml\"\n");
    let before = fs::read(asked.join("cell.toml")).expect("a file");
    assert!(said(&run(&asked, &[]), 2).contains("which this run reads"));
    assert_eq!(fs::read(asked.join("cell.toml")).expect("a file"), before);
}

#[test]
fn fault_71_of_the_files_that_are_there_only_recordings_are_written_anew() {
    let folder = folder("command-anew", "");
    fs::write(folder.join("notes.txt"), "not to be lost").expect("a file");
    for more in [&[][..], &["--virtual"]] {
        let told = said(&run(&folder, &[&["--record", "notes.txt"], more].concat()), 2);
        assert!(
            told.contains("notes.txt: cannot be written: it is there already and no recording"),
            "{told}"
        );
        assert_eq!(fs::read(folder.join("notes.txt")).expect("a file"), b"not to be lost");
    }
    let file = folder.join("a.mcap");
    fs::write(&file, "").expect("a file");
    said(&run(&folder, &["--record", "a.mcap"]), 0);
    let whole = fs::read(&file).expect("a recording");
    // A whole one, and what is left of one that was cut off.
    for length in [whole.len(), whole.len() / 2, 5] {
        fs::write(&file, &whole[..length]).expect("a file");
        said(&run(&folder, &["--record", "a.mcap"]), 0);
        assert!(said(&run(&folder, &["replay", "a.mcap"]), 0).ends_with(" steps: identical\n"));
    }
}

#[test]
fn fault_79_what_a_cell_file_says_reaches_the_terminal_without_control_characters() {
    let folder = folder("command-plain", &format!("\"\\u001b[31m{}\" = 1\n", "long".repeat(10_000)));
    let told = said(&run(&folder, &[]), 2);
    assert!(told.contains("unknown key ` [31mlong") && told.len() < 2000, "{told}");
    assert!(told.chars().all(|c| c == '\n' || !c.is_control()), "{told:?}");
}
