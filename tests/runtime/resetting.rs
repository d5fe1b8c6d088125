//! After a fault stop: latch, acknowledgement, reset, and programs that start again where the robots stand.

use std::cell::{Cell as Shared, RefCell};
use std::rc::Rc;
use std::time::Duration;

use mrroc::cell::{AfterFault, RunReport};
use mrroc::fault::{Excess, FaultKind};
use mrroc::operator::{Latch, LatchRefusal, Operator};
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, Measured};
use mrroc::sensor::VspMode;
use mrroc_tests::{Gantry, MS, Q, fault, gantry, peaks, traced};

use crate::runtime::kit::{Counter, Counting, Phase, Smooth};

/// The left gantry to `end` and the right one to `-end` \[m\], by a smoothstep of 1 s from where they are; throws a fault
/// in a step, if it is to.
struct Mirror {
    end: f64,
    throws_at: Option<u64>,
    t: f64,
    from: [f64; 2],
}

impl Mirror {
    fn to(end: f64, throws_at: Option<u64>) -> Self {
        Mirror { end, throws_at, t: 0.0, from: [0.0; 2] }
    }
}

#[generator(mp, first = mirror_start)]
fn mirror(c: &mut Mirror, t: Tick) -> Result<Step<(Gantry, Gantry)>, Fault> {
    if c.throws_at == Some(t.step) {
        return Err(Fault::thrown("enough"));
    }
    if c.t >= 1.0 {
        return Ok(Step::Done);
    }
    c.t = (c.t + t.dt).min(1.0);
    let s = c.t * c.t * (3.0 - 2.0 * c.t);
    let at = |from: f64, end: f64| Demand::joints(Q::<3>::new(from + (end - from) * s, 0.0, 0.0));
    Ok(Step::Next((at(c.from[0], c.end), at(c.from[1], -c.end))))
}

fn mirror_start(
    c: &mut Mirror,
    e: &State<(Gantry, Gantry)>,
    t: Tick,
) -> Result<Step<(Gantry, Gantry)>, Fault> {
    c.from = [e.0.demanded().joints[0], e.1.demanded().joints[0]];
    mirror(c, t)
}

/// The result of a run with its operator.
struct Seen {
    outcome: Result<RunReport, mrroc::cell::CellError>,
    left: Vec<Q<3>>,
    right: Vec<Q<3>>,
    runs: u32,
}

/// Two gantries to 0.4 m; the program's first run throws a fault in `throws_at`.
fn run(after: AfterFault, throws_at: u64, act: impl FnMut(u64, &Operator) + 'static) -> Seen {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    let runs = Rc::new(Shared::new(0));
    let count = Rc::clone(&runs);
    let cell = Cell::new(MS).robot(left).robot(right).after_fault(after).on_step(act).program(move |mp| {
        count.set(count.get() + 1);
        let (mut left, mut right) = (mp.robot("left")?, mp.robot("right")?);
        let throws_at = (count.get() == 1).then_some(throws_at);
        mp.move_robots((&mut left, &mut right), (), Mirror::to(0.4, throws_at)).map(drop)
    });
    let outcome = cell.run();
    let runs = runs.get();
    Seen { outcome, left: left_trace.take(), right: right_trace.take(), runs }
}

/// Acknowledges and resets as soon as the robots stand.
fn attend(operator: &Operator) {
    if operator.latch() == Latch::Latched {
        operator.acknowledge().expect("latched");
        operator.reset().expect("acknowledged");
    }
}

/// Whether a trace stands still from period `from` to `to`.
fn stands(trace: &[Q<3>], from: usize, to: usize) -> bool {
    trace[from..to].windows(2).all(|w| w[0] == w[1])
}

#[test]
fn fault_40_after_acknowledgement_and_reset_programs_start_again_from_their_first_line() {
    // In every part of the motion: speeding up, fast, slowing down.
    for throws_at in [0, 1, 50, 300, 500, 700, 999] {
        let seen = run(AfterFault::AwaitReset, throws_at, |_, operator| attend(operator));
        seen.outcome.unwrap_or_else(|why| panic!("thrown in step {throws_at}: {why}"));
        assert_eq!(seen.runs, 2, "thrown in step {throws_at}");
        for (trace, end) in [(&seen.left, 0.4), (&seen.right, -0.4)] {
            assert!((trace[trace.len() - 1][0] - end).abs() < 1e-9, "thrown in step {throws_at}");
            let (v, a) = peaks(trace, 1e-3);
            assert!(v <= 1.0 && a <= 10.0 + 1e-6, "thrown in step {throws_at}: {v} m/s, {a} m/s²");
        }
    }
}

