//! Blend: what moving robots do after a Move, with and without a next Move that takes them over.

use std::rc::Rc;

use mrroc::fault::FaultKind;
use mrroc::generator::RobotHandle;
use mrroc::prelude::*;
use mrroc_tests::{Gantry, MS, Q, Trace, fault, gantry, peaks};

use crate::runtime::kit::{Along, Counter, Counting, Phase, transmit, x};

/// Speeds up along x by 10 m/s² to 0.5 m/s in 50 steps, and ends there.
struct Up {
    steps: u32,
    speed: f64,
    x: f64,
}

impl Up {
    const fn new() -> Up {
        Up { steps: 50, speed: 0.0, x: 0.0 }
    }

    fn advance(&mut self, dt: f64) -> Option<f64> {
        self.steps = self.steps.checked_sub(1)?;
        self.speed += 10.0 * dt;
        self.x += self.speed * dt;
        Some(self.x)
    }
}

#[generator(mp)]
fn up(c: &mut Up, t: Tick) -> Step<(Gantry,)> {
    c.advance(t.dt).map_or(Step::Done, |position| Step::Next((x(position),)))
}

/// The same for an ECP that transmits numbers.
struct UpBy(Up);

#[generator(mp)]
fn up_by(c: &mut UpBy, t: Tick) -> Step<(Gantry,), Along> {
    c.0.advance(t.dt).map_or(Step::Done, |x| Step::Next((Along { x },)))
}

struct Nothing;

#[generator(mp)]
fn nothing(_c: &mut Nothing) -> Step<(Gantry,)> {
    Step::Done
}

struct Holding(u32);

#[generator(mp)]
fn holding(c: &mut Holding) -> Step<(Gantry,)> {
    if c.0 == 0 {
        return Step::Done;
    }
    c.0 -= 1;
    Step::Next((mrroc::generator::Demand::hold(),))
}

/// 0.5 m/s at 10 m/s²: v² / 2a beyond the distance of speeding up, 1e-5 (1 + 2 + .. + 50).
const BRAKED_END: f64 = 1e-5 * 1275.0 + 0.5 * 0.5 / 20.0;

fn brakes_at_once(trace: &[Q<3>]) {
    assert!(peaks(trace, 1e-3).1 <= 10.0 + 1e-6, "{:?}", peaks(trace, 1e-3));
    let end = trace.last().expect("recorded")[0];
    assert!((end - BRAKED_END).abs() < 1e-9, "stops at {end}, not at {BRAKED_END}");
}

fn two(
    mut program: impl FnMut(&mut Mp, RobotHandle<Gantry>, RobotHandle<Gantry>) -> Result<(), Fault> + 'static,
) -> (Result<mrroc::cell::RunReport, mrroc::cell::CellError>, Trace<3>) {
    let ((left, trace), (right, _)) = (gantry("left"), gantry("right"));
    let cell = Cell::new(MS).robot(left).robot(right).program(move |mp| {
        let (left, right) = (mp.robot("left")?, mp.robot("right")?);
        program(mp, left, right)
    });
    (cell.run(), trace)
}

#[test]
fn a_blend_at_the_end_of_the_program_brakes() {
    let (result, trace) = two(|mp, mut left, _| mp.blend_robots((&mut left,), (), Up::new()).map(drop));
    result.expect("brakes within the limits");
    brakes_at_once(&trace.borrow());
}

#[test]
fn a_blend_that_a_wait_follows_brakes_before_the_wait() {
    let (result, trace) = two(|mp, mut left, _| {
        mp.blend_robots((&mut left,), (), Up::new())?;
        mp.wait_until((&mut left,), (), Soon(1))?;
        assert!(left.demanded().velocity.norm() <= 1e-9);
        Ok(())
    });
    result.expect("brakes within the limits");
    brakes_at_once(&trace.borrow());
}

struct Soon(u32);

#[condition(mp)]
fn soon(c: &mut Soon) -> bool {
    c.0 -= 1;
    c.0 == 0
}

#[test]
fn a_blend_that_a_motion_of_no_steps_takes_over_brakes() {
    let (result, trace) = two(|mp, mut left, _| {
        mp.blend_robots((&mut left,), (), Up::new())?;
        mp.move_robots((&mut left,), (), Nothing)?;
        assert!(left.demanded().velocity.norm() <= 1e-9, "returned while the robot moves");
        mp.wait_until((), (), Soon(100)).map(drop)
    });
    result.expect("brakes within the limits");
    brakes_at_once(&trace.borrow());
}

