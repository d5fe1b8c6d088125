//! The operator of a running cell, at consoles that are processes of their own. The cell runs in lock-step, so that nothing is late.

use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ChildStdout, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use mrroc_tests::fixture::{SUSPENDED, TIMES};

use crate::launch::{Launch, Place, demanded, periods_at_rest, wait_until};
use crate::runs::{MEMORY, ROBOTS, VIRTUAL};
use crate::sound::{assert_robots_stand, rests};

/// The step in which cells are suspended, in the first motion of their robots.
const SUSPENDED_IN: &str = "100";

/// Runs a cell in lock-step that stands suspended on its path when `operate` operates it, and gives it to `check` at its end. While it
/// stands, its steps go on.
pub fn operate<T>(
    place: &Place,
    operate: impl FnOnce(&mut Launch) -> T,
    check: impl FnOnce(&Launch, Option<i32>, T),
) {
    operate_with(place, &[], operate, check);
}

/// The same with options of the test program.
pub fn operate_with<T>(
    place: &Place,
    options: &[(&str, &str)],
    operate: impl FnOnce(&mut Launch) -> T,
    check: impl FnOnce(&Launch, Option<i32>, T),
) {
    let options = [&[(SUSPENDED, SUSPENDED_IN)], options].concat();
    let mut launch = place.start_with(&options, "operated", VIRTUAL);
    assert!(launch.comes_to(|launch| stand(launch)), "{}", launch.said());
    let seen = operate(&mut launch);
    let status = launch.end().code();
    launch.assert_nothing_left(&[]);
    check(&launch, status, seen);
    assert_robots_stand(&launch, None);
}

/// Sends one request from a console; returns its exit status and what it printed.
pub fn ask(place: &Place, words: &[&str]) -> (Option<i32>, String) {
    let output = place.program(words).output().expect("a console starts");
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(said).expect("text"))
}

/// The same of one that is carried out; in which step.
pub fn done(place: &Place, words: &[&str], told: &str) -> u64 {
    carried_out(words, ask(place, words), told)
}

/// The step in which a request was carried out that was answered so.
pub fn carried_out(words: &[&str], (status, said): (Option<i32>, String), told: &str) -> u64 {
    assert_eq!(status, Some(0), "{words:?}: {said}");
    step(&said, told)
}

/// The step in an answer that says this.
fn step(said: &str, told: &str) -> u64 {
    assert!(said.contains(told), "{said}");
    let step = said.rsplit_once("step ").map(|(_, step)| step.trim().parse());
    step.expect("a step").expect("a number")
}

/// A console with several requests.
struct Console {
    child: Child,
    asks: ChildStdin,
    hears: BufReader<ChildStdout>,
}

impl Console {
    fn new(place: &Place) -> Console {
        let mut command = place.program(&["console"]);
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("a console starts");
        let asks = child.stdin.take().expect("piped");
        let hears = BufReader::new(child.stdout.take().expect("piped"));
        Console { child, asks, hears }
    }

