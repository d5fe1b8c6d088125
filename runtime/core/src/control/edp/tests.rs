//! An EDP without its ECP.

use crate::link::Host;
use crate::observe::servo::ServoRecord;
use core::cell::RefCell;
use std::rc::Rc;

use nalgebra::Vector1;

use super::*;
use crate::link::message::{Kind, Message, OrderKind, RequestKind, flag};
use crate::link::{Closed, StopBoard, Waiter};
use crate::model::demand::Demand;
use crate::model::fault::Role;
use crate::model::name::Name;
use crate::model::wire::Wire;
use crate::tests::slide::{Exact, Slide};

mod answers;
mod signals;

struct Still;

impl Waiter for Still {
    fn now(&self) -> Nanos {
        0
    }
    fn wait(&self, _: Option<Nanos>) -> Result<(), Closed> {
        Err(Closed)
    }
}

/// Keeps the replies.
struct Replies(Rc<RefCell<Vec<Message>>>);

impl Server for Replies {
    fn receive(&self, _: &mut Message) -> bool {
        false
    }
    fn reply(&self, reply: &Message) {
        self.0.borrow_mut().push(*reply);
    }
}

fn config(servo: Duration) -> EdpConfig<Slide> {
    EdpConfig {
        process: ProcessId::new(Role::Edp, Name::new("g").expect("a name")),
        robot: Slide::new(),
        drive: Drive::Here(Box::new(Exact::new(servo))),
        tool: Pose::identity(),
        period: Duration::from_millis(1),
        delay: crate::control::interpolation::delay(Duration::from_millis(1), [servo].into_iter()),
        space: InterpolationSpace::Joints,
        following_error: Vector1::new(1.0),
        stop_steps: 200,
        declared: Declared::default(),
        observers: Vec::new(),
        step_observers: crate::observe::step_observer::StepObservers::to(Vec::new()),
        states: Vec::new(),
        replayed: None,
    }
}

fn edp(servo: Duration) -> (Edp<'static, Slide>, Rc<RefCell<Vec<Message>>>) {
    let replies = Rc::default();
    (Edp::new(config(servo), Host::of(&Still), Box::new(Replies(Rc::clone(&replies)))), replies)
}

impl Edp<'_, Slide> {
    /// A servo period that begins in time.
    fn tick_at(&mut self, begins: Nanos) {
        let ends = begins + self.clock.servo_period();
        self.tick(clock::Period { begins, ends, lost: 0, late: 0 });
    }
}

#[test]
fn fault_14_an_edp_bridges_twenty_steps_however_long_its_servo_period_is() {
    for millis in [1, 2, 4, 5, 8, 20] {
        let (mut edp, _) = edp(Duration::from_millis(millis));
        edp.answers.request = Message::new(Kind::Request(RequestKind::Demand));
        (edp.answers.request.header.dt, edp.answers.request.header.duration) = (1e-3, 1e-3);
        edp.answers.request.header.len = <Demand<Slide> as Wire>::LEN as u32;
        Demand::<Slide>::joints(Vector1::new(1e-6)).put(&mut edp.answers.request.body);
        edp.serve();
        // The demand itself, and then nothing.
        edp.begin_step();
        let mut bridged = 0;
        while matches!(edp.path.mode, Mode::Moving { .. }) {
            bridged += 1;
            assert!(bridged < 1000, "never brakes");
            edp.begin_step();
        }
        // The last of them is the one that no longer bridges.
        assert_eq!(bridged - 1, 20, "servo period {millis} ms");
        assert_eq!(edp.answers.fault.as_ref().map(Fault::kind), Some(FaultKind::PeerLost));
    }
}

/// A state board on which consoles have asked for a stop.
struct Asked(core::cell::Cell<u64>);

impl StopBoard for Asked {
    fn asked(&self) -> u64 {
        self.0.get()
    }
}

#[test]
fn fault_64_a_robot_whose_mp_does_not_begin_a_stop_that_was_asked_for_stops_by_itself() {
    let (board, waiter) = (Asked(core::cell::Cell::new(0)), Late(core::cell::Cell::new(0)));
    let host = Host { stops: &board, ..Host::of(&waiter) };
    let mut moving = Moving::on(host, Duration::from_millis(1));
    // Demands come in every step: an ECP goes on, whatever its MP does.
    for step in 0..60 {
        waiter.0.set(step * 1_000_000);
        moving.demand(step);
        board.0.set(u64::from(step >= 30));
        moving.edp.serve();
        moving.edp.begin_step();
        let stops = moving.edp.answers.fault.as_ref().map(|fault| (fault.kind(), fault.step()));
        let expected = (step >= 51).then_some((FaultKind::ProtectiveStop, Some(51)));
        assert_eq!(stops, expected, "step {step}: L is 20, and it was asked for in step 30");
    }
}

