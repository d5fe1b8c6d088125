//! Processes that are killed at any moment.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

use crate::launch::{Launch, Place, Process, periods_at_rest};
use crate::runs::{L, MEMORY, PROCESSES, ROBOTS, VIRTUAL};

/// Servo periods in which a robot's brakes bring it to a standstill; as long as its own braking may take.
const BRAKES: usize = 108;

/// Steps in which a robot must stand after a process is gone, `L + 2 + T_b`: at 2 ms `L` = 10, and the IRp-6 brakes from
/// 1.5 rad/s at 7 rad/s2 in 108 steps; two more until its drives are where the last demand was.
const BOUND: usize = L + 2 + 108 + 2;

#[test]
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

/// Fault 1: drives whose EDP is gone bridge `L` steps, then brake to a standstill.
fn assert_drives_brake(launch: &Launch, robot: &str) {
    let (commanded, drives) = (launch.record(robot).len(), launch.drives(robot));
    let Some(last) = drives.last() else { return };
    let braked = drives.iter().position(|period| !period.powered).expect("they brake");
    // The EDP may be gone before it has written its last demand.
    let bridged = braked.saturating_sub(commanded);
    assert!((L..=L + 1).contains(&bridged), "{robot}: {bridged} periods bridged");
    let braking = drives[braked..].iter().take_while(|period| !period.stands()).count();
    assert!(braking <= BRAKES && last.stands(), "{robot}: {braking} periods");
    assert!(drives[braked..].iter().all(|period| !period.powered), "{robot}: powered again");
}

/// How often each process was killed.
#[derive(Default)]
pub struct Killed(BTreeMap<String, usize>);

impl Killed {
    /// One launch more.
    pub fn count(&mut self, killed: Option<&Process>) {
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

/// Kills the process of a role after so many microseconds, or as soon as the process exists. Returns that process and
/// all processes; `None` if the cell is over by then.
pub fn kill_one(launch: &mut Launch, role: &str, micros: u64) -> (Option<Process>, Vec<Process>) {
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

/// How many kills a test makes.
pub fn kills() -> usize {
    std::env::var("MRROC_KILLS").ok().and_then(|count| count.parse().ok()).unwrap_or(10)
}

/// A seeded generator (xorshift64): the seed is printed and may be given again.
pub struct Random {
    pub seed: u64,
    state: u64,
}

impl Random {
    pub fn new() -> Random {
        let seed = std::env::var("MRROC_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(20_260_926);
        Random { seed, state: seed }
    }

    pub fn below(&mut self, limit: u64) -> u64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        self.state % limit.max(1)
    }
}
