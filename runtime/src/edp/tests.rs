//! An EDP without its ECP.

use core::cell::RefCell;
use std::rc::Rc;

use nalgebra::Vector1;

use super::*;
use crate::demand::Demand;
use crate::driver::{DriveFault, Driver};
use crate::fault::Role;
use crate::message::{Kind, OrderKind, RequestKind, flag};
use crate::name::Name;
use crate::robot::{Limits, NoInverse};
use crate::wire::Wire;

#[derive(Clone)]
struct Slide(Limits<Vector1<f64>>);

impl Robot for Slide {
    const KIND: &'static str = "slide";
    type Joints = Vector1<f64>;
    fn limits(&self) -> &Limits<Vector1<f64>> {
        &self.0
    }
    fn forward(&self, q: &Vector1<f64>) -> Pose {
        Pose::translation(q[0], 0.0, 0.0)
    }
    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _: &Vector1<f64>) -> Result<Vector1<f64>, NoInverse> {
        Ok(Vector1::new(X_WF.translation.x))
    }
}

struct Exact(Duration, Measured<Vector1<f64>>);

impl Driver<Slide> for Exact {
    fn period(&self) -> Duration {
        self.0
    }
    fn measured(&self) -> Measured<Vector1<f64>> {
        self.1
    }
    fn tick(&mut self, demanded: &Vector1<f64>) -> Result<Measured<Vector1<f64>>, DriveFault> {
        self.1.position = *demanded;
        Ok(self.1)
    }
}

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

fn edp(servo: Duration) -> (Edp<'static, Slide>, Rc<RefCell<Vec<Message>>>) {
    let zero = Vector1::zeros();
    let limits = Limits {
        lower: Vector1::new(-1.0),
        upper: Vector1::new(1.0),
        velocity: Vector1::new(1.0),
        acceleration: Vector1::new(10.0),
        jerk: None,
    };
    let config = EdpConfig {
        process: ProcessId::new(Role::Edp, Name::new("g").expect("a name")),
        robot: Slide(limits),
        drive: Drive::Here(Box::new(Exact(servo, Measured { position: zero, velocity: zero }))),
        tool: Pose::identity(),
        step: Duration::from_millis(1),
        delay: crate::interpolation::delay(Duration::from_millis(1), [servo].into_iter()),
        space: InterpolationSpace::Joints,
        following_error: Vector1::new(1.0),
        observers: Vec::new(),
    };
    let replies = Rc::default();
    (Edp::new(config, &Still, Box::new(Replies(Rc::clone(&replies)))), replies)
}

#[test]
fn fault_14_an_edp_bridges_twenty_steps_however_long_its_servo_period_is() {
    for millis in [1, 2, 4, 5, 8, 20] {
        let (mut edp, _) = edp(Duration::from_millis(millis));
        edp.request = Message::new(Kind::Request(RequestKind::Demand));
        (edp.request.header.dt, edp.request.header.duration) = (1e-3, 1e-3);
        edp.request.header.len = <Demand<Slide> as Wire>::LEN as u32;
        Demand::<Slide>::joints(Vector1::new(1e-6)).put(&mut edp.request.body);
        edp.serve();
        // The demand itself, and then nothing.
        edp.begin_step();
        let mut bridged = 0;
        while matches!(edp.mode, Mode::Moving { .. }) {
            bridged += 1;
            assert!(bridged < 1000, "never brakes");
            edp.begin_step();
        }
        // The last of them is the one that no longer bridges.
        assert_eq!(bridged - 1, 20, "servo period {millis} ms");
        assert_eq!(edp.fault.as_ref().map(Fault::kind), Some(FaultKind::PeerLost));
    }
}

#[test]
fn what_is_no_request_is_a_fault_and_moves_nothing() {
    for kind in [Kind::Order(OrderKind::Step), Kind::Command, Kind::Read, Kind::Reply, Kind::Fault] {
        let (mut edp, replies) = edp(Duration::from_millis(1));
        edp.request = Message::new(kind);
        edp.serve();
        let reply = *replies.borrow().last().expect("answered");
        assert_eq!((reply.header.kind, reply.fault().kind()), (Kind::Fault, FaultKind::Message));
        assert!(reply.is(flag::STANDSTILL));
    }
}