#[test]
fn a_program_that_fails_after_a_blend_leaves_no_robot_moving() {
    let (result, trace) = two(|mp, mut left, _| {
        mp.blend_robots((&mut left,), (), Up::new())?;
        Err(Fault::thrown("the drawing has no second line"))
    });
    assert_eq!(fault(result).message(), "the drawing has no second line");
    brakes_at_once(&trace.borrow());
}

#[test]
fn a_move_that_does_not_name_a_robot_handed_over_is_refused_and_that_robot_brakes() {
    let (result, trace) = two(|mp, mut left, mut right| {
        mp.blend_robots((&mut left,), (), Up::new())?;
        mp.move_robots((&mut right,), (), Holding(100)).map(drop)
    });
    let fault = fault(result);
    assert_eq!(fault.kind(), FaultKind::Program, "{fault}");
    assert!(fault.message().contains("left"), "{fault}");
    brakes_at_once(&trace.borrow());
}

#[test]
fn a_robot_whose_program_is_over_brakes_from_a_blend_at_once() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| ecp.serve(|ecp, _: Along| ecp.move_robot((), transmit {}).map(drop)));
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.blend_robots((&mut g,), (), UpBy(Up::new()))?;
        mp.wait_until((), (), Soon(100)).map(drop)
    });
    cell.run().expect("brakes within the limits");
    brakes_at_once(&trace.borrow());
}

/// Triggers for so many steps.
struct Triggering(u32);

#[generator(mp)]
fn triggering(c: &mut Triggering) -> Step<(Gantry,), Phase> {
    if c.0 == 0 {
        return Step::Done;
    }
    c.0 -= 1;
    Step::Next((Phase::Approach,))
}

/// A path of the ECP's own: on at the speed that the robot has.
struct On {
    speed: f64,
    x: f64,
    steps: u32,
}

impl On {
    fn until(steps: u32) -> On {
        On { speed: 0.0, x: 0.0, steps }
    }
}

#[generator(ecp, first = from_here)]
fn on(c: &mut On, t: Tick) -> Step<Gantry> {
    if c.steps == 0 {
        return Step::Done;
    }
    c.steps -= 1;
    c.x += c.speed * t.dt;
    Step::Next(x(c.x))
}

fn from_here(c: &mut On, e: &mrroc::robot::State<Gantry>, t: Tick) -> Step<Gantry> {
    (c.x, c.speed) = (e.demanded().joints[0], e.demanded().velocity[0]);
    on(c, t)
}

struct EcpUp(Up);

#[generator(ecp)]
fn ecp_up(c: &mut EcpUp, t: Tick) -> Step<Gantry> {
    c.0.advance(t.dt).map_or(Step::Done, |position| Step::Next(x(position)))
}

#[test]
fn a_blend_of_the_mp_hands_over_a_robot_in_the_middle_of_a_path_of_its_own() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.serve(|ecp, _: Phase| {
            ecp.blend_robot((), EcpUp(Up::new()))?;
            ecp.move_robot((), On::until(1000)).map(drop)
        })?;
        ecp.serve(|ecp, _: Phase| ecp.move_robot((), On::until(100)).map(drop))
    });
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.blend_robots((&mut g,), (), Triggering(150))?;
        mp.move_robots((&mut g,), (), trigger {}).map(drop)
    });
    cell.run().expect("the hand-over keeps the limits");
    let trace = trace.borrow();
    assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6);
    let cruising = trace.windows(2).filter(|pair| ((pair[1] - pair[0])[0] / 1e-3 - 0.5).abs() < 1e-9).count();
    // The last step up, 100 steps of the first instruction, 100 of the second.
    assert_eq!(cruising, 201);
}

#[generator(mp)]
fn trigger() -> Always<(Gantry,), Phase> {
    Always((Phase::Approach,))
}

#[test]
fn a_blend_with_a_robot_in_its_braking_tail_waits_for_it_and_brakes_the_others() {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    // Its own motion ends at speed in step 50: it brakes for 50 steps, in the middle of which the MP's ends.
    let left = left.program(|ecp| {
        ecp.serve(|ecp, _: Phase| ecp.move_robot((), EcpUp(Up::new())).map(drop))?;
        ecp.serve(|_, _: Phase| Ok(()))
    });
    let right = right.program(|ecp| {
        ecp.serve(|ecp, _: Phase| {
            ecp.blend_robot((), EcpUp(Up::new()))?;
            ecp.move_robot((), On::until(1000)).map(drop)
        })?;
        ecp.serve(|_, _: Phase| Ok(()))
    });
    let cell = Cell::new(MS).robot(left).robot(right).program(|mp| {
        let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
        mp.blend_robots((&mut left, &mut right), (), Both(75))?;
        mp.move_robots((&mut left, &mut right), (), both_told {}).map(drop)
    });
    cell.run().expect("both keep the limits");
    for trace in [left_trace, right_trace] {
        let trace = trace.borrow();
        assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6);
        assert_eq!(trace[trace.len() - 1], trace[trace.len() - 2], "not at standstill");
    }
}

