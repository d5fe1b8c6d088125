//! A guard of the cell: it sees all robots, and what it forbids is a protective stop on the path.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::{Cell, Fault, FaultKind, RobotView};
use mrroc_tests::{Gantry, MS, fault, gantry, peaks};

use crate::kit::{Smooth, Twin};

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
    // Within ten steps of the fence at 0.5 m/s at most, and the way of braking with less than the limit.
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
            // The other robot is not named: what is known of it holds.
            let mut left = mp.robot::<Gantry>("left")?;
            mp.move_robots((&mut left,), (), Alone(Smooth::to(0.3, 0.6)))?;
            Ok(())
        })
        .run()
        .expect("nothing is forbidden");
    let looks = looks.borrow();
    let steps: Vec<_> = looks.iter().map(|(step, ..)| *step).collect();
    let mut once = steps.clone();
    once.dedup();
    assert!(once.iter().all(|step| step % 25 == 0), "{steps:?}");
    assert_eq!(once.len() as u64, report.steps / 25, "{steps:?}");
    assert!(looks.iter().all(|(_, names, _)| names == &["left", "right"]));
    let ways: Vec<_> = looks.iter().map(|(.., x)| *x).collect();
    assert!(ways.windows(2).all(|w| w[1] >= w[0]) && ways[ways.len() - 1] > 0.29, "{ways:?}");
}

/// One gantry along x, in the MP.
struct Alone(Smooth);

#[mrroc::generator(mp)]
fn alone(c: &mut Alone, t: mrroc::Tick) -> mrroc::Step<(Gantry,)> {
    match c.0.advance(t.dt) {
        Some(x) => mrroc::Step::Next((mrroc::Demand::joints(nalgebra::Vector3::new(x, 0.0, 0.0)),)),
        None => mrroc::Step::Done,
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
    // Beyond the fence by a hair, at the very end.
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
    assert_eq!(fault.kind(), FaultKind::GeneratorPanicked, "{fault}");
    let trace = trace.borrow();
    assert_eq!(trace[trace.len() - 1], trace[trace.len() - 2], "not at a standstill");
}
