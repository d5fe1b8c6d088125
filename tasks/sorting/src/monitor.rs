//! What a run shows: where the hand got hold of parts, and where they went.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::fault::Fault;
use mrroc::robot::RobotView;
use mrroc_robots::grasp::{Hand, Touch, Whereabouts, World};

use crate::parts::Arrival;
use crate::plant::END_BIN;

/// A grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// Which part.
    pub part: usize,
    /// When \[s\].
    pub time: f64,
    /// How far its middle was from that of the fingers along the belt \[m\], > 0 ahead ..
    pub along: f64,
    /// .. and across it, once both fingers had it \[m\].
    pub across: f64,
    /// Its speed along the belt less that of the fingers, when the first one touched it [m/s].
    pub slip: f64,
}

/// What became of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// In the tray for its length.
    Sorted,
    /// In the other tray.
    Wrong,
    /// Over the end of the belt, or not picked when the run ended.
    Missed,
    /// A stranger that was not taken, as it should be.
    Passed,
    /// A stranger that a hand took, and that came into no bin: it was put back, or is still in the hand.
    Gripped,
}

/// Watches a hand.
#[derive(Clone, Debug)]
pub struct HandMonitor {
    hand: Hand,
    grips: Rc<RefCell<Vec<Grip>>>,
}

impl HandMonitor {
    /// Of this hand.
    #[must_use]
    pub fn of(hand: Hand) -> Self {
        Self { hand, grips: Rc::default() }
    }

    /// Looks, after each step: what a guard of a cell does.
    pub fn look(&self) -> impl FnMut(&[RobotView]) -> Result<(), Fault> + 'static {
        let Self { hand, grips } = self.clone();
        let mut last = None;
        move |_| {
            if let (Some(touch), Some(grip)) = (hand.touched(), hand.gripped())
                && last != Some(grip.time)
            {
                last = Some(grip.time);
                grips.borrow_mut().push(Grip::of(&touch, &grip));
            }
            Ok(())
        }
    }

    /// The grasps.
    #[must_use]
    pub fn grips(&self) -> Vec<Grip> {
        self.grips.borrow().clone()
    }
}

impl Grip {
    /// y of E is against the belt.
    fn of(touch: &Touch, grip: &Touch) -> Self {
        let middle = grip.X_EB.translation.vector;
        Self { part: grip.body, time: grip.time, along: -middle.y, across: middle.x, slip: -touch.velocity.y }
    }
}

/// What became of the parts.
#[must_use]
pub fn fates(world: &World, parts: &[Arrival]) -> Vec<Fate> {
    let fate = |(number, part): (usize, &Arrival)| match world.whereabouts(number) {
        Some(Whereabouts::Gone { sink: END_BIN, .. }) => Fate::Missed,
        Some(Whereabouts::Gone { sink, .. }) if sink == part.shape.tray() => Fate::Sorted,
        Some(Whereabouts::Gone { .. }) => Fate::Wrong,
        Some(Whereabouts::Awaited | Whereabouts::Here) | None => Fate::Missed,
    };
    parts.iter().enumerate().map(fate).collect()
}
