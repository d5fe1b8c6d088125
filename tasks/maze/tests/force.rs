//! A force sensor at the wrist: the ball slides along walls, needs fewer touches, and what is wrong with the sensor is named.
//!
//! The shipped mazes and one by chance; `just maze-whole` takes thirty.

use maze::force::sensor::{Failing, Felt, Going, WallForce, Wrist};
use maze::options::Means;
use maze::plant::stylus::TRAVEL;
use maze::run::Ready;
use maze::summary::Summary;
use mrroc::prelude::*;

use crate::usage::{islands, with_shipped};

/// The shipped mazes and so many by chance.
fn exits_are_found(count: u64) {
    let mazes = with_shipped(count);
    let [probe, force] = [Means::Probe, Means::Force].map(|means| Summary::sweep(means, &mazes));
    println!("{probe}\n{force}");
    assert_eq!(force.faults(), 0, "{force}");
    for row in &force.0 {
        assert!(row.travel < TRAVEL && row.ratio > 0.999, "{force}");
    }
}

#[test]
fn the_exit_is_found_by_force_without_a_fault_or_over_travel() {
    exits_are_found(1);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just maze-whole`"]
    fn the_exit_is_found_by_force_without_a_fault_or_over_travel() {
        super::exits_are_found(30);
    }
}

#[test]
fn the_ball_slides_along_walls_and_the_map_has_them_where_they_are() {
    let ready = Ready::by_force(&islands(), 3, |wrist| wrist).expect("a cell");
    let world = ready.plant.world();
    let outcome = ready.run();
    outcome.report.expect("no fault");
    let world = world.borrow();
    let off = |at| world.walls.near(at).map(|wall| wall.distance(at)).fold(1.0, f64::min);
    let mut offs: Vec<f64> = outcome.contacts.iter().map(|contact| off(&contact.at)).collect();
    offs.sort_by(f64::total_cmp);
    println!(
        "off the walls: p90 {:.2} mm, worst {:.2} mm",
        1e3 * offs[offs.len() * 9 / 10],
        1e3 * offs[offs.len() - 1]
    );
    // What the map takes for one line, 6 % of a wall's length: beyond that a panel would not be known by its slide.
    assert!(offs[offs.len() - 1] < 0.06 * outcome.sizes.pitch);
    // Along each wall many more places are known than touches were needed.
    assert!(outcome.contacts.len() > 2 * outcome.touches, "{}", outcome.touches);
}

/// A sensor of which every seventh reading points in the other direction, as a light force does now and then.
struct Turning(Wrist);

impl VirtualSensor for Turning {
    type Kind = WallForce;

    fn aggregate(&mut self, order: &ReadingOrder<Going>) -> Result<Felt, Fault> {
        let felt = self.0.aggregate(order)?;
        Ok(if order.step.is_multiple_of(7) { Felt { force: felt.force.map(|of| -of), ..felt } } else { felt })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

#[test]
fn fault_243_a_retreat_that_presses_the_ball_to_a_wall_is_followed_by_one_that_frees_it() {
    let outcome = Ready::by_force(&islands(), 3, Turning).expect("a cell").run();
    outcome.report.expect("the exit is found");
    assert!(outcome.travel < TRAVEL, "{} m", outcome.travel);
}

/// A sensor that fails from a step on.
struct Broken {
    wrist: Wrist,
    from: u64,
    how: Option<Failing>,
}

impl VirtualSensor for Broken {
    type Kind = WallForce;

    fn aggregate(&mut self, order: &ReadingOrder<Going>) -> Result<Felt, Fault> {
        if order.step >= self.from {
            match self.how {
                Some(how) => self.wrist.fail(Some(how)),
                None => return Err(Fault::thrown("the cable of the force sensor is off")),
            }
        }
        self.wrist.aggregate(order)
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

/// The fault of a run whose sensor fails so, and how far the stylus was bent \[m\].
fn broken(from: u64, how: Option<Failing>) -> (String, f64) {
    let ready = Ready::by_force(&islands(), 0, |wrist| Broken { wrist, from, how }).expect("a cell");
    let outcome = ready.run();
    (outcome.report.expect_err("a fault").to_string(), outcome.travel)
}

/// Steps of 4 ms into the run: while the frame is looked for, and in legs and slides between the walls.
const STEPS: [u64; 4] = [1200, 3200, 4000, 5000];

#[test]
fn fault_236_a_force_sensor_that_is_lost_or_saturates_is_a_named_fault_and_the_arm_stops() {
    for from in STEPS {
        let (fault, travel) = broken(from, None);
        assert!(fault.contains("force") && fault.contains("cable"), "{fault}");
        assert!(travel < TRAVEL, "{travel} m, from step {from}");
        let (fault, travel) = broken(from, Some(Failing::Saturated));
        assert!(fault.contains("saturates"), "{fault}");
        assert!(travel < TRAVEL, "{travel} m, from step {from}");
    }
}

#[test]
fn fault_219_a_force_sensor_that_stands_at_one_value_is_a_named_fault_and_the_arm_stops() {
    for from in STEPS {
        let (fault, travel) = broken(from, Some(Failing::Stuck));
        assert!(fault.contains("stands at one value"), "from step {from}: {fault}");
        assert!(travel < TRAVEL, "from step {from}: {travel} m");
    }
}
