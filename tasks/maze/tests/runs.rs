//! Undisturbed runs: the exit is found by touch alone.
//!
//! A few mazes; `just maze-whole` takes a hundred by chance.

use maze::mazes::Seeded;
use maze::places::{HIGH, LOOSE, LOW, Sizes, TURNED, said, tool};
use maze::plant::stylus::TRAVEL;
use maze::run::Ready;
use maze::summary::Summary;
use mrroc::prelude::*;
use mrroc_robots::Irp6;
use nalgebra::{Point3, Vector3};

use crate::usage::camera::START;
use crate::usage::with_shipped;

/// The shipped mazes and so many by chance.
fn exits_are_found(count: u64) {
    let summary = Summary::sweep(maze::options::EffectorKind::Arm, &with_shipped(count));
    println!("{summary}");
    assert_eq!(summary.faults(), 0, "{summary}");
    for row in &summary.0 {
        assert!(row.travel < TRAVEL, "{summary}");
        // No path of a ball is shorter than the shortest one, which is 0.3 % too short at most.
        assert!(row.ratio > 0.999, "{summary}");
    }
}

#[test]
fn the_exit_is_found_by_touch_without_a_fault_or_over_travel() {
    exits_are_found(1);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just maze-whole`"]
    fn the_exit_is_found_by_touch_without_a_fault_or_over_travel() {
        super::exits_are_found(100);
    }
}

#[test]
fn the_left_hand_rule_goes_round_an_island_where_the_map_finds_the_exit() {
    let [islands, _] = Seeded::shipped(0).expect("mazes");
    assert_eq!(islands.layout.cells_by_the_left_hand(), None);
}

#[test]
fn the_same_seed_gives_the_same_run_to_the_bit() {
    let [_, comb] = Seeded::shipped(4).expect("mazes");
    let [one, two] = [(), ()].map(|()| Ready::new(&comb.layout, comb.seed).expect("a cell").run());
    assert!(
        one.distance.to_bits() == two.distance.to_bits()
            && one.trace == two.trace
            && one.contacts == two.contacts
    );
}

#[test]
fn all_corners_of_a_maze_are_within_reach_wherever_it_stands() {
    let arm = Irp6::nominal();
    let (lower, upper) = (arm.limits().lower, arm.limits().upper);
    // Beside it, as at the start; from there on from corner to corner.
    let mut near = START.into();
    let side = 16.0 * Sizes::CLASSIC.pitch;
    let middle = Pose::translation(0.5 * side, 0.5 * side, 0.0);
    for turn in [-TURNED, TURNED] {
        let turned = middle * Pose::rotation(Vector3::z() * turn) * middle.inverse();
        for (x, y) in [(0.0, 0.0), (0.0, side), (side, side), (side, 0.0)] {
            for (off_x, off_y) in [(-LOOSE, -LOOSE), (-LOOSE, LOOSE), (LOOSE, LOOSE), (LOOSE, -LOOSE)] {
                for height in [LOW, HIGH] {
                    let corner = said([side, side]) * turned * Point3::new(x, y, 0.0);
                    // The flange is 0.25 m over the ball.
                    let flange =
                        tool(corner.x + off_x, corner.y + off_y, height) * Pose::translation(0.0, 0.0, -0.25);
                    near = arm.inverse(&flange, &near).expect("within reach");
                    assert!((0..6).all(|i| lower[i] < near[i] && near[i] < upper[i]), "{corner}: {near:?}");
                }
            }
        }
    }
}
