//! Motions in the background: a robot goes on while the program moves others.

use mrroc::fault::FaultKind;
use mrroc::generator::RobotHandle;
use mrroc::operator::Operator;
use mrroc::prelude::*;
use mrroc_tests::{ExactDrive, Gantry, MS, Q, Trace, fault, gantry, peaks};

use crate::runtime::kit::{Phase, Smooth, x};

const SPEED: f64 = 0.2;
const ACCELERATION: f64 = 2.0;

/// Along x, from whatever motion it finds, to a speed \[m/s\] by 2 m/s², and on at it for ever or for some steps.
struct Run {
    wanted: f64,
    left: u64,
    speed: f64,
    x: f64,
}

impl Run {
    const fn at(wanted: f64) -> Run {
        Run { wanted, left: u64::MAX, speed: 0.0, x: 0.0 }
    }

    const fn steps(self, left: u64) -> Run {
        Run { left, ..self }
    }
}

#[generator(ecp, first = found)]
fn run(c: &mut Run, t: Tick) -> Step<Gantry> {
    if c.left == 0 {
        return Step::Done;
    }
    c.left -= 1;
    let most = ACCELERATION * t.dt;
    c.speed += (c.wanted - c.speed).clamp(-most, most);
    c.x += c.speed * t.dt;
    Step::Next(x(c.x))
}

fn found(c: &mut Run, e: &State<Gantry>, t: Tick) -> Step<Gantry> {
    (c.x, c.speed) = (e.demanded().joints[0], e.demanded().velocity[0]);
    run(c, t)
}

/// Where it is after so many steps from rest: n (n + 1) / 2 steps of 2e-6 m up to the speed, then 0.2 mm each.
fn distance(steps: u64) -> f64 {
    let up = steps.min(100) as f64;
    up * (up + 1.0) / 2.0 * ACCELERATION * 1e-6 + (steps.saturating_sub(100)) as f64 * SPEED * 1e-3
}

/// The distance of braking from a speed by the EDP's law, which falls to zero by 10 m/s² at most.
const BRAKED: f64 = 0.01;

type Handles = (RobotHandle<Gantry>, RobotHandle<Gantry>);

/// An arm and a belt; where they were in every step.
fn cell(
    act: impl FnMut(u64, &Operator) + 'static,
    mut program: impl FnMut(&mut Mp, &mut Handles) -> Result<(), Fault> + 'static,
) -> (Result<mrroc::cell::RunReport, mrroc::cell::CellError>, Trace<3>, Trace<3>) {
    let ((arm, arms), (belt, belts)) = (gantry("arm"), gantry("belt"));
    let cell = Cell::new(MS).robot(arm).robot(belt).on_step(act).program(move |mp| {
        let mut handles = (mp.robot("arm")?, mp.robot("belt")?);
        program(mp, &mut handles)
    });
    (cell.run(), arms, belts)
}

/// The demands without those of the standstill at the start.
fn moved(trace: &Trace<3>) -> Vec<f64> {
    let trace = trace.borrow();
    let begin = trace.iter().position(|q| q[0] != trace[0][0]).expect("it moves");
    trace[begin..].iter().map(|q| q[0]).collect()
}

fn keeps_to_its_limits(trace: &[Q<3>]) {
    assert!(peaks(trace, 1e-3).1 <= 10.0 + 1e-6, "{:?}", peaks(trace, 1e-3));
}

#[test]
fn a_belt_runs_on_through_moves_and_waits_of_others_without_losing_a_step() {
    let (result, arms, belts) = cell(
        |_, _| {},
        |mp, (arm, belt)| {
            mp.start_robot(belt, Run::at(SPEED))?;
            mp.move_robot(arm, (), Smooth::to(0.2, 0.4))?;
            mp.wait_until((&mut *arm,), (), Soon(50))?;
            mp.move_robot(arm, (), Smooth::to(0.0, 0.4))?;
            // The Wait may name it, and sees it move.
            mp.wait_until((&mut *belt,), (), Beyond(0.25))?;
            assert!((belt.demanded().velocity[0] - SPEED).abs() < 1e-9, "the Wait stopped it");
            assert!(mp.is_in_background(belt));
            mp.end_robot(belt)?;
            assert!(!mp.is_in_background(belt));
            assert_eq!(belt.demanded().velocity[0], 0.0);
            Ok(())
        },
    );
    result.expect("within the limits");
    let belt = moved(&belts);
    let running = belt.iter().position(|x| *x > 0.25).expect("it gets there");
    for (i, x) in belt[..=running].iter().enumerate() {
        assert!(
            (x - distance(i as u64 + 1)).abs() < 1e-9,
            "step {i}: {x} instead of {}",
            distance(i as u64 + 1)
        );
    }
    let end = belt[belt.len() - 1];
    assert!((0.25..0.25 + BRAKED).contains(&end), "stops at {end}");
    keeps_to_its_limits(&belts.borrow());
    // The arm moves as it would without a belt: a smoothstep up, 50 steps of the Wait, and down.
    let arm = moved(&arms);
    let there = arm.iter().position(|x| (x - 0.2).abs() < 1e-12).expect("it gets there");
    assert_eq!(there, 399);
    assert!(arm[arm.len() - 1].abs() < 1e-12);
}

