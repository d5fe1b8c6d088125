//! A guard of the cell: it sees all robots, and what it forbids causes a protective stop on the path.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::robot::RobotView;
use mrroc_tests::{Gantry, MS, fault, gantry, peaks};

use crate::runtime::kit::{Smooth, Twin};

/// Stops the cell when the first robot is demanded beyond `x` \[m\].
fn fence(x: f64) -> impl FnMut(&[RobotView]) -> Result<(), Fault> {
    move |robots| {
        let at = robots[0].demanded.joints[0];
        if at > x {
            return Err(Fault::thrown(&format!("{} is at {at:.3} m, behind the fence", robots[0].name)));
        }
        Ok(())
    }
}

#[test]
fn a_guard_stops_both_robots_on_their_path_within_the_limits_and_latches() {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    let refused = Rc::new(RefCell::new(None));
    let keep = Rc::clone(&refused);
    let fault = fault(
        Cell::new(MS)
            .robot(left)
            .robot(right)
            .guard(10, fence(0.1))
            .program(move |mp| {
                let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
                let ended = mp.move_robots((&mut left, &mut right), (), Twin(Smooth::to(0.4, 1.0))).map(drop);
                let again = mp.move_robots((&mut left, &mut right), (), Twin(Smooth::to(0.0, 1.0))).map(drop);
                *keep.borrow_mut() = again.err().map(|fault| fault.kind());
                ended
            })
            .run(),
    );
    assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
    assert!(
        fault.to_string().contains("left is at 0.1") && fault.to_string().contains("behind the fence"),
        "{fault}"
    );
    assert_eq!(*refused.borrow(), Some(FaultKind::ProtectiveStop), "the next Move went on");
    let (left, right) = (left_trace.borrow(), right_trace.borrow());
    assert!(left.iter().zip(right.iter()).all(|(l, r)| (l[0] + r[0]).abs() < 1e-12), "not together");
    let (_, acceleration) = peaks(&left, 1e-3);
    assert!(acceleration <= 10.0 + 1e-6, "{acceleration} m/s²");
    let end = left[left.len() - 1][0];
    // Within ten steps of the fence at 0.5 m/s at most, and the distance of braking with less than the limit.
    assert!((0.1..0.2).contains(&end), "stopped at {end}");
    assert_eq!(left[left.len() - 2][0], end, "not at a standstill");
}

#[test]
fn a_guard_looks_at_all_robots_in_the_steps_that_it_asked_for() {
    let (left, _) = gantry("left");
    let (right, _) = gantry("right");
    let looks = Rc::new(RefCell::new(Vec::new()));
    let keep = Rc::clone(&looks);
    let clock = Rc::new(std::cell::Cell::new(0));
    let now = Rc::clone(&clock);
    let report = Cell::new(MS)
        .robot(left)
        .robot(right)
        .on_step(move |step, _| clock.set(step))
        .guard(25, move |robots| {
            let names: Vec<_> = robots.iter().map(|robot| robot.name.to_string()).collect();
            keep.borrow_mut().push((now.get(), names, robots[0].demanded.joints[0]));
            Ok(())
        })
        .program(|mp| {
            // The other robot is not named in the instruction: its last known state is used.
            let mut left = mp.robot::<Gantry>("left")?;
            mp.move_robots((&mut left,), (), Alone(Smooth::to(0.3, 0.6)))?;
            Ok(())
        })
        .run()
        .expect("nothing is forbidden");
    let looks = looks.borrow();
    let steps: Vec<_> = looks.iter().map(|(step, ..)| *step).collect();
    // As soon as the robots are known, and then every 25 steps.
    let expected: Vec<_> = std::iter::once(1).chain((25..=report.steps).step_by(25)).collect();
    assert_eq!(steps, expected);
    assert!(looks.iter().all(|(_, names, _)| names == &["left", "right"]));
    let positions: Vec<_> = looks.iter().map(|(.., x)| *x).collect();
    assert!(
        positions.windows(2).all(|w| w[1] >= w[0]) && positions[positions.len() - 1] > 0.29,
        "{positions:?}"
    );
}

/// One gantry along x, in the MP.
struct Alone(Smooth);

#[mrroc::generator(mp)]
fn alone(c: &mut Alone, t: mrroc::generator::Tick) -> mrroc::generator::Step<(Gantry,)> {
    match c.0.advance(t.dt) {
        Some(x) => mrroc::generator::Step::Next((mrroc::generator::Demand::joints(nalgebra::Vector3::new(
            x, 0.0, 0.0,
        )),)),
        None => mrroc::generator::Step::Done,
    }
}

#[test]
fn a_guard_stops_programs_of_ecps_in_a_cell_without_an_mp_program() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(0.4, 1.0)).map(drop));
    let fault = fault(Cell::new(MS).robot(robot).guard(1, fence(0.2)).run());
    assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
    let trace = trace.borrow();
    let (end, (_, acceleration)) = (trace[trace.len() - 1][0], peaks(&trace, 1e-3));
    assert!((0.2..0.3).contains(&end) && acceleration <= 10.0 + 1e-6, "{end} m, {acceleration} m/s²");
}