#[test]
fn a_cell_that_is_not_told_to_wait_ends_with_its_first_cause() {
    let seen = run(AfterFault::End, 300, |_, operator| attend(operator));
    let fault = fault(seen.outcome);
    assert_eq!((fault.message(), seen.runs), ("enough", 1), "{fault}");
}

#[test]
fn fault_40_a_reset_that_is_held_or_comes_before_the_acknowledgement_does_nothing_and_says_why() {
    let said = Rc::new(RefCell::new(Vec::new()));
    let keep = Rc::clone(&said);
    let mut since: Option<u64> = None;
    let seen = run(AfterFault::AwaitReset, 300, move |step, operator| {
        if operator.latch() == Latch::Stopping {
            assert_eq!(operator.acknowledge(), Err(LatchRefusal::Stopping));
            assert_eq!(operator.reset(), Err(LatchRefusal::Stopping));
        }
        if operator.latch() == Latch::Latched && since.is_none() {
            since = Some(step);
        }
        let Some(since) = since else { return };
        let say = |what| keep.borrow_mut().push((step - since, what));
        match step - since {
            0 => {
                assert_eq!(operator.fault().expect("latched").message(), "enough");
                say(operator.reset());
                say(operator.press_reset(true));
            }
            100 => say(operator.acknowledge()),
            101 => say(operator.press_reset(true)),
            102 => say(operator.reset()),
            200 => {
                say(operator.press_reset(false));
                say(operator.press_reset(true));
            }
            201 => assert_ne!(operator.latch(), Latch::Acknowledged),
            _ => {}
        }
    });
    seen.outcome.expect("it was reset");
    assert_eq!(
        *said.borrow(),
        [
            (0, Err(LatchRefusal::NotAcknowledged)),
            (0, Err(LatchRefusal::NotAcknowledged)),
            (100, Ok(())),
            (101, Err(LatchRefusal::Held)),
            (102, Err(LatchRefusal::Held)),
            (200, Ok(())),
            (200, Ok(())),
        ]
    );
    // 300 steps of the motion, 0.504 m/s / 10 m/s² of braking, 200 steps of standing; nothing moved in these.
    assert!(stands(&seen.left, 360, 550) && stands(&seen.right, 360, 550));
    assert!(!stands(&seen.left, 300, 350) && !stands(&seen.left, 550, 600));
}

#[test]
fn an_operator_that_gives_up_ends_a_latched_cell_with_its_first_cause() {
    let mut latched = 0;
    let seen = run(AfterFault::AwaitReset, 300, move |_, operator| {
        latched += u32::from(operator.latch() == Latch::Latched);
        if latched == 500 {
            operator.give_up();
        }
    });
    assert_eq!((fault(seen.outcome).message(), seen.runs), ("enough", 1));
}

/// Drives that trip at a tick, do not come on at their first tries, and can be pushed while they have no power.
struct Trips {
    at: f64,
    ticks: u32,
    trips_at: u32,
    fails: u32,
    push: f64,
    off: Rc<Shared<bool>>,
}

impl Driver<Gantry> for Trips {
    fn period(&self) -> core::time::Duration {
        MS
    }

    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Ok(Measured { position: Q::<3>::new(self.at, 0.0, 0.0), velocity: Q::zeros() })
    }

    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        assert!(!self.off.get(), "ticked without power");
        self.ticks += 1;
        if self.ticks == self.trips_at {
            self.off.set(true);
            return Err(DriveFault::exceeded(0, "motor current", Excess::new(30.0, 25.0, "A")));
        }
        self.at = demanded[0];
        self.measured()
    }

    fn has_brakes(&self) -> bool {
        true
    }

    fn switch_off(&mut self) {
        self.off.set(true);
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        assert!(self.off.get(), "switched on twice");
        if self.fails > 0 {
            self.fails -= 1;
            return Err(DriveFault::exceeded(0, "bus voltage", Excess::new(0.0, 40.0, "V")));
        }
        self.off.set(false);
        // The robot was pushed while it had no power.
        self.at += core::mem::take(&mut self.push);
        Ok(())
    }
}