    fn ask(&mut self, request: &str) -> String {
        writeln!(self.asks, "{request}").expect("asked");
        let mut line = String::new();
        self.hears.read_line(&mut line).expect("answered");
        line.trim_end().to_owned()
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The socket of the cell that runs.
pub fn socket(place: &Place) -> PathBuf {
    let session = place.sessions().into_iter().next().expect("a session");
    place.base().join(session).join("operator")
}

/// Where each joint of a robot was demanded to be last.
fn last_joints(launch: &Launch, robot: &str) -> Vec<f64> {
    let record = launch.record(robot);
    let bits = demanded(record.last().expect("it moved")).split(' ');
    bits.map(|bits| f64::from_bits(u64::from_str_radix(bits, 16).expect("bits"))).collect()
}

/// Asserts that the robots end where they do without an operator, to 1e-9 rad; under these options of the test program.
pub fn assert_ends_where_it_would_have(place: &Place, launch: &Launch, options: &[(&str, &str)]) {
    let mut reference = place.start_with(options, "reference", MEMORY);
    assert!(reference.end().success(), "{}", reference.said());
    for robot in ROBOTS {
        let (is, should) = (last_joints(launch, robot), last_joints(&reference, robot));
        let error = is.iter().zip(&should).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error <= 1e-9, "{robot}: {error:e} rad");
    }
}

pub fn stand(launch: &Launch) -> bool {
    ROBOTS.iter().all(|robot| periods_at_rest(&launch.record(robot)) >= 50)
}

#[test]
fn a_cell_that_another_process_suspends_and_resumes_ends_where_it_would_have() {
    let place = Place::new(20);
    // Long enough that a console suspends it once more before it is over.
    let options = [(TIMES, "4")];
    let operator = |launch: &mut Launch| {
        let (status, said) = ask(&place, &["status"]);
        assert!(status == Some(0) && said.starts_with("suspended: step "), "{said}");
        assert!(said.contains("rate 0.000") && said.contains("move Ask"), "{said}");
        for process in launch.processes() {
            assert!(said.contains(&format!("{:>8} {} ", process.pid, process.role)), "{process:?}: {said}");
        }
        let stood = last_joints(launch, "left");
        let mut console = Console::new(&place);
        let resumed = step(&console.ask("resume"), "resumed: step ");
        wait_until(|| last_joints(launch, "left") != stood);
        let suspended = step(&console.ask("suspend"), "suspended: step ");
        assert!(suspended > resumed, "{resumed}, {suspended}");
        wait_until(|| stand(launch));
        let again = step(&console.ask("resume"), "resumed: step ");
        assert!(again >= suspended + 50, "{suspended} to {again}");
    };
    operate_with(&place, &options, operator, |launch, status, ()| {
        assert_eq!(status, Some(0), "{}", launch.said());
        assert_ends_where_it_would_have(&place, launch, &options);
    });
}

#[test]
fn a_cell_runs_at_the_speed_that_is_asked_for() {
    let place = Place::new(21);
    let operator = |launch: &mut Launch| {
        done(&place, &["speed", "50%"], "speed 50%: step ");
        assert!(ask(&place, &["status"]).1.contains("speed 50 %"));
        let at = launch.record("left").len();
        done(&place, &["resume"], "resumed: step ");
        at
    };
    operate(&place, operator, |launch, status, at| {
        assert_eq!(status, Some(0), "{}", launch.said());
        assert_ends_where_it_would_have(&place, launch, &[]);
        // The path takes 3.5 s, 1750 periods; it was suspended after 100 of them and stood within so many more. What is left takes twice
        // as long at half the speed.
        let record = launch.record("left");
        let moving = record[at..].windows(2).filter(|pair| demanded(&pair[0]) != demanded(&pair[1])).count();
        let stands_after = 100 + 350;
        assert!(moving >= 2 * (1750 - stands_after), "{moving} periods");
    });
}

#[test]
fn a_cell_that_is_stopped_or_aborted_says_so_and_its_robots_stand() {
    let place = Place::new(22);
    for (word, told, fault) in [
        ("stop", "stopping: step ", "by the operator"),
        ("abort", "aborting: step ", "aborted by the operator"),
    ] {
        operate(
            &place,
            |_| done(&place, &[word], told),
            |launch, status, _| {
                assert!(status == Some(1) && launch.said().contains(fault), "{status:?}: {}", launch.said());
            },
        );
    }
}

#[test]
fn a_cell_that_was_stopped_starts_again_after_acknowledgement_and_reset() {
    let place = Place::new(28);
    let cell = place.base().parent().expect("a folder").join("cell.toml");
    let text = format!("after_fault = \"await reset\"\n{}", include_str!("cell.toml"));
    std::fs::write(cell, text).expect("written");
    let refused = |word, told: &str| {
        let (status, said) = ask(&place, &[word]);
        assert!(status == Some(1) && said.contains(told), "{word}: {status:?}: {said}");
    };
    let operator = |launch: &mut Launch| {
        // Long enough that drives with friction are not where they were told to be.
        wait_until(|| ROBOTS.iter().all(|robot| periods_at_rest(&launch.record(robot)) >= 1000));
        let stopped = done(&place, &["stop"], "stopping: step ");
        wait_until(|| ask(&place, &["status"]).1.starts_with("latched: "));
        let (_, said) = ask(&place, &["status"]);
        assert!(said.contains("last fault: mp: protective stop: by the operator"), "{said}");
        wait_until(|| ROBOTS.iter().all(|robot| rests(launch, robot)));
        refused("reset", "refused: it has stopped for a fault, which is not acknowledged: step ");
        refused("resume", "refused: it has stopped for a fault");
        let acknowledged = done(&place, &["acknowledge"], "acknowledged: step ");
        let reset = done(&place, &["reset"], "resetting: step ");
        assert!(stopped < acknowledged && acknowledged < reset, "{stopped}, {acknowledged}, {reset}");
        // The program begins at its first line; what was suspended stays so.
        wait_until(|| ask(&place, &["status"]).1.starts_with("suspended: "));
        done(&place, &["resume"], "resumed: step ");
    };
    operate(&place, operator, |launch, status, ()| {
        assert_eq!(status, Some(0), "{}", launch.said());
        let mut reference = place.start_with(&[], "reference", MEMORY);
        assert!(reference.end().success(), "{}", reference.said());
        for robot in ROBOTS {
            // The program turns the column to where it always ends. It begins where the drives were when their power was off, and leaves
            // the other joints there.
            let off =
                launch.drives(robot).into_iter().find(|period| period.switched_off).expect("it was off");
            let should = [&last_joints(&reference, robot)[..1], &off.measured[1..6]].concat();
            let error = last_joints(launch, robot)
                .iter()
                .zip(&should)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(error <= 1e-9, "{robot}: {error:e} rad");
        }
    });
}

#[test]
fn fault_05_a_console_that_is_killed_disturbs_no_motion_and_returns_the_token() {
    let place = Place::new(23);
    let operator = |_: &mut Launch| {
        let mut first = Console::new(&place);
        assert!(first.ask("take").contains("holds the control token"));
        let (status, said) = ask(&place, &["speed", "90%"]);
        let told = format!("refused: the console of process {} holds the control token\n", first.child.id());
        assert_eq!((status, said), (Some(1), told));
        // What only brings robots to rest is taken from every console.
        assert!(Console::new(&place).ask("let-go 5").starts_with("let go: step "));
        assert!(
            ask(&place, &["status"])
                .1
                .contains(&format!("control: the console of process {}", first.child.id()))
        );
        first.child.kill().expect("killed");
        // It is gone when the console server sees the end of its socket.
        wait_until(|| ask(&place, &["status"]).1.contains("control: nobody"));
        done(&place, &["speed", "100%"], "speed 100%: step ");
        let mut second = Console::new(&place);
        assert!(second.ask("release").starts_with("refused: "));
        assert!(second.ask("take").contains("holds"));
        assert!(second.ask("release").starts_with("nobody holds"));
        done(&place, &["resume"], "resumed: step ");
    };
    operate(&place, operator, |launch, status, ()| {
        assert_eq!(status, Some(0), "{}", launch.said());
        assert_ends_where_it_would_have(&place, launch, &[]);
    });
}

#[test]
fn fault_36_what_contradicts_the_state_of_the_cell_is_refused_with_it() {
    let place = Place::new(24);
    // It lasts longer than all that is asked.
    let options = [(TIMES, "1000")];
    let operator = |_: &mut Launch| {
        let mut console = Console::new(&place);
        assert!(console.ask("resume").starts_with("resumed: step "));
        assert!(console.ask("resume").starts_with("refused: it runs: step "));
        assert!(console.ask("reset").starts_with("refused: it runs: step "));
        assert!(console.ask("suspend").starts_with("suspended: step "));
        assert!(console.ask("suspend").starts_with("suspended: step "));
        assert!(console.ask("acknowledge").starts_with("refused: it is suspended: step "));
        assert!(console.ask("resume").starts_with("resumed: step "));
        assert!(console.ask("speed much").starts_with("refused: `speed much` is no request"));
        // Another console: every console may stop the cell.
        let mut other = Console::new(&place);
        assert!(other.ask("resume").starts_with("refused: the console of process"));
        assert!(other.ask("stop").starts_with("stopping: step "));
        for request in ["resume", "suspend", "abort"] {
            let answer = console.ask(request);
            let stops = [
                "refused: it is stopping: step ",
                "refused: it has stopped for a fault",
                "refused: the cell closes",
            ];
            assert!(stops.iter().any(|told| answer.starts_with(told)), "{request}: {answer}");
        }
    };
    operate_with(&place, &options, operator, |launch, status, ()| {
        assert!(status == Some(1) && launch.said().contains("by the operator"), "{}", launch.said());
    });
}

#[test]
fn fault_36_a_flood_of_requests_reaches_the_cell_once_a_step_and_no_stop_is_lost_in_it() {
    let place = Place::new(25);
    let operator = |launch: &mut Launch| {
        let socket = socket(&place);
        let over = AtomicBool::new(false);
        let flood = |request: &'static [u8]| {
            let mut stream = UnixStream::connect(&socket).expect("connected");
            stream.set_nonblocking(true).expect("set");
            let (mut offered, mut heard) = (0_u64, Vec::new());
            let mut bytes = [0; 4096];
            while !over.load(Ordering::Acquire) {
                // Most find the socket full: the console server takes one at a time from each console.
                offered += 1;
                let _ = stream.write(request);
                if let Ok(count) = stream.read(&mut bytes) {
                    heard.extend_from_slice(&bytes[..count]);
                }
            }
            (offered, String::from_utf8_lossy(&heard).into_owned())
        };
        let (requests, steps) = std::thread::scope(|scope| {
            let speed = scope.spawn(|| flood(b"speed 100%\n"));
            let others =
                [&b"status\n"[..], b"no such thing\n", b"\xff\n"].map(|r| scope.spawn(move || flood(r)));
            launch.let_run(Duration::from_millis(700));
            // An endless flood of requests would block itself after the end of the cell.
            let stopped = ask(&place, &["stop"]);
            over.store(true, Ordering::Release);
            carried_out(&["stop"], stopped, "stopping: step ");
            let (offered, heard) = speed.join().expect("flooded");
            let others: u64 = others.into_iter().map(|other| other.join().expect("flooded").0).sum();
            let steps: Vec<u64> = heard
                .lines()
                .filter_map(|line| line.strip_prefix("done speed 100%: step ")?.parse().ok())
                .collect();
            (offered + others, steps)
        });
        assert!(!steps.is_empty() && steps.windows(2).all(|two| two[0] < two[1]), "{steps:?}");
        println!(
            "{requests} requests in the sockets, {} of one kind carried out, each in a step of its own",
            steps.len()
        );
    };
    operate(&place, operator, |launch, status, ()| {
        assert!(status == Some(1) && launch.said().contains("by the operator"), "{}", launch.said());
    });
}