struct Soon(u32);

#[condition(mp)]
fn soon(c: &mut Soon) -> bool {
    c.0 -= 1;
    c.0 == 0
}

struct Beyond(f64);

#[condition(mp)]
fn beyond(c: &mut Beyond, e: &State<(Gantry,)>) -> bool {
    e.0.demanded().joints[0] > c.0
}

#[test]
fn its_speed_is_changed_and_a_move_takes_it_over_as_it_moves() {
    let (result, _, belts) = cell(
        |_, _| {},
        |mp, (arm, belt)| {
            mp.start_robot(belt, Run::at(SPEED))?;
            mp.wait_until((), (), Soon(200))?;
            mp.start_robot(belt, Run::at(SPEED / 2.0))?;
            mp.move_robot(arm, (), Smooth::to(0.1, 0.3))?;
            // Together with the arm: the belt slows down to rest in the list of a Move.
            let stop = Run::at(0.0).steps(100);
            mp.move_robots((&mut *arm, &mut *belt), (), Each::of((Smooth::to(0.0, 0.3), stop)))?;
            assert!(belt.demanded().velocity[0].abs() < 1e-9);
            Ok(())
        },
    );
    result.expect("a motion that takes over goes on at the speed that it finds");
    let belt = moved(&belts);
    // No step of it is missing, and no change of speed is faster than by 2 m/s².
    let speeds: Vec<f64> = belt.windows(2).map(|x| (x[1] - x[0]) * 1e3).collect();
    assert!(speeds.windows(2).all(|v| (v[1] - v[0]).abs() <= ACCELERATION * 1e-3 + 1e-9), "{speeds:?}");
    assert!(speeds.iter().any(|v| (v - SPEED).abs() < 1e-9));
    assert!(speeds.iter().filter(|v| (**v - SPEED / 2.0).abs() < 1e-9).count() > 200);
    assert!(speeds[speeds.len() - 1].abs() < 1e-9);
}

#[test]
fn a_generator_that_is_done_leaves_its_robot_at_rest_and_the_program_goes_on() {
    let (result, arms, belts) = cell(
        |_, _| {},
        |mp, (arm, belt)| {
            assert!(!mp.is_in_background(belt));
            mp.start_robot(belt, Run::at(SPEED).steps(150))?;
            assert!(mp.is_in_background(belt) && !mp.is_in_background(arm));
            mp.move_robot(arm, (), Smooth::to(0.2, 0.6))?;
            // It was done on its own meanwhile.
            assert!(!mp.is_in_background(belt));
            mp.end_robot(belt)?;
            assert_eq!(belt.demanded().velocity[0], 0.0);
            mp.move_robot(belt, (), Smooth::to(0.0, 0.4)).map(drop)
        },
    );
    result.expect("within the limits");
    assert!((arms.borrow().last().expect("recorded")[0] - 0.2).abs() < 1e-12);
    let belts = belts.borrow();
    let farthest = belts.iter().fold(0.0_f64, |most, q| most.max(q[0]));
    assert!((distance(150)..distance(150) + BRAKED).contains(&farthest), "{farthest}");
    assert!(belts[belts.len() - 1][0].abs() < 1e-12, "moved again after it was done");
}

#[test]
fn at_the_end_of_the_program_it_brakes() {
    let (result, _, belts) = cell(
        |_, _| {},
        |mp, (_, belt)| {
            mp.start_robot(belt, Run::at(SPEED))?;
            mp.wait_until((), (), Soon(300)).map(drop)
        },
    );
    result.expect("within the limits");
    let belt = moved(&belts);
    let end = belt[belt.len() - 1];
    assert!((distance(299)..distance(301) + BRAKED).contains(&end), "{end}");
    keeps_to_its_limits(&belts.borrow());
}