struct Both(u32);

#[generator(mp)]
fn both(c: &mut Both) -> Step<(Gantry, Gantry), Phase> {
    if c.0 == 0 {
        return Step::Done;
    }
    c.0 -= 1;
    Step::Next((Phase::Approach, Phase::Approach))
}

#[generator(mp)]
fn both_told() -> Always<(Gantry, Gantry), Phase> {
    Always((Phase::Approach, Phase::Approach))
}

#[test]
fn a_motion_handed_over_while_suspended_goes_on_at_resume() {
    // The motion ends in the very step in which the rate has come to 0: found by trying every step.
    let resumed = Rc::new(std::cell::Cell::new(0_u32));
    for at in 1..60 {
        let (robot, _) = gantry("g");
        let count = Rc::clone(&resumed);
        let cell = Cell::new(MS)
            .robot(robot)
            .on_step(move |step, operator| match step {
                _ if step == at => operator.suspend(),
                _ if step == at + 600 => operator.resume(),
                _ => {}
            })
            .program(move |mp| {
                let mut g = mp.robot::<Gantry>("g")?;
                mp.blend_robots((&mut g,), (), UpFor { calls: 60, up: Up { steps: 300, ..Up::new() } })?;
                let up = mp.move_robots((&mut g,), (), Holding(1));
                count.set(count.get() + 1);
                up.map(drop)
            });
        cell.run().unwrap_or_else(|error| panic!("suspended at {at}: {error}"));
    }
    assert_eq!(resumed.get(), 59);
}

/// Ends after so many calls, moving or suspended: an end that path time has no part in.
struct UpFor {
    calls: u32,
    up: Up,
}

#[generator(mp)]
fn up_for(c: &mut UpFor, t: Tick) -> Step<(Gantry,)> {
    if c.calls == 0 {
        return Step::Done;
    }
    c.calls -= 1;
    // 1 m/s² at most, so that the next motion's hold is within the limits.
    c.up.x += 0.009 * t.dt;
    Step::Next((x(c.up.x),))
}

/// Goes on at 0.5 m/s for 100 steps; looks at a sensor from the second step on.
struct Onward {
    steps: u32,
    x: f64,
}

#[generator(mp, first = begin)]
fn onward(c: &mut Onward, _v: &Reading<(Counter,)>, t: Tick) -> Step<(Gantry,)> {
    begin(c, t)
}

fn begin(c: &mut Onward, t: Tick) -> Step<(Gantry,)> {
    if c.steps == 0 {
        return Step::Done;
    }
    c.steps -= 1;
    c.x += 0.5 * t.dt;
    Step::Next((x(c.x),))
}

#[test]
fn a_motion_that_takes_over_loses_no_step_by_asking_for_the_robot_of_its_sensor() {
    let ((a, trace), (b, _)) = (gantry("a"), gantry("b"));
    // The sensor is of a robot that nobody has asked for its state yet.
    let sensor = SensorSetup::new("counter", Counting::default()).of("b");
    let cell = Cell::new(MS).robot(a).robot(b).sensor(sensor).program(|mp| {
        let mut a = mp.robot::<Gantry>("a")?;
        let mut counter = mp.sensor::<Counter>("counter")?;
        mp.blend_robots((&mut a,), (), Up::new())?;
        let x = a.demanded().joints[0];
        mp.move_robots((&mut a,), (&mut counter,), Onward { steps: 100, x })?;
        Ok(())
    });
    cell.run().expect("nothing jumps");
    let trace = trace.borrow();
    let first = trace.iter().position(|q| q[0] > 0.0).expect("it moves");
    // 50 steps of speeding up, then 100 of 0.5 mm, without a hole where the motions meet.
    let speeds: Vec<_> =
        trace[first + 49..first + 149].windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
    assert!(speeds.iter().all(|d| (d - 0.5e-3).abs() < 1e-9), "{speeds:?}");
}
