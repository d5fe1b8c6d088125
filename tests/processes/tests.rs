//! The tests, run one after the other: they start processes, which would disturb each other's time.

use std::collections::BTreeMap;
use std::fmt;
use std::panic::catch_unwind;
use std::process::ExitCode;
use std::time::Duration;

use rustix::process::Signal;

use crate::allocations::STEPS;
use crate::launch::{
    Launch, Period, Place, Process, demanded, periods_at_rest, segments, wait_for_end, wait_until,
};

/// Runs those whose names contain a word of the command line, or all.
pub fn main() -> ExitCode {
    let own: [(&str, fn()); 10] = [
        (
            "processes_under_the_virtual_clock_demand_the_same_to_the_bit_as_the_memory_link",
            processes_under_the_virtual_clock_demand_the_same_to_the_bit_as_the_memory_link,
        ),
        (
            "a_cell_of_processes_runs_in_real_time_and_leaves_nothing",
            a_cell_of_processes_runs_in_real_time_and_leaves_nothing,
        ),
        (
            "fault_01_to_03_robots_of_a_cell_of_which_a_process_is_killed_stand_within_the_bound",
            fault_01_to_03_robots_of_a_cell_of_which_a_process_is_killed_stand_within_the_bound,
        ),
        (
            "fault_06_a_process_that_stood_still_for_longer_than_the_budget_moves_nothing_afterwards",
            fault_06_a_process_that_stood_still_for_longer_than_the_budget_moves_nothing_afterwards,
        ),
        (
            "fault_07_a_kill_at_any_moment_ends_the_cell_cleanly",
            fault_07_a_kill_at_any_moment_ends_the_cell_cleanly,
        ),
        (
            "fault_28_a_second_launch_is_refused_with_the_number_of_the_first",
            fault_28_a_second_launch_is_refused_with_the_number_of_the_first,
        ),
        (
            "fault_30_what_crashed_launches_left_is_removed_and_does_no_harm",
            fault_30_what_crashed_launches_left_is_removed_and_does_no_harm,
        ),
        (
            "a_step_of_a_process_in_any_role_allocates_nothing",
            a_step_of_a_process_in_any_role_allocates_nothing,
        ),
        (
            "an_interrupt_ends_a_cell_whose_program_computes_for_ever",
            an_interrupt_ends_a_cell_whose_program_computes_for_ever,
        ),
        ("an_interrupt_aborts_and_ends_the_cell", an_interrupt_aborts_and_ends_the_cell),
    ];
    let all = own.iter().chain(&crate::operator::TESTS).chain(&crate::rows::TESTS);
    let words: Vec<_> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let mut failed = false;
    for (name, test) in all.filter(|(name, _)| words.is_empty() || words.iter().any(|w| name.contains(w))) {
        let passed = catch_unwind(test).is_ok();
        println!("test {name} ... {}", if passed { "ok" } else { "FAILED" });
        failed |= !passed;
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

pub const REAL: &[&str] = &["--processes", "--quiet"];
pub const VIRTUAL: &[&str] = &["--virtual", "--quiet"];
pub const MEMORY: &[&str] = &["--no-picture", "--quiet"];
pub const ROBOTS: [&str; 2] = ["left", "right"];

/// The processes of the cell.
pub const PROCESSES: [&str; 10] = [
    "mp",
    "ecp left",
    "ecp right",
    "edp left",
    "edp right",
    "plant",
    "vsp count",
    "vsp slow",
    "vsp free",
    "vsp shaft",
];

/// Steps that an EDP or the drives bridge, `L` at 2 ms.
const L: usize = 10;

/// Servo periods in which a robot's brakes bring it to a standstill; as long as its own braking may take.
const BRAKES: usize = 108;

/// Steps in which a robot must stand after a process is gone, `L + 2 + T_b`: at 2 ms `L` = 10, and the IRp-6 brakes from
/// 1.5 rad/s at 7 rad/s2 in 108 steps; two more until its drives are where the last demand was.
const BOUND: usize = L + 2 + 108 + 2;

fn processes_under_the_virtual_clock_demand_the_same_to_the_bit_as_the_memory_link() {
    let place = Place::new(0);
    let mut memory = place.start("memory", MEMORY);
    assert!(memory.end().success(), "{}", memory.said());
    let mut processes = place.start("virtual", VIRTUAL);
    assert!(processes.end().success(), "{}", processes.said());
    for robot in ROBOTS {
        let record = memory.record(robot);
        // 1 s out, 1.5 s back and 1 s of tight motion, in periods of 2 ms.
        assert!(record.len() > 1750, "{}", record.len());
        assert_eq!(record, processes.record(robot), "{robot}");
        // So did the drives, until their commands stopped.
        let (own, apart) = (memory.drives(robot), processes.drives(robot));
        assert!(own.len() >= record.len() && apart.starts_with(&own), "{robot}");
        assert!(apart.len() - own.len() <= L + 1, "{robot}");
    }
    processes.assert_nothing_left(&[]);
}

fn a_cell_of_processes_runs_in_real_time_and_leaves_nothing() {
    let place = Place::new(1);
    let mut launch = place.start("real", REAL);
    let status = launch.end();
    assert_ended_well_or_late(&launch, status.code());
    assert_robots_stand(&launch, None);
    launch.assert_nothing_left(&[]);
}

/// A machine without a real-time scheduler may be late for more than `L` steps: that is a fault of one of few kinds, and
/// nothing else may be wrong.
fn assert_ended_well_or_late(launch: &Launch, status: Option<i32>) {
    let said = launch.said();
    match status {
        Some(0) => assert_eq!(said, ""),
        Some(1) => assert!(is_late(&said), "{said}"),
        _ => panic!("status {status:?}: {said}"),
    }
}

pub fn is_late(said: &str) -> bool {
    [
        "the process at the other end is gone",
        "too many steps were missed",
        "demanded acceleration exceeds",
        "demanded velocity exceeds",
    ]
    .iter()
    .any(|kind| said.contains(kind))
}

/// A robot stands when its EDP goes, and whatever was killed, its drives stand when the plant goes. One whose EDP was killed
/// is not told anything more, and without the plant there is no robot.
pub fn assert_robots_stand(launch: &Launch, killed: Option<&Process>) {
    let is_killed = |role: &str| killed.is_some_and(|killed| killed.role == role);
    if is_killed("plant") {
        return;
    }
    for robot in ROBOTS {
        let record = launch.record(robot);
        assert!(
            is_killed(&format!("edp {robot}")) || rests(launch, robot),
            "{robot}, {killed:?}: {:?}: {}",
            &record[record.len().saturating_sub(8)..],
            launch.said()
        );
        let drives = launch.drives(robot);
        let stands = |last: &Period| last.stands() || last.switched_off;
        assert!(drives.last().is_none_or(stands), "{robot}: {:?}", drives.last());
    }
}

/// Whether a robot's demands rest, or its drives are without power: switched off by their EDP, or braked for want of demands.
/// Where a machine stood still, a robot may have had one period only: it has not been asked to be anywhere else.
pub fn rests(launch: &Launch, robot: &str) -> bool {
    let record = launch.record(robot);
    periods_at_rest(&record) >= record.len().min(2)
        || launch.drives(robot).last().is_some_and(|last| !last.powered)
}

fn fault_01_to_03_robots_of_a_cell_of_which_a_process_is_killed_stand_within_the_bound() {
    let place = Place::new(2);
    let mut reference = place.start("reference", MEMORY);
    assert!(reference.end().success(), "{}", reference.said());
    let mut random = Random::new();
    let (mut stopped, mut braked, mut tally) = (0, 0, Killed::default());
    for kill in 0..kills() {
        let mut launch = place.start("killed", VIRTUAL);
        let role = PROCESSES[kill % PROCESSES.len()];
        let (killed, processes) = kill_one(&mut launch, role, random.below(1_200_000));
        tally.count(killed.as_ref());
        let status = launch.end().code();
        let said = launch.said();
        assert!(matches!(status, Some(0 | 1)), "kill {kill}, {killed:?}: {status:?}: {said}");
        let is_killed = |role: &str| killed.as_ref().is_some_and(|killed| killed.role == role);
        for robot in ROBOTS {
            if is_killed(&format!("edp {robot}")) {
                assert_drives_brake(&launch, robot);
                braked += 1;
                continue;
            }
            let (record, whole) = (launch.record(robot), reference.record(robot));
            let same = record.iter().zip(&whole).take_while(|(a, b)| a == b).count();
            let moved = record.len() - (periods_at_rest(&record).max(1) - 1);
            let after = moved.saturating_sub(same);
            assert!(after <= BOUND, "kill {kill}, {killed:?}: {robot} stood {after} steps after it: {said}");
        }
        stopped += usize::from(status == Some(1));
        launch.assert_nothing_left(&processes);
    }
    println!(
        "{} launches in lock-step, killed: {tally}; {stopped} cells stopped, {braked} robots stood by their drives' brakes \
         (seed {})",
        kills(),
        random.seed
    );
}

/// Row 1: drives whose EDP is gone bridge `L` steps, then brake, and stand.
fn assert_drives_brake(launch: &Launch, robot: &str) {
    let (commanded, drives) = (launch.record(robot).len(), launch.drives(robot));
    let Some(last) = drives.last() else { return };
    let braked = drives.iter().position(|period| !period.powered).expect("they brake");
    // The EDP may be gone before it has written what it commanded last.
    let bridged = braked.saturating_sub(commanded);
    assert!((L..=L + 1).contains(&bridged), "{robot}: {bridged} periods bridged");
    let braking = drives[braked..].iter().take_while(|period| !period.stands()).count();
    assert!(braking <= BRAKES && last.stands(), "{robot}: {braking} periods");
    assert!(drives[braked..].iter().all(|period| !period.powered), "{robot}: powered again");
}

fn fault_06_a_process_that_stood_still_for_longer_than_the_budget_moves_nothing_afterwards() {
    let place = Place::new(7);
    for role in ["mp", "ecp left"] {
        let mut launch = place.start("stopped", REAL);
        while launch.record("left").len() < 100 {
            assert!(launch.end_if_over().is_none(), "{}", launch.said());
            launch.let_run(Duration::from_millis(1));
        }
        let processes = launch.processes();
        let stopped = processes.iter().find(|process| process.role == role).expect("it runs").clone();
        stopped.signal(Signal::STOP);
        // Far more than the 22 ms after which its robots brake: they are seen to stand, or their EDPs have left them so.
        let edps: Vec<_> = processes.iter().filter(|process| process.role.starts_with("edp")).collect();
        let stands = |robot| periods_at_rest(&launch.record(robot)) >= 200;
        wait_until(|| ROBOTS.into_iter().all(stands) || edps.iter().all(|edp| !edp.is_alive()));
        let stood = ROBOTS.map(|robot| launch.record(robot));
        launch.let_run(Duration::ZERO);
        stopped.signal(Signal::CONT);
        assert_eq!(launch.end().code(), Some(1), "{role}: {}", launch.said());
        for (robot, stood) in ROBOTS.into_iter().zip(stood) {
            let (record, last) = (launch.record(robot), stood.last().expect("it moved"));
            assert!(rests(&launch, robot), "{role}: {robot}");
            assert!(
                record[stood.len()..].iter().all(|line| demanded(line) == demanded(last)),
                "{role}: {robot}"
            );
        }
        launch.assert_nothing_left(&processes);
    }
}

fn fault_07_a_kill_at_any_moment_ends_the_cell_cleanly() {
    let place = Place::new(3);
    let mut random = Random::new();
    let (mut ran_on, mut stopped, mut late, mut tally) = (0, 0, 0, Killed::default());
    for kill in 0..kills() {
        let mut launch = place.start("killed", REAL);
        // Each process dies while the cell starts in one of two launches, and while robots move in the other.
        let starting = kill % 2 == kill / PROCESSES.len() % 2;
        while !starting && launch.record("left").is_empty() && launch.end_if_over().is_none() {
            launch.let_run(Duration::from_millis(1));
        }
        let role = PROCESSES[kill % PROCESSES.len()];
        let within = if starting { 300_000 } else { 3_500_000 };
        let (killed, processes) = kill_one(&mut launch, role, random.below(within));
        tally.count(killed.as_ref());
        let status = launch.end().code();
        let said = launch.said();
        match status {
            Some(0) => ran_on += 1,
            Some(1) if said.contains("killed by signal 9") => stopped += 1,
            Some(1) => {
                assert!(is_late(&said), "kill {kill}, {killed:?}: {said}");
                late += 1;
            }
            _ => panic!("kill {kill}, {killed:?}: status {status:?}: {said}"),
        }
        assert_robots_stand(&launch, killed.as_ref());
        launch.assert_nothing_left(&processes);
        assert!(place.sessions().is_empty());
    }
    let mut next = place.start("next", VIRTUAL);
    assert!(next.end().success(), "{}", next.said());
    println!(
        "{} launches in real time, killed: {tally}; {ran_on} cells ran on or started again, {stopped} stopped for the killed \
         process, {late} were late (seed {})",
        kills(),
        random.seed
    );
}

/// How often each process was killed.
#[derive(Default)]
struct Killed(BTreeMap<String, usize>);

impl Killed {
    fn count(&mut self, killed: Option<&Process>) {
        let role = killed.map_or("none, the cell was over", |killed| &killed.role);
        *self.0.entry(role.to_owned()).or_default() += 1;
    }
}

impl fmt::Display for Killed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for (role, count) in &self.0 {
            write!(f, "{separator}{role} {count}")?;
            separator = ", ";
        }
        Ok(())
    }
}

