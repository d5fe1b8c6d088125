//! Robots with a jerk limit, suspended anywhere.

use mrroc::prelude::*;
use mrroc_tests::{ExactDrive, Gantry, MS, traced};
use nalgebra::Vector3;

/// x = 0.25 (10 u³ - 15 u⁴ + 6 u⁵) over 0.6 s: 0.78 m/s, 4 m/s², 42 m/s³ within and 69 m/s³ at its ends.
struct Quintic(f64);

#[generator(ecp)]
fn quintic(c: &mut Quintic, t: Tick) -> Step<Gantry> {
    if c.0 >= 0.6 {
        return Step::Done;
    }
    c.0 = (c.0 + t.dt).min(0.6);
    let u = c.0 / 0.6;
    Step::Next(Demand::joints(Vector3::new(0.25 * u * u * u * (10.0 + u * (6.0 * u - 15.0)), 0.0, 0.0)))
}

#[test]
fn fault_37_a_robot_with_a_jerk_limit_may_be_suspended_in_every_step() {
    for at in (1..600).step_by(7) {
        // Resumed while it brakes and at it.
        for later in [10, 150, 1500] {
            let drive = ExactDrive::at_origin();
            let (robot, trace) = traced(RobotSetup::new("g", Gantry::with_jerk(1000.0), drive));
            let robot = robot.program(|ecp| ecp.move_robot((), Quintic(0.0)).map(drop));
            let cell = Cell::new(MS).robot(robot).on_step(move |step, operator| {
                if step == at {
                    operator.suspend();
                }
                if step == at + later {
                    operator.resume();
                }
            });
            cell.run().unwrap_or_else(|error| panic!("suspended at {at} for {later}: {error}"));
            let end = trace.borrow().last().expect("recorded")[0];
            assert!((end - 0.25).abs() < 1e-9, "suspended at {at} for {later}: {end}");
        }
    }
}
