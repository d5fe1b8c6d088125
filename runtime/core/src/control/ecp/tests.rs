//! An ECP between an MP and an EDP that answer as they are told.

use core::cell::{Cell, RefCell};
use std::rc::Rc;

use super::*;
use crate::control::overruns::Timed;
use crate::link::message::{Kind, Message, OrderKind};
use crate::link::timeout::AnswerTimeout;
use crate::link::{Closed, Meter, Sample, Waiter};
use crate::model::class::{Class, Level, Uses};
use crate::model::demand::Demand;
use crate::model::fault::Role;
use crate::model::generator::{Condition, Generator};
use crate::model::list::{AnyRobots, Motion, Owner, Reading, State};
use crate::model::name::Name;
use crate::model::payload::Order;
use crate::model::step::{Step, Tick};
use crate::model::wire::Wire;
use crate::tests::slide::Slide;

const STEP: Nanos = 1_000_000;

/// Time that passes while the process works and while it sleeps, and what was counted of the process.
#[derive(Default)]
struct Counting {
    now: Cell<Nanos>,
    worked: RefCell<Vec<Nanos>>,
    closes: Cell<bool>,
}

impl Waiter for Counting {
    fn now(&self) -> Nanos {
        self.now.get()
    }
    /// A message comes when the next step begins.
    fn wait(&self, _: Option<Nanos>) -> Result<(), Closed> {
        self.now.set(self.now.get() / STEP * STEP + STEP);
        if self.closes.get() { Err(Closed) } else { Ok(()) }
    }
}

impl Meter for Counting {
    fn sample(&self, sample: Sample) {
        if let Sample::Worked(time) = sample {
            self.worked.borrow_mut().push(time);
        }
    }
}

/// An MP that orders one thing, and another whenever the last one was answered, after a while. It wants the robot's state if it queries.
struct Orderer {
    orders: [OrderKind; 2],
    sent: Cell<u64>,
    waits: Cell<bool>,
}

impl Orderer {
    fn of(orders: [OrderKind; 2]) -> Orderer {
        Orderer { orders, sent: Cell::new(0), waits: Cell::new(false) }
    }
}

impl Server for Orderer {
    fn receive(&self, request: &mut Message) -> bool {
        // Each order is there when the process has waited for it once.
        if !self.waits.replace(false) {
            self.waits.set(true);
            return false;
        }
        let sent = self.sent.get();
        self.sent.set(sent + 1);
        let order = self.orders[usize::from(sent > 0)];
        *request = Message::new(Kind::Order(order));
        request.header.flags = if order == OrderKind::Query { flag::WANT_STATE } else { 0 };
        request.header.payload = PayloadType::of::<Trigger>().id;
        request.header.instruction = 1;
        request.header.step = sent;
        (request.header.dt, request.header.duration) = (1e-3, 1e-3);
        true
    }
    fn reply(&self, _: &Message) {
        self.waits.set(false);
    }
}

/// An EDP whose robot stands.
struct Stands(RefCell<Message>);

impl Client for Stands {
    fn send(&self, request: &Message) {
        let mut reply = Message::new(Kind::Reply);
        (reply.header.epoch, reply.header.step) = (request.header.epoch, request.header.step);
        reply.header.flags = flag::STANDSTILL | flag::STATE;
        reply.header.len = RobotImage::<Slide>::LEN as u32;
        RobotImage::<Slide>::unknown().put(&mut reply.body);
        *self.0.borrow_mut() = reply;
    }
    fn receive(&self, reply: &mut Message) -> bool {
        reply.copy_from(&self.0.borrow());
        true
    }
}

/// An EDP that has not answered when the cell closes.
struct ClosesFirst(Rc<Counting>, Rc<Cell<u32>>);

impl Client for ClosesFirst {
    fn send(&self, _: &Message) {
        self.0.closes.set(true);
        self.1.set(self.1.get() + 1);
        assert!(self.1.get() < 100, "it asks for ever");
    }
    fn receive(&self, _: &mut Message) -> bool {
        false
    }
}

/// A condition, or a generator, whose steps each take a time of the process.
struct Working(Rc<Counting>, Nanos, u64);

