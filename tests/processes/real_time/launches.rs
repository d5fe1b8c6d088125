//! Launches in real time, each with a disturbance that is drawn: a signal, a killed process, a terminal that takes nothing, a
//! session whose folder is gone, another user. After each no robot moves, no process is left, and the cell can be launched.
//!
//! `MRROC_LAUNCHES` says how many, `MRROC_SEED` with which seed, `MRROC_DISTURBANCE` which alone, such as `Killed("mp")`;
//! the moment is drawn in servo periods of the left robot.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::{self, File};
use std::os::unix::fs::chown;
use std::os::unix::process::CommandExt;
use std::process::Stdio;
use std::time::Duration;

use rustix::process::Signal;

use crate::kills::Random;
use crate::launch::{Launch, Period, Place, Process, periods_at_rest, wait_for_end, wait_until};
use crate::operator::ask;
use crate::runs::{L, PROCESSES, ROBOTS, VIRTUAL};
use crate::sound::assert_within_limits;

use super::supervision::pipe_without_reader;

/// Servo periods of a whole run, 3.5 s.
const WHOLE: u64 = 1750;

/// Another user.
const OTHER: u32 = 1234;

/// What happens to a launch.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Disturbance {
    /// Nothing, but for what its output is.
    Nothing,
    /// A signal to the launcher, after which the cell ends.
    Ends(Signal),
    /// A signal that the launcher stands still for until it is continued.
    Stops(Signal),
    /// The launcher is killed.
    KilledLauncher,
    /// A process is killed.
    Killed(&'static str),
    /// The folder of the session is removed.
    RemovedSession,
    /// Another user's consoles ask for everything.
    OtherUser,
}

/// In an order in which neighbours are of different kinds.
const DISTURBANCES: [Disturbance; 17] = [
    Disturbance::Ends(Signal::TERM),
    Disturbance::Killed("edp left"),
    Disturbance::Stops(Signal::STOP),
    Disturbance::KilledLauncher,
    Disturbance::RemovedSession,
    Disturbance::Ends(Signal::HUP),
    Disturbance::Killed("mp"),
    Disturbance::Stops(Signal::TSTP),
    Disturbance::OtherUser,
    Disturbance::Killed("plant"),
    Disturbance::Ends(Signal::INT),
    Disturbance::Killed("ecp right"),
    Disturbance::Nothing,
    Disturbance::Killed("edp right"),
    Disturbance::Ends(Signal::QUIT),
    Disturbance::Killed("ecp left"),
    Disturbance::Killed("vsp slow"),
];

/// Where a program writes to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Output {
    /// A file.
    Kept,
    /// Nothing has room any more.
    Full,
    /// A pipe that is full and that nobody reads.
    Unread,
    /// A pipe whose other end is closed.
    Closed,
}

const OUTPUTS: [Output; 4] = [Output::Kept, Output::Full, Output::Unread, Output::Closed];

/// What programs are asked for beside `--processes`: messages differ, and who tells the end.
const WORDS: [&[&str]; 3] = [
    &["--processes", "--quiet"],
    &["--processes", "--no-picture"],
    &["--processes", "--picture", "drawn.svg"],
];

/// How a robot came to a standstill.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Came {
    /// It never moved.
    Still,
    /// Its EDP demanded it, and stayed until it stood.
    ByDemand,
    /// Its drives applied their brakes: their EDP was killed.
    ByBrakes,
    /// The same, because this machine was late by more than they bridge.
    Late,
    /// The same, and the launch could not say why.
    Unsaid,
    /// It is gone with the plant.
    Gone,
}

#[test]
fn fault_87_launches_under_disturbances_leave_no_robot_moving_and_the_next_one_works() {
    let place = Place::new(90);
    let mut random = Random::new();
    let launches = std::env::var("MRROC_LAUNCHES").ok().and_then(|count| count.parse().ok()).unwrap_or(3);
    println!("{launches} launches, MRROC_SEED={}", random.seed);
    let mut tally = BTreeMap::<Came, u32>::new();
    let only = std::env::var("MRROC_DISTURBANCE").unwrap_or_default();
    let disturbances = DISTURBANCES.into_iter().filter(|one| format!("{one:?}").starts_with(&only));
    for (number, disturbance) in disturbances.cycle().take(launches).enumerate() {
        let drawn = Drawn::of(disturbance, &mut random);
        print!("launch {number}: {drawn}: ");
        let came = one(&place, &drawn, &format!("launch {number}"));
        println!("{came:?}");
        came.into_iter().for_each(|came| *tally.entry(came).or_default() += 1);
    }
    println!("{tally:?}");
}