/// Kills the process of a role after so many microseconds, or as soon as it is there; says which that was, and which there
/// were. None when the cell is over by then.
fn kill_one(launch: &mut Launch, role: &str, micros: u64) -> (Option<Process>, Vec<Process>) {
    launch.let_run(Duration::from_micros(micros));
    loop {
        let processes = launch.processes();
        let killed = processes.iter().find(|process| process.role == role).cloned();
        if let Some(killed) = &killed {
            killed.kill();
        }
        if killed.is_some() || launch.end_if_over().is_some() {
            return (killed, processes);
        }
        launch.let_run(Duration::from_millis(1));
    }
}

fn fault_28_a_second_launch_is_refused_with_the_number_of_the_first() {
    let place = Place::new(4);
    let mut first = place.start("first", VIRTUAL);
    while first.processes().len() < PROCESSES.len() {
        first.let_run(Duration::from_millis(1));
    }
    let mut second = place.start("second", REAL);
    assert_eq!(second.end().code(), Some(2));
    let said = second.said();
    assert!(said.contains(&format!("run by process {} already", first.pid())), "{said}");
    assert!(first.end().success(), "{}", first.said());
    // The first one is undisturbed.
    let mut alone = place.start("alone", MEMORY);
    assert!(alone.end().success());
    assert!(ROBOTS.iter().all(|robot| alone.record(robot) == first.record(robot)));
}