#[test]
fn what_is_no_request_is_a_fault_and_moves_nothing() {
    for kind in [Kind::Order(OrderKind::Step), Kind::Command, Kind::Read, Kind::Reply, Kind::Fault] {
        let (mut edp, replies) = edp(Duration::from_millis(1));
        edp.answers.request = Message::new(kind);
        edp.serve();
        let reply = *replies.borrow().last().expect("answered");
        assert_eq!((reply.header.kind, reply.fault().kind()), (Kind::Fault, FaultKind::Message));
        assert!(reply.is(flag::STANDSTILL));
    }
}

/// Time that is where it is put.
struct Late(core::cell::Cell<Nanos>);

impl Waiter for Late {
    fn now(&self) -> Nanos {
        self.0.get()
    }
    fn wait(&self, _: Option<Nanos>) -> Result<(), Closed> {
        Err(Closed)
    }
}

/// A robot that comes to 0.1 m/s in ten steps and goes on, and what its drives are told in each servo period that happens.
struct Moving<'w> {
    edp: Edp<'w, Slide>,
    told: Rc<RefCell<Vec<(u64, f64)>>>,
    step: u64,
}

impl<'w> Moving<'w> {
    fn new(waiter: &'w Late, servo: Duration) -> Self {
        Self::on(Host::of(waiter), servo)
    }

    fn on(host: Host<'w>, servo: Duration) -> Self {
        let mut config = config(servo);
        let told = Rc::<RefCell<Vec<(u64, f64)>>>::default();
        let (seen, servo) = (Rc::clone(&told), servo.as_secs_f64());
        config.observers.push(Box::new(move |record: &ServoRecord<Slide>| {
            let period = (record.time / servo - 1.5).round() as u64;
            seen.borrow_mut().push((period, record.demanded[0]));
        }));
        Moving { edp: Edp::new(config, host, Box::new(Replies(Rc::default()))), told, step: 0 }
    }

    /// The demand of a step, for which all periods have passed since the one before.
    fn demand(&mut self, step: u64) {
        let periods = (step - self.step) as f64;
        self.step = step;
        self.edp.answers.request = Message::new(Kind::Request(RequestKind::Demand));
        let header = &mut self.edp.answers.request.header;
        (header.step, header.len) = (step, <Demand<Slide> as Wire>::LEN as u32);
        (header.dt, header.duration) = (1e-3 * periods, 1e-3 * periods);
        let x: f64 = (1..=step).map(|k| 1e-5 * k.min(10) as f64).sum();
        Demand::<Slide>::joints(Vector1::new(x)).put(&mut self.edp.answers.request.body);
        self.edp.serve();
    }

    /// Wakes at a time and does what is due.
    fn wake(&mut self, waiter: &Late, now: Nanos) {
        waiter.0.set(now);
        while now >= self.edp.clock.next_step.min(self.edp.clock.next_tick) {
            self.edp.advance(now);
        }
    }

    /// A step in which it wakes whenever anything is due.
    fn punctual(&mut self, waiter: &Late, step: u64) {
        waiter.0.set(step * STEP);
        self.demand(step);
        self.rest_of(waiter, step, 0);
    }

    fn rest_of(&mut self, waiter: &Late, step: u64, from: Nanos) {
        (from..STEP).step_by(62_500).for_each(|time| self.wake(waiter, step * STEP + time));
    }
}

const STEP: Nanos = 1_000_000;

