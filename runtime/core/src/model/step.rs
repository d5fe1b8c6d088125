//! What a step function returns, and what it is told of time.

use core::fmt;

use crate::model::demand::Demand;
use crate::model::fault::Fault;
use crate::model::list::{Motion, Robots};
use crate::model::robot::Robot;

/// The next step of a motion of the robots `L` in the language `O`: demands, or the end.
pub enum Step<L: Robots<O>, O = Motion> {
    /// The demanded next state of every robot of the list: `(Demand<Rnt>, Demand<Polycrank>)`.
    Next(L::Demands),
    /// The terminal condition holds: the motion is over, at the state demanded last.
    Done,
}

/// What a step function without state returns: in every step the demands that follow from its arguments
/// alone. A motion of this kind has no `Done`; it ends when every ECP of its list has finished, or by `until`.
pub struct Always<L: Robots<O>, O = Motion>(pub L::Demands);

impl<R: Robot + Robots<Motion, Demands = Demand<R>>> Step<R> {
    /// The same step of one robot, whose demand says where the motion leads: see [`Demand::with_goal`].
    #[must_use]
    pub fn with_goal(self, goal: Demand<R>) -> Self {
        match self {
            Step::Next(demand) => Step::Next(demand.with_goal(goal)),
            Step::Done => Step::Done,
        }
    }
}

impl<L: Robots<O>, O> Clone for Step<L, O> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<L: Robots<O>, O> Copy for Step<L, O> {}
impl<L: Robots<O>, O> Clone for Always<L, O> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<L: Robots<O>, O> Copy for Always<L, O> {}

impl<L: Robots<O>, O> PartialEq for Step<L, O>
where
    L::Demands: PartialEq,
{
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Step::Next(a), Step::Next(b)) => a == b,
            (Step::Done, Step::Done) => true,
            (Step::Next(_), Step::Done) | (Step::Done, Step::Next(_)) => false,
        }
    }
}
impl<L: Robots<O>, O> fmt::Debug for Step<L, O>
where
    L::Demands: fmt::Debug,
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Step::Next(demands) => f.debug_tuple("Next").field(demands).finish(),
            Step::Done => f.write_str("Done"),
        }
    }
}

/// What may stand where a step function returns: [`Step`], [`Always`], or a `Result` of one with a [`Fault`].
#[doc(hidden)]
pub trait IntoStep<L: Robots<O>, O> {
    fn into_step(self) -> Result<Step<L, O>, Fault>;
}

impl<L: Robots<O>, O> IntoStep<L, O> for Step<L, O> {
    fn into_step(self) -> Result<Step<L, O>, Fault> {
        Ok(self)
    }
}

impl<L: Robots<O>, O> IntoStep<L, O> for Always<L, O> {
    fn into_step(self) -> Result<Step<L, O>, Fault> {
        Ok(Step::Next(self.0))
    }
}

impl<L: Robots<O>, O, T: IntoStep<L, O>> IntoStep<L, O> for Result<T, Fault> {
    fn into_step(self) -> Result<Step<L, O>, Fault> {
        self?.into_step()
    }
}

/// What may stand where a condition returns: `bool`, or a `Result` of one with a [`Fault`].
#[doc(hidden)]
pub trait IntoVerdict {
    fn into_verdict(self) -> Result<bool, Fault>;
}

impl IntoVerdict for bool {
    fn into_verdict(self) -> Result<bool, Fault> {
        Ok(self)
    }
}

impl IntoVerdict for Result<bool, Fault> {
    fn into_verdict(self) -> Result<bool, Fault> {
        self
    }
}

/// Time as a step function sees it.
///
/// Generators advance by `dt`, never by a clock: the operator's speed scales it, so that every robot slows
/// down on its path in the same step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Index of the step within the instruction, 0 for the first.
    pub step: u64,
    /// Path time that passes in this step \[s\]: the step times the rate, 0 ..= step for a punctual step.
    pub dt: f64,
    /// The step's duration in real time \[s\], counting the periods that a late step skipped.
    pub duration: f64,
}