#[test]
fn fault_40_a_reset_while_the_cause_persists_leaves_the_cell_latched_and_tells_the_cause() {
    let off = Rc::new(Shared::new(false));
    let drives = Trips { at: 0.0, ticks: 0, trips_at: 400, fails: 2, push: 0.03, off: Rc::clone(&off) };
    let (robot, trace) = traced(RobotSetup::new("g", Gantry::default(), drives));
    let (other, other_trace) = gantry("other");
    let (told, runs) = (Rc::new(RefCell::new(Vec::new())), Rc::new(Shared::new(0)));
    let (keep, count) = (Rc::clone(&told), Rc::clone(&runs));
    let cell = Cell::new(MS)
        .robot(robot)
        .robot(other)
        .after_fault(AfterFault::AwaitReset)
        .on_step(move |_, operator| {
            if operator.latch() == Latch::Latched {
                let persisting = operator.persisting().map(|fault| fault.message().to_owned());
                keep.borrow_mut().push((operator.fault().map(|fault| fault.kind()), persisting));
            }
            attend(operator);
        })
        .program(move |mp| {
            count.set(count.get() + 1);
            let (mut g, mut other) = (mp.robot("g")?, mp.robot("other")?);
            mp.move_robots((&mut g, &mut other), (), Mirror::to(0.4, None)).map(drop)
        });
    cell.run().expect("the third reset succeeds");
    let voltage = Some("bus voltage".to_owned());
    let cause = Some(FaultKind::DriveFault);
    assert_eq!(*told.borrow(), [(cause, None), (cause, voltage.clone()), (cause, voltage)]);
    assert_eq!(runs.get(), 2);
    // The demand began where the robot was pushed to, and the motion from there.
    let trace = trace.borrow();
    let (tripped, last) = (trace[399][0], trace[trace.len() - 1][0]);
    assert!((trace[400][0] - tripped - 0.03).abs() < 2e-3, "{} and {}", tripped, trace[400][0]);
    assert!((last - 0.4).abs() < 1e-9);
    let (v, a) = peaks(&trace[400..], 1e-3);
    assert!(v <= 1.0 && a <= 10.0 + 1e-6, "{v} m/s, {a} m/s²");
    let (v, a) = peaks(&other_trace.borrow(), 1e-3);
    assert!(v <= 1.0 && a <= 10.0 + 1e-6, "{v} m/s, {a} m/s²");
}

#[test]
fn what_a_fault_stop_has_switched_off_comes_on_again_and_what_cannot_be_switched_holds_what_it_was_told() {
    let off = Rc::new(Shared::new(false));
    let drives = Trips { at: 0.0, ticks: 0, trips_at: u32::MAX, fails: 0, push: 0.0, off: Rc::clone(&off) };
    let (robot, _) = traced(RobotSetup::new("g", Gantry::default(), drives));
    // The drives lag: they never quite reach their demand, as fingers that hold a body.
    let (other, other_trace) = gantry("other");
    let were_off = Rc::new(Shared::new(0));
    let (count, runs) = (Rc::clone(&were_off), Rc::new(Shared::new(0)));
    let mut latched = 0;
    let cell = Cell::new(MS)
        .robot(robot)
        .robot(other)
        .after_fault(AfterFault::AwaitReset)
        .on_step(move |_, operator| {
            latched += u32::from(operator.latch() == Latch::Latched);
            count.set(count.get() + u32::from(operator.latch() == Latch::Latched && off.get()));
            if latched > 20 {
                attend(operator);
            }
        })
        .program(move |mp| {
            runs.set(runs.get() + 1);
            let (mut g, mut other) = (mp.robot("g")?, mp.robot("other")?);
            let throws_at = (runs.get() == 1).then_some(300);
            mp.move_robots((&mut g, &mut other), (), Mirror::to(0.4, throws_at)).map(drop)
        });
    cell.run().expect("reset");
    assert!(were_off.get() >= 20, "{}", were_off.get());
    assert!((other_trace.borrow().last().expect("moved")[0] + 0.4).abs() < 1e-9);
}