/// Fault 37: it stops on its path with the others and goes on with them.
#[test]
fn fault_37_suspend_and_speed_act_on_the_background_as_on_the_others() {
    for at in [1, 2, 60, 150, 399, 400, 401, 500] {
        let (result, arms, belts) = cell(
            move |step, operator| {
                if step == at {
                    operator.suspend();
                }
                if step == at + 700 {
                    operator.resume();
                }
                if step == 1500 {
                    operator.set_speed(0.5).expect("half");
                }
            },
            |mp, (arm, belt)| {
                mp.start_robot(belt, Run::at(SPEED))?;
                mp.move_robot(arm, (), Smooth::to(0.2, 0.4))?;
                mp.move_robot(arm, (), Smooth::to(0.0, 0.4))?;
                mp.wait_until((), (), Soon(900))?;
                mp.end_robot(belt)
            },
        );
        result.unwrap_or_else(|error| panic!("suspended at {at}: {error}"));
        let (arms, belts) = (arms.borrow(), belts.borrow());
        // 400 steps slow it down, whatever the rate's change may be; it stands until 700.
        let from = (at + 450) as usize;
        assert!(belts[from..from + 200].iter().all(|q| *q == belts[from]), "suspended at {at}: it moves");
        assert!(arms[from..from + 200].iter().all(|q| *q == arms[from]), "suspended at {at}: the arm moves");
        keeps_to_its_limits(&belts);
        keeps_to_its_limits(&arms);
        assert!(belts[belts.len() - 1][0] > belts[from][0] + 0.05, "suspended at {at}: it does not go on");
        // At half speed it runs by 0.1 mm a step.
        let late = &belts[2000..2100];
        assert!(
            late.windows(2).all(|q| (q[1][0] - q[0][0] - SPEED * 0.5e-3).abs() < 1e-9) || belts.len() < 2100,
            "suspended at {at}"
        );
    }
}

#[test]
fn fault_36_an_abort_ends_the_background_with_the_instruction_and_the_program_may_go_on() {
    for at in [1, 2, 3, 50, 200, 399, 400, 401, 402, 403, 500, 550] {
        let (result, arms, belts) = cell(
            move |step, operator| {
                if step == at {
                    operator.abort();
                }
            },
            move |mp, (arm, belt)| {
                let outcome = mp.start_robot(belt, Run::at(SPEED)).and_then(|()| {
                    mp.move_robot(arm, (), Smooth::to(0.2, 0.4))?;
                    mp.wait_until((), (), Soon(200)).map(drop)
                });
                let fault = outcome.expect_err("aborted");
                assert_eq!(fault.kind(), FaultKind::Aborted, "aborted at {at}: {fault}");
                // It stands: a Wait sees it hold.
                mp.wait_until((&mut *belt,), (), Soon(5))?;
                assert_eq!(belt.demanded().velocity[0], 0.0, "aborted at {at}");
                mp.end_robot(belt)?;
                let here = belt.demanded().joints[0];
                mp.move_robot(belt, (), Smooth::to(here + 0.01, 0.2)).map(drop)
            },
        );
        result.unwrap_or_else(|error| panic!("aborted at {at}: {error}"));
        keeps_to_its_limits(&arms.borrow());
        keeps_to_its_limits(&belts.borrow());
    }
}

#[test]
fn a_protective_stop_and_a_fault_of_another_robot_stop_it() {
    for at in [1, 50, 250, 420, 600] {
        let (result, arms, belts) = cell(
            move |step, operator| {
                if step == at {
                    operator.protective_stop();
                }
            },
            |mp, (arm, belt)| {
                mp.start_robot(belt, Run::at(SPEED))?;
                mp.move_robot(arm, (), Smooth::to(0.2, 0.4))?;
                mp.wait_until((), (), Soon(2000)).map(drop)
            },
        );
        assert_eq!(fault(result).kind(), FaultKind::ProtectiveStop, "at {at}");
        keeps_to_its_limits(&belts.borrow());
        keeps_to_its_limits(&arms.borrow());
        let belts = belts.borrow();
        assert_eq!(belts[belts.len() - 1], belts[belts.len() - 2], "at {at}: it moves");
    }
    // The arm's generator demands a jump.
    let (result, _, belts) = cell(
        |_, _| {},
        |mp, (arm, belt)| {
            mp.start_robot(belt, Run::at(SPEED))?;
            mp.wait_until((), (), Soon(200))?;
            mp.move_robot(arm, (), Jump(20)).map(drop)
        },
    );
    let fault = fault(result);
    assert_eq!(fault.robot().map(|name| name.to_string()).as_deref(), Some("arm"), "{fault}");
    keeps_to_its_limits(&belts.borrow());
    let end = belts.borrow().last().expect("recorded")[0];
    assert!((distance(215)..distance(235) + BRAKED).contains(&end), "{end}");
}