#[test]
fn fault_38_the_console_of_another_user_is_refused_and_told_of() {
    if !rustix::process::geteuid().is_root() {
        return println!("skipped: only root can be another user");
    }
    let place = Place::new(26);
    let operator = |_: &mut Launch| {
        let socket = socket(&place);
        let session = socket.parent().expect("a session").to_owned();
        let connect = || {
            let user = rustix::process::Uid::from_raw(1234);
            rustix::thread::set_thread_res_uid(user, user, user).expect("another user");
            let mut stream = UnixStream::connect(&socket)?;
            stream.write_all(b"stop\n")?;
            let mut answer = String::new();
            stream.read_to_string(&mut answer).map(|_| answer)
        };
        // With the usual permissions, no other user can reach the socket ..
        let outside = std::thread::scope(|scope| scope.spawn(connect).join().expect("no panic"));
        assert_eq!(outside.map_err(|error| error.kind()), Err(std::io::ErrorKind::PermissionDenied));
        // .. and where folders are open the console server asks the kernel who it is.
        for (path, mode) in [(&place.base(), 0o711), (&session, 0o711), (&socket, 0o666)] {
            std::fs::set_permissions(path, PermissionsExt::from_mode(mode)).expect("set");
        }
        let inside = std::thread::scope(|scope| scope.spawn(connect).join().expect("no panic"));
        std::fs::set_permissions(place.base(), PermissionsExt::from_mode(0o700)).expect("set");
        // Refused before it was read: the answer may be lost with what it had written.
        let refused = "refused the cell belongs to another user than 1234\n";
        assert!(inside.as_ref().map_or(true, |answer| answer == refused), "{inside:?}");
        done(&place, &["resume"], "resumed: step ");
    };
    operate(&place, operator, |launch, status, ()| {
        assert_eq!(status, Some(0), "{}", launch.said());
        assert!(launch.said().contains("of user 1234 was refused"), "{}", launch.said());
    });
}