#[test]
fn a_guard_that_trips_in_the_last_step_of_a_motion_stops_the_program_all_the_same() {
    let (robot, _) = gantry("g");
    // Slightly beyond the fence, at the very end.
    let fault = fault(
        Cell::new(MS)
            .robot(robot)
            .guard(1, fence(0.4 - 1e-12))
            .program(|mp| {
                let mut g = mp.robot::<Gantry>("g")?;
                mp.move_robots((&mut g,), (), Alone(Smooth::to(0.4, 1.0)))?;
                panic!("the program went on");
            })
            .run(),
    );
    assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
}

#[test]
fn a_guard_that_panics_stops_the_cell() {
    let (robot, trace) = gantry("g");
    let fault = fault(
        Cell::new(MS)
            .robot(robot)
            .guard(1, |robots| {
                assert!(robots[0].demanded.joints[0] < 0.1, "no place for this robot");
                Ok(())
            })
            .program(|mp| {
                let mut g = mp.robot::<Gantry>("g")?;
                mp.move_robots((&mut g,), (), Alone(Smooth::to(0.4, 1.0))).map(drop)
            })
            .run(),
    );
    assert_eq!(fault.kind(), FaultKind::Panicked, "{fault}");
    let trace = trace.borrow();
    assert_eq!(trace[trace.len() - 1], trace[trace.len() - 2], "not at a standstill");
}

/// Reads in 1.6 ms, longer than a step.
struct Slow;

impl mrroc::sensor::Sensor for Slow {
    const KIND: &'static str = "slow";
    type Reading = mrroc::payload::Trigger;
    type Configuration = ();
}

impl mrroc::sensor::VirtualSensor for Slow {
    type Kind = Slow;

    fn aggregate(&mut self, _: &mrroc::sensor::ReadingOrder<()>) -> Result<mrroc::payload::Trigger, Fault> {
        Ok(mrroc::payload::Trigger)
    }
}

/// As [`Alone`], and reads in every step.
struct Reads(Smooth);

#[mrroc::generator(mp)]
fn reads(
    c: &mut Reads,
    _v: &mrroc::sensor::Reading<(Slow,)>,
    t: mrroc::generator::Tick,
) -> mrroc::generator::Step<(Gantry,)> {
    match c.0.advance(t.dt) {
        Some(x) => mrroc::generator::Step::Next((mrroc::generator::Demand::joints(nalgebra::Vector3::new(
            x, 0.0, 0.0,
        )),)),
        None => mrroc::generator::Step::Done,
    }
}

/// A cell whose MP takes two periods for a step, with an end of its motion [m, s].
fn slow_cell(end: (f64, f64)) -> Cell {
    let (robot, _) = gantry("g");
    Cell::new(MS)
        .robot(robot)
        .sensor(mrroc::cell::SensorSetup::new("slow", Slow).latency(std::time::Duration::from_micros(1600)))
        .program(move |mp| {
            let (mut g, mut slow) = (mp.robot::<Gantry>("g")?, mp.sensor::<Slow>("slow")?);
            mp.move_robots((&mut g,), (&mut slow,), Reads(Smooth::to(end.0, end.1))).map(drop)
        })
}

#[test]
fn a_guard_of_an_mp_whose_steps_are_late_looks_all_the_same_and_its_stop_is_the_cause() {
    // Steps 3, 5, 7 ..: none of them a multiple of 10.
    let fault = fault(slow_cell((0.3, 1.6)).guard(10, fence(0.1)).run());
    assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
}

#[test]
fn suspensions_of_an_mp_that_takes_two_periods_for_a_step_keep_the_limits() {
    // Catching up after every second period takes four times the path's acceleration, of which there are nine tenths.
    for at in (60_u64..1500).step_by(20) {
        let cell = slow_cell((0.3, 1.6)).on_step(move |step, operator| {
            if (at..at + 3).contains(&step) {
                operator.suspend();
            } else if step > at + 700 {
                operator.resume();
            }
        });
        cell.run().unwrap_or_else(|error| panic!("suspended in step {at}: {error}"));
    }
}

#[test]
fn a_guard_sees_a_robot_that_goes_on_while_its_instruction_ends() {
    // The MP ends a loose motion in whose middle the ECP's generator slows down on its own path.
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.serve(|ecp, _: crate::runtime::kit::Phase| ecp.move_robot((), Smooth::to(0.4, 1.0)).map(drop))
    });
    let tripped = Rc::new(std::cell::Cell::new(0.0));
    let keep = Rc::clone(&tripped);
    let fault = fault(
        Cell::new(MS)
            .robot(robot)
            .guard(1, move |robots| {
                let x = robots[0].demanded.joints[0];
                if x > 0.21 {
                    keep.set(x);
                    return Err(Fault::thrown("behind the fence"));
                }
                Ok(())
            })
            .program(|mp| {
                let mut g = mp.robot::<Gantry>("g")?;
                mp.move_robots((&mut g,), (), Approach(500)).map(drop)
            })
            .run(),
    );
    assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
    assert!(trace.borrow()[trace.borrow().len() - 1][0] > 0.22, "it had come to rest before the fence");
    // At some 0.6 m/s a step is 0.6 mm.
    assert!(tripped.get() < 0.2125, "seen at {} only", tripped.get());
}

/// Orders the approach for so many steps.
struct Approach(u32);

#[mrroc::generator(mp)]
fn approach(c: &mut Approach) -> mrroc::generator::Step<(Gantry,), crate::runtime::kit::Phase> {
    c.0 -= 1;
    if c.0 == 0 {
        mrroc::generator::Step::Done
    } else {
        mrroc::generator::Step::Next((crate::runtime::kit::Phase::Approach,))
    }
}