impl Working {
    /// Whether so many steps are over.
    fn is_over(&mut self) -> bool {
        self.0.now.set(self.0.now.get() + self.1);
        self.2 -= 1;
        self.2 == 0
    }
}

impl Condition for Working {
    type Robots = AnyRobots;
    type Sensors = ();
    type Order = ();
    const CLASS: Class = Class::new(Level::Ecp, Uses::NOTHING);
    fn is_met(
        &mut self,
        _: &Order<()>,
        _: &State<AnyRobots>,
        _: &Reading<()>,
        _: Tick,
    ) -> Result<bool, Fault> {
        Ok(self.is_over())
    }
}

impl Generator for Working {
    type Robots = Slide;
    type Language = Motion;
    type Sensors = ();
    type Order = ();
    const CLASS: Class = Class::new(Level::Ecp, Uses::NOTHING);
    fn first_step(
        &mut self,
        _: &Order<()>,
        _: &State<Slide>,
        _: &Reading<()>,
        _: Tick,
    ) -> Result<Step<Slide>, Fault> {
        Ok(if self.is_over() { Step::Done } else { Step::Next(Demand::hold()) })
    }
    fn next_step(
        &mut self,
        order: &Order<()>,
        e: &State<Slide>,
        v: &Reading<()>,
        t: Tick,
    ) -> Result<Step<Slide>, Fault> {
        self.first_step(order, e, v, t)
    }
}

/// An ECP without sensors between these.
fn ecp<'w>(host: Host<'w>, mp: Orderer, edp: impl Client + 'static) -> Ecp<'w, Slide> {
    let name = Name::new("slide").expect("a name");
    let sensing = Sensing {
        owner: Owner::unique(),
        ports: Vec::new(),
        timeout: AnswerTimeout { most: 20 * STEP, again: STEP },
        step_observers: StepObservers::to(Vec::new()),
    };
    let pace = Pace { period: STEP, grace: STEP / 2, stop_steps: 100 };
    let driver = (ProcessId::new(Role::Ecp, name), Rc::new(Slide::new()));
    Ecp::new(driver, host, Box::new(mp), Box::new(edp), sensing, pace, None)
}

#[test]
fn what_a_wait_took_in_all_its_steps_is_no_late_step_of_the_move_after_it() {
    let host = Rc::new(Counting::default());
    let timed = Timed::new(Host { meter: &*host, ..Host::of(&*host) });
    let mp = Orderer::of([OrderKind::Start, OrderKind::Step]);
    let mut ecp = ecp(timed.host(), mp, Stands(RefCell::new(Message::empty())));
    let outcome = ecp.serve(|ecp, _: Trigger| {
        // 300 steps of a tenth of a period: 30 periods in all.
        ecp.wait_until((), Working(Rc::clone(&host), STEP / 10, 300))?;
        // What a program computes between its instructions makes no step late, either.
        host.now.set(host.now.get() + 7 * STEP);
        ecp.move_robot((), Working(Rc::clone(&host), STEP / 5, 50))?;
        Err(Fault::thrown("that was all"))
    });
    assert_eq!(outcome.map_err(|fault| fault.kind()), Err(FaultKind::Program));
    let worked = host.worked.borrow();
    let of = |time| worked.iter().filter(|worked| **worked == time).count();
    // The work of a step is known when the next one begins.
    assert_eq!((of(STEP / 10), of(STEP / 5), worked.len()), (299, 49, 348), "{worked:?}");
}

#[test]
fn a_process_returns_when_its_cell_closes_before_its_edp_has_answered() {
    let host = Rc::new(Counting::default());
    let asked = Rc::new(Cell::new(0));
    let mp = Orderer::of([OrderKind::Query, OrderKind::Query]);
    let mut ecp = ecp(Host::of(&*host), mp, ClosesFirst(Rc::clone(&host), Rc::clone(&asked)));
    let outcome = ecp.run_program(|ecp| ecp.serve(|_, _: Trigger| Ok(())));
    assert_eq!(outcome.as_ref().map_err(|fault| fault.kind()), Err(FaultKind::CellClosed));
    assert_eq!(asked.get(), 1);
    // Its order is still open, and nobody waits for the answer.
    assert!(!ecp.answer_after_program(&outcome), "a reset");
}
