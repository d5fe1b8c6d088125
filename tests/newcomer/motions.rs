//! Motions as they are filled in, with what is wrong about them.

use mrroc::prelude::*;
use mrroc_robots::Irp6;
use mrroc_tests::Q;
use nalgebra::Translation3;

use crate::newcomer::kinds::Slides;

/// Ten seconds of what a closure makes of the state and the path time.
pub struct Shift<F> {
    next: F,
    t: f64,
}

impl<F> Shift<F> {
    pub fn new(next: F) -> Shift<F> {
        Shift { next, t: 0.0 }
    }
}

#[generator(ecp)]
fn shift<F: FnMut(&State<Irp6>, f64) -> Demand<Irp6>>(
    c: &mut Shift<F>,
    e: &State<Irp6>,
    t: Tick,
) -> Step<Irp6> {
    if c.t >= 10.0 {
        return Step::Done;
    }
    c.t += t.dt;
    Step::Next((c.next)(e, c.t))
}

/// Turns the column by an angle over time \[rad\].
pub fn turn(angle: fn(f64) -> f64) -> impl FnMut(&State<Irp6>, f64) -> Demand<Irp6> {
    let mut from = None;
    move |e, t| {
        let mut joints = *from.get_or_insert_with(|| e.demanded().joints);
        joints[0] += angle(t);
        Demand::joints(joints)
    }
}

/// Lifts the tool by a height over time \[m\].
pub fn lift(height: fn(f64) -> f64) -> impl FnMut(&State<Irp6>, f64) -> Demand<Irp6> {
    let mut from: Option<Pose> = None;
    move |e, t| {
        let from = *from.get_or_insert_with(|| e.demanded().pose);
        Demand::pose(Translation3::new(0.0, 0.0, height(t)) * from)
    }
}

/// Along x by a decimetre, by poses.
#[derive(Default)]
pub struct Glide {
    from: Option<Pose>,
    t: f64,
}

#[generator(ecp)]
fn glide(c: &mut Glide, e: &State<Slides>, t: Tick) -> Step<Slides> {
    if c.t >= 1.0 {
        return Step::Done;
    }
    c.t += t.dt;
    let from = *c.from.get_or_insert_with(|| e.demanded().pose);
    let s = 0.3 * c.t * c.t * (3.0 - 2.0 * c.t);
    Step::Next(Demand::pose(Translation3::new(s, 0.0, 0.0) * from))
}

/// Never done.
pub struct Endless;

#[generator(ecp)]
fn endless(_: &mut Endless) -> Step<Irp6> {
    Step::Next(Demand::hold())
}

/// What the coordinator tells.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Phase {
    Out,
}

/// The same, step by step.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Plan {
    pub x: f64,
}

pub struct Ask(pub Phase);

#[generator(mp)]
fn ask(c: &mut Ask) -> Always<(Irp6,), Phase> {
    Always((c.0,))
}

pub struct Numbers;

#[generator(mp)]
fn numbers(_: &mut Numbers) -> Step<(Irp6,), Plan> {
    Step::Next((Plan { x: 0.0 },))
}

/// Demands of the coordinator itself.
pub struct Circle;

#[generator(mp)]
fn circle(_: &mut Circle) -> Step<(Irp6,)> {
    Step::Next((Demand::hold(),))
}

/// Reads orders of another type.
pub struct Ordered;

#[generator(ecp)]
fn ordered(_: &mut Ordered, order: &Order<Plan>) -> Step<Irp6> {
    let _ = order.value().x;
    Step::Done
}

/// Begins where the robot is not.
#[derive(Default)]
pub struct Elsewhere {
    q: Q<6>,
}

#[generator(mp)]
fn elsewhere(c: &mut Elsewhere) -> Step<(Irp6,)> {
    Step::Next((Demand::joints(c.q),))
}