/// A launch that is drawn.
struct Drawn {
    disturbance: Disturbance,
    output: Output,
    errors: Output,
    words: &'static [&'static str],
    /// When: after so many periods of the left robot, or when so many processes are there.
    at: u64,
    starting: bool,
}

impl Drawn {
    fn of(disturbance: Disturbance, random: &mut Random) -> Drawn {
        let mut output = || OUTPUTS[random.below(OUTPUTS.len() as u64) as usize];
        let (output, errors) = (output(), output());
        let words = WORDS[random.below(WORDS.len() as u64) as usize];
        // One in five while the cell starts.
        let starting = random.below(5) == 0;
        let at = random.below(if starting { PROCESSES.len() as u64 } else { WHOLE });
        Drawn { disturbance, output, errors, words, at, starting }
    }
}

impl fmt::Display for Drawn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let when = if self.starting { "with processes" } else { "in period" };
        write!(f, "{:?} {when} {}, {}", self.disturbance, self.at, self.words.join(" "))?;
        write!(f, ", output {:?}, errors {:?}", self.output, self.errors)
    }
}

/// One launch, checked; how its robots came to a standstill.
fn one(place: &Place, drawn: &Drawn, number: &str) -> [Came; 2] {
    // Held until the launch is over: a pipe that nobody reads has a reader.
    let mut readers = Vec::new();
    let [output, errors] = [drawn.output, drawn.errors].map(|output| match output {
        Output::Kept => None,
        Output::Full => Some(File::options().write(true).open("/dev/full").expect("a device").into()),
        Output::Unread | Output::Closed => {
            let (reader, writer) = pipe_without_reader(output == Output::Closed);
            readers.extend(reader);
            Some(Stdio::from(writer))
        }
    });
    let mut launch = place.start_writing([output, errors], &[], "disturbed", drawn.words);
    let is_due = |launch: &mut Launch| {
        if !drawn.starting {
            return launch.record("left").len() as u64 >= drawn.at;
        }
        let processes = launch.processes();
        let is_there = |role| processes.iter().any(|process| process.role == role);
        processes.len() as u64 >= drawn.at
            && !matches!(drawn.disturbance, Disturbance::Killed(role) if !is_there(role))
    };
    while !is_due(&mut launch) && launch.end_if_over().is_none() {
        launch.let_run(Duration::from_millis(1));
    }
    let processes = launch.processes();
    let killed = disturb(place, &mut launch, &processes, drawn.disturbance);
    // Who says how it ended, the launcher or a plant that draws, waits for its reader as any program does: nothing else of
    // the cell is left then, and it may be launched again.
    let last_words = || place.processes().iter().all(|left| left.role == "plant");
    wait_until(|| launch.end_if_over().is_some() || !readers.is_empty() && lasts(last_words));
    let again = launch.end_if_over().is_none().then(|| place.start("again", VIRTUAL).end());
    drop(readers);
    let status = launch.end();
    // A launcher that is gone leaves processes behind, which brake.
    wait_until(|| place.processes().is_empty());
    wait_for_end(&processes);
    let said = launch.said();
    let told = || format!("{number}: {drawn}, killed {killed:?}: {status}: {said}");
    assert!(!said.contains("it did not end when the cell closed"), "{}", told());
    assert!(!said.contains("panicked at"), "{}", told());
    assert!(again.is_none_or(|again| again.success()), "launched again: {again:?}; {}", told());
    // A launcher that is gone says nothing.
    let is_told = status.code().is_some();
    ROBOTS.iter().for_each(|robot| assert_within_limits(&launch, robot));
    let came = ROBOTS.map(|robot| {
        let came = standstill(&launch, robot, killed.as_ref(), is_told);
        came.unwrap_or_else(|moves| panic!("{robot} {moves}: {}", told()))
    });
    // It starts, runs to its end, and has removed what a killed launcher has left.
    let mut next = place.start("next", VIRTUAL);
    let status = next.end();
    assert!(status.success(), "the next launch: {status}: {}; after {}", next.said(), told());
    launch.assert_nothing_left(&[]);
    next.assert_nothing_left(&[]);
    assert!(place.sessions().is_empty(), "{:?}; after {}", place.sessions(), told());
    came
}

/// Whether something is so, and is still so a second later.
fn lasts(is_so: impl Fn() -> bool) -> bool {
    is_so() && {
        std::thread::sleep(Duration::from_secs(1));
        is_so()
    }
}

