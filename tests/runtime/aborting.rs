//! Abort: ends the instruction, not the cell.

use mrroc::{Always, Cell, FaultKind, condition, generator};
use mrroc_tests::{Gantry, MS, fault, gantry, peaks};

use crate::kit::{Phase, Smooth, Twin};

#[test]
fn after_an_abort_the_mp_may_move_transparent_robots_again() {
    for at in [1, 2, 3, 100, 399, 400, 401, 402] {
        let ((left, trace), (right, _)) = (gantry("left"), gantry("right"));
        let cell = Cell::new(MS)
            .robot(left)
            .robot(right)
            .on_step(move |step, operator| {
                if step == at {
                    operator.abort();
                }
            })
            .program(move |mp| {
                let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
                let first = mp.move_robots((&mut left, &mut right), (), Twin(Smooth::to(0.2, 0.4)));
                let here = left.demanded().joints[0];
                match first {
                    Ok(_) => assert!(at >= 402, "not aborted at {at}"),
                    Err(fault) => assert_eq!(fault.kind(), FaultKind::Aborted),
                }
                let again = mp.move_robots((&mut left, &mut right), (), Holding(5));
                match again {
                    Ok(_) => {}
                    Err(fault) => assert!(at >= 402 && fault.kind() == FaultKind::Aborted, "{fault}"),
                }
                assert_eq!(left.demanded().joints[0], here);
                Ok(())
            });
        cell.run().unwrap_or_else(|error| panic!("aborted at {at}: {error}"));
        assert!(peaks(&trace.borrow(), 1e-3).1 <= 10.0 + 1e-6, "aborted at {at}");
    }
}

struct Holding(u32);

#[generator(mp)]
fn holding(c: &mut Holding) -> mrroc::Step<(Gantry, Gantry)> {
    if c.0 == 0 {
        return mrroc::Step::Done;
    }
    c.0 -= 1;
    mrroc::Step::Next((mrroc::Demand::hold(), mrroc::Demand::hold()))
}

#[generator(mp)]
fn told() -> Always<(Gantry, Gantry), Phase> {
    Always((Phase::Approach, Phase::Retreat))
}

#[test]
fn an_abort_ends_a_loose_motion_of_which_one_robot_has_finished_and_one_waits() {
    for at in [1, 2, 3, 50, 150, 250, 500] {
        let ((left, left_trace), (right, _)) = (gantry("left"), gantry("right"));
        let left =
            left.program(|ecp| ecp.obey(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.1, 0.3)).map(drop)));
        let right = right.program(|ecp| ecp.obey(|ecp, _: Phase| ecp.wait_until((), Never).map(drop)));
        let cell = Cell::new(MS)
            .robot(left)
            .robot(right)
            .on_step(move |step, operator| {
                if step == at {
                    operator.abort();
                }
            })
            .program(|mp| {
                let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
                mp.move_robots((&mut left, &mut right), (), told()).map(drop)
            });
        let fault = fault(cell.run());
        assert_eq!(fault.kind(), FaultKind::Aborted, "aborted at {at}: {fault}");
        assert!(peaks(&left_trace.borrow(), 1e-3).1 <= 10.0 + 1e-6);
    }
}

struct Never;

#[condition(ecp)]
fn never(_c: &mut Never) -> bool {
    false
}

#[test]
fn an_abort_of_a_suspended_motion_ends_it_where_it_stands() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(0.3, 0.5)).map(drop));
    let cell = Cell::new(MS).robot(robot).on_step(|step, operator| match step {
        200 => operator.suspend(),
        600 => operator.abort(),
        _ => {}
    });
    assert_eq!(fault(cell.run()).kind(), FaultKind::Aborted);
    let trace = trace.borrow();
    assert!(trace[500..].iter().all(|q| *q == trace[500]));
    assert!(trace.len() < 620, "{} steps", trace.len());
}

#[test]
fn a_program_of_an_ecp_that_ignores_the_end_of_its_instruction_is_ended() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.obey(|ecp, _: Phase| {
            loop {
                let _ = ecp.move_robot((), Smooth::to(0.1, 0.2));
                let _ = ecp.wait_until((), Never);
            }
        })
    });
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robots((&mut g,), (), Nudging(100)).map(drop)
    });
    let fault = fault(cell.run());
    assert_eq!(fault.robot().expect("named").as_str(), "g", "{fault}");
}

struct Nudging(u32);

#[generator(mp)]
fn nudging(c: &mut Nudging) -> mrroc::Step<(Gantry,), Phase> {
    if c.0 == 0 {
        return mrroc::Step::Done;
    }
    c.0 -= 1;
    mrroc::Step::Next((Phase::Approach,))
}
