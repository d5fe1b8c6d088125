//! How far a generator of the MP has come, and its next demands.

use core::any::TypeId;

use crate::control::sensing::{Readings, SensorsRead};
use crate::model::class::Uses;
use crate::model::fault::{Fault, FaultKind};
use crate::model::generator::Generator;
use crate::model::list::{Motion, PayloadType, RobotList, Robots, SensorsOf, State};
use crate::model::payload::Order;
use crate::model::step::{Step, Tick};

use super::robots::RobotPorts;

/// A generator in progress, with the handles of its sensors.
pub(super) struct Progress<G: Generator, H: SensorsOf<G::Sensors>> {
    pub generator: G,
    pub sensors: Readings<G::Sensors, H>,
    /// What it is shown of its robots.
    e: State<G::Robots>,
    order: Order<G::Order>,
    /// Its steps in which path time passed.
    step: u64,
}

/// What a generator's type says.
#[derive(Clone, Copy)]
pub(super) struct Facts {
    pub first_uses: Uses,
    pub next_uses: Uses,
    /// Whether it has an end of its own.
    pub ends: bool,
    /// Whether it demands motions, and gives no orders.
    pub moves: bool,
}

/// What it said for a step.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Said {
    /// It was not asked: path time stands still, and it would not notice.
    Nothing,
    /// Demands, which are in the robots' orders.
    Demands,
    Done,
}

/// A generator in progress, whatever its type: what moves robots by it is compiled once.
pub(super) trait AnyProgress {
    fn facts(&self) -> Facts;
    /// What robot `i` of its list is told.
    fn payload(&self, i: usize) -> PayloadType;
    fn sensors(&mut self) -> &mut dyn SensorsRead;
    /// Its steps in which path time passed.
    fn step(&self) -> u64;

    /// Asks it for its step: shows it the images in the replies of its robots, which are at `indices`, and writes what it demands into their
    /// orders.
    ///
    /// # Errors
    /// The fault that it throws.
    fn next(
        &mut self,
        robots: &mut RobotPorts,
        indices: &[usize],
        t: Tick,
        standing: bool,
    ) -> Result<Said, Fault>;

    /// Whether the first step is to come.
    fn is_first(&self) -> bool {
        self.step() == 0
    }
}

impl<G: Generator, H: SensorsOf<G::Sensors>> Progress<G, H> {
    pub fn new(generator: G, robots: <G::Robots as RobotList>::Images, sensors: H) -> Result<Self, Fault> {
        // There is nobody who could order an MP anything.
        let order = Order::unread().map_err(|_| Fault::new(FaultKind::Message))?;
        Ok(Progress { generator, e: State::new(robots), sensors: Readings::of(sensors), order, step: 0 })
    }
}

impl<G: Generator, H: SensorsOf<G::Sensors>> AnyProgress for Progress<G, H> {
    fn facts(&self) -> Facts {
        Facts {
            first_uses: const { G::CLASS.first_uses() },
            next_uses: const { G::CLASS.next_uses() },
            ends: G::ENDS,
            moves: TypeId::of::<G::Language>() == TypeId::of::<Motion>(),
        }
    }

    fn payload(&self, i: usize) -> PayloadType {
        <G::Robots as Robots<G::Language>>::payload(i)
    }

    fn sensors(&mut self) -> &mut dyn SensorsRead {
        &mut self.sensors
    }

    fn step(&self) -> u64 {
        self.step
    }

    fn next(
        &mut self,
        robots: &mut RobotPorts,
        indices: &[usize],
        t: Tick,
        standing: bool,
    ) -> Result<Said, Fault> {
        let first = self.step == 0;
        let uses = if first { const { G::CLASS.first_uses() } } else { const { G::CLASS.next_uses() } };
        let Progress { generator, sensors: Readings { v, .. }, e, order, .. } = self;
        if uses.robots {
            robots.read_images::<G::Robots>(indices, e)?;
        }
        let next = if standing && (first || !const { G::CLASS.next_uses() }.tick) {
            return Ok(Said::Nothing);
        } else if first {
            generator.first_step(order, e, v, t)
        } else {
            generator.next_step(order, e, v, t)
        };
        match next.map_err(Fault::thrown_by_program)? {
            Step::Done => Ok(Said::Done),
            Step::Next(demands) => {
                robots.write::<G::Robots, G::Language>(indices, &demands);
                // Suspended, nothing moves whatever a generator returns, but orders say what they say.
                self.step += u64::from(!standing);
                Ok(Said::Demands)
            }
        }
    }
}
