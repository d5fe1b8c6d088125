//! Moves an FR3 to its middle position, and from there to and fro: `cargo run -p mrroc-examples --example franka -- --cell robots/drivers/franka/examples/cell.toml
//! --simulated`, and with `--processes` in its place where a robot is at the address of that file.
//!
//! `--times` behind a `--` says how often, once by default; each time takes five seconds.

use std::time::Duration;

use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc_franka::{Collision, FciSettings, Fr3, with_franka_as};
use mrroc_generators::generators::JointMove;
use mrroc_robots::{Seven, simulated};

/// Where the arm is far from the ends of its range \[rad\].
const MIDDLE: [f64; 7] = [0.0, 0.0, 0.0, -1.57, 0.0, 1.57, 0.785];

/// Where the robot takes something for a collision.
const COLLISION: Collision = Collision {
    contact_torques: [20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0],
    collision_torques: [20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0],
    contact_forces: [20.0, 20.0, 20.0, 25.0, 25.0, 25.0],
    collision_forces: [20.0, 20.0, 20.0, 25.0, 25.0, 25.0],
};

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    // A simulator may be late for longer than a robot, whose settings are those of `with_franka`.
    let settings = |robot| FciSettings {
        silence: Duration::from_millis(100),
        collision: Some(COLLISION),
        stiffness: [Some([3000.0, 3000.0, 3000.0, 2500.0, 2500.0, 2000.0, 2000.0]), Some([300.0; 7]), None],
        ..FciSettings::new(robot)
    };
    Ok(file.cell(&with_franka_as(simulated(), settings))?.program(to_and_fro))
}

fn to_and_fro(mp: &mut Mp) -> Result<(), Fault> {
    let times = own_number("times", 1)?;
    let mut arm = mp.robot::<Fr3>("arm")?;
    let here = Seven::from(MIDDLE);
    mp.move_robot(&mut arm, (), JointMove::to(here, Seven::repeat(0.3), Seven::repeat(0.6)))?;
    let there = here + Seven::from([0.4, 0.2, -0.3, 0.4, 0.3, 0.3, -0.5]);
    for _ in 0..times {
        for goal in [there, here] {
            mp.move_robot(&mut arm, (), JointMove::to(goal, Seven::repeat(0.3), Seven::repeat(0.6)))?;
        }
    }
    Ok(())
}