struct Jump(u32);

#[generator(ecp)]
fn jump(c: &mut Jump) -> Step<Gantry> {
    c.0 = c.0.saturating_sub(1);
    Step::Next(x(if c.0 == 0 { 0.5 } else { 0.0 }))
}

#[test]
fn a_fault_of_its_own_generator_stops_the_cell_with_its_message() {
    let (result, arms, belts) = cell(
        |_, _| {},
        |mp, (arm, belt)| {
            mp.start_robot(belt, Breaks(150))?;
            mp.move_robot(arm, (), Smooth::to(0.2, 0.4)).map(drop)
        },
    );
    assert_eq!(fault(result).message(), "the belt is torn");
    keeps_to_its_limits(&arms.borrow());
    keeps_to_its_limits(&belts.borrow());
    assert!(arms.borrow().last().expect("recorded")[0] < 0.2);
}

struct Breaks(u32);

#[generator(ecp)]
fn breaks(c: &mut Breaks) -> Result<Step<Gantry>, Fault> {
    c.0 -= 1;
    if c.0 == 0 { Err(Fault::thrown("the belt is torn")) } else { Ok(Step::Next(Demand::hold())) }
}

/// Two robots by one generator in the background.
struct Both(Run);

#[generator(mp)]
fn both(c: &mut Both, t: Tick) -> Step<(Gantry, Gantry)> {
    match run(&mut c.0, t) {
        Step::Next(demand) => Step::Next((demand, demand)),
        Step::Done => Step::Done,
    }
}

#[test]
fn a_move_that_names_one_of_two_robots_of_a_motion_is_refused_with_both_names() {
    let (result, arms, belts) = cell(
        |_, _| {},
        |mp, (arm, belt)| {
            mp.start_robots((&mut *arm, &mut *belt), Both(Run::at(SPEED)))?;
            mp.wait_until((), (), Soon(150))?;
            mp.move_robot(arm, (), Smooth::to(0.0, 0.4)).map(drop)
        },
    );
    let fault = fault(result);
    assert_eq!(fault.kind(), FaultKind::Program);
    assert!(fault.message().contains("`arm` and `belt` move in the background by one generator"), "{fault}");
    keeps_to_its_limits(&arms.borrow());
    keeps_to_its_limits(&belts.borrow());
}

#[test]
fn two_robots_of_one_motion_end_together() {
    let (result, arms, belts) = cell(
        |_, _| {},
        |mp, (arm, belt)| {
            mp.start_robots((&mut *arm, &mut *belt), Both(Run::at(SPEED)))?;
            mp.wait_until((), (), Soon(150))?;
            mp.end_robot(arm)?;
            mp.move_robot(belt, (), Smooth::to(0.0, 0.4)).map(drop)
        },
    );
    result.expect("both stand");
    let (arms, belts) = (arms.borrow(), belts.borrow());
    let farthest = |trace: &[Q<3>]| trace.iter().fold(0.0_f64, |most, q| most.max(q[0]));
    assert!((farthest(&arms) - farthest(&belts)).abs() < 1e-12);
}

#[generator(mp)]
fn told() -> Always<(Gantry,), Phase> {
    Always((Phase::Approach,))
}

