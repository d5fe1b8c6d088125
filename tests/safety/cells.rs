//! Small cells for sweeps, each of which uses another part of the protocol.

use mrroc::prelude::*;
use mrroc::sensor::VspMode;
use mrroc_tests::{ExactDrive, Gantry, MS, Q};
use nalgebra::Vector3;

/// Along x to `end` \[m\] in `duration` \[s\] of path time, by a quintic from rest to rest.
pub struct Smooth {
    end: f64,
    duration: f64,
    t: f64,
    start: f64,
}

impl Smooth {
    pub fn to(end: f64, duration: f64) -> Self {
        Smooth { end, duration, t: 0.0, start: 0.0 }
    }

    fn advance(&mut self, dt: f64) -> Option<f64> {
        if self.t >= self.duration {
            return None;
        }
        self.t = (self.t + dt).min(self.duration);
        let u = self.t / self.duration;
        Some(self.start + (self.end - self.start) * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u))
    }
}

fn x(x: f64) -> Demand<Gantry> {
    Demand::joints(Vector3::new(x, 0.0, 0.0))
}

#[generator(ecp, first = smooth_start)]
pub fn smooth(c: &mut Smooth, t: Tick) -> Step<Gantry> {
    c.advance(t.dt).map_or(Step::Done, |position| Step::Next(x(position)))
}

fn smooth_start(c: &mut Smooth, e: &State<Gantry>, t: Tick) -> Step<Gantry> {
    c.start = e.demanded().joints[0];
    smooth(c, t)
}

/// Both gantries along x together, the second one mirrored.
struct Twin(Smooth);

#[generator(mp, first = twin_start)]
fn twin(c: &mut Twin, t: Tick) -> Step<(Gantry, Gantry)> {
    c.0.advance(t.dt).map_or(Step::Done, |position| Step::Next((x(position), x(-position))))
}

fn twin_start(c: &mut Twin, e: &State<(Gantry, Gantry)>, t: Tick) -> Step<(Gantry, Gantry)> {
    c.0.start = e.0.demanded().joints[0];
    twin(c, t)
}

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Phase {
    Approach,
    Retreat,
}

#[generator(mp)]
fn trigger(c: &mut Triggering) -> Always<(Gantry, Gantry), Phase> {
    Always((c.0, c.0))
}

struct Triggering(Phase);

/// x \[m\] of both.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Along {
    pub x: f64,
}

#[generator(mp)]
fn order_along(c: &mut Ordering, t: Tick) -> Step<(Gantry, Gantry), Along> {
    c.0.advance(t.dt).map_or(Step::Done, |x| Step::Next((Along { x }, Along { x })))
}

struct Ordering(Smooth);

#[generator(ecp)]
fn transmit(order: &Order<Along>) -> Always<Gantry> {
    Always(x(order.value().x))
}

/// A gantry at the origin whose drives have this servo period.
pub fn gantry(name: &str, servo: core::time::Duration) -> RobotSetup<Gantry> {
    RobotSetup::new(name, Gantry::default(), ExactDrive::new(Q::<3>::zeros(), servo))
}

fn both(
    mp: &mut Mp,
) -> Result<(mrroc::generator::RobotHandle<Gantry>, mrroc::generator::RobotHandle<Gantry>), Fault> {
    Ok((mp.robot("a")?, mp.robot("b")?))
}

/// Moves both robots together, to the end and back.
pub fn back_and_forth(mp: &mut Mp) -> Result<(), Fault> {
    let (mut a, mut b) = both(mp)?;
    mp.move_robots((&mut a, &mut b), (), Twin(Smooth::to(0.02, 0.12)))?;
    mp.move_robots((&mut a, &mut b), (), Twin(Smooth::to(0.0, 0.12))).map(drop)
}

/// Two transparent ECPs: the MP's demands are passed on.
pub fn transparent() -> Cell {
    Cell::new(MS).robot(gantry("a", MS)).robot(gantry("b", MS)).program(back_and_forth)
}

