//! How robots that move together come back onto their path when all of them had no demand.
//!
//! In: the twists of the path before and over the time without demands, and the twists that the robots followed meanwhile. Out: the
//! displacement of the body from its path, in the world, step by step until it is zero. All arms of one body know these twists, each by its own flange
//! ([`together`](crate::safety::common_twist)), so all of them are displaced alike and keep their relative pose.

use crate::model::pose::Pose;
use crate::safety::common_twist::Twist;

/// How many steps robots take to come back, for each multiple of the path's change of velocity in a step by which they are too
/// fast. The first acceleration of the return is `4/50` of the path's, and a little more for the displacement itself: a path
/// that uses nine tenths of a limit leaves as much as that.
const STEPS: f64 = 50.0;

/// Twists of the path and of the robots over a time without demands.
pub(super) struct GapTwists {
    /// The path's twist in its last step before the time without demands, and over that time and the step of the late demand.
    pub last: Twist,
    pub over: Twist,
    /// The robots' over that time, from where the path was before, and in its last step.
    pub bridged: Twist,
    pub change: Twist,
}

/// A return to the path: the displacement from the path is a cubic polynomial in time. It begins with the displacement, and
/// its change, that bridging left, and ends at rest without a displacement.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rejoining {
    /// The displacement at the last bridged step, and its change in that step.
    from: Twist,
    change: Twist,
    /// The path's twist in the step of the late demand, and the largest change of such a twist in a step since the robots
    /// left the path.
    path: Twist,
    bend: f64,
    /// Steps since, and in all.
    step: f64,
    steps: f64,
}

impl Rejoining {
    /// After `missed` steps without demands, from the return on which the robots were.
    pub fn after(known: Option<&Rejoining>, twists: &GapTwists, missed: f64) -> Rejoining {
        let GapTwists { last, over, bridged, change } = *twists;
        // Both are twists of the middles of their times: the path's changes by this in each step.
        let bend = (over * (1.0 + missed).recip() - last) * (0.5 * (missed + 2.0)).recip();
        let from = bridged - last * missed - bend * (0.5 * missed * (missed + 1.0));
        let change = change - last - bend * missed;
        let path = last + bend * (missed + 1.0);
        // What bridged it may have bent where the path does not.
        let bend = bend.size().max(change.size() / missed.max(1.0));
        let bend = known.map_or(bend, |known| bend.max(known.bend));
        // One that does not bend comes to no offset.
        let steps = if bend > 0.0 { STEPS * (change.size() / bend).max(1.0) } else { 1.0 };
        Rejoining { from, change, path, bend, step: 1.0, steps }
    }

    /// So many steps later, unless it is over.
    pub fn advanced(&self, steps: f64) -> Option<Rejoining> {
        let step = self.step + steps;
        (step < self.steps).then_some(Rejoining { step, ..*self })
    }

    /// From the path to where the robots are, in the world.
    pub fn displacement(&self) -> Pose {
        self.offset(self.step).part(1.0)
    }

    /// By how much that changed in the last step.
    pub fn change(&self) -> Twist {
        self.offset(self.step) - self.offset(self.step - 1.0)
    }

    /// The path's last twist, of the step of the late demand: later ones are those of the demands.
    pub fn path_twist(&self) -> Option<Twist> {
        (self.step == 1.0).then_some(self.path)
    }

    fn offset(&self, step: f64) -> Twist {
        let u = step / self.steps;
        let rest = 1.0 - u;
        self.from * ((1.0 + 2.0 * u) * rest * rest) + self.change * (step * rest * rest)
    }
}
