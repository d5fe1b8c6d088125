//! A guard: what watches over all robots of a cell while programs move them.
//!
//! In: the states of all robots, every few steps. Out: nothing, or the fault for which the cell stops: a protective stop,
//! on the path, with bounded deceleration, latched at standstill.

use crate::model::fault::Fault;
use crate::model::joints::MAX_JOINTS;
use crate::model::name::Name;
use crate::model::pose::Pose;
use crate::model::sensor::EffectorState;

/// The states of one robot, as a [guard](crate::cell::Cell::guard) sees them: those that its EDP reported last.
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
        Guard {
            every: u64::from(every.max(1)),
            watch: Some(Box::new(watch)),
            views: Vec::new(),
            known: Vec::new(),
            looked: None,
        }
    }

    /// The robots of the cell.
    pub fn over(mut self, robots: impl Iterator<Item = Name>) -> Guard {
        let state = EffectorState {
            joints: [0.0; MAX_JOINTS],
            velocity: [0.0; MAX_JOINTS],
            pose: Pose::identity(),
            wrench: None,
        };
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

#[cfg(test)]
mod tests {
    use core::cell::Cell;
    use std::rc::Rc;

    use super::*;
    use crate::model::fault::FaultKind;

    fn name(text: &str) -> Name {
        Name::new(text).expect("a name")
    }

    /// Looks every five steps at two robots, counts how often, and stops them when the second one's joint is above 1.
    fn guard() -> (Guard, Rc<Cell<u32>>) {
        let looks = Rc::<Cell<u32>>::default();
        let counted = Rc::clone(&looks);
        let guard = Guard::new(5, move |views| {
            counted.set(counted.get() + 1);
            if views[1].measured.joints[0] > 1.0 {
                return Err(Fault::new(FaultKind::ProtectiveStop));
            }
            Ok(())
        });
        (guard.over([name("a"), name("b")].into_iter()), looks)
    }

    fn at(robot: &str, joint: f64) -> RobotView {
        let mut joints = [0.0; MAX_JOINTS];
        joints[0] = joint;
        let state =
            EffectorState { joints, velocity: [0.0; MAX_JOINTS], pose: Pose::identity(), wrench: None };
        RobotView { name: name(robot), measured: state, demanded: state }
    }

    #[test]
    fn a_guard_looks_once_in_so_many_steps_and_later_when_it_was_late() {
        let (mut guard, _) = guard();
        guard.see(0, at("a", 0.0));
        guard.see(1, at("b", 0.0));
        assert!(guard.is_due(3));
        guard.look(3).expect("in order");
        // Steps 5 to 9 were all late; the look of 12 counts for 10.
        for (step, due) in [(4, false), (5, true), (9, true), (10, true), (12, true)] {
            assert_eq!(guard.is_due(step), due, "{step}");
        }
        guard.look(12).expect("in order");
        for (step, due) in [(13, false), (14, false), (15, true), (60, true)] {
            assert_eq!(guard.is_due(step), due, "{step}");
        }
    }

    #[test]
    fn a_guard_looks_at_what_all_robots_report() {
        let (mut guard, looks) = guard();
        guard.see(0, at("a", 0.0));
        guard.look(0).expect("nothing of `b` is known");
        assert_eq!((looks.get(), guard.is_due(0)), (0, true));
        guard.see(1, at("b", 2.0));
        assert_eq!(guard.look(0).map_err(|fault| fault.kind()), Err(FaultKind::ProtectiveStop));
        assert_eq!((looks.get(), guard.is_due(0)), (1, false));
        // After a reset at the next chance, at reports of the time after it.
        guard.forget();
        assert!(guard.is_due(0));
        guard.see(0, at("a", 0.0));
        guard.look(0).expect("nothing of `b` is known any more");
        assert_eq!(looks.get(), 1);
    }

    #[test]
    fn a_guard_that_panicked_sleeps() {
        let mut guard = Guard::new(1, |_| panic!("a bug of the watch")).over(core::iter::empty());
        assert!(guard.is_awake());
        let look = std::panic::AssertUnwindSafe(|| guard.look(1));
        assert!(std::panic::catch_unwind(look).is_err());
        assert!(!guard.is_awake());
        guard.look(2).expect("asleep");
    }
}
