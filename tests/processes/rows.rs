//! What a launch refuses before any robot moves, and what another user of the machine can do to a running cell.

use std::fs::{File, OpenOptions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};

use mrroc_tests::fixture::{ARMS, OTHER};

use rustix::process::Signal;

use crate::launch::{Launch, Place, segments};
use crate::runs::{MEMORY, PROCESSES, REAL, ROBOTS, VIRTUAL};
use crate::sound::{assert_sound, nothing};

#[test]
fn fault_29_a_second_edp_of_a_robot_takes_no_part_and_disturbs_nothing() {
    let place = Place::new(30);
    let mut launch = place.start("first", VIRTUAL);
    launch.freeze(PROCESSES.len());
    let session = place.sessions().into_iter().next().expect("a session");
    let session = place.base().join(session);
    let mut second = Command::new(env!("CARGO_BIN_EXE_cell"));
    second.args(["edp", "left", "--session"]).arg(session).args([
        "--cell",
        "cell.toml",
        "--",
        "--program",
        ARMS,
    ]);
    second.current_dir(place.base().parent().expect("a folder")).stdin(Stdio::null());
    assert!(!second.status().expect("it starts").success());
    launch.thaw();
    assert!(launch.end().success(), "{}", launch.said());
    let mut alone = place.start("alone", MEMORY);
    assert!(alone.end().success());
    for robot in ROBOTS {
        assert_eq!(launch.record(robot), alone.record(robot), "{robot}");
    }
}

#[test]
fn fault_31_a_process_of_another_program_is_refused_before_anything_moves() {
    let place = Place::new(31);
    let mut launch = place.start_with(&[(OTHER, "")], "other", REAL);
    assert_eq!(launch.end().code(), Some(2));
    let said = launch.said();
    assert!(said.contains("edp left sees another cell than its launcher\n help: "), "{said}");
    assert!(ROBOTS.iter().all(|robot| launch.record(robot).is_empty()));
    launch.assert_nothing_left(&[]);
}

