//! Processes that are killed at any moment, in real time.

use std::time::Duration;

use crate::kills::{Killed, Random, kill_one, kills};
use crate::launch::Place;
use crate::runs::{PROCESSES, REAL, VIRTUAL};
use crate::sound::{Ended, assert_sound};

#[test]
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
        println!("kill {kill}: {killed:?}: {said}");
        match assert_sound(&launch, status, killed.as_ref(), |_, text| text.contains("killed by signal 9")) {
            Ended::Well => ran_on += 1,
            Ended::Stopped => stopped += 1,
            Ended::Late => late += 1,
        }
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