#[test]
fn programs_of_ecps_start_again_with_their_sensors_and_their_obedience() {
    use crate::runtime::kit::{Counter, Counting};
    let (robot, trace) = gantry("g");
    let runs = Rc::new(RefCell::new((0, 0)));
    let (ecps, mps) = (Rc::clone(&runs), Rc::clone(&runs));
    let robot = robot.program(move |ecp| {
        ecps.borrow_mut().0 += 1;
        let first = ecps.borrow().0 == 1;
        let _counter = ecp.sensor::<Counter>("counter")?;
        ecp.serve_all(|ecp, phase: Phase| {
            if phase == Phase::Retreat && first {
                return Err(Fault::thrown("not today"));
            }
            let end = if phase == Phase::Approach { 0.2 } else { 0.0 };
            ecp.move_robot((), Smooth::to(end, 0.5)).map(drop)
        })
    });
    let cell = Cell::new(MS)
        .robot(robot)
        .sensor(mrroc::cell::SensorSetup::new("counter", Counting::default()).of("g"))
        .after_fault(AfterFault::AwaitReset)
        .on_step(|_, operator| attend(operator))
        .program(move |mp| {
            mps.borrow_mut().1 += 1;
            let mut g = mp.robot::<Gantry>("g")?;
            for phase in [Phase::Approach, Phase::Retreat] {
                mp.move_robots((&mut g,), (), Orders(phase))?;
            }
            Ok(())
        });
    cell.run().expect("the second run succeeds");
    assert_eq!(*runs.borrow(), (2, 2));
    assert!(trace.borrow().last().expect("moved")[0].abs() < 1e-9);
}

/// One phase, until the ECP has finished it.
struct Orders(Phase);

#[generator(mp)]
fn orders(c: &mut Orders) -> mrroc::generator::Always<(Gantry,), Phase> {
    mrroc::generator::Always((c.0,))
}

#[test]
fn a_guard_that_still_sees_what_it_forbids_lets_no_reset_pass() {
    let (robot, trace) = gantry("g");
    let (other, _) = gantry("other");
    let mut tries = 0;
    let seen = Rc::new(RefCell::new(Vec::new()));
    let keep = Rc::clone(&seen);
    let fault = fault(
        Cell::new(MS)
            .robot(robot)
            .robot(other)
            .guard(25, |robots| {
                let at = robots[0].demanded.joints[0];
                if at > 0.1 { Err(Fault::thrown("behind the fence")) } else { Ok(()) }
            })
            .after_fault(AfterFault::AwaitReset)
            .on_step(move |_, operator| {
                if operator.latch() == Latch::Latched {
                    keep.borrow_mut().push(operator.persisting().map(|fault| fault.kind()));
                    tries += 1;
                    if tries == 4 {
                        operator.give_up();
                    }
                }
                attend(operator);
            })
            .program(|mp| {
                let (mut g, mut other) = (mp.robot("g")?, mp.robot("other")?);
                mp.move_robots((&mut g, &mut other), (), Mirror::to(0.4, None)).map(drop)
            })
            .run(),
    );
    assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
    let again = Some(FaultKind::ProtectiveStop);
    assert_eq!(*seen.borrow(), [None, again, again, again]);
    // The robot stopped once, and has not moved since.
    let trace = trace.borrow();
    let end = trace[trace.len() - 1];
    let stopped = trace.iter().position(|q| *q == end).expect("it stands");
    // Three resets were tried, of a step each at least.
    assert!(stands(&trace, stopped, trace.len()) && trace.len() - stopped >= 6);
}