fn fault_30_what_crashed_launches_left_is_removed_and_does_no_harm() {
    let place = Place::new(5);
    let mut crashed = place.start("crashed", REAL);
    // Killed as soon as its robots move.
    while crashed.record("left").len() < 20 {
        assert!(crashed.end_if_over().is_none(), "{}", crashed.said());
        crashed.let_run(Duration::from_millis(1));
    }
    let processes = crashed.processes();
    assert_eq!(processes.len(), PROCESSES.len(), "{processes:?}");
    crashed.signal(Signal::KILL);
    crashed.end();
    // Without their launcher all end, and the robots stand.
    wait_for_end(&processes);
    assert_robots_stand(&crashed, None);
    let left = place.sessions();
    assert_eq!(&left, crashed.had());
    let left_segments: usize = left.iter().map(|session| segments(session).len()).sum();
    // A hundred more, in all stages of a start, and files of others.
    for number in 0_u64..100 {
        let session = place.base().join(format!("0123abcd-{number:012x}"));
        std::fs::create_dir(&session).expect("a folder");
        if number % 2 == 0 {
            std::fs::write(session.join("lock"), "").expect("a file");
            std::fs::write(format!("/dev/shm/mrroc_{number:012x}_x.data"), "").expect("a segment");
        }
    }
    let foreign = place.base().join("notes-of-mine");
    std::fs::write(&foreign, "").expect("a file");
    let mut next = place.start("next", VIRTUAL);
    assert!(next.end().success(), "{}", next.said());
    let mut memory = place.start("memory", MEMORY);
    assert!(memory.end().success());
    assert!(ROBOTS.iter().all(|robot| memory.record(robot) == next.record(robot)));
    assert_eq!(place.sessions().into_iter().collect::<Vec<_>>(), ["notes-of-mine"]);
    for session in left.iter().cloned().chain((0..100).map(|number| format!("0123abcd-{number:012x}"))) {
        assert_eq!(segments(&session), Vec::<String>::new());
    }
    println!("a crashed launch left {left_segments} segments; the next one removed them, and 100 sessions");
}

