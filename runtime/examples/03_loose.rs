//! Two arms, loosely: the MP says what, each ECP decides how, and the early one holds until both are there.
//!
//! `cargo run -p mrroc-examples --example 03_loose`

use std::time::Duration;

use mrroc::prelude::*;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

/// What the MP orders: a constant from a finite set makes the cooperation loose.
#[derive(Clone, Copy, Payload)]
enum Phase {
    Left,
    Right,
}

/// The MP's half of the motion. It has no end of its own: it ends when both arms have finished.
#[generator(mp)]
fn apart() -> Always<(Irp6, Irp6), Phase> {
    Always((Phase::Left, Phase::Right))
}

/// The ECP's half: to an angle of the column within `duration` seconds.
struct GoTo {
    angle: f64,
    duration: f64,
    from: Six,
    t: f64,
}

#[generator(ecp)]
impl GoTo {
    fn first_step(&mut self, e: &State<Irp6>, t: Tick) -> Step<Irp6> {
        self.from = e.demanded().joints;
        self.next_step(t)
    }

    fn next_step(&mut self, t: Tick) -> Step<Irp6> {
        if self.t >= self.duration {
            return Step::Done;
        }
        self.t = (self.t + t.dt).min(self.duration);
        let u = self.t / self.duration;
        let mut q = self.from;
        q[0] += (self.angle - self.from[0]) * u * u * (3.0 - 2.0 * u);
        Step::Next(Demand::joints(q))
    }
}

/// The program of either arm's ECP.
fn arm(ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
    let go = |angle, duration| GoTo { angle, duration, from: Six::zeros(), t: 0.0 };
    ecp.serve(|ecp, phase: Phase| match phase {
        Phase::Left => ecp.move_robot((), go(0.5, 2.0)).map(drop),
        Phase::Right => ecp.move_robot((), go(-0.5, 4.0)).map(drop),
    })
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), CellError> {
    let start = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let robot = |name| RobotSetup::new(name, Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start));
    let report = Cell::new(Duration::from_millis(2))
        .robot(robot("left").program(arm))
        .robot(robot("right").program(arm))
        .program(|mp| {
            let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
            mp.move_robots((&mut left, &mut right), (), apart())?;
            assert_eq!([left.demanded().joints[0], right.demanded().joints[0]], [0.5, -0.5]);
            Ok(())
        })
        .run()?;
    println!("both are there after {:.3} s", report.time.as_secs_f64());
    assert!((4.0..4.05).contains(&report.time.as_secs_f64()));
    Ok(())
}
