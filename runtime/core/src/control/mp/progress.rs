//! How far a generator of the MP has come, and its next demands.

use crate::model::class::Uses;
use crate::model::fault::{Fault, FaultKind};
use crate::model::generator::Generator;
use crate::model::list::{Reading, RobotList, SensorList, State};
use crate::model::payload::Order;
use crate::model::step::{Step, Tick};

/// What a generator says for a step; nothing if it was not asked.
type Said<G> = Option<Step<<G as Generator>::Robots, <G as Generator>::Language>>;

/// A generator in progress.
pub(super) struct Progress<G: Generator> {
    pub generator: G,
    /// What it is shown.
    pub e: State<G::Robots>,
    pub v: Reading<G::Sensors>,
    order: Order<G::Order>,
    /// Its steps in which path time passed.
    pub step: u64,
}

impl<G: Generator> Progress<G> {
    pub fn new(
        generator: G,
        robots: <G::Robots as RobotList>::Images,
        sensors: <G::Sensors as SensorList>::Images,
    ) -> Result<Self, Fault> {
        // There is nobody who could order an MP anything.
        let order = Order::unread().map_err(|_| Fault::new(FaultKind::Message))?;
        Ok(Progress { generator, e: State::new(robots), v: Reading::new(sensors), order, step: 0 })
    }

    /// Whether the first step is to come.
    pub const fn is_first(&self) -> bool {
        self.step == 0
    }

    /// What the next step takes.
    pub const fn uses(&self) -> Uses {
        if self.is_first() { G::CLASS.first_uses() } else { G::CLASS.next_uses() }
    }

    /// What the generator says for this step; nothing if path time stands still, and it would not notice.
    ///
    /// # Errors
    /// The fault that it throws.
    pub fn next(&mut self, t: Tick, standing: bool) -> Result<Said<G>, Fault> {
        let Progress { generator, e, v, order, .. } = self;
        let next = if standing && (self.step == 0 || !const { G::CLASS.next_uses() }.tick) {
            return Ok(None);
        } else if self.step == 0 {
            generator.first_step(order, e, v, t)
        } else {
            generator.next_step(order, e, v, t)
        };
        let next = next.map_err(Fault::thrown_by_program)?;
        // Suspended, nothing moves whatever a generator returns, but orders say what they say.
        self.step += u64::from(matches!(next, Step::Next(_)) && !standing);
        Ok(Some(next))
    }
}
