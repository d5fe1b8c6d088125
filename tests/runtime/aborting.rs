//! Abort: ends the instruction, not the cell.

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_tests::{Gantry, MS, fault, gantry, peaks};

use crate::runtime::kit::{Phase, Smooth, Twin};

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
fn holding(c: &mut Holding) -> mrroc::generator::Step<(Gantry, Gantry)> {
    if c.0 == 0 {
        return mrroc::generator::Step::Done;
    }
    c.0 -= 1;
    mrroc::generator::Step::Next((mrroc::generator::Demand::hold(), mrroc::generator::Demand::hold()))
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
            left.program(|ecp| ecp.serve(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.1, 0.3)).map(drop)));
        let right = right.program(|ecp| ecp.serve(|ecp, _: Phase| ecp.wait_until((), Never).map(drop)));
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
        ecp.serve(|ecp, _: Phase| {
            loop {
                let _ = ecp.move_robot((), Smooth::to(0.1, 0.4));
                let _ = ecp.wait_until((), Never);
            }
        })
    });
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robots((&mut g,), (), Triggering(100)).map(drop)
    });
    let fault = fault(cell.run());
    assert_eq!(fault.robot().expect("named").as_str(), "g", "{fault}");
    // There was no panic.
    assert_eq!(fault.kind(), FaultKind::Program, "{fault}");
    assert!(fault.message().contains("the end of its instruction"), "{fault}");
}

struct Triggering(u32);

#[generator(mp)]
fn triggering(c: &mut Triggering) -> mrroc::generator::Step<(Gantry,), Phase> {
    if c.0 == 0 {
        return mrroc::generator::Step::Done;
    }
    c.0 -= 1;
    mrroc::generator::Step::Next((Phase::Approach,))
}

#[test]
fn fault_36_an_abort_while_nothing_runs_is_refused_and_the_next_instruction_runs() {
    let (robot, _) = gantry("g");
    let cell = Cell::new(MS).robot(robot);
    let operator = cell.operator();
    assert!(!operator.is_running());
    operator.abort();
    let cell = cell.program(move |mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robots((&mut g,), (), Triggering2(5))?;
        assert!(!operator.is_running());
        operator.abort();
        mp.wait_until((), (), Soon(5))?;
        operator.abort();
        mp.move_robots((&mut g,), (), Triggering2(5)).map(drop)
    });
    cell.run().expect("there was nothing to abort");
}

#[test]
fn fault_36_an_abort_between_two_motions_that_blend_aborts_the_second_one() {
    let (robot, trace) = gantry("g");
    let cell = Cell::new(MS).robot(robot);
    let operator = cell.operator();
    let cell = cell.program(move |mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.blend_robots((&mut g,), (), Rising { x: 0.0, v: 0.0, steps: 50 })?;
        // The robot moves: that can be aborted.
        assert!(operator.is_running());
        operator.abort();
        let on = Rising { x: g.demanded().joints[0], v: 0.25, steps: 5000 };
        mp.move_robots((&mut g,), (), on).map(drop)
    });
    let fault = fault(cell.run());
    assert_eq!(fault.kind(), FaultKind::Aborted, "{fault}");
    let trace = trace.borrow();
    assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6);
    assert!(trace.len() < 350, "{} steps", trace.len());
}

/// Up to 0.25 m/s by 5 m/s², and on.
struct Rising {
    x: f64,
    v: f64,
    steps: u32,
}

#[generator(mp)]
fn rising(c: &mut Rising, t: mrroc::generator::Tick) -> mrroc::generator::Step<(Gantry,)> {
    if c.steps == 0 {
        return mrroc::generator::Step::Done;
    }
    c.steps -= 1;
    c.v = (c.v + 5.0 * t.dt).min(0.25);
    c.x += c.v * t.dt;
    mrroc::generator::Step::Next((crate::runtime::kit::x(c.x),))
}

struct Triggering2(u32);

#[generator(mp)]
fn triggering2(c: &mut Triggering2) -> mrroc::generator::Step<(Gantry,)> {
    if c.0 == 0 {
        return mrroc::generator::Step::Done;
    }
    c.0 -= 1;
    mrroc::generator::Step::Next((mrroc::generator::Demand::hold(),))
}

