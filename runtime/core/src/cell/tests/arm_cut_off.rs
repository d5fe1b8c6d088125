//! Arms that carry a body, and the link to one of which is cut: both brake in the same step, on their common twist.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use nalgebra::Vector3;

use super::arms_without_mp::{Arm, DURATION, Exact, Six, apart, program, slides_and_turns};
use crate::cell::{Cell, RobotSetup};
use crate::link::memory::{Scheduler, Stuck};
use crate::link::message::Message;
use crate::link::{Board, Body, Client, Link, Server};
use crate::model::fault::{FaultKind, ProcessId, Role};
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::observe::servo::ServoRecord;
use crate::safety::stopping::together_budget;

/// What does not arrive of one arm's orders and replies: those from a step on, and all those of one step.
#[derive(Clone, Copy, Debug)]
struct Cut {
    arm: &'static str,
    orders: u64,
    replies: u64,
    /// The order of this step is lost, and sent again in the next one.
    lost: u64,
}

/// The MP's end of a port that is cut.
struct CutClient {
    inner: Box<dyn Client>,
    cut: Cut,
    sent: RefCell<Message>,
}

impl Client for CutClient {
    fn send(&self, order: &Message) {
        self.sent.borrow_mut().copy_from(order);
        if order.header.step < self.cut.orders && order.header.step != self.cut.lost {
            self.inner.send(order);
        }
    }

    /// Links that lose messages ask again in the next step.
    fn send_again(&self) {
        let order = self.sent.borrow();
        if order.header.step == self.cut.lost {
            self.inner.send(&order);
        }
    }

    fn receive(&self, reply: &mut Message) -> bool {
        self.inner.receive(reply) && reply.header.step < self.cut.replies
    }
}

/// The memory link, on which the link to one arm is cut.
struct Cutting {
    scheduler: Scheduler,
    cut: Cut,
    places: Vec<ProcessId>,
}

impl Link for Cutting {
    fn place(&mut self, process: ProcessId) -> usize {
        self.places.push(process);
        self.scheduler.place(process)
    }

    fn port(&mut self, client: usize, server: usize) -> (Box<dyn Client>, Box<dyn Server>) {
        let (inner, answering) = self.scheduler.port(client, server);
        let to = self.places[server];
        let is_cut = to.role == Role::Ecp && to.name.is_some_and(|name| name.as_str() == self.cut.arm);
        if !is_cut {
            return (inner, answering);
        }
        (Box::new(CutClient { inner, cut: self.cut, sent: RefCell::new(Message::empty()) }), answering)
    }

    fn board(&mut self, writer: usize, reader: usize) -> Rc<dyn Board> {
        self.scheduler.board(writer, reader)
    }

    fn body(&mut self, place: usize, body: Body) -> Result<(), Stuck> {
        self.scheduler.body(place, body)
    }

    fn closer(&self) -> Box<dyn Fn()> {
        self.scheduler.closer()
    }
}

/// The poses of both flanges, step by step, and the kind of the fault that the MP's program ended with.
fn run(step: Duration, cut: Cut) -> ([Vec<Pose>; 2], Option<FaultKind>) {
    let traces: [Rc<RefCell<Vec<Pose>>>; 2] = Default::default();
    let turned = Pose::new(Vector3::new(1.0, 0.8, 0.3), Vector3::new(0.3, -0.4, 2.0));
    let mut cell = Cell::new(step).program(program);
    for ((name, base), trace) in [("left", Pose::identity()), ("right", turned)].into_iter().zip(&traces) {
        let arm = Arm::on(base, slides_and_turns(10.0, 20.0));
        let (trace, model) = (Rc::clone(trace), arm.clone());
        let start = Six::new(0.1, 0.2, 0.3, 0.1, -0.2, 0.3);
        let keep = move |record: &ServoRecord<Arm>| trace.borrow_mut().push(model.forward(&record.demanded));
        cell = cell.robot(RobotSetup::new(name, arm, Exact(start, step)).observe(keep));
    }
    let names = cell.check().expect("nothing is wrong with it");
    let mut link = Cutting { scheduler: Scheduler::new(), cut, places: Vec::new() };
    let assembly = cell.assemble(&names, &mut link).expect("put together");
    link.scheduler.run().expect("runs");
    let outcomes = assembly.outcomes.take();
    let fault = outcomes.iter().find_map(|(_, outcome)| outcome.as_ref().err()).map(|fault| fault.kind());
    (traces.map(|trace| trace.take()), fault)
}

/// By how much the relative pose is off at most \[m, rad\], and how far the left flange comes.
fn off(traces: &[Vec<Pose>; 2]) -> (f64, f64) {
    let relative = traces[0][0].inv_mul(&traces[1][0]);
    let off = traces[0].iter().zip(&traces[1]).map(|(a, b)| apart(&a.inv_mul(b), &relative));
    (off.fold(0.0, f64::max), apart(&traces[0][0], &traces[0][traces[0].len() - 1]))
}

const NEVER: u64 = u64::MAX;

/// A link on which everything arrives.
const WHOLE: Cut = Cut { arm: "left", orders: NEVER, replies: NEVER, lost: NEVER };

/// In which steps something is cut: in one in each so many milliseconds.
const SHARE: u64 = 22;