/// Disturbs a launch; the process that was killed.
fn disturb(
    place: &Place,
    launch: &mut Launch,
    processes: &[Process],
    disturbance: Disturbance,
) -> Option<Process> {
    match disturbance {
        Disturbance::Nothing => {}
        Disturbance::Ends(signal) => launch.signal(signal),
        Disturbance::KilledLauncher => launch.signal(Signal::KILL),
        Disturbance::Killed(role) => {
            let killed = processes.iter().find(|process| process.role == role).cloned();
            killed.iter().for_each(Process::kill);
            return killed;
        }
        Disturbance::Stops(signal) => stop(place, launch, signal),
        Disturbance::RemovedSession => {
            for session in place.sessions() {
                // What processes make meanwhile may keep it.
                let _ = fs::remove_dir_all(place.base().join(session));
            }
        }
        Disturbance::OtherUser => intrude(place),
    }
    None
}

/// Stops the launcher, which is continued when nothing moves any more.
fn stop(place: &Place, launch: &mut Launch, signal: Signal) {
    launch.signal(signal);
    // Drives without power are demanded nothing more.
    let is_off = |last: &Period| !last.powered && (last.stands() || last.switched_off);
    let rests = |launch: &Launch, robot: &str| {
        periods_at_rest(&launch.record(robot)) >= 200 || launch.drives(robot).last().is_some_and(is_off)
    };
    let stands = |launch: &Launch| ROBOTS.iter().all(|robot| rests(launch, robot));
    // Before it hears signals, a terminal's stop is that of any process.
    let over = |launch: &mut Launch| launch.end_if_over().is_some();
    wait_until(|| {
        over(launch) || launch.is_stopped() && (stands(launch) || launch.record("left").is_empty())
    });
    launch.signal(Signal::CONT);
    // What was suspended for the launcher stays so until the operator says otherwise. A launcher that was about to end has
    // suspended nothing.
    let may_resume = |launch: &mut Launch| !over(launch) && !place.sessions().is_empty();
    while signal == Signal::TSTP && may_resume(launch) && ask(place, &["resume"]).0 != Some(0) {
        launch.let_run(Duration::from_millis(20));
    }
}

/// Another user asks for what is the operator's alone, with folders of his own.
fn intrude(place: &Place) {
    let folder = place.base().parent().expect("a folder").join("other");
    fs::create_dir_all(&folder).expect("a folder");
    if !rustix::process::geteuid().is_root() {
        return println!("without another user: not root");
    }
    chown(&folder, Some(OTHER), Some(OTHER)).expect("given away");
    for word in [&["stop"][..], &["suspend"], &["status"], &["--processes"]] {
        let mut command = place.program(word);
        command.env("XDG_RUNTIME_DIR", &folder).uid(OTHER).gid(OTHER);
        // Where that user may not enter the folder of the program, it cannot start it.
        if let Ok(output) = command.output() {
            assert!(!output.status.success(), "{word:?}: {}", String::from_utf8_lossy(&output.stdout));
        }
    }
}

/// How a robot came to a standstill.
///
/// # Errors
/// How it still moves, or was left to its brakes without need.
fn standstill(launch: &Launch, robot: &str, killed: Option<&Process>, is_told: bool) -> Result<Came, String> {
    let is_killed = |role: &str| killed.is_some_and(|killed| killed.role == role);
    let (record, drives) = (launch.record(robot), launch.drives(robot));
    if is_killed("plant") {
        // There is no robot any more. Its EDP demands nothing after `L` periods without a reading, wherever it was.
        let without = record.len().saturating_sub(drives.len());
        return if without <= L + 2 {
            Ok(Came::Gone)
        } else {
            Err(format!("{without} demands to no drives"))
        };
    }
    let last = drives.last();
    if !last.is_none_or(|last| last.stands() || last.switched_off) {
        return Err(format!("moves: {last:?}"));
    }
    // An EDP takes the power away as soon as the last step of its braking is over.
    let has_come =
        periods_at_rest(&record) >= record.len().min(2) || last.is_some_and(|last| last.switched_off);
    match has_come {
        _ if is_killed(&format!("edp {robot}")) => Ok(Came::ByBrakes),
        true if drives.iter().all(Period::stands) => Ok(Came::Still),
        true => Ok(Came::ByDemand),
        false if !is_told => Ok(Came::Unsaid),
        // Its demands did not come in time: the outcome says so, where the launcher was not killed before it could write it.
        false if matches!(launch.outcome()["fault"]["kind"].as_str(), Some("PeerLost" | "Overrun")) => {
            Ok(Came::Late)
        }
        false => Err(format!("was left to its brakes: {:?}", record.last())),
    }
}
