//! The plant: the simulated drives of a cell, where they are a process of their own.
//!
//! In: commands of EDPs, one per servo period and robot. Out: what the encoders read. It outlives the EDPs as real drives
//! do: drives whose commands stop bridge `L` steps and apply their brakes in the next one (faults 1 to 3 in docs/safety). One
//! process has all of them, because simulated robots may be in one world, with a body between them.
//!
//! Drives that have yet to find their reference marks stay in their EDP, and so do the drives that they become: while a
//! robot searches nothing is commanded that could be bridged or run out, and a search that is called no more comes to rest
//! by itself. A robot of a shared world is therefore one that knows where it is.
//!
//! A program that asks for it has its observers here, beside the drives ([`Launch::watching`](crate::Launch::watching)).
//!
//! [`Site`] puts it together, [`Drives`](drives::Drives) are those of one robot, [`command`] is what goes to and fro;
//! [`sensors`] are virtual sensors that sense this world.

mod bodies;
mod drives;
pub(crate) mod sensors;
#[cfg(test)]
mod tests;

use crate::link::Host;
use core::cell::RefCell;
use core::time::Duration;
use std::rc::Rc;

use crate::control::drive::{Drive, PlantDrive, PlantEnd};
use crate::control::plant_sensor::PlantSensor;
use crate::control::vsp::{Aggregator, AnyVirtualSensor, RawSensors};
use crate::link::memory::Stuck;
use crate::link::timeout::AnswerTimeout;
use crate::link::{Board, Clock, Closed, Link, Sample, Simulation};
use crate::model::driver::{Driver, Measured};
use crate::model::fault::ProcessId;
use crate::model::robot::Robot;
use crate::model::time::Nanos;
use crate::observe::servo::Observer;

pub(crate) use bodies::{Bodies, Body};
use drives::{Commands, Drives};
use sensors::Sensor;

/// How a robot came to a standstill after its commands had stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rest {
    /// Its EDP.
    pub edp: ProcessId,
    /// Steps from the servo period of its last command to the one in which its brakes were applied.
    pub braked_after: u64,
    /// Steps from then to its standstill.
    pub stood_after: u64,
}

/// What the plant leaves behind.
pub type Rests = Rc<RefCell<Vec<Rest>>>;

/// A robot's drives or a simulated sensor, of any kind.
trait Part {
    /// Does what has come for it.
    fn serve(&mut self);
    /// Does the servo periods that are due.
    fn advance(&mut self, now: Nanos);
    /// When the next one is due; `None` when nothing moves by itself.
    fn due(&self) -> Option<Nanos>;
    /// Shows nothing more to observers: the cell's time stands still, and that of the drives goes on.
    fn blindfold(&mut self) {}
    /// Whether nothing moves any more, whatever commands come.
    fn rests(&self) -> bool;
    /// How it came to that.
    fn rest(&self) -> Option<Rest>;
}

/// The plant of a cell that is put together.
pub struct Site {
    simulation: Simulation,
    place: Option<usize>,
    /// Length of a step.
    period: Duration,
    /// Whether observers look at the drives here, and not in their EDPs.
    watched: bool,
    parts: Vec<Box<dyn Part>>,
}

impl Site {
    /// The plant of a cell with this step; with a place of its own if the link has one for it and anything is simulated;
    /// `watched`: observers look at it.
    pub fn new(link: &mut dyn Link, period: Duration, anything: bool, watched: bool) -> Site {
        let simulation = link.simulation();
        let apart = anything && simulation != Simulation::InEdps;
        let place = apart.then(|| link.place(ProcessId::PLANT));
        Site { simulation, place, period, watched, parts: Vec::new() }
    }

    /// From now on it takes what is of a cell with this step; that of the cell before.
    pub const fn goes_by(&mut self, period: Duration) -> Duration {
        core::mem::replace(&mut self.period, period)
    }

