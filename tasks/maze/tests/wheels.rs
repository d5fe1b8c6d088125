//! The base with wheels in the maze: the same coordinator, map and planner; no wall is touched.
//!
//! One maze and four by chance; `just maze-whole` takes thirty by chance.

use maze::options::EffectorKind;
use maze::summary::Summary;
use maze::wheels::plant::Traced;
use maze::wheels::run::Ready;
use mrroc::prelude::*;
use mrroc_wheels::sensing::infrared::SENSORS;
use mrroc_wheels::sensing::{Lookout, Sight, Watch};

use crate::usage::{islands, with_shipped};

/// One maze and so many by chance.
fn exits_are_found(count: u64) {
    let mazes: Vec<_> = with_shipped(count).into_iter().filter(|maze| maze.name != "comb").collect();
    let summary = Summary::sweep(EffectorKind::Wheels, &mazes);
    println!("{summary}");
    assert_eq!(summary.faults(), 0, "{summary}");
    for row in &summary.0 {
        // How deep the body pressed into a wall: never.
        assert!(row.travel == 0.0, "{summary}");
        assert!(row.ratio > 0.999, "{summary}");
    }
}

#[test]
fn a_base_finds_the_exit_and_touches_no_wall() {
    exits_are_found(4);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just maze-whole`"]
    fn a_base_finds_the_exit_and_touches_no_wall() {
        super::exits_are_found(30);
    }
}

#[test]
fn the_base_knows_where_it_stands_to_a_few_millimetres_at_the_end_of_the_maze() {
    /// The sensor, and how far it was wrong last.
    struct Checked(Traced, std::rc::Rc<std::cell::Cell<f64>>, mrroc_wheels::Floor);

    impl VirtualSensor for Checked {
        type Kind = Lookout;

        fn aggregate(&mut self, order: &ReadingOrder<Watch>) -> Result<Sight, Fault> {
            let sight = self.0.aggregate(order)?;
            self.1.set((sight.pose.at() - self.2.motion().pose.at()).norm());
            Ok(sight)
        }

        fn is_simulated(&self) -> bool {
            true
        }
    }

    let wrong = std::rc::Rc::new(std::cell::Cell::new(0.0));
    let seen = std::rc::Rc::clone(&wrong);
    let ready = Ready::sensed_by(&islands(), 0, |lookout| {
        let floor = lookout.floor().clone();
        Checked(lookout, seen, floor)
    });
    let outcome = ready.expect("a cell").run();
    outcome.report.expect("no fault");
    println!("after {:.1} m it is wrong by {:.1} mm", outcome.distance, 1e3 * wrong.get());
    // Put down 4 mm beside where it is said to stand at the worst; put right by walls since then.
    assert!(wrong.get() < 0.006, "{}", wrong.get());
}

#[test]
fn fault_178_a_base_whose_infrared_sensors_see_nothing_ends_with_a_named_fault_at_the_first_wall() {
    let ready = Ready::sensed_by(&islands(), 0, |mut lookout| {
        (0..SENSORS).for_each(|sensor| lookout.inner_mut().infrared_mut().blind(sensor));
        lookout
    });
    let outcome = ready.expect("a cell").run();
    let fault = outcome.report.expect_err("the wall is touched").to_string();
    assert!(fault.contains("bumper"), "{fault}");
}
