//! Move, eq. 6 of the paper.

use mrroc::{Cell, Class, Demand, Fault, Generator, Level, Motion, Order, Reading, State, Step, Tick, Uses};
use mrroc_tests::{Gantry, MS, gantry, peaks};
use nalgebra::Vector3;

/// Along x to `end` at rest-to-rest smoothstep over `duration` of path time.
struct Smooth {
    end: f64,
    duration: f64,
    t: f64,
    start: f64,
}

impl Smooth {
    fn to(end: f64, duration: f64) -> Self {
        Smooth { end, duration, t: 0.0, start: 0.0 }
    }
    fn next(&mut self, t: Tick) -> Step<Gantry> {
        if self.t >= self.duration {
            return Step::Done;
        }
        self.t = (self.t + t.dt).min(self.duration);
        let u = self.t / self.duration;
        let s = u * u * (3.0 - 2.0 * u);
        Step::Next(Demand::joints(Vector3::new(self.start + (self.end - self.start) * s, 0.0, 0.0)))
    }
}

impl Generator for Smooth {
    type Robots = Gantry;
    type Language = Motion;
    type Sensors = ();
    type Order = ();
    const CLASS: Class = Class {
        level: Level::Ecp,
        first: Uses { state: true, robots: true, tick: true, ..Uses::NOTHING },
        next: Uses { state: true, tick: true, ..Uses::NOTHING },
        until: None,
    };
    fn first_step(
        &mut self,
        _: &Order<()>,
        e: &State<Gantry>,
        _: &Reading<()>,
        t: Tick,
    ) -> Result<Step<Gantry>, Fault> {
        self.start = e.demanded().joints[0];
        Ok(self.next(t))
    }
    fn next_step(
        &mut self,
        _: &Order<()>,
        _: &State<Gantry>,
        _: &Reading<()>,
        t: Tick,
    ) -> Result<Step<Gantry>, Fault> {
        Ok(self.next(t))
    }
}

#[test]
fn a_program_of_an_ecp_alone_is_nudged_and_moves_its_robot() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.move_robot((), Smooth::to(0.3, 0.5))?;
        ecp.move_robot((), Smooth::to(0.1, 0.5))?;
        Ok(())
    });
    let report = Cell::new(MS).robot(robot).run().expect("the motion keeps the limits");
    let trace = trace.borrow();
    assert_eq!(trace.last().expect("recorded")[0], 0.1);
    // 1000 steps of motion, one before the first, and the one in which the MP learns of the end.
    assert!((1001..=1004).contains(&report.steps), "{}", report.steps);
    let (v, a) = peaks(&trace, 1e-3);
    // Smoothstep: v = 1.5 s / T, a = 6 s / T^2.
    assert!((v - 0.9).abs() < 1e-3 && (a - 7.2).abs() < 0.1, "{v} {a}");
}
