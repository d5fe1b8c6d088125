//! How fast a robot's rate, and its speed on a screw, may change.
//!
//! In: the state accepted last, the limits. Out: the headroom that goes back to the MP with each reply.

use crate::model::joints::JointVector;
use crate::model::robot::Robot;
use crate::safety::braking::{self, BrakingLaw};

use crate::safety::rate::{DEFAULT_CHANGE, RateHeadroom};

use super::Acceptor;

/// The share of an acceleration limit that a generator may plan with: what is left keeps every motion stoppable
/// on its path.
const PATH_SHARE: f64 = 0.9;

/// The share of an acceleration limit that a path and the change of its rate use together.
const USABLE_SHARE: f64 = 0.98;

impl<R: Robot> Acceptor<R> {
    /// How fast the rate may change now: what the acceleration limits leave beside a path that uses
    /// [`PATH_SHARE`] of them.
    ///
    /// A path that has been gentle may brake hard in its next step, so what was seen of it proves nothing.
    /// From rate 1 at velocity v a standstill takes 2.05 v / a, as dr/dt = -(0.98 - 0.9 r²) a / v. Where demands come in
    /// every n-th step only, catching up after bridging takes n² times the path's acceleration: a plan and the change of
    /// its rate have the n²-th part of the limit together.
    pub fn headroom(&self) -> RateHeadroom {
        let limits = self.robot.limits();
        // By how much the rate itself may be higher at the end of a step in which it rises.
        let raised = (self.rate + DEFAULT_CHANGE * self.period).min(1.0);
        let mut headroom = RateHeadroom::UNLIMITED;
        for i in 0..R::Joints::LEN {
            let limit = limits.acceleration[i];
            // Within the step the path's speed may grow by the limit.
            let along = self.path_speed[i] + limit * self.period;
            let part = limit / (1.0 + self.bridged).powi(2);
            let left = |rate: f64| (USABLE_SHARE - PATH_SHARE * rate * rate) * part / along;
            let (mut rise, mut fall, mut bend) = (left(raised), left(self.rate), f64::INFINITY);
            if let Some(jerk) = limits.jerk {
                // The path's jerk at a changing rate: r³ q''' + 3 r r' q'' + r'' q'. Half of the rest is for each.
                let rest = 0.5 * (USABLE_SHARE - PATH_SHARE) * jerk[i];
                let change = rest / (3.0 * PATH_SHARE * limit);
                (rise, fall, bend) = (rise.min(change), fall.min(change), rest / along);
            }
            headroom = headroom.and(RateHeadroom { rise, fall, bend });
        }
        headroom
    }

    /// How fast the robot may slow down on its screw from here: within [`braking::SHARE`] of the acceleration limits, and
    /// not longer than it brakes from its velocity limits.
    pub fn braking_law(&self, duration: f64) -> BrakingLaw {
        let limits = self.robot.limits();
        if self.is_at_rest() {
            return BrakingLaw::UNLIMITED;
        }
        let (mut law, mut longest) = (BrakingLaw::UNLIMITED, 0.0_f64);
        for i in 0..R::Joints::LEN {
            let (v, a) = (self.velocity[i], limits.acceleration[i]);
            // What the speed will be when the law is used, if the acceleration goes on, and a tenth of what it may change by.
            let faster = (v + self.acceleration[i] * duration).abs() + 0.1 * a * duration;
            let bend = limits.jerk.map_or(f64::INFINITY, |jerk| 0.5 * braking::SHARE * jerk[i] / faster);
            law = law.and(BrakingLaw { fall: braking::SHARE * a / faster, bend });
            longest = longest.max(limits.velocity[i] / a);
        }
        BrakingLaw { fall: law.fall.max(longest.recip()), ..law }
    }
}
