//! Two arms, tightly: the MP computes a number for every step, and an operator suspends both on their paths.
//!
//! `cargo run -p mrroc-examples --example 04_tight`

use std::time::Duration;

use mrroc::prelude::*;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

/// What the MP orders: numbers make the cooperation tight.
#[derive(Clone, Copy, Payload)]
struct Turn {
    angle: f64,
}

/// The MP's half of the motion: both columns by the same angle, smoothly within three seconds of path time.
struct Together {
    t: f64,
}

#[generator(mp)]
fn together(c: &mut Together, t: Tick) -> Step<(Irp6, Irp6), Turn> {
    if c.t >= 3.0 {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(3.0);
    let u = c.t / 3.0;
    let order = Turn { angle: 0.4 * u * u * (3.0 - 2.0 * u) };
    Step::Next((order, order))
}

/// The ECP's half: adds what the MP orders to where the arm was.
struct Follow {
    from: Six,
}

#[generator(ecp, first = start)]
fn follow(order: &Order<Turn>, c: &mut Follow) -> Step<Irp6> {
    let mut q = c.from;
    q[0] += order.value().angle;
    Step::Next(Demand::joints(q))
}

fn start(order: &Order<Turn>, c: &mut Follow, e: &State<Irp6>) -> Step<Irp6> {
    c.from = e.demanded().joints;
    follow(order, c)
}

/// The program of either arm's ECP.
fn arm(ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
    ecp.serve(|ecp, _: Turn| ecp.move_robot((), Follow { from: Six::zeros() }).map(drop))
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), CellError> {
    let start = Six::new(0.1, -1.57, 0.16, -0.16, 4.71, 0.0);
    let robot = |name| RobotSetup::new(name, Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start));
    let report = Cell::new(Duration::from_millis(2))
        .robot(robot("left").program(arm))
        .robot(robot("right").program(arm))
        .on_step(|step, operator| match step {
            500 => operator.suspend(),
            1500 => operator.resume(),
            _ => {}
        })
        .program(|mp| {
            let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
            mp.move_robots((&mut left, &mut right), (), Together { t: 0.0 })?;
            assert_eq!(left.demanded(), right.demanded());
            println!("both turned to {:.3} rad", left.demanded().joints[0]);
            Ok(())
        })
        .run()?;
    // Three seconds of motion and two of suspension, less what the arms still moved while slowing down.
    assert!((4.8..5.2).contains(&report.time.as_secs_f64()), "{:?}", report.time);
    Ok(())
}