    /// Takes the drives of the EDP `process` at `edp`, if they are simulated and the plant has a place; returns what the
    /// EDP has of them. Who looks at them here is taken out of `observers`.
    pub(crate) fn take<R: Robot>(
        &mut self,
        link: &mut dyn Link,
        process: ProcessId,
        edp: usize,
        mut driver: Box<dyn Driver<R>>,
        observers: &mut Vec<Observer<R>>,
    ) -> Drive<R> {
        if let Some(drives) = driver.stepped() {
            drives.run_by(match self.simulation {
                Simulation::Free => Clock::Real,
                Simulation::InEdps | Simulation::Asked => Clock::Virtual,
            });
        }
        let is_simulated = driver.simulation().is_some();
        let Some(plant) = self.place.filter(|_| is_simulated) else { return Drive::Here(driver) };
        let AnswerTimeout { most: timeout, again: period } = AnswerTimeout::of_step(self.period);
        let (end, commands) = match self.simulation {
            Simulation::InEdps | Simulation::Asked => {
                let (client, server) = link.port(edp, plant);
                (PlantEnd::Asks(client, plant), Commands::Asked(server))
            }
            Simulation::Free => {
                let commands = link.board(edp, plant);
                let readings = link.board(plant, edp);
                let end = PlantEnd::Reads(Rc::clone(&commands), Rc::clone(&readings));
                (end, Commands::Free(commands, readings))
            }
        };
        let measured = match driver.measured() {
            Ok(measured) => measured,
            Err(trip) => return Drive::unread_in_plant(&*driver, &trip),
        };
        let drive = Drive::Plant(Box::new(PlantDrive::new(&*driver, measured, end, timeout)));
        let observers = if self.watched { core::mem::take(observers) } else { Vec::new() };
        self.parts
            .push(Box::new(Drives::new(process, driver, measured, commands, period, timeout, observers)));
        drive
    }

    /// The place of the plant, if it has one and senses what this sensor does.
    pub(crate) fn place_of(&self, sensor: &dyn AnyVirtualSensor) -> Option<usize> {
        self.place.filter(|_| sensor.is_simulated())
    }

    /// Takes the raw sensors of the VSP at `vsp`, if they are simulated and the plant has a place; returns what the VSP has
    /// of them.
    pub(crate) fn take_sensor(
        &mut self,
        link: &mut dyn Link,
        vsp: usize,
        aggregator: Aggregator,
    ) -> RawSensors {
        let Some(plant) = self.place_of(&*aggregator.sensor) else {
            return RawSensors::Here(aggregator);
        };
        let (port, server) = link.port(vsp, plant);
        self.parts.push(Box::new(Sensor::new(aggregator, server)));
        RawSensors::Plant(PlantSensor { port, plant, timeout: AnswerTimeout::of_step(self.period) })
    }

    /// Takes the bodies that are shown to observers, if the plant has a place; gives them back otherwise.
    pub(crate) fn take_bodies(&mut self, bodies: Bodies) -> Option<Bodies> {
        if self.place.is_none() {
            return Some(bodies);
        }
        self.parts.push(Box::new(bodies));
        None
    }

    /// A board that the process at `writer` writes and the plant reads, if that has a place.
    pub fn board(&self, link: &mut dyn Link, writer: usize) -> Option<Rc<dyn Board>> {
        self.place.map(|plant| link.board(writer, plant))
    }

    /// Gives the plant its body.
    ///
    /// # Errors
    /// [`Stuck`] when the link has none for it.
    pub fn spawn(self, link: &mut dyn Link, rests: Rests) -> Result<(), Stuck> {
        let Some(place) = self.place else { return Ok(()) };
        link.body(place, Box::new(move |host| run(self.parts, host, &rests)))
    }
}

/// Runs until the cell closes and all robots stand.
fn run(mut parts: Vec<Box<dyn Part>>, host: Host<'_>, rests: &Rests) {
    let waiter = host.waiter;
    let due = |parts: &[Box<dyn Part>]| parts.iter().filter_map(|part| part.due()).min();
    let attend = |parts: &mut [Box<dyn Part>], now: Nanos| {
        parts.iter_mut().for_each(|part| part.serve());
        parts.iter_mut().for_each(|part| part.advance(now));
    };
    loop {
        let awaited = due(&parts);
        if waiter.wait(awaited).is_err() {
            break;
        }
        let woke = waiter.now();
        attend(&mut parts, woke);
        if let Some(late) = awaited.and_then(|due| woke.checked_sub(due)) {
            host.meter.sample(Sample::Late(late));
            host.meter.sample(Sample::Worked(waiter.now().saturating_sub(woke)));
        }
    }
    // EDPs may still brake their robots. Those that are gone send nothing more.
    while parts.iter().any(|part| !part.rests()) {
        let Some(due) = due(&parts) else { break };
        // Where time stands still then, that of the drives goes on.
        let now = match waiter.wait_closing(due) {
            Ok(()) => waiter.now(),
            Err(Closed) => {
                parts.iter_mut().for_each(|part| part.blindfold());
                due
            }
        };
        attend(&mut parts, now);
    }
    rests.borrow_mut().extend(parts.iter().filter_map(|part| part.rest()));
}

/// The fastest that a robot moves which stands [rad/s or m/s].
const STANDSTILL: f64 = 1e-3;

/// Whether a robot stands.
fn stands<J: crate::model::joints::JointVector>(measured: &Measured<J>) -> bool {
    measured.velocity.as_slice().iter().all(|velocity| velocity.abs() <= STANDSTILL)
}