struct Soon(u32);

#[condition(mp)]
fn soon(c: &mut Soon) -> bool {
    c.0 -= 1;
    c.0 == 0
}

/// Throws a fault of this kind in step 100, at 0.04 m along x by 8 m/s².
struct Forges(FaultKind);

#[generator(mp)]
fn forges(
    c: &mut Forges,
    t: mrroc::generator::Tick,
) -> Result<mrroc::generator::Step<(Gantry, Gantry)>, mrroc::fault::Fault> {
    if t.step == 100 {
        return Err(mrroc::fault::Fault::new(c.0));
    }
    let u = (t.step + 1) as f64;
    Ok(mrroc::generator::Step::Next((
        crate::runtime::kit::x(4e-6 * u * u),
        crate::runtime::kit::x(-4e-6 * u * u),
    )))
}

struct ForgesAlone(FaultKind);

#[generator(ecp)]
fn forges_alone(
    c: &mut ForgesAlone,
    t: mrroc::generator::Tick,
) -> Result<mrroc::generator::Step<Gantry>, mrroc::fault::Fault> {
    if t.step == 100 {
        return Err(mrroc::fault::Fault::new(c.0));
    }
    let u = (t.step + 1) as f64;
    Ok(mrroc::generator::Step::Next(crate::runtime::kit::x(4e-6 * u * u)))
}

const ENDS: [FaultKind; 5] = [
    FaultKind::Aborted,
    FaultKind::InstructionEnded,
    FaultKind::CellClosed,
    FaultKind::StoppedByCell,
    FaultKind::TimedOut,
];

#[test]
fn a_generator_that_throws_the_end_of_an_instruction_stops_the_cell_as_any_fault_does() {
    for kind in ENDS {
        let ((left, trace), (right, _)) = (gantry("left"), gantry("right"));
        let cell = Cell::new(MS).robot(left).robot(right).program(move |mp| {
            let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
            let thrown = mp.move_robots((&mut left, &mut right), (), Forges(kind));
            assert!(thrown.is_err());
            // Latched: the next Move is refused.
            assert!(mp.move_robots((&mut left, &mut right), (), Holding(5)).is_err());
            Ok(())
        });
        let by_mp = fault(cell.run());
        assert!(matches!(by_mp.kind(), FaultKind::Program | FaultKind::TimedOut), "{kind:?}: {by_mp}");
        let trace = trace.borrow();
        assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6, "{kind:?}");
        assert_eq!(trace[trace.len() - 1], trace[trace.len() - 2], "{kind:?}: not at standstill");

        let (robot, trace) = gantry("g");
        let robot = robot.program(move |ecp| ecp.move_robot((), ForgesAlone(kind)).map(drop));
        let by_ecp = fault(Cell::new(MS).robot(robot).run());
        assert!(matches!(by_ecp.kind(), FaultKind::Program | FaultKind::TimedOut), "{kind:?}: {by_ecp}");
        assert_eq!(by_ecp.process().expect("named").to_string(), "ecp g");
        let trace = trace.borrow();
        assert_eq!(trace[trace.len() - 1], trace[trace.len() - 2], "{kind:?}: not at standstill");
    }
}

#[test]
fn a_program_that_returns_the_end_of_an_instruction_that_goes_on_is_stopped() {
    for kind in ENDS {
        let (robot, _) = gantry("g");
        let robot = robot.program(move |ecp| {
            let outcome = ecp.serve(|_, _: Phase| Err(mrroc::fault::Fault::new(kind)));
            assert!(outcome.is_err(), "{kind:?} passed for an end");
            outcome
        });
        let cell = Cell::new(MS).robot(robot).program(|mp| {
            let mut g = mp.robot::<Gantry>("g")?;
            mp.move_robots((&mut g,), (), Triggering(1000)).map(drop)
        });
        let fault = fault(cell.run());
        assert!(matches!(fault.kind(), FaultKind::Program | FaultKind::TimedOut), "{kind:?}: {fault}");
    }
}
