//! Bodies that the robots of a cell handle, shown to observers at a run.
//!
//! In: their poses, from whatever simulates or measures them, where the simulated drives are. Out: the same to observers,
//! some tens of times a second. Nothing in a cell acts on them.

use core::time::Duration;

use super::{Part, Rest};
use crate::model::name::Name;
use crate::model::pose::Pose;
use crate::model::time::Nanos;
use crate::model::wire::Wire;
use crate::observe::step_observer::{StepEvent, StepObservers};

/// How often bodies are shown: as often as an eye can follow, which is less than a step's rate.
const EVERY: Nanos = Duration::from_millis(20).as_nanos() as Nanos;

/// A body, and what tells its pose `X_WB`.
pub(crate) struct Body {
    pub name: Name,
    pub pose: Box<dyn FnMut() -> Pose>,
}

/// The bodies of a cell.
pub(crate) struct Bodies {
    bodies: Vec<Body>,
    step_observers: StepObservers,
    /// Length of a step \[ns\].
    step: Nanos,
    /// When they are shown next.
    due: Nanos,
}

impl Bodies {
    /// Bodies of a cell with steps of this length.
    pub fn of(bodies: Vec<Body>, step_observers: StepObservers, step: Duration) -> Self {
        Bodies { bodies, step_observers, step: (step.as_nanos() as Nanos).max(1), due: 0 }
    }

    /// Whether there is nothing to show, or nobody to show it to.
    pub fn is_idle(&self) -> bool {
        self.bodies.is_empty() || !self.step_observers.is_watched()
    }

    /// Shows them, if it is time to.
    pub fn look(&mut self, now: Nanos) {
        if now < self.due {
            return;
        }
        self.due = (now / EVERY + 1) * EVERY;
        for body in &mut self.bodies {
            let mut words = [0; Pose::LEN];
            (body.pose)().put(&mut words);
            let what = StepEvent::Body { step: now / self.step, body: body.name };
            self.step_observers.show(now, &what, &words);
        }
    }
}

impl Part for Bodies {
    fn serve(&mut self) {}

    fn advance(&mut self, now: Nanos) {
        self.look(now);
    }

    fn due(&self) -> Option<Nanos> {
        // They move with the drives, whose servo periods wake the plant.
        None
    }

    fn blindfold(&mut self) {
        self.bodies.clear();
    }

    fn rests(&self) -> bool {
        true
    }

    fn rest(&self) -> Option<Rest> {
        None
    }
}