#[test]
fn a_cell_that_does_not_run_cannot_be_operated() {
    let place = Place::new(27);
    for words in [&["status"][..], &["stop"], &["console"], &["speed", "10%"]] {
        let (status, said) = ask(&place, words);
        assert!(status == Some(2) && said.contains("no processes run the cell of cell.toml"), "{said}");
    }
    // Another cell of the same user runs: it is not this one.
    let other = place.base().parent().expect("a folder").join("other.toml");
    std::fs::write(&other, include_str!("cell.toml")).expect("written");
    operate(
        &place,
        |_| {
            let (status, said) = ask(&place, &["stop", "--cell", "other.toml"]);
            assert!(status == Some(2), "{status:?}: {said}");
            done(&place, &["resume"], "resumed: step ");
        },
        |launch, status, ()| assert_eq!(status, Some(0), "{}", launch.said()),
    );
}

#[test]
fn fault_234_a_console_that_may_not_jog_is_told_why() {
    let place = Place::new(74);
    let operator = |launch: &mut Launch| {
        let mut console = Console::new(&place);
        let jog = |hold: u32, robot: &str, order: &str| format!("jog {hold} 0 {robot} {order}");
        let answer = console.ask(&jog(5, "left", "tool x 20%"));
        assert!(answer.starts_with("refused: the cell is not at reduced speed"), "{answer}");
        assert!(console.ask("reduced on").starts_with("reduced speed"));
        let stands = last_joints(launch, "left");
        for (hold, robot, order, why) in [
            (6, "left", "tool x 20%", "no program lets this robot be jogged now"),
            (7, "nobody", "tool x 20%", "the cell has no such robot"),
            (8, "left", "frame moon x 20%", "the cell names no such frame"),
            (9, "left", "joint 8 20%", "the robot has not these joints"),
            (10, "left", "to 20% 0 0", "the robot has not these joints"),
            (11, "left", "tool x 120%", "it is not said what is to be jogged"),
        ] {
            let answer = console.ask(&jog(hold, robot, order));
            assert!(answer.starts_with("refused: ") && answer.contains(why), "{robot} {order}: {answer}");
        }
        let answer = console.ask("jog-done left");
        assert!(answer.starts_with("refused: no program lets this robot be jogged now"), "{answer}");
        // Another console has not the control.
        let answer = Console::new(&place).ask(&jog(12, "left", "tool x 20%"));
        assert!(answer.starts_with("refused: the console of process"), "{answer}");
        assert_eq!(last_joints(launch, "left"), stands, "nothing has moved");
        assert!(console.ask("reduced off").starts_with("full speed, and suspended"));
        assert!(console.ask("resume").starts_with("resumed: step "));
    };
    operate(&place, operator, |launch, status, ()| {
        assert_eq!(status, Some(0), "{}", launch.said());
        assert_ends_where_it_would_have(&place, launch, &[]);
    });
}