#[test]
fn fault_40_a_guard_that_panicked_forbids_every_reset_and_says_so() {
    let ((robot, trace), (other, _)) = (gantry("g"), gantry("other"));
    let (told, runs) = (Rc::new(RefCell::new(Vec::new())), Rc::new(Shared::new(0)));
    let (keep, count) = (Rc::clone(&told), Rc::clone(&runs));
    let mut steps = 0;
    let fault = fault(
        Cell::new(MS)
            .robot(robot)
            .robot(other)
            .guard(1, |robots| {
                assert!(robots[0].demanded.joints[0] < 0.1, "no place for this robot");
                Ok(())
            })
            .after_fault(AfterFault::AwaitReset)
            .on_step(move |_, operator| {
                if !matches!(operator.latch(), Latch::Latched | Latch::Acknowledged) {
                    return;
                }
                steps += 1;
                // What forbids a reset is known from the first step on in which the cell is latched.
                if steps == 2 {
                    operator.acknowledge().expect("latched");
                }
                if steps > 1 {
                    let persisting = operator.persisting().map(|fault| fault.kind());
                    keep.borrow_mut().push((persisting, operator.reset()));
                }
                if steps >= 4 {
                    operator.give_up();
                }
            })
            .program(move |mp| {
                count.set(count.get() + 1);
                let (mut g, mut other) = (mp.robot("g")?, mp.robot("other")?);
                mp.move_robots((&mut g, &mut other), (), Mirror::to(0.4, None)).map(drop)
            })
            .run(),
    );
    assert_eq!(fault.kind(), FaultKind::Panicked, "{fault}");
    let refused = (Some(FaultKind::Panicked), Err(LatchRefusal::CausePersists));
    assert_eq!(*told.borrow(), [refused, refused, refused]);
    assert_eq!(runs.get(), 1);
    let trace = trace.borrow();
    let stopped = trace.iter().position(|q| *q == trace[trace.len() - 1]).expect("it stands");
    assert!(stands(&trace, stopped, trace.len()));
}

#[test]
fn fault_36_a_protective_stop_of_the_operator_in_any_step_stops_both_robots_on_their_path_and_latches() {
    for at in (1..1005).step_by(37) {
        let seen = run(AfterFault::End, u64::MAX, move |step, operator| {
            if step == at {
                operator.protective_stop();
            }
        });
        let fault = fault(seen.outcome);
        assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "pressed in step {at}: {fault}");
        // The mirror image: one on its path, the other one there, too.
        assert!(seen.left.iter().zip(&seen.right).all(|(l, r)| (l[0] + r[0]).abs() < 1e-12), "at {at}");
        let (v, a) = peaks(&seen.left, 1e-3);
        assert!(v <= 1.0 && a <= 10.0 + 1e-6, "pressed in step {at}: {v} m/s, {a} m/s²");
        // What it moves by in its last step, its acceleration limit takes away in the next one.
        let last = seen.left.windows(2).last().map_or(0.0, |w| (w[1] - w[0]).norm());
        assert!(last <= 10.0 * 1e-6, "pressed in step {at}: {last} m");
    }
}

#[test]
fn a_protective_stop_between_two_instructions_or_during_a_reset_lets_nothing_move() {
    // Before the first step of the first Move, and then in each of the steps of the reset that follows.
    for wait in 1..6 {
        let mut pressed = 0;
        let mut resets = 0;
        let seen = run(AfterFault::AwaitReset, u64::MAX, move |step, operator| {
            match operator.latch() {
                Latch::Clear if step == 1 => operator.protective_stop(),
                Latch::Resetting => {
                    resets += 1;
                    if resets == wait && pressed == 0 {
                        pressed += 1;
                        operator.protective_stop();
                    }
                }
                Latch::Latched if pressed == 1 => operator.give_up(),
                _ => {}
            }
            attend(operator);
        });
        let Err(mrroc::cell::CellError::Fault(fault)) = seen.outcome else {
            panic!("pressed {wait} steps into the reset, it ran on: {:?}", seen.outcome)
        };
        assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
        assert!(stands(&seen.left, 0, seen.left.len()), "it moved, pressed {wait} steps into the reset");
        assert_eq!(seen.runs, 1, "pressed {wait} steps into the reset");
    }
}

/// A sensor that gives up at a reading.
struct Gives {
    left: u32,
}

impl mrroc::sensor::VirtualSensor for Gives {
    type Kind = crate::runtime::kit::Counter;

    fn aggregate(
        &mut self,
        order: &mrroc::sensor::ReadingOrder<crate::runtime::kit::Offset>,
    ) -> Result<crate::runtime::kit::Count, Fault> {
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            return Err(Fault::thrown("the cable is cut"));
        }
        Ok(crate::runtime::kit::Count { count: u64::from(self.left), x: 0.0, step: order.step })
    }
}

