//! A guard: what watches over all robots of a cell while programs move them.
//!
//! In: the states of all robots, every few steps. Out: nothing, or the fault for which the cell stops: a protective stop,
//! on the path, with bounded deceleration, latched at standstill.

use crate::fault::Fault;
use crate::joints::MAX_JOINTS;
use crate::name::Name;
use crate::pose::Pose;
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
    /// All robots of the cell, and which of them have reported.
    views: Vec<RobotView>,
    known: Vec<bool>,
    /// The last step that it looked in, as a multiple of `every`.
    looked: Option<u64>,
}

impl Guard {
    /// A guard that looks every so many steps.
    pub fn new(every: u32, watch: impl FnMut(&[RobotView]) -> Result<(), Fault> + 'static) -> Guard {
        let (views, known) = (Vec::new(), Vec::new());
        Guard { every: u64::from(every.max(1)), watch: Some(Box::new(watch)), views, known, looked: None }
    }

    /// The robots of the cell.
    pub fn over(mut self, robots: impl Iterator<Item = Name>) -> Guard {
        let state =
            EffectorState { joints: [0.0; MAX_JOINTS], velocity: [0.0; MAX_JOINTS], pose: Pose::identity() };
        self.views = robots.map(|name| RobotView { name, measured: state, demanded: state }).collect();
        self.known = vec![false; self.views.len()];
        self
    }

    /// Whether it is to look in this step, which may be later than the one in which it should have.
    pub fn is_due(&self, step: u64) -> bool {
        self.looked != Some(step / self.every)
    }

    /// What a robot of the cell reported.
    pub fn see(&mut self, robot: usize, view: RobotView) {
        if let (Some(seen), Some(known)) = (self.views.get_mut(robot), self.known.get_mut(robot)) {
            (*seen, *known) = (view, true);
        }
    }

    /// It is to look at the next chance, at what robots report from now on.
    pub fn forget(&mut self) {
        self.looked = None;
        self.known.fill(false);
    }

    /// Whether it still looks: a watch that has panicked does not.
    pub const fn is_awake(&self) -> bool {
        self.watch.is_some()
    }

    /// Looks, once all robots have reported. A watch that panics is not called again by the stop that follows.
    pub fn look(&mut self, step: u64) -> Result<(), Fault> {
        if self.known.contains(&false) {
            return Ok(());
        }
        let Some(mut watch) = self.watch.take() else { return Ok(()) };
        self.looked = Some(step / self.every);
        let seen = watch(&self.views);
        self.watch = Some(watch);
        seen
    }
}
