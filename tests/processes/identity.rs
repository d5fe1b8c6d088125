//! One cell, whatever path, user or folder it is started from; and its hardware, whatever the cell.

use std::fs;
use std::os::unix::fs::chown;
use std::os::unix::process::CommandExt;
use std::process::Command;

use mrroc_tests::fixture::{COMPUTES, HARDWARE};

use rustix::process::Signal;

use crate::launch::{Launch, Place, wait_for_end};
use crate::operator::{carried_out, operate};
use crate::runs::{PROCESSES, REAL, ROBOTS, VIRTUAL};

/// Another user.
const OTHER: u32 = 1234;

/// How a command ended, and what it printed.
fn run(command: &mut Command) -> (Option<i32>, String) {
    let output = command.output().expect("it starts");
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(said).expect("text"))
}

/// The program with these arguments after the place's own, started from elsewhere: with another folder for its sessions,
/// with the usual one, under another name of the cell's file; and by another user, where the tests run as root.
fn from_elsewhere(place: &Place, arguments: &[&str]) -> Vec<(&'static str, Command)> {
    let folder = place.base().parent().expect("a folder").to_owned();
    let (elsewhere, of_other) = (folder.join("e"), folder.join("o"));
    for path in [&elsewhere, &of_other] {
        fs::create_dir_all(path).expect("a folder");
    }
    let link = folder.join("link.toml");
    if !link.exists() {
        fs::hard_link(folder.join("cell.toml"), &link).expect("linked");
    }
    let linked: Vec<_> = arguments.iter().copied().chain(["--cell", "link.toml"]).collect();
    let mut all = vec![
        ("folder", place.program(arguments)),
        ("usual", place.program(arguments)),
        ("link", place.program(&linked)),
    ];
    all[0].1.env("XDG_RUNTIME_DIR", &elsewhere);
    all[1].1.env_remove("XDG_RUNTIME_DIR");
    all[2].1.env("XDG_RUNTIME_DIR", &elsewhere);
    if rustix::process::geteuid().is_root() {
        chown(&of_other, Some(OTHER), Some(OTHER)).expect("given away");
        let mut command = place.program(arguments);
        command.env("XDG_RUNTIME_DIR", &of_other).uid(OTHER).gid(OTHER);
        // Where that user may not enter the folder of the program, it cannot start it.
        if Command::new(command.get_program()).arg("--help").uid(OTHER).output().is_ok() {
            all.push(("user", command));
        }
    }
    all
}

#[test]
fn fault_66_a_cell_is_run_once_whatever_path_folder_or_user_it_is_started_from() {
    let place = Place::new(69);
    let mut first = place.start("first", VIRTUAL);
    first.freeze(PROCESSES.len());
    for (from, mut second) in from_elsewhere(&place, &[REAL, &["--no-picture"]].concat()) {
        let (status, said) = run(&mut second);
        let told = format!("the cell is run by process {}", first.pid());
        assert!(
            status == Some(2) && said.contains(&told) && said.contains("already"),
            "{from}: {status:?}: {said}"
        );
        println!("{from}: {}", said.lines().next().unwrap_or_default());
    }
    first.thaw();
    // The first one is undisturbed.
    assert!(first.end().success(), "{}", first.said());
    let mut alone = place.start("alone", VIRTUAL);
    assert!(alone.end().success(), "{}", alone.said());
    assert!(ROBOTS.iter().all(|robot| alone.record(robot) == first.record(robot)));
}

#[test]
fn fault_66_a_cell_whose_folder_of_sessions_was_cleaned_away_is_run_once_and_found() {
    let place = Place::new(70);
    let operator = |launch: &mut Launch| {
        fs::remove_dir_all(place.base()).expect("removed");
        let (status, said) = run(&mut place.program(REAL));
        assert!(
            status == Some(2) && said.contains(&format!("by process {} already", launch.pid())),
            "{said}"
        );
        carried_out(&["stop"], run(&mut place.program(&["stop"])), "stopping: step ")
    };
    operate(&place, operator, |launch, status, _| {
        assert!(status == Some(1) && launch.said().contains("by the operator"), "{}", launch.said());
    });
}