/// Steps of so many milliseconds, and those of them in which something is cut, one in each `every` milliseconds.
fn steps_of(millis: u64, every: u64) -> (Duration, impl Iterator<Item = u64>) {
    let last = (DURATION * 1e3) as u64 / millis;
    (Duration::from_millis(millis), (2..last).step_by((every / millis).max(1) as usize))
}

/// By how much an arm that goes on for `n` steps as the path changed last may be off it \[m, rad\]: by `1 + 3 + 6 + ..`, which are
/// `n (n + 1) (n + 2) / 6`, third differences of the path. Its largest jerk is `60 / T³` times its whole displacement, and in the flange less
/// than √3 times as much.
fn third_differences(step: Duration, n: u32) -> f64 {
    let n = f64::from(n);
    n * (n + 1.0) * (n + 2.0) / 6.0 * 3.0_f64.sqrt() * 60.0 * 0.55 * (step.as_secs_f64() / DURATION).powi(3)
}

fn arms_are_cut_off(every: u64) {
    for millis in [1, 2, 4] {
        let (step, steps) = steps_of(millis, every);
        let bound = third_differences(step, together_budget(step));
        let mut worst = [0.0_f64; 3];
        for (at, arm) in steps.flat_map(|at| ["left", "right"].map(|arm| (at, arm))) {
            // Both directions, orders alone, replies alone.
            for (i, (orders, replies)) in [(at, at), (at, NEVER), (NEVER, at)].into_iter().enumerate() {
                let (traces, fault) = run(step, Cut { arm, orders, replies, ..WHOLE });
                assert_eq!(fault, Some(FaultKind::PeerLost), "{arm} from {at} on");
                let (off, _) = off(&traces);
                worst[i] = worst[i].max(off);
                assert!(off <= bound, "{step:?}, {arm} from {at} on, {orders} {replies}: {off}, {bound}");
            }
        }
        println!("{step:?}: {worst:?} m or rad, at most {bound:.1e}");
        // What only replies are lost of is told the arm.
        assert!(worst[2] < 1e-9, "{worst:?}");
    }
}

#[test]
fn fault_153_arms_of_which_one_is_cut_off_in_any_step_brake_together_on_their_twist() {
    arms_are_cut_off(SHARE);
}

/// Nobody can say what two ends should do together whose last message may have arrived or not: this bound is the best one.
fn arms_are_cut_off_before_an_answer(every: u64) {
    for millis in [1, 2, 4] {
        let (step, steps) = steps_of(millis, every);
        // The path's largest speed in a step, 15/8 of the mean one, and that of a flange is less than √3 times as much.
        let displacement = 3.0_f64.sqrt() * 15.0 / 8.0 * 0.55 * step.as_secs_f64() / DURATION;
        let bound = displacement + third_differences(step, together_budget(step));
        let mut worst = 0.0_f64;
        for at in steps {
            let (traces, fault) = run(step, Cut { orders: at + 1, replies: at, ..WHOLE });
            assert_eq!(fault, Some(FaultKind::PeerLost), "from {at} on");
            worst = worst.max(off(&traces).0);
            assert!(worst <= bound, "{step:?}, from {at} on: {worst}, {bound}");
        }
        println!("{step:?}: {worst:.1e} m or rad, at most {bound:.1e}");
    }
}

#[test]
fn fault_155_arms_of_which_one_is_cut_off_between_an_order_and_its_answer_come_apart_by_the_displacement_of_a_step()
 {
    arms_are_cut_off_before_an_answer(SHARE);
}

fn orders_are_lost(every: u64) {
    for millis in [1, 2, 4] {
        let (step, steps) = steps_of(millis, every);
        let (calm, fault) = run(step, WHOLE);
        assert_eq!((fault, off(&calm).0 < 1e-9), (None, true));
        // The order is sent again in the next step.
        let bound = third_differences(step, 2);
        for (lost, arm) in steps.flat_map(|at| ["left", "right"].map(|arm| (at, arm))) {
            let (traces, fault) = run(step, Cut { arm, lost, ..WHOLE });
            assert_eq!(fault, None, "{step:?}, {arm} has lost {lost}");
            let (off, end) = off(&traces);
            assert!(off <= bound, "{step:?}, {arm} has lost {lost}: {off}, {bound}");
            assert!((end - self::off(&calm).1).abs() < 1e-12, "{step:?}, {arm} has lost {lost}: {end}");
        }
    }
}

#[test]
fn fault_153_an_order_that_one_arm_has_lost_is_bridged_and_both_go_on_together() {
    orders_are_lost(SHARE);
}

/// In all steps.
mod whole {
    use super::{arms_are_cut_off, arms_are_cut_off_before_an_answer, orders_are_lost};

    #[test]
    #[ignore = "takes minutes: `just wires-whole`"]
    fn fault_153_arms_of_which_one_is_cut_off_in_any_step_brake_together_on_their_twist() {
        arms_are_cut_off(1);
    }

    #[test]
    #[ignore = "takes minutes: `just wires-whole`"]
    fn fault_155_arms_of_which_one_is_cut_off_between_an_order_and_its_answer_come_apart_by_the_displacement_of_a_step()
     {
        arms_are_cut_off_before_an_answer(1);
    }

    #[test]
    #[ignore = "takes minutes: `just wires-whole`"]
    fn fault_153_an_order_that_one_arm_has_lost_is_bridged_and_both_go_on_together() {
        orders_are_lost(1);
    }
}
