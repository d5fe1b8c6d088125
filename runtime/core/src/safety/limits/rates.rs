//! How fast a robot's rate, and its speed on a screw, may change.
//!
//! In: the steps that were accepted, the limits. Out: the headroom and the braking law that go back to the MP with each
//! reply.

use crate::model::joints::JointVector;
use crate::model::robot::Limits;
use crate::safety::braking::{self, BrakingLaw};

use crate::safety::rate::{DEFAULT_CHANGE, RateHeadroom};

use super::state::JointState;

/// The share of an acceleration limit that a generator may plan with: what is left keeps every motion stoppable
/// on its path.
const PATH_SHARE: f64 = 0.9;

/// The share of an acceleration limit that a path and the change of its rate use together.
const USABLE_SHARE: f64 = 0.98;

/// How fast the path is gone along.
pub(super) struct Pace<J> {
    /// Path time over real time of the step accepted last, 0 to 1.
    pub rate: f64,
    /// Duration of that step \[s\].
    pub period: f64,
    /// How many such steps before it had no demand of their own.
    pub bridged: f64,
    /// The path's speed at rate 1 [rad/s or m/s], kept while the robot is suspended: it will be resumed into it.
    pub path_speed: J,
}

impl<J: JointVector> Pace<J> {
    /// Of a robot that has not moved yet.
    pub fn at_rest() -> Self {
        Pace { rate: 1.0, period: 0.0, bridged: 0.0, path_speed: J::zeros() }
    }

    /// A motion begins at a standstill: its path has no speed yet.
    pub fn begin(&mut self) {
        self.path_speed = J::zeros();
    }

    /// A demand was accepted for a step of `duration` \[s\], of which `dt` \[s\] is path time; `missing` \[s\] is the time
    /// without demands before it.
    pub fn accept(&mut self, dt: f64, duration: f64, missing: f64) {
        self.rate = dt / duration;
        self.period = duration;
        self.bridged = missing / duration;
    }

    /// The path has this velocity at the present rate.
    pub fn learn_path_speed(&mut self, velocity: &J) {
        // Near rate 0 the quotient is round-off.
        if self.rate > 1e-3 {
            self.path_speed = J::from_joints(|i| velocity[i].abs() / self.rate);
        }
    }

    /// How fast the rate may change now: what the acceleration limits leave beside a path that uses
    /// [`PATH_SHARE`] of them.
    ///
    /// A path that has been gentle may brake hard in its next step, so what was seen of it proves nothing.
    /// From rate 1 at velocity v a standstill takes 2.05 v / a, as dr/dt = -(0.98 - 0.9 r²) a / v. Where demands come in
    /// every n-th step only, catching up after bridging takes n² times the path's acceleration: a plan and the change of
    /// its rate have the n²-th part of the limit together.
    pub fn headroom(&self, limits: &Limits<J>) -> RateHeadroom {
        // By how much the rate itself may be higher at the end of a step in which it rises.
        let raised = (self.rate + DEFAULT_CHANGE * self.period).min(1.0);
        let mut headroom = RateHeadroom::UNLIMITED;
        for i in 0..J::LEN {
            let limit = limits.acceleration[i];
            // Within the step the path's speed may grow by the limit.
            let along = self.path_speed[i] + limit * self.period;
            let part = limit / (1.0 + self.bridged).powi(2);
            let left = |rate: f64| (USABLE_SHARE - PATH_SHARE * rate * rate) * part / along;
            let mut rise = left(raised);
            let mut fall = left(self.rate);
            let mut bend = f64::INFINITY;
            if let Some(jerk) = limits.jerk {
                // The path's jerk at a changing rate: r³ q''' + 3 r r' q'' + r'' q'. Half of the rest is for each.
                let rest = 0.5 * (USABLE_SHARE - PATH_SHARE) * jerk[i];
                let change = rest / (3.0 * PATH_SHARE * limit);
                rise = rise.min(change);
                fall = fall.min(change);
                bend = rest / along;
            }
            headroom = headroom.and(RateHeadroom { rise, fall, bend });
        }
        headroom
    }
}

/// How fast a robot in this state may slow down on its screw, in steps of `period` \[s\]: within [`braking::SHARE`] of the
/// acceleration limits, and not longer than it brakes from its velocity limits.
pub(super) fn braking_law<J: JointVector>(
    state: &JointState<J>,
    limits: &Limits<J>,
    period: f64,
) -> BrakingLaw {
    if state.is_at_rest() {
        return BrakingLaw::UNLIMITED;
    }
    let mut law = BrakingLaw::UNLIMITED;
    let mut longest = 0.0_f64;
    for i in 0..J::LEN {
        let a = limits.acceleration[i];
        // What the speed will be when the law is used, if the acceleration goes on, and a tenth of what it may change by.
        let faster = (state.velocity[i] + state.acceleration[i] * period).abs() + 0.1 * a * period;
        let bend = limits.jerk.map_or(f64::INFINITY, |jerk| 0.5 * braking::SHARE * jerk[i] / faster);
        law = law.and(BrakingLaw { fall: braking::SHARE * a / faster, bend });
        longest = longest.max(limits.velocity[i] / a);
    }
    BrakingLaw { fall: law.fall.max(longest.recip()), ..law }
}