/// Two programs in ECPs: a loose motion, then a tight one, then a loose one.
pub fn cooperating() -> Cell {
    let program = |ecp: &mut mrroc::program::Ecp<Gantry>| {
        ecp.serve(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.01, 0.1)).map(drop))?;
        ecp.serve(|ecp, _: Along| ecp.move_robot((), transmit {}).map(drop))?;
        ecp.serve(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.0, 0.15)).map(drop))
    };
    let [a, b] = ["a", "b"].map(|name| gantry(name, MS).program(program));
    Cell::new(MS).robot(a).robot(b).program(|mp| {
        let (mut a, mut b) = both(mp)?;
        mp.move_robots((&mut a, &mut b), (), Triggering(Phase::Approach))?;
        let carry = Ordering(Smooth { start: 0.01, ..Smooth::to(0.02, 0.1) });
        mp.move_robots((&mut a, &mut b), (), carry)?;
        mp.move_robots((&mut a, &mut b), (), Triggering(Phase::Retreat)).map(drop)
    })
}

/// One robot whose drives take several positions in a step, and one whose drives take one in several.
pub fn interpolated() -> Cell {
    let fast = gantry("a", MS / 2).program(|ecp| ecp.move_robot((), Smooth::to(0.02, 0.15)).map(drop));
    let slow = gantry("b", MS * 4).program(|ecp| ecp.move_robot((), Smooth::to(0.02, 0.15)).map(drop));
    Cell::new(MS).robot(fast).robot(slow)
}

/// The position that a sensor gives for a gantry.
pub struct Place;

/// Along x \[m\].
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct At {
    pub x: f64,
}

impl Sensor for Place {
    const KIND: &'static str = "place";
    type Reading = At;
    type Configuration = ();
}

/// Reads a quintic of the steps: 0.02 m from step 10 to step 160.
pub struct Path;

impl VirtualSensor for Path {
    type Kind = Place;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<At, Fault> {
        let u = (order.step.saturating_sub(10) as f64 / 150.0).min(1.0);
        Ok(At { x: 0.02 * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u) })
    }
}

/// Goes where the sensor says, for so many steps.
struct Follow(u32);

#[generator(mp)]
fn follow(c: &mut Follow, v: &Reading<(Place,)>) -> Step<(Gantry,)> {
    if c.0 == 0 {
        return Step::Done;
    }
    c.0 -= 1;
    Step::Next((v.0.reading().map_or(Demand::hold(), |place| x(place.x)),))
}

/// Follows `sensor` in a mode.
pub fn following(sensor: impl VirtualSensor<Kind = Place>, mode: VspMode) -> Cell {
    Cell::new(MS).robot(gantry("a", MS)).sensor(SensorSetup::new("place", sensor).mode(mode)).program(|mp| {
        let (mut a, mut place) = (mp.robot::<Gantry>("a")?, mp.sensor::<Place>("place")?);
        mp.move_robots((&mut a,), (&mut place,), Follow(180)).map(drop)
    })
}

/// Follows a sensor that answers each order.
pub fn sensing() -> Cell {
    following(Path, VspMode::Interactive)
}

/// Both robots by their own programs, there and back.
pub fn triggered(mp: &mut Mp) -> Result<(), Fault> {
    let (mut a, mut b) = both(mp)?;
    mp.move_robots((&mut a, &mut b), (), Triggering(Phase::Approach))?;
    mp.move_robots((&mut a, &mut b), (), Triggering(Phase::Retreat)).map(drop)
}

/// Both gantries along x together, led by poses.
struct PosedTwin(Smooth);

#[generator(mp)]
fn posed_twin(c: &mut PosedTwin, t: Tick) -> Step<(Gantry, Gantry)> {
    c.0.advance(t.dt).map_or(Step::Done, |x| {
        let pose = Pose::translation(x, 0.0, 0.0);
        Step::Next((Demand::pose(pose), Demand::pose(pose)))
    })
}

/// Two robots that one Move leads by poses.
pub fn posed(step: core::time::Duration) -> Cell {
    Cell::new(step).robot(gantry("a", MS)).robot(gantry("b", MS)).program(|mp| {
        let (mut a, mut b) = both(mp)?;
        mp.move_robots((&mut a, &mut b), (), PosedTwin(Smooth::to(0.05, 0.4))).map(drop)
    })
}