#[test]
fn fault_05_robots_at_reduced_speed_move_while_a_console_holds_and_end_where_they_would_have() {
    let place = Place::new(95);
    let operator = |launch: &mut Launch| {
        let mut console = Console::new(&place);
        assert!(console.ask("hold 5 0").starts_with("refused: the cell is not at reduced speed"));
        assert!(console.ask("speed 10%").starts_with("speed 10%: step "));
        assert!(console.ask("reduced on").starts_with("reduced speed"));
        assert!(console.ask("resume").starts_with("resumed: step "));
        let before = last_joints(launch, "left");
        let mut count = 0;
        while last_joints(launch, "left") == before && launch.end_if_over().is_none() {
            let answer = console.ask(&format!("hold 5 {count}"));
            assert!(answer.starts_with("held: step "), "{answer}");
            count += 1;
        }
        // Another console may stop the cell, and not hold it.
        assert!(Console::new(&place).ask("hold 6 0").starts_with("refused: the console of process"));
        assert!(console.ask("let-go 5").starts_with("let go: step "));
        wait_until(|| stand(launch));
        let stands = last_joints(launch, "left");
        let periods = launch.record("left").len();
        assert!(console.ask("hold 5 60000").starts_with("held: step "));
        wait_until(|| launch.record("left").len() > periods + 50);
        assert_eq!(last_joints(launch, "left"), stands, "a hold that was let go");
        assert!(console.ask("speed 100%").starts_with("speed 100%: step "));
        assert!(console.ask("reduced off").starts_with("full speed, and suspended"));
        assert!(console.ask("resume").starts_with("resumed: step "));
    };
    operate(&place, operator, |launch, status, ()| {
        assert_eq!(status, Some(0), "{}", launch.said());
        assert_ends_where_it_would_have(&place, launch, &[]);
    });
}
