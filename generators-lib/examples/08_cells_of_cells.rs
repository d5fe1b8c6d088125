//! Two cells of an arm each are robots of one MP. One has a fault; the other goes on without it, until the operator of that
//! cell has reset it.
//!
//! `cargo run -p mrroc-examples --example 08_cells_of_cells`

use std::time::Duration;

use mrroc::cell::{AfterFault, LowerCell};
use mrroc::operator::Latch;
use mrroc::prelude::*;
use mrroc_generators::generators::JointMove;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

/// What the MP of the plant orders: loosely, and with data.
#[derive(Clone, Copy, Payload)]
enum Job {
    Turn { angle: f64 },
    Fetch,
}

/// One job for each cell.
struct Jobs(Job, Job);

#[generator(mp)]
fn jobs(c: &mut Jobs) -> Always<(LowerCell, LowerCell), Job> {
    Always((c.0, c.1))
}

#[condition(mp)]
fn is_back(e: &State<(LowerCell,)>) -> bool {
    e.0.is_ready()
}

// ANCHOR: lower
/// A cell of one arm. Its MP serves, and moves the arm as any MP does.
fn cell() -> Cell {
    let rest = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &rest));
    Cell::new(Duration::from_millis(2)).robot(arm).after_fault(AfterFault::AwaitReset).program(move |mp| {
        let mut arm = mp.robot::<Irp6>("arm")?;
        mp.serve_all(|mp, job: Job| match job {
            Job::Turn { angle } => {
                let there = JointMove::to(rest + Six::x() * angle, Six::repeat(0.4), Six::repeat(0.8));
                mp.move_robot(&mut arm, (), there).map(drop)
            }
            Job::Fetch => Err(Fault::thrown("there is no part")),
        })
    })
}
// ANCHOR_END: lower

/// Runs the example.
///
/// # Errors
/// When the plant stops with a fault.
pub fn main() -> Result<(), CellError> {
    let press = cell().on_step(|step, operator| {
        // Its operator comes three seconds after the start.
        if step > 1500 && operator.latch() == Latch::Latched {
            operator.acknowledge().and_then(|()| operator.reset()).expect("the arm stands");
        }
    });
    // ANCHOR: upper
    let plant = Cell::new(Duration::from_millis(4)).cell("press", press).cell("paint", cell());
    let plant = plant.program(|mp| {
        let (mut press, mut paint) = (mp.robot::<LowerCell>("press")?, mp.robot::<LowerCell>("paint")?);
        mp.go_on_without(&press)?;
        mp.move_robots((&mut press, &mut paint), (), Jobs(Job::Fetch, Job::Turn { angle: 0.5 }))?;
        println!("left out: {:?}", mp.left_out(&press)); // the paint cell has worked alone
        mp.wait_until((&mut press,), (), is_back {})?;
        let both = Jobs(Job::Turn { angle: 0.5 }, Job::Turn { angle: 0.0 });
        mp.move_robots((&mut press, &mut paint), (), both).map(drop)
    });
    // ANCHOR_END: upper
    let time = plant.run()?.time.as_secs_f64();
    println!("both have turned after {time:.3} s");
    assert!((4.75..4.85).contains(&time)); // 3 s, and 0.5 rad by 0.4 rad/s and 0.8 rad/s²
    Ok(())
}
