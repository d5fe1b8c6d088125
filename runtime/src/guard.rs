//! A guard: what watches over all robots of a cell while programs move them.
//!
//! In: the states of all robots, every few steps. Out: nothing, or the fault for which the cell stops: a protective stop,
//! on the path, with bounded deceleration, latched at standstill.

use crate::fault::Fault;
use crate::name::Name;
use crate::vsp::EffectorState;

/// The states of one robot, as a [guard](crate::Cell::guard) sees them: those that its EDP reported last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotView {
    /// The robot's name.
    pub name: Name,
    /// The state that the encoders gave.
    pub measured: EffectorState,
    /// The state demanded last: where the robot is on its way to.
    pub demanded: EffectorState,
}

/// What a guard is called with: all robots, in the order in which the cell has them.
type Watch = Box<dyn FnMut(&[RobotView]) -> Result<(), Fault>>;

/// A guard and what it has seen.
pub(crate) struct Guard {
    every: u64,
    watch: Option<Watch>,
    views: Vec<RobotView>,
}

impl Guard {
    /// A guard that looks every so many steps.
    pub fn new(every: u32, watch: impl FnMut(&[RobotView]) -> Result<(), Fault> + 'static) -> Guard {
        Guard { every: u64::from(every.max(1)), watch: Some(Box::new(watch)), views: Vec::new() }
    }

    /// Whether it looks in this step.
    pub const fn is_due(&self, step: u64) -> bool {
        step.is_multiple_of(self.every)
    }

    /// What a robot of the cell reported.
    pub fn see(&mut self, robot: usize, view: RobotView) {
        match self.views.get_mut(robot) {
            Some(known) => *known = view,
            // The robots report in their order when the cell starts.
            None => self.views.push(view),
        }
    }

    /// Looks. A watch that panics is not called again by the stop that follows.
    pub fn look(&mut self) -> Result<(), Fault> {
        let Some(mut watch) = self.watch.take() else { return Ok(()) };
        let seen = watch(&self.views);
        self.watch = Some(watch);
        seen
    }
}
