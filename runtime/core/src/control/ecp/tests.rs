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
use crate::model::step::{Step, Tick};
use crate::model::wire::Wire;
use crate::tests::slide::Slide;

const STEP: Nanos = 1_000_000;

/// Time that passes while the process works and while it sleeps, and what was counted of the process.
#[derive(Default)]
struct Counting {
    now: Cell<Nanos>,
    worked: RefCell<Vec<Nanos>>,
}

impl Waiter for Counting {
    fn now(&self) -> Nanos {
        self.now.get()
    }
    /// A message comes when the next step begins.
    fn wait(&self, _: Option<Nanos>) -> Result<(), Closed> {
        self.now.set(self.now.get() / STEP * STEP + STEP);
        Ok(())
    }
}

impl Meter for Counting {
    fn sample(&self, sample: Sample) {
        if let Sample::Worked(time) = sample {
            self.worked.borrow_mut().push(time);
        }
    }
}

/// An MP that opens an instruction, and orders a step of it whenever the last one was answered, after a while.
struct Orderer {
    sent: Cell<u64>,
    waits: Cell<bool>,
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
        *request = Message::new(Kind::Order(if sent == 0 { OrderKind::Start } else { OrderKind::Step }));
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

#[test]
fn what_a_wait_took_in_all_its_steps_is_no_late_step_of_the_move_after_it() {
    let host = Rc::new(Counting::default());
    let timed = Timed::new(Host { meter: &*host, ..Host::of(&*host) });
    let name = Name::new("slide").expect("a name");
    let sensing = Sensing {
        owner: Owner::unique(),
        ports: Vec::new(),
        timeout: AnswerTimeout { most: 20 * STEP, again: STEP },
        step_observers: StepObservers::to(Vec::new()),
    };
    let pace = Pace { period: STEP, grace: STEP / 2, stop_steps: 100 };
    let process = ProcessId::new(Role::Ecp, name);
    let mp = Orderer { sent: Cell::new(0), waits: Cell::new(false) };
    let edp = Stands(RefCell::new(Message::empty()));
    let mut ecp = Ecp::<Slide>::new(
        (process, Rc::new(Slide::new())),
        timed.host(),
        Box::new(mp),
        Box::new(edp),
        sensing,
        pace,
        None,
    );
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
