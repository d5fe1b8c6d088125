//! One robot, one generator, no level of its own: the MP moves the arm through a transparent ECP.
//!
//! `cargo run -p mrroc-examples --example 01_move`

use std::time::Duration;

use mrroc::prelude::*;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

/// Waves with the column: half a radian to the left and back.
struct Wave {
    from: Six,
    t: f64,
}

const DURATION: f64 = 4.0;

/// The next steps: nothing is asked of the robot, so nothing is exchanged but the demand.
#[generator(mp, first = look)]
fn wave(c: &mut Wave, t: Tick) -> Step<(Irp6,)> {
    if c.t >= DURATION {
        return Step::Done;
    }
    // Advance by path time, never by a clock: the operator's speed scales `dt`.
    c.t = (c.t + t.dt).min(DURATION);
    let mut q = c.from;
    q[0] += 0.25 * (1.0 - (std::f64::consts::TAU * c.t / DURATION).cos());
    Step::Next((Demand::joints(q),))
}

/// The first step: the one place that needs to know where the arm is.
fn look(c: &mut Wave, e: &State<(Irp6,)>, t: Tick) -> Step<(Irp6,)> {
    c.from = e.0.demanded().joints;
    wave(c, t)
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), CellError> {
    let start = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let report = Cell::new(Duration::from_millis(2))
        .robot(RobotSetup::new("irp6", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start)))
        .program(move |mp| {
            let mut irp6 = mp.robot::<Irp6>("irp6")?;
            let wave = mp.move_robots((&mut irp6,), (), Wave { from: Six::zeros(), t: 0.0 })?;
            // Where it began, to the encoders' resolution.
            assert!((wave.from - start).amax() < 1e-5);
            // The simulated arm follows: its encoders read nearly what was demanded.
            assert!((irp6.measured().joints - irp6.demanded().joints).amax() < 1e-3);
            Ok(())
        })
        .run()?;
    println!("waved for {:.3} s in {} steps", report.time.as_secs_f64(), report.steps);
    assert!((report.time.as_secs_f64() - DURATION).abs() < 0.02);
    Ok(())
}
