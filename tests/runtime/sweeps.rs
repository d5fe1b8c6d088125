//! Events in step k, for every k: aborts, suspensions of waits and braking tails, sensors of a first step.

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_tests::{ExactDrive, Gantry, MS, fault, gantry, peaks, traced};

use crate::runtime::kit::{Counter, Counting, Smooth, x};

#[test]
fn fault_36_an_abort_in_every_step_of_a_motion_stops_it_on_its_path_within_the_limits() {
    for at in (1..500).step_by(3) {
        let (robot, trace) = gantry("g");
        let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(0.3, 0.5)).map(drop));
        let cell = Cell::new(MS).robot(robot).on_step(move |step, operator| {
            if step == at {
                operator.abort();
                // Contradictions, in the same step and later, change nothing.
                operator.suspend();
                operator.resume();
            }
            if step == at + 5 {
                operator.abort();
                operator.resume();
            }
        });
        let aborted = fault(cell.run());
        assert_eq!(aborted.kind(), FaultKind::Aborted, "aborted at {at}: {aborted}");
        let trace = trace.borrow();
        let (v, a) = peaks(&trace, 1e-3);
        assert!(v <= 1.0 && a <= 10.0 + 1e-6, "aborted at {at}: {v} m/s, {a} m/s²");
        // 2 steps of detection, 2.05 v / a or 0.2 s of slowing down.
        assert!(trace.len() as u64 <= at + 300, "aborted at {at}: {} steps", trace.len());
    }
}

/// Speeds up and is done at speed: a braking tail of 50 steps follows.
struct Tail {
    t: f64,
}

#[generator(ecp)]
fn tail(c: &mut Tail, t: Tick) -> Step<Gantry> {
    if c.t >= 0.05 {
        return Step::Done;
    }
    c.t += t.dt;
    Step::Next(x(4.5 * c.t * c.t))
}

#[test]
fn a_suspension_in_a_braking_tail_leaves_the_tail_as_it_is() {
    let run = |at: u64| {
        let (robot, trace) = gantry("g");
        let robot = robot.program(|ecp| ecp.move_robot((), Tail { t: 0.0 }).map(drop));
        let cell = Cell::new(MS).robot(robot).on_step(move |step, operator| {
            if step == at {
                operator.suspend();
            }
            if step == at + 300 {
                operator.resume();
            }
        });
        cell.run().unwrap_or_else(|error| panic!("suspended at {at}: {error}"));
        let end = trace.borrow().last().expect("recorded")[0];
        assert!(peaks(&trace.borrow(), 1e-3).1 <= 10.0 + 1e-6, "suspended at {at}");
        end
    };
    let undisturbed = run(10_000);
    for at in 53..110 {
        assert_eq!(run(at), undisturbed, "suspended at {at}");
    }
}

/// Keeps the step of the order of the reading that its first step got, and its own.
struct First {
    ordered: u64,
    calls: u32,
}

#[generator(mp, first = look, sensors = (Counter,))]
fn first(c: &mut First) -> Step<(Gantry,)> {
    c.calls += 1;
    if c.calls > 3 { Step::Done } else { Step::Next((mrroc::generator::Demand::hold(),)) }
}

fn look(c: &mut First, v: &Reading<(Counter,)>) -> Step<(Gantry,)> {
    c.ordered = v.0.reading().map_or(0, |reading| reading.step);
    Step::Next((mrroc::generator::Demand::hold(),))
}

#[test]
fn a_first_step_that_was_suspended_has_a_reading_of_the_step_before_it() {
    let (robot, _) = gantry("g");
    let cell = Cell::new(MS)
        .robot(robot)
        .sensor(SensorSetup::new("counter", Counting::default()))
        .on_step(|step, operator| match step {
            1 => operator.suspend(),
            500 => operator.resume(),
            _ => {}
        })
        .program(|mp| {
            let (mut g, mut counter) = (mp.robot::<Gantry>("g")?, mp.sensor::<Counter>("counter")?);
            let first = mp.move_robots((&mut g,), (&mut counter,), First { ordered: 0, calls: 0 })?;
            assert_eq!(first.ordered, 499);
            Ok(())
        });
    cell.run().expect("nothing moves");
}

#[test]
fn fault_21_an_abort_keeps_the_jerk_limit_in_every_step() {
    for at in (1..500).step_by(13) {
        let drive = ExactDrive::at_origin();
        let (robot, trace) = traced(RobotSetup::new("g", Gantry::with_jerk(20_000.0), drive));
        // 36 m/s³ within; at its ends a step of 7.2 m/s² in 1 ms, 7200 m/s³.
        let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(0.3, 0.5)).map(drop));
        let cell = Cell::new(MS).robot(robot).on_step(move |step, operator| {
            if step == at {
                operator.abort();
            }
        });
        let aborted = fault(cell.run());
        assert_eq!(aborted.kind(), FaultKind::Aborted, "aborted at {at}: {aborted}");
        assert!(peaks(&trace.borrow(), 1e-3).1 <= 10.0 + 1e-6, "aborted at {at}");
    }
}