#[test]
fn fault_66_consoles_find_the_cell_from_everywhere_or_say_who_runs_it() {
    let place = Place::new(71);
    let operator = |launch: &mut Launch| {
        for (from, mut status) in from_elsewhere(&place, &["status"]) {
            let (status, said) = run(&mut status);
            match from {
                "user" => {
                    let told = format!("process {} of user 0 runs the cell of cell.toml", launch.pid());
                    assert!(status == Some(2) && said.contains(&told), "{status:?}: {said}");
                }
                _ => assert!(
                    status == Some(0) && said.contains("suspended: step "),
                    "{from}: {status:?}: {said}"
                ),
            }
        }
        let (_, mut stop) = from_elsewhere(&place, &["stop"]).swap_remove(1);
        carried_out(&["stop"], run(&mut stop), "stopping: step ")
    };
    operate(&place, operator, |launch, status, _| {
        assert!(status == Some(1) && launch.said().contains("by the operator"), "{}", launch.said());
    });
}

#[test]
fn fault_67_hardware_that_one_cell_has_is_refused_to_all_others() {
    let place = Place::new(72);
    let other = place.base().parent().expect("a folder").join("copy.toml");
    fs::write(other, include_str!("cell.toml")).expect("written");
    let with_hardware = |arguments: &[&str]| {
        let mut program = place.program(arguments);
        program.args(["--hardware", "arms of test 72"]);
        run(&mut program)
    };
    // Its MP computes, so that it runs until it is killed, whether its machine is late or not.
    let options = [(HARDWARE, "arms of test 72"), (COMPUTES, "")];
    let mut first = place.start_with(&options, "first", REAL);
    assert!(first.comes_to(|launch| launch.processes().len() == PROCESSES.len()), "{}", first.said());
    let (status, said) = with_hardware(&[REAL, &["--cell", "copy.toml"]].concat());
    assert!(status == Some(2), "{status:?}: {said}");
    let told = format!("arms of test 72 is driven by another cell, which process {} of user", first.pid());
    assert!(said.contains(&told), "{said}");
    let processes = first.processes();
    first.signal(Signal::KILL);
    wait_for_end(&processes);
    // Hardware cannot follow the virtual clock.
    let (status, said) = with_hardware(VIRTUAL);
    assert!(status == Some(2) && said.contains("has real drives, arms of test 72"), "{status:?}: {said}");
}

#[test]
fn fault_83_simulated_drives_stand_in_for_hardware_in_dry_runs_and_where_the_operator_says_so() {
    let place = Place::new(80);
    let with_hardware = |arguments: &[&str]| {
        let mut program = place.program(arguments);
        program.args(["--hardware", "arms of test 80"]);
        run(&mut program)
    };
    let ends_well = |arguments: &[&str]| {
        let (status, said) = with_hardware(arguments);
        assert!(status == Some(0), "{arguments:?}: {status:?}: {said}");
        said
    };
    let said = ends_well(&["--dry-run"]);
    for robot in ROBOTS {
        let told = format!("{robot}: simulated drives stood in for arms of test 80");
        assert!(said.contains("within all limits") && said.contains(&told), "{said}");
    }
    let checked = ends_well(&["--check"]);
    assert!(checked.contains("real drives, arms of test 80: not opened; a dry run takes"), "{checked}");
    // Nobody has the hardware meanwhile: it is not touched.
    for arguments in [&["--simulated", "--no-picture"][..], &["--simulated", "--virtual", "--no-picture"]] {
        assert!(ends_well(arguments).contains("simulated drives stood in for arms of test 80"));
    }
    // Where the file does not say where a robot starts, its stand-in does not know it.
    let file = place.base().parent().expect("a folder").join("elsewhere.toml");
    let without = include_str!("cell.toml").replace("start = [0.0", "# start = [0.0");
    fs::write(file, without).expect("written");
    let (status, said) = with_hardware(&["--check", "--cell", "elsewhere.toml"]);
    assert!(status == Some(2) && said.contains("has no `start`"), "{status:?}: {said}");
}
