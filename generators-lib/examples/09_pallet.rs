//! An arm takes parts from one pallet, as they come, and sets them down on another: a simulated world of bodies and fingers.
//!
//! `cargo run -p mrroc-examples --example 09_pallet`

use std::time::Duration;

use mrroc::prelude::*;
use mrroc_generators::generators::{JointMove, StraightLine};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::grasp::{Body, Grasp, Jaws, Pads, Table, World};
use mrroc_robots::{Gripper, Irp6, One, Simulated, SimulatedIrp6};

/// Where the parts are on a pallet, from its middle along the fingers and across them \[m\].
const GRID: [[f64; 2]; 4] = [[-0.06, -0.04], [0.06, -0.04], [-0.06, 0.04], [0.06, 0.04]];
/// The middles of both pallets, across the fingers from the tool at its start \[m\].
const PALLETS: [f64; 2] = [-0.12, 0.12];
/// How far the fingers go down to a part \[m\], and its edges \[m\].
const DOWN: f64 = 0.1;
const EDGES: [f64; 3] = [0.065, 0.04, 0.04];

/// `X_WE` over a place of a pallet, so far below the start; the fingers point down.
fn over(pallet: usize, [x, y]: [f64; 2], down: f64) -> Pose {
    Irp6::nominal().forward(&Irp6::READY) * Pose::translation(x, PALLETS[pallet] + y, down)
}

fn move_all(mp: &mut Mp) -> Result<(), Fault> {
    let (mut arm, mut hand) = (mp.robot::<Irp6>("arm")?, mp.robot::<Gripper>("hand")?);
    let limits = ProfileLimits { velocity: 0.2, acceleration: 0.5 };
    let limits = ToolLimits { translation: limits, rotation: limits };
    let fingers = |opening| JointMove::to(One::new(opening), One::new(0.008), One::new(0.018));
    for place in GRID {
        // From the first pallet by closing the fingers on the part, onto the second by opening them.
        for (pallet, opening) in [(0, 0.055), (1, 0.08)] {
            mp.move_robot(&mut arm, (), StraightLine::to(over(pallet, place, 0.0), limits))?;
            mp.move_robot(&mut arm, (), StraightLine::to(over(pallet, place, DOWN), limits))?;
            mp.move_robot(&mut hand, (), fingers(opening))?;
            mp.move_robot(&mut arm, (), StraightLine::to(over(pallet, place, 0.0), limits))?;
        }
    }
    Ok(())
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault, or a figure of the world is out of range.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The table is below the parts, between whose pads the fingers come to rest.
    let height = |down| over(0, [0.0, 0.0], down).translation.z;
    let table = Table::at(height(DOWN) - 0.5 * EDGES[2]).with_stiffness(4e3, 12.0); // as of rubber
    let world = World::empty().with_table(table)?;
    for (number, place) in GRID.into_iter().enumerate() {
        let part = Body::block(0.3, EDGES).at(over(0, place, DOWN - 1e-3));
        world.put_at(&part, 5.0 * number as f64)?; // one every 5 s
    }
    let drives = world.arm(SimulatedIrp6::new(Irp6::nominal(), &Irp6::READY), Grasp::new(2e4, 20.0))?;
    let jaws = Jaws::new(
        Simulated::new(Gripper::new(), &One::new(0.08)),
        drives.hand(),
        Pads::new(0.024, 0.01), // [m] wide, and ahead of the tool's frame
    )?;
    let fingers = drives.hand();
    let cell = Cell::new(Duration::from_millis(2))
        .robot(RobotSetup::new("arm", Irp6::nominal(), drives))
        .robot(RobotSetup::new("hand", Gripper::new(), jaws).following_error(One::new(0.04)))
        .program(move_all);
    let report = cell.run()?;

    let off = GRID.into_iter().enumerate().map(|(number, place)| {
        let part = world.body_of(number).expect("no part leaves the world");
        over(1, place, DOWN).inv_mul(&part.pose).translation.vector.norm()
    });
    let farthest = off.fold(0.0, f64::max);
    println!("4 parts in {:.1} s, at most {:.2} mm off", report.time.as_secs_f64(), farthest * 1e3);
    // The fingers centre a part; the arm is within 0.2 mm of its demand, and lets parts fall by less than 1 mm.
    assert!(farthest < 1.5e-3 && fingers.crashes() == 0);
    Ok(())
}