#[test]
fn fault_11_servo_periods_that_are_over_are_left_out_and_the_present_one_gets_its_own_position() {
    for servo in [Duration::from_millis(1), Duration::from_micros(250), Duration::from_millis(2)] {
        let (on_time, late) = (Late(core::cell::Cell::new(0)), Late(core::cell::Cell::new(0)));
        let (mut punctual, mut delayed) = (Moving::new(&on_time, servo), Moving::new(&late, servo));
        for step in 1..60 {
            punctual.punctual(&on_time, step);
            match step {
                // It sleeps from the beginning of a step until late in another one; the first one's demand has come.
                20 | 40 | 43 => {}
                21 | 22 => {}
                23 | 41 | 44 => {
                    late.0.set(step * STEP + 562_500);
                    delayed.demand(if step == 23 { 20 } else { step - 1 });
                    delayed.rest_of(&late, step, 562_500);
                }
                _ => delayed.punctual(&late, step),
            }
        }
        let (punctual, delayed_told) = (punctual.told.take(), delayed.told.take());
        // All that began and were over while it slept.
        let period = servo.as_nanos() as Nanos;
        let sleeps = [(20, 23), (40, 41), (43, 44)].map(|(from, to)| (from * STEP, to * STEP + 562_500));
        let begins = (0..1000).map(|i| i * period + period / 2);
        let over = |&begin: &Nanos| sleeps.iter().any(|(from, to)| (*from..=to - period).contains(&begin));
        assert_eq!(punctual.len() - delayed_told.len(), begins.filter(over).count(), "{servo:?}");
        let mut next = 0;
        for (index, position) in delayed_told {
            // Every period happens at most once, in its own time, where the punctual robot was as well.
            assert!(index >= next, "period {index} of {servo:?} is repeated");
            next = index + 1;
            let (_, expected) =
                *punctual.iter().find(|(other, _)| *other == index).expect("the same periods");
            assert!(
                (position - expected).abs() < 1e-12,
                "period {index} of {servo:?}: {position}, {expected}"
            );
        }
        assert_eq!(delayed.edp.answers.fault, None, "{servo:?}");
    }
}

#[test]
fn fault_12_an_edp_that_is_late_for_too_many_steps_stops_its_robot_with_overrun() {
    // Ten naps of two steps, or one of more than L.
    for (nap, naps) in [(2, 10), (21, 1)] {
        let waiter = Late(core::cell::Cell::new(0));
        let mut robot = Moving::new(&waiter, Duration::from_millis(1));
        (1..20).for_each(|step| robot.punctual(&waiter, step));
        let mut step = 20;
        for done in 0..naps {
            assert_eq!(robot.edp.answers.fault, None, "{done} naps of {nap}");
            // The first step's demand has come meanwhile.
            waiter.0.set((step + nap) * STEP + 500_000);
            robot.demand(step);
            robot.wake(&waiter, (step + nap) * STEP + 500_000);
            step += nap + 1;
        }
        assert_eq!(
            robot.edp.answers.fault.as_ref().map(Fault::kind),
            Some(FaultKind::Overrun),
            "naps of {nap}"
        );
        assert!(!matches!(robot.edp.path.mode, Mode::Moving { .. }));
    }
}

/// What an answer and a recording say of a step is the same whether an EDP slept when a request came or not.
#[test]
fn fault_11_a_request_of_a_later_step_comes_after_what_was_due_before_it_whatever_it_asks_for() {
    for kind in [RequestKind::Brake, RequestKind::Query, RequestKind::Stop] {
        let (on_time, late) = (Late(core::cell::Cell::new(0)), Late(core::cell::Cell::new(0)));
        let servo = Duration::from_millis(1);
        let (mut punctual, mut delayed) = (Moving::new(&on_time, servo), Moving::new(&late, servo));
        (1..20).for_each(|step| punctual.punctual(&on_time, step));
        (1..20).for_each(|step| delayed.punctual(&late, step));
        // Nobody demands anything in step 20; one of the two sleeps through it.
        punctual.rest_of(&on_time, 20, 0);
        for (robot, waiter) in [(&mut punctual, &on_time), (&mut delayed, &late)] {
            waiter.0.set(21 * STEP + 10);
            robot.edp.answers.request = Message::new(Kind::Request(kind));
            robot.edp.answers.request.header.step = 21;
            robot.edp.serve();
            let (demanded, _) = robot.edp.path.acceptor.demanded();
            // It moves at 0.1 m/s: step 20 was bridged, so its demand is one step further than that of step 19.
            let distance: f64 = (1..=20).map(|k| 1e-5 * f64::from(k.min(10))).sum();
            assert_eq!(robot.edp.clock.due, 21, "{kind:?}");
            assert!((demanded[0] - distance).abs() < 1e-12, "{kind:?}: {}, {distance}", demanded[0]);
            (21..60).for_each(|step| robot.rest_of(waiter, step, 62_500));
        }
        let told = |robot: &Moving<'_>| robot.told.borrow().last().copied();
        assert_eq!(told(&punctual), told(&delayed), "{kind:?}");
    }
}
