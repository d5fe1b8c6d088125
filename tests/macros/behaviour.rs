//! What the macros make of step functions: plain functions stay plain, the class follows from the signature,
//! and the implementation calls what it should.
#![allow(missing_docs)]

use mrroc::{
    Always, Condition, Demand, Fault, Generator, Order, Reading, Robot, State, Step, Tick, condition,
    generator,
};

mod cell;
use cell::*;

const TICK: Tick = Tick { step: 3, dt: 0.002, duration: 0.002 };

#[derive(Debug, PartialEq)]
struct Carry {
    left: u32,
    grasped: bool,
}

/// Carries.
#[generator(mp, first = grasp)]
fn carry(c: &mut Carry, t: Tick) -> Step<(Rnt, Polycrank)> {
    assert_eq!(t, TICK);
    if c.left == 0 {
        return Step::Done;
    }
    c.left -= 1;
    Step::Next((Demand::hold(), Demand::hold()))
}

fn grasp(c: &mut Carry, _: &State<(Rnt, Polycrank)>, _: Tick) -> Step<(Rnt, Polycrank)> {
    c.grasped = true;
    Step::Next((Demand::hold(), Demand::hold()))
}

#[generator(mp)]
fn nudge() -> Always<(Rnt, Polycrank), Phase> {
    Always((Phase::Grasp, Phase::Close))
}

#[generator(ecp)]
fn transmit(order: &Order<Displacement>) -> Always<Rnt> {
    Always(Demand::displacement(order.value().pose))
}

struct Press<R> {
    seen: f64,
    of: std::marker::PhantomData<R>,
}

#[generator(ecp, until = pressed, sensors = (WristForce,), order = Phase, first = begin)]
fn press<R: Robot>(c: &mut Press<R>, e: &State<R>) -> Result<Step<R>, Fault> {
    let _ = e.measured();
    c.seen += 1.0;
    Ok(Step::Next(Demand::hold()))
}

fn begin<R: Robot>(order: &Order<Phase>, c: &mut Press<R>) -> Step<R> {
    c.seen = if order.value() == Phase::Close { 100.0 } else { 0.0 };
    Step::Next(Demand::hold())
}

fn pressed(v: &Reading<(WristForce,)>) -> bool {
    v.0.reading().is_some_and(|force| force.along[2] > 5.0)
}

struct Dwell<const N: usize>(usize);

#[condition(mp)]
fn dwell<const N: usize>(c: &mut Dwell<N>) -> bool {
    c.0 += 1;
    c.0 >= N
}

struct Line<R: Robot> {
    to: f64,
    robot: std::marker::PhantomData<R>,
}

#[generator(ecp)]
impl<R: Robot> Line<R> {
    const SPEED: f64 = 0.5;

    fn to(to: f64) -> Self {
        Line { to, robot: std::marker::PhantomData }
    }

    fn first_step(&mut self, _e: &State<R>, _t: Tick) -> Step<R> {
        Step::Next(Demand::hold())
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.to -= Self::SPEED * t.dt;
        if self.to < 0.0 { Step::Done } else { Step::Next(Demand::hold()) }
    }
}

#[test]
fn classes_follow_from_signatures() {
    assert_eq!(Carry::CLASS.to_string(), "MP f*0(c0), first step f*2(c0, e)");
    assert_eq!(nudge::CLASS.to_string(), "MP f**() = const");
    assert_eq!(transmit::CLASS.to_string(), "ECP f*4(c0, c)");
    assert_eq!(Press::<Rnt>::CLASS.to_string(), "ECP f*2(c, e), first step f*4(c0, c), until f*1(c, v)");
    assert_eq!(Line::<Rnt>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(Dwell::<3>::CLASS.to_string(), "MP f*0(c0)");
}