#[test]
fn an_ecp_with_a_program_of_its_own_works_in_the_background_by_a_loose_order() {
    let ((arm, _), (belt, belts)) = (gantry("arm"), gantry("belt"));
    let belt = belt.program(|ecp| {
        ecp.serve_all(|ecp, _: Phase| {
            ecp.move_robot((), Smooth::to(0.1, 0.3))?;
            ecp.move_robot((), Smooth::to(0.0, 0.3)).map(drop)
        })
    });
    let cell = Cell::new(MS).robot(arm).robot(belt).program(|mp| {
        let (mut arm, mut belt) = (mp.robot::<Gantry>("arm")?, mp.robot::<Gantry>("belt")?);
        for _ in 0..2 {
            mp.start_robots((&mut belt,), told {})?;
            mp.move_robot(&mut arm, (), Smooth::to(0.2, 0.4))?;
            mp.move_robot(&mut arm, (), Smooth::to(0.0, 0.4))?;
        }
        Ok(())
    });
    cell.run().expect("in order");
    let belts = belts.borrow();
    let peaks = belts.windows(3).filter(|q| q[1][0] > 0.0999 && q[0][0] <= q[1][0] && q[1][0] > q[2][0]);
    assert_eq!(peaks.count(), 2, "there and back twice");
}

#[test]
fn a_restart_after_a_fault_finds_nothing_in_the_background() {
    let mut runs = 0;
    let (result, _, belts) = {
        let ((arm, arms), (belt, belts)) = (gantry("arm"), gantry("belt"));
        let cell = Cell::new(MS)
            .robot(arm)
            .robot(belt)
            .after_fault(mrroc::cell::AfterFault::AwaitReset)
            .on_step(|step, operator| {
                if step == 1000 {
                    let _ = operator.acknowledge();
                    let _ = operator.reset();
                }
            })
            .program(move |mp| {
                runs += 1;
                let (mut arm, mut belt) = (mp.robot::<Gantry>("arm")?, mp.robot::<Gantry>("belt")?);
                if runs == 1 {
                    mp.start_robot(&mut belt, Run::at(SPEED))?;
                    mp.move_robot(&mut arm, (), Breaks(200))?;
                }
                let here = belt.demanded().joints[0];
                mp.wait_until((&mut belt,), (), Soon(50))?;
                assert_eq!(belt.demanded().joints[0], here, "it moves after the reset");
                mp.move_robot(&mut belt, (), Smooth::to(here, 0.2)).map(drop)
            });
        (cell.run(), arms, belts)
    };
    result.expect("reset");
    keeps_to_its_limits(&belts.borrow());
}

#[test]
fn a_step_beside_a_motion_in_the_background_allocates_nothing() {
    use mrroc_counting_allocator::allocations;
    let counts = std::rc::Rc::new(std::cell::Cell::new((0, 0)));
    let seen = std::rc::Rc::clone(&counts);
    let still = |name| RobotSetup::new(name, Gantry::default(), ExactDrive::new(Q::<3>::zeros(), MS));
    let cell = Cell::new(MS).robot(still("arm")).robot(still("belt"));
    let cell = cell.on_step(move |step, _| match step {
        20 => seen.set((allocations(), 0)),
        380 => seen.set((seen.get().0, allocations())),
        _ => {}
    });
    let cell = cell.program(|mp| {
        let (mut arm, mut belt) = (mp.robot::<Gantry>("arm")?, mp.robot::<Gantry>("belt")?);
        mp.start_robot(&mut belt, Run::at(SPEED))?;
        mp.move_robot(&mut arm, (), Smooth::to(0.2, 0.4)).map(drop)
    });
    cell.run().expect("within the limits");
    let (warm, end) = counts.get();
    assert!(warm > 0, "nothing was counted");
    assert_eq!(end - warm, 0, "allocations in 360 steps");
}

#[test]
fn while_it_moves_an_abort_is_taken_between_instructions_too() {
    let (arm, _) = gantry("arm");
    let cell = Cell::new(MS).robot(arm);
    let operator = cell.operator();
    let cell = cell.program(move |mp| {
        let mut arm = mp.robot::<Gantry>("arm")?;
        mp.start_robot(&mut arm, Run::at(SPEED))?;
        assert!(operator.is_running());
        mp.wait_until((), (), Soon(100))?;
        operator.abort();
        let aborted = mp.wait_until((), (), Soon(100)).map(drop).expect_err("aborted");
        assert_eq!(aborted.kind(), FaultKind::Aborted);
        assert!(!operator.is_running());
        mp.wait_until((&mut arm,), (), Soon(2))?;
        assert_eq!(arm.demanded().velocity[0], 0.0);
        mp.start_robot(&mut arm, Run::at(SPEED))?;
        mp.end_robot(&mut arm)?;
        assert!(!operator.is_running());
        Ok(())
    });
    cell.run().expect("it goes on after the abort");
}
