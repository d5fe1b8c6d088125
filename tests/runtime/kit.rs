//! Generators, orders and sensors that several of the tests use.

use std::cell::Cell as Shared;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_tests::Gantry;
use nalgebra::Vector3;

/// Along x to `end` \[m\] by a smoothstep over `duration` \[s\] of path time, from where the robot was demanded to be.
#[derive(Debug)]
pub struct Smooth {
    pub end: f64,
    pub duration: f64,
    t: f64,
    start: f64,
}

impl Smooth {
    pub fn to(end: f64, duration: f64) -> Self {
        Smooth { end, duration, t: 0.0, start: 0.0 }
    }

    pub fn advance(&mut self, dt: f64) -> Option<f64> {
        if self.t >= self.duration {
            return None;
        }
        self.t = (self.t + dt).min(self.duration);
        let u = self.t / self.duration;
        Some(self.start + (self.end - self.start) * u * u * (3.0 - 2.0 * u))
    }
}

pub fn x(x: f64) -> Demand<Gantry> {
    Demand::joints(Vector3::new(x, 0.0, 0.0))
}

#[generator(ecp, first = smooth_start)]
pub fn smooth(c: &mut Smooth, t: Tick) -> Step<Gantry> {
    match c.advance(t.dt) {
        Some(position) => Step::Next(x(position)),
        None => Step::Done,
    }
}

fn smooth_start(c: &mut Smooth, e: &State<Gantry>, t: Tick) -> Step<Gantry> {
    c.start = e.demanded().joints[0];
    smooth(c, t)
}

/// Along x at a constant speed [m/s] for `steps` steps: starts and ends moving.
pub struct Coast {
    pub speed: f64,
    pub steps: u32,
    x: f64,
}

impl Coast {
    pub fn new(speed: f64, steps: u32) -> Self {
        Coast { speed, steps, x: 0.0 }
    }
}

#[generator(ecp, first = coast_start)]
pub fn coast(c: &mut Coast, t: Tick) -> Step<Gantry> {
    if c.steps == 0 {
        return Step::Done;
    }
    c.steps -= 1;
    c.x += c.speed * t.dt;
    Step::Next(x(c.x))
}

fn coast_start(c: &mut Coast, e: &State<Gantry>, t: Tick) -> Step<Gantry> {
    c.x = e.demanded().joints[0];
    coast(c, t)
}

/// Both gantries along x together, the second one mirrored, in the MP.
pub struct Twin(pub Smooth);

#[generator(mp)]
pub fn twin(c: &mut Twin, t: Tick) -> Step<(Gantry, Gantry)> {
    match c.0.advance(t.dt) {
        Some(position) => Step::Next((x(position), x(-position))),
        None => Step::Done,
    }
}

/// The orders of loose cooperation.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Phase {
    Approach,
    Retreat,
}

/// The order of tight cooperation: x \[m\].
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Along {
    pub x: f64,
}

#[generator(ecp)]
pub fn transmit(order: &Order<Along>) -> Always<Gantry> {
    Always(x(order.value().x))
}

/// A sensor that counts its aggregations.
pub struct Counter;

impl Sensor for Counter {
    const KIND: &'static str = "counter";
    type Reading = Count;
    type Configuration = Offset;
}

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Count {
    /// Aggregations so far, plus the configured offset.
    pub count: u64,
    /// Where the associated robot was measured along x \[m\]; NaN without one.
    pub x: f64,
    /// The step of the order.
    pub step: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Offset {
    pub offset: u64,
}

#[derive(Default)]
pub struct Counting {
    pub count: Rc<Shared<u64>>,
    /// Fails at this aggregation.
    pub fails_at: Option<u64>,
}

impl VirtualSensor for Counting {
    type Kind = Counter;

    fn aggregate(&mut self, order: &ReadingOrder<Offset>) -> Result<Count, Fault> {
        self.count.set(self.count.get() + 1);
        if self.fails_at == Some(self.count.get()) {
            return Err(Fault::thrown("the cable is cut"));
        }
        let x = order.robot.map_or(f64::NAN, |robot| robot.pose.translation.x);
        Ok(Count { count: self.count.get() + order.configuration.offset, x, step: order.step })
    }
}

/// Moves by the readings of a counter: keeps them.
#[derive(Default)]
pub struct Watch {
    pub seen: Vec<Option<(u64, u32)>>,
    pub steps: usize,
    pub of_robot: Vec<f64>,
}

#[generator(ecp)]
pub fn watch(c: &mut Watch, v: &Reading<(Counter,)>) -> Step<Gantry> {
    if c.seen.len() == c.steps {
        return Step::Done;
    }
    c.seen.push(v.0.reading().map(|reading| (reading.count, v.0.age())));
    c.of_robot.push(v.0.reading().map_or(f64::NAN, |reading| reading.x));
    Step::Next(Demand::hold())
}