/// Runs the cell in lock-step after commands of a shell; returns how it ended and what it printed.
fn after(place: &Place, shell: &str) -> (Option<i32>, String) {
    let program = place.program(VIRTUAL);
    let mut command = Command::new("unshare");
    command.args(["--mount", "sh", "-c", &format!("{shell} && exec \"$@\""), "sh"]);
    command.arg(program.get_program()).args(program.get_args());
    command.current_dir(program.get_current_dir().expect("a place"));
    command.envs(program.get_envs().filter_map(|(name, value)| Some((name, value?))));
    let output = command.output().expect("it starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Whether this user may have mounts of its own.
fn may_mount() -> bool {
    Command::new("unshare").args(["--mount", "true"]).status().is_ok_and(|status| status.success())
}

#[test]
fn fault_35_too_few_open_files_are_refused_with_what_to_change() {
    if !may_mount() {
        return println!("skipped: needs unshare");
    }
    let place = Place::new(32);
    let (status, said) = after(&place, "ulimit -n 24");
    assert!(
        status == Some(2) && said.contains("error: a process may open 24 files, one of this cell needs "),
        "{said}"
    );
    assert!(said.contains("\n help: ulimit -n "), "{said}");
    // The launcher itself raises the limits that it may raise.
    let (status, said) = after(&place, "ulimit -S -n 24");
    assert_eq!(status, Some(0), "{said}");
}

#[test]
fn fault_35_shared_memory_that_is_full_is_refused_with_what_to_change() {
    if !may_mount() {
        return println!("skipped: only root can have shared memory of its own");
    }
    let place = Place::new(33);
    let (status, said) = after(&place, "mount -t tmpfs -o size=256k tmpfs /dev/shm");
    assert!(
        status == Some(2) && said.contains("error: /dev/shm has 256 kB free, the cell needs "),
        "{status:?}: {said}"
    );
    assert!(said.contains("\n help: "), "{said}");
    assert!(place.sessions().is_empty());
}

#[test]
fn fault_78_a_launch_without_room_for_its_files_or_processes_says_what_to_do() {
    if !may_mount() {
        return println!("skipped: only root can have a disk of its own");
    }
    let place = Place::new(38);
    let (status, said) =
        after(&place, "mkdir -m 700 mrroc && mount -t tmpfs -o nr_inodes=2,mode=700 tmpfs mrroc");
    assert_eq!(status, Some(2), "{said}");
    assert!(
        said.contains("mrroc") && said.contains("\n help: there is no room left, or no inode: "),
        "{said}"
    );
    // Root may have as many processes as it likes, so another user does without.
    let place = Place::new(39);
    let few = "chown -R 1234 . && set -- prlimit --nproc=3 setpriv --reuid 1234 --clear-groups \"$@\"";
    let (status, said) = after(&place, few);
    if status == Some(126) || status == Some(127) {
        return println!("no other user may start the program: {said}");
    }
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("\n help: there is no room for another process or thread: "), "{said}");
    assert!(place.sessions().is_empty());
}

/// The number of the session that a launch has begun.
fn number_of_session(place: &Place, launch: &mut Launch) -> Option<String> {
    loop {
        if let Some(session) = place.sessions().into_iter().next() {
            return Some(session.split_once('-').expect("a session's name").1.to_owned());
        }
        if launch.end_if_over().is_some() {
            return None;
        }
        std::thread::yield_now();
    }
}

#[test]
fn fault_72_a_link_in_shared_memory_makes_the_launcher_change_no_file() {
    let place = Place::new(35);
    let victim = place.base().with_file_name("victim");
    std::fs::write(&victim, "text").expect("a file");
    std::fs::set_permissions(&victim, PermissionsExt::from_mode(0o644)).expect("a mode");
    for mode in [VIRTUAL, REAL] {
        let mut launch = place.start("linked", mode);
        let number = number_of_session(&place, &mut launch).expect("a session");
        let link = Path::new("/dev/shm").join(format!("mrroc_{number}_zzz"));
        // Long before the processes are connected, which takes them some hundredths of a second.
        std::os::unix::fs::symlink(&victim, &link).expect("a link");
        let status = launch.end().code();
        match mode {
            VIRTUAL => assert_eq!(status, Some(0), "{}", launch.said()),
            _ => drop(assert_sound(&launch, status, None, nothing)),
        }
        assert_eq!(victim.metadata().expect("it is there").permissions().mode() & 0o7777, 0o644);
        assert!(link.symlink_metadata().is_err(), "the link itself is removed with the session");
    }
}

#[test]
fn fault_73_a_launch_refused_for_a_name_that_another_user_took_says_so() {
    if !rustix::process::geteuid().is_root() {
        return println!("skipped: only root can be another user");
    }
    let place = Place::new(36);
    // At the lowest priority, and stopped as soon as its session is there: before its processes have names in shared memory.
    let mut program = place.program(REAL);
    let mut idle = Command::new("chrt");
    idle.args(["--idle", "0"]).arg(program.get_program()).args(program.get_args());
    idle.current_dir(program.get_current_dir().expect("a place"));
    idle.envs(program.get_envs().filter_map(|(name, value)| Some((name, value?))));
    program = idle;
    let mut launch = place.start_command(program, "taken");
    let number = number_of_session(&place, &mut launch).expect("a session");
    launch.signal(Signal::STOP);
    let names: Vec<_> = (0..PROCESSES.len()).map(|i| format!("/dev/shm/mrroc_{number}_wake{i}")).collect();
    let takes = || {
        let user = rustix::process::Uid::from_raw(1234);
        rustix::thread::set_thread_res_uid(user, user, user).expect("another user");
        names.iter().filter(|name| File::create_new(name).is_ok()).count()
    };
    let taken = std::thread::scope(|scope| scope.spawn(takes).join().expect("no panic"));
    launch.signal(Signal::CONT);
    let status = launch.end();
    let said = launch.said();
    names.iter().for_each(|name| drop(std::fs::remove_file(name)));
    assert!(taken > 0, "the processes had their names before this test: {said}");
    assert_eq!(status.code(), Some(2), "{said}");
    assert!(said.contains(&format!("error: /dev/shm/mrroc_{number}_wake")), "{said}");
    assert!(said.contains(" was made by user 1234 ") && said.contains("\n help: start again: "), "{said}");
    println!("{taken} names taken");
}

#[test]
fn fault_38_another_user_can_neither_read_nor_write_nor_remove_what_the_cell_shares() {
    if !rustix::process::geteuid().is_root() {
        return println!("skipped: only root can be another user");
    }
    let place = Place::new(34);
    let mut launch = place.start("shared", VIRTUAL);
    launch.freeze(PROCESSES.len());
    let session = place.sessions().into_iter().next().expect("a session");
    let shared = segments(&session);
    // A folder of the session's files, which nobody else can list or enter.
    let folder = place.base().join(&session);
    let tried = std::thread::scope(|scope| {
        let tries = || {
            let user = rustix::process::Uid::from_raw(1234);
            rustix::thread::set_thread_res_uid(user, user, user).expect("another user");
            let mut opened = Vec::new();
            for path in shared.iter().map(|name| Path::new("/dev/shm").join(name)) {
                let done = [
                    ("read", File::open(&path).is_ok()),
                    ("written", OpenOptions::new().write(true).open(&path).is_ok()),
                    ("removed", std::fs::remove_file(&path).is_ok()),
                ];
                opened.extend(done.into_iter().filter(|(_, is)| *is).map(|(what, _)| (what, path.clone())));
            }
            opened.extend(std::fs::read_dir(&folder).is_ok().then(|| ("listed", folder.clone())));
            opened
        };
        scope.spawn(tries).join().expect("no panic")
    });
    launch.thaw();
    assert!(launch.end().success(), "{}", launch.said());
    assert!(!shared.is_empty() && tried.is_empty(), "{} segments: {tried:?}", shared.len());
    println!("{} segments of shared memory tried as user 1234", shared.len());
}

#[test]
fn fault_86_a_dry_run_refuses_a_motion_that_could_not_be_suspended() {
    let place = Place::new(73);
    let dry = |farther: &str| {
        let mut program = place.program(&["--dry-run"]);
        let output = program.args(["--farther", farther]).output().expect("it starts");
        (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    // A smoothstep by 2 mrad in half a second begins with 0.048 of 7 rad/s², less 0.8 % in the mean of its first steps of 2 ms:
    // 91.8 % of the limit when it is 135 times as far, and 86.4 %.
    let (status, said) = dry("135");
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("left joint 1 uses 91.8 % of its acceleration limit in step "), "{said}");
    assert!(said.contains("help: plan with at most 90 %"), "{said}");
    let (status, said) = dry("127");
    assert_eq!(status, Some(0), "{said}");
}