fn a_step_of_a_process_in_any_role_allocates_nothing() {
    let place = Place::new(8);
    let roles = ["mp", "ecp", "edp left", "edp right", "plant left", "plant right", "vsp count", "vsp free"];
    for (counts, arguments) in [("virtual", VIRTUAL), ("real", REAL)] {
        let mut launch = place.count(counts, arguments);
        let status = launch.end().code();
        assert_ended_well_or_late(&launch, status);
        let mut counted = 0;
        for role in roles {
            let text = launch.text(role);
            // A cell that was too late for its machine has not come so far.
            assert!(!text.is_empty() || status == Some(1), "{role} of {counts} has not been counted");
            assert!(text.is_empty() || text == "0", "{role} of {counts}: {text} allocations");
            counted += usize::from(!text.is_empty());
        }
        println!("{counts}: no allocations in {STEPS} steps of {counted} of {} roles", roles.len());
    }
}

fn an_interrupt_aborts_and_ends_the_cell() {
    let place = Place::new(6);
    let mut launch = place.start("interrupted", REAL);
    while launch.record("left").len() < 100 {
        assert!(launch.end_if_over().is_none(), "{}", launch.said());
        launch.let_run(Duration::from_millis(1));
    }
    let processes = launch.processes();
    launch.signal(Signal::INT);
    let status = launch.end().code();
    let said = launch.said();
    assert!(status == Some(1) && (said.contains("abort") || is_late(&said)), "{status:?}: {said}");
    assert_robots_stand(&launch, None);
    assert!(launch.record("left").last().map(|line| demanded(line).to_owned()).is_some());
    launch.assert_nothing_left(&processes);
}

fn an_interrupt_ends_a_cell_whose_program_computes_for_ever() {
    let place = Place::new(9);
    let mut launch = place.start_for(crate::program::COMPUTES, "computes", REAL);
    while launch.processes().len() < PROCESSES.len() {
        assert!(launch.end_if_over().is_none(), "{}", launch.said());
        launch.let_run(Duration::from_millis(1));
    }
    let processes = launch.processes();
    launch.signal(Signal::INT);
    let status = launch.end().code();
    let said = launch.said();
    assert!(status == Some(1) && said.contains("did not end when the cell closed"), "{status:?}: {said}");
    launch.assert_nothing_left(&processes);
}

/// How many kills a test makes.
fn kills() -> usize {
    std::env::var("MRROC_KILLS").ok().and_then(|count| count.parse().ok()).unwrap_or(10)
}

/// A seeded generator (xorshift64): the seed is printed and may be given again.
struct Random {
    seed: u64,
    state: u64,
}

impl Random {
    fn new() -> Random {
        let seed = std::env::var("MRROC_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(20_260_926);
        Random { seed, state: seed }
    }

    fn below(&mut self, limit: u64) -> u64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        self.state % limit.max(1)
    }
}