/// Along x to 0.4 m in 1 s, with a sensor.
struct Sees(Smooth);

#[generator(ecp)]
fn sees(c: &mut Sees, _v: &mrroc::sensor::Reading<(crate::runtime::kit::Counter,)>, t: Tick) -> Step<Gantry> {
    c.0.advance(t.dt).map_or(Step::Done, |x| Step::Next(crate::runtime::kit::x(x)))
}

#[test]
fn fault_25_robots_stop_on_their_paths_together_when_a_sensor_of_one_of_them_fails() {
    for fails_at in [2, 50, 300, 500, 800] {
        let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
        let left = left.program(|ecp| {
            let mut counter = ecp.sensor::<crate::runtime::kit::Counter>("counter")?;
            ecp.move_robot((&mut counter,), Sees(Smooth::to(0.4, 1.0))).map(drop)
        });
        let right = right.program(|ecp| ecp.move_robot((), Smooth::to(0.4, 1.0)).map(drop));
        let sensor = mrroc::cell::SensorSetup::new("counter", Gives { left: fails_at }).of("left");
        let fault = fault(Cell::new(MS).robot(left).robot(right).sensor(sensor).run());
        assert_eq!(fault.message(), "the cable is cut", "{fault}");
        let (left, right) = (left_trace.borrow(), right_trace.borrow());
        let (_, a) = peaks(&left, 1e-3);
        assert!(a <= 10.0 + 1e-6 && left[left.len() - 1] == left[left.len() - 2], "{a} m/s²");
        // Both ran the same path, and stopped at one place of it.
        assert!(left.iter().zip(right.iter()).all(|(l, r)| (l - r).norm() < 1e-12), "fails at {fails_at}");
    }
}

/// Keeps what it reads, and for how many steps it has been asking when it does.
struct Asking(Rc<RefCell<Vec<Option<u32>>>>, u32);

#[generator(ecp)]
fn asking(c: &mut Asking, v: &Reading<(Counter,)>) -> Step<Gantry> {
    // The orders of one or two steps were out before its first step; a free-running sensor has read in the three before that.
    let since = c.1 + 2 + 3;
    c.1 += 1;
    let age = v.0.reading().map(|_| v.0.age());
    assert!(age.is_none_or(|age| age <= since), "a reading of {age:?} steps after {since} steps");
    c.0.borrow_mut().push(age);
    if c.1 == 40 { Step::Done } else { Step::Next(Demand::hold()) }
}

#[test]
fn fault_248_after_a_reset_no_motion_begins_by_a_reading_from_before_the_stop() {
    let free = VspMode::NonInteractive(MS * 3);
    for mode in [VspMode::Interactive, VspMode::WithDelay, free] {
        for latency in [0, 3500, 9000].map(Duration::from_micros) {
            if mode != VspMode::WithDelay && latency > Duration::ZERO {
                continue;
            }
            for stop in 3..30 {
                let ages = Rc::new(RefCell::new(Vec::new()));
                let keep = Rc::clone(&ages);
                let robot = gantry("g").0.program(move |ecp| {
                    keep.borrow_mut().clear();
                    let mut counter = ecp.sensor::<Counter>("counter")?;
                    ecp.move_robot((&mut counter,), Asking(Rc::clone(&keep), 0)).map(drop)
                });
                let sensor =
                    SensorSetup::new("counter", Counting::default()).of("g").mode(mode).latency(latency);
                let cell = Cell::new(MS).robot(robot).sensor(sensor).after_fault(AfterFault::AwaitReset);
                let cell = cell.on_step(move |step, operator| match step {
                    step if step == stop => operator.protective_stop(),
                    // Sixty steps later, as a person who is quick.
                    step if step >= stop + 60 && operator.latch() == Latch::Latched => {
                        operator.acknowledge().and_then(|()| operator.reset()).expect("nothing persists");
                    }
                    _ => {}
                });
                cell.run().expect("the second run of the program is over");
                assert_eq!(ages.borrow().len(), 40, "{mode:?}, stopped in step {stop}");
                assert!(ages.borrow().last().expect("asked").is_some(), "{mode:?}, stopped in step {stop}");
            }
        }
    }
}
