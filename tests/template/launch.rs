//! A task program from its command line: exit statuses, the picture, and where it finds its cell.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of its own for one test, with the cell.
fn project(name: &str, cell: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("src")).expect("a folder");
    fs::write(folder.join("cell.toml"), cell).expect("a file");
    fs::write(folder.join("Cargo.toml"), "").expect("a file");
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_template_main"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn error(output: &Output, status: i32) -> String {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(status), "{text}");
    text
}

const CELL: &str = include_str!("cell.toml");

#[test]
fn a_run_says_how_long_it_took_and_draws_what_moved() {
    let folder = project("runs", CELL);
    // From a folder below, as with cargo.
    let output = run(&folder.join("src"), &["--picture", "a.svg"]);
    assert_eq!(error(&output, 0), "");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    // In place the first motions of both tasks run, twice two seconds and twice one, and the steps between them.
    assert!(said.starts_with("ran 6.0") && said.ends_with("see a.svg\n"), "{said}");
    assert!(fs::read_to_string(folder.join("src/a.svg")).expect("drawn").starts_with("<svg"));
    let quiet = run(&folder, &["--quiet", "--no-picture"]);
    assert!(quiet.status.success() && quiet.stdout.is_empty() && quiet.stderr.is_empty());
    assert!(!folder.join("picture.svg").exists());
}

#[test]
fn a_fault_is_told_with_what_to_do_and_what_moved_until_then_is_drawn() {
    let folder = project("faults", &CELL.replace("0.16, -0.16", "-0.40, 0.40"));
    let output = run(&folder, &[]);
    let told = error(&output, 1);
    assert!(told.starts_with("error: ") && told.contains("\n help: "), "{told}");
    assert!(fs::read_to_string(folder.join("picture.svg")).expect("drawn").starts_with("<svg"));
}

#[test]
fn what_is_refused_moves_nothing_and_ends_with_status_2() {
    let folder = project("refuses", &CELL.replace("step_ms = 2", "step_ms = 3\nstop = 4"));
    let told = error(&run(&folder, &[]), 2);
    assert!(told.contains("unknown key `stop`") && told.contains("did you mean `stop_ms`?"), "{told}");
    let folder = project("no-picture", CELL);
    let told = error(&run(&folder, &["--picture", "no/such/folder/a.svg"]), 2);
    assert!(told.contains("cannot be written"), "{told}");
    assert!(error(&run(&folder, &["--pictures"]), 2).contains("a similar argument exists: '--picture'"));
    fs::remove_file(folder.join("cell.toml")).expect("was there");
    // A cell.toml above the project is another's.
    fs::write(folder.parent().expect("a folder").join("cell.toml"), CELL).expect("a file");
    assert!(error(&run(&folder, &["--check"]), 2).contains("cell.toml: cannot be read"));
}

#[test]
fn the_check_prints_the_cell_with_what_its_stops_take() {
    use mrroc::robot::Robot;
    let real_time = "\n[realtime]\npriority = 42\ncores = [1, 0]\n";
    let folder = project("checks", &format!("dry_run = true\n{CELL}{real_time}"));
    let output = run(&folder, &["--check"]);
    assert_eq!(error(&output, 0), "");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let row = |begins: &str| {
        let row =
            said.lines().find(|line| line.starts_with(begins)).unwrap_or_else(|| panic!("{begins}: {said}"));
        row.split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    // safety.md: a lost peer is noticed after 20 ms of steps and one more; T_brake = v/a + 2.5 a/j, of the IRp-6 v/a.
    let (arm, detection) = (mrroc_robots::Irp6::nominal(), 0.022);
    assert!(said.contains("step 2 ms, stops within 600 ms, a lost peer is noticed after 22 ms\n"), "{said}");
    for joint in 0..6 {
        let (v, a) = (arm.limits().velocity[joint], arm.limits().acceleration[joint]);
        let braking = v / a + arm.limits().jerk.map_or(0.0, |jerk| 2.5 * a / jerk[joint]);
        let row = row(&format!("{} rad ", joint + 1)).join(" ");
        let times = format!("{braking:.3} s {:.3} s 0.600 s", detection + braking);
        assert!(row.ends_with(&times), "{row}: {times}");
        assert!(row.contains(&format!(" {v:.4} {a:.4} ")), "{row}");
    }
    assert_eq!(row("ecp arm").last().map(String::as_str), Some("1"));
    assert!(
        row("mp").contains(&"42".to_owned())
            && said.contains("after a dry run")
            && said.contains("recording: none")
    );
    assert!(said.contains("sensor") && row("touch").contains(&"interactive".to_owned()), "{said}");
}

#[test]
fn a_dry_run_says_how_near_it_comes_to_the_limits_and_draws_nothing() {
    let folder = project("dry", CELL);
    let output = run(&folder, &["--dry-run"]);
    assert_eq!(error(&output, 0), "");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.starts_with("dry run: 6.0") && said.contains("within all limits\n"), "{said}");
    let joint = said.lines().find(|line| line.starts_with("arm 3 ")).expect("a row for each joint");
    let share = joint.split_whitespace().nth(2).and_then(|share| share.parse::<f64>().ok());
    assert!(share.is_some_and(|share| share > 0.0 && share <= 100.0), "{said}");
    assert!(!folder.join("picture.svg").exists());
    let folder = project("dry-faults", &CELL.replace("0.16, -0.16", "-0.40, 0.40"));
    let told = error(&run(&folder, &["--dry-run"]), 1);
    assert!(told.contains("until the fault") && told.contains("error: "), "{told}");
}
