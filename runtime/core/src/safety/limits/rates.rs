//! How fast a robot's rate, and its speed on a twist, may change.
//!
//! In: the steps that were accepted, the limits. Out: the rate margin and the braking law that go back to the MP with each
//! reply.

use crate::model::joints::JointVector;
use crate::model::robot::Limits;
use crate::safety::braking::{self, BrakingLaw};

use crate::safety::rate::{FullRate, RateMargin, larger, raised, smaller};

use super::state::JointState;

/// The share of the limits of acceleration and jerk that a generator may plan with: what is left keeps every motion
/// stoppable on its path.
pub const PATH_SHARE: f64 = 0.9;

/// The share of an acceleration limit that a path and the change of its rate use together.
const USABLE_SHARE: f64 = 0.98;

/// By how much the curvature of a twist may grow while a robot brakes on it: the posture changes meanwhile.
const GROWN: f64 = 1.25;

/// How fast the path is gone along.
#[derive(Clone, Copy)]
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

    /// How fast the rate may change now.
    ///
    /// Without a jerk limit that follows the path's own speed: a slow path may change its rate fast. With one it is that of
    /// a path at the velocity limits, because a rate that changes must not meet a bound that becomes narrower meanwhile.
    pub fn rate_margin(&self, limits: &Limits<J>) -> RateMargin {
        let speed = |i: usize| match limits.jerk {
            Some(_) => self.path_speed[i].max(limits.velocity[i]),
            None => self.path_speed[i],
        };
        MarginRule { limits, rate: self.rate, period: self.period, bridged: self.bridged }.at_speed(speed)
    }
}

/// What the limits leave for changes of the rate, beside a path that uses [`PATH_SHARE`] of them.
///
/// A path that has been gentle may brake hard in its next step, so what was seen of its acceleration proves nothing.
struct MarginRule<'a, J> {
    limits: &'a Limits<J>,
    /// Path time over real time, 0 to 1.
    rate: f64,
    /// Length of a step \[s\].
    period: f64,
    /// Steps before it that had no demand of their own.
    bridged: f64,
}

impl<J: JointVector> MarginRule<'_, J> {
    /// Beside a path that has, at rate 1, this speed in each joint [rad/s or m/s].
    ///
    /// The path's acceleration at a changing rate is `r² q'' + r' q'`, its jerk `r³ q''' + 3 r r' q'' + r'' q'`. Of what the
    /// path's own part leaves of a jerk limit, a half is for each of the others. Where demands come in every n-th step only,
    /// catching up after bridging takes n² times the path's acceleration: a plan and the change of its rate have the n²-th
    /// part of the limit together.
    fn at_speed(&self, speed: impl Fn(usize) -> f64) -> RateMargin {
        // By how much the rate itself may be higher at the end of a step in which it rises.
        let raised = raised(self.rate, self.period);
        let mut margin = RateMargin::UNLIMITED;
        let parts = (1.0 + self.bridged).powi(2);
        let jerk = self.limits.jerk.as_ref();
        for i in 0..J::LEN {
            let limit = self.limits.acceleration[i];
            // Within the step the path's speed may grow by the limit.
            let along = speed(i) + limit * self.period;
            let part = limit / parts;
            let left = |rate: f64| (USABLE_SHARE - PATH_SHARE * rate * rate) * part / along;
            let Some(jerk) = jerk.map(|jerk| jerk[i]) else {
                margin.rise = smaller(margin.rise, left(raised));
                margin.fall = smaller(margin.fall, left(self.rate));
                continue;
            };
            let rest = |rate: f64| 0.5 * (USABLE_SHARE - PATH_SHARE * rate.powi(3)) * jerk;
            let change = |rate: f64| left(rate).min(rest(rate) / (3.0 * PATH_SHARE * limit * rate));
            // Below rate 1 the squares of both parts of `change` grow by twice these at least, as they are convex there.
            let unused = USABLE_SHARE - PATH_SHARE;
            let of_left = 2.0 * PATH_SHARE * unused * (part / along).powi(2);
            let of_jerk = unused
                * (USABLE_SHARE + 2.0 * PATH_SHARE)
                * (0.5 * jerk / (3.0 * PATH_SHARE * limit)).powi(2);
            margin = margin.and(RateMargin {
                rise: change(raised),
                fall: change(self.rate),
                bend: rest(raised) / along,
                full: FullRate { rise: change(1.0), bend: (rest(1.0) / along).min(of_left).min(of_jerk) },
                ..RateMargin::UNLIMITED
            });
        }
        margin
    }
}

/// The least that a robot at this rate leaves for changes of the rate, in steps of `period` \[s\]: beside a path at all
/// velocity limits.
pub(crate) fn least_margin<J: JointVector>(limits: &Limits<J>, rate: f64, period: f64) -> RateMargin {
    MarginRule { limits, rate, period, bridged: 0.0 }.at_speed(|i| limits.velocity[i])
}

/// What a robot that stands leaves for changes of the rate, in steps of `period` \[s\]: it may begin to move in the next one.
pub(crate) fn standing_margin<J: JointVector>(limits: &Limits<J>, rate: f64, period: f64) -> RateMargin {
    let pace = Pace { rate, period, ..Pace::at_rest() };
    pace.rate_margin(limits)
}

/// How fast a robot in this state may slow down on its twist, in steps of `period` \[s\]: within [`braking::SHARE`] of the
/// acceleration limits, and within what the twist's `curvature` \[rad/s² or m/s²\] leaves of them where it slows a joint down as well.
/// Where the curvature leaves enough, that takes no longer than braking from the velocity limits. It never takes longer than
/// braking from them with that share.
pub(super) fn braking_law<J: JointVector>(
    state: &JointState<J>,
    curvature: &J,
    limits: &Limits<J>,
    period: f64,
) -> BrakingLaw {
    if state.is_at_rest() {
        return BrakingLaw::UNLIMITED;
    }
    let mut law = BrakingLaw::UNLIMITED;
    let mut left = f64::INFINITY;
    let mut longest = 0.0_f64;
    for i in 0..J::LEN {
        let a = limits.acceleration[i];
        // What the speed will be when the law is used, if the acceleration goes on, and a tenth of what it may change by.
        let faster = (state.velocity[i] + state.acceleration[i] * period).abs() + 0.1 * a * period;
        let bend = limits.jerk.map_or(f64::INFINITY, |jerk| 0.5 * braking::SHARE * jerk[i] / faster);
        // The first step of braking has both; the curvature's part falls with the square of the speed.
        let bent = larger(-curvature[i] * state.velocity[i].signum(), 0.0);
        let fall = larger(a - GROWN * bent, 0.0) / faster;
        law = law.and(BrakingLaw { fall: smaller(braking::SHARE * a / faster, fall), bend });
        left = smaller(left, fall);
        longest = larger(longest, limits.velocity[i] / a);
    }
    let fall = law.fall.max(longest.recip().min(left)).max(braking::SHARE / longest);
    BrakingLaw { fall, ..law }
}
