//! How robots come to rest on their path: their path time passes slower and slower.

use mrroc::cell::PATH_SHARE;
use mrroc::generator::{Tick, steepest};

use super::path::TimedPath;

/// The rate at which the time of a path passes while the robots on it are brought to rest, as the cell's own path time does it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Halt {
    /// 1 as planned, 0 at rest.
    pub rate: f64,
    /// Its change \[1/s\], at most 0.
    pub slope: f64,
    /// What jerk limits leave for it; `None` without such limits.
    jerk: Option<JerkRule>,
}

/// What a path needs at most from here to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
struct JerkRule {
    /// The largest speed of a joint by its limit of acceleration \[s\], and by that of jerk \[s²\].
    speed: [f64; 2],
    /// The largest acceleration by its limit, and by that of jerk \[s\].
    acceleration: [f64; 2],
    /// The largest jerk by its limit.
    jerk: f64,
}

impl Halt {
    /// Begins at a time of a path \[s\].
    pub fn at(path: &TimedPath, time: f64) -> Halt {
        let is_limited = path.limits().iter().any(|limits| limits.jerk.is_finite());
        Halt { rate: 1.0, slope: 0.0, jerk: is_limited.then(|| JerkRule::of(path, time)) }
    }

    /// The rate of the next step, of `dt` \[s\] of the cell's path time, on a path that has come to `time` \[s\] by a step that had a share of
    /// its duration as path time.
    pub fn advance(&mut self, path: &TimedPath, time: f64, t: Tick, share: f64) {
        let dt = t.dt;
        if dt <= 0.0 || self.rate == 0.0 {
            return;
        }
        // As after a suspension: they hardly move yet.
        if stops_at_once(path, time, share * self.rate, t.duration) {
            (self.rate, self.slope) = (0.0, 0.0);
            return;
        }
        let (fall, bend) = match &self.jerk {
            None => (self.fall(path, time, dt), f64::INFINITY),
            Some(rule) => rule.fall_and_bend(self.rate),
        };
        let steepest = steepest(self.rate / dt, bend * dt);
        self.slope = (-fall.min(steepest)).clamp(self.slope - bend * dt, self.slope + bend * dt);
        let next = self.rate + self.slope * dt;
        self.rate = if next <= 4.0 * f64::EPSILON { 0.0 } else { next.min(1.0) };
        if self.rate == 0.0 {
            self.slope = 0.0;
        }
    }

    /// The fastest that the rate may fall \[1/s\] where only the acceleration is limited. That of the path at a rate r is `r² q'' + r' q'`; it
    /// may be [`PATH_SHARE`] of the limit, which a path that uses less always leaves room for.
    fn fall(&self, path: &TimedPath, time: f64, dt: f64) -> f64 {
        let mut fall = f64::INFINITY;
        for (joint, limits) in path.limits().iter().enumerate() {
            let usable = PATH_SHARE * limits.acceleration;
            // The step begins here, and ends no later than there.
            for at in [time, time + self.rate * dt] {
                let [_, velocity, acceleration] = path.at(at, joint);
                let along = velocity.abs() + limits.acceleration * self.rate * dt;
                let own = self.rate * self.rate * acceleration * velocity.signum();
                fall = fall.min((usable + own).max(0.0) / along);
            }
        }
        fall
    }
}

/// Whether robots that go along a path at this rate may stand in the next step of `duration` \[s\].
fn stops_at_once(path: &TimedPath, time: f64, rate: f64, duration: f64) -> bool {
    let mut joints = path.limits().iter().enumerate();
    joints.all(|(joint, limits)| {
        let [_, velocity, _] = path.at(time, joint);
        let change = rate * velocity.abs() / duration;
        // The jerk of it is twice: what it takes to begin to brake, and to end.
        change <= PATH_SHARE * limits.acceleration && 2.0 * change <= PATH_SHARE * limits.jerk * duration
    })
}

impl JerkRule {
    fn of(path: &TimedPath, time: f64) -> JerkRule {
        let mut rule = JerkRule { speed: [0.0; 2], acceleration: [0.0; 2], jerk: 0.0 };
        for (duration, pieces) in path.rest(time) {
            for (piece, limits) in pieces.iter().zip(path.limits()) {
                let velocity = piece.derivative();
                let acceleration = velocity.derivative();
                let [speed, most, jerk] =
                    [velocity, acceleration, acceleration.derivative()].map(|piece| piece.bound(duration));
                rule.speed[0] = rule.speed[0].max(speed / limits.acceleration);
                rule.speed[1] = rule.speed[1].max(speed / limits.jerk);
                rule.acceleration[0] = rule.acceleration[0].max(most / limits.acceleration);
                rule.acceleration[1] = rule.acceleration[1].max(most / limits.jerk);
                rule.jerk = rule.jerk.max(jerk / limits.jerk);
            }
        }
        // The control points may be beyond what a check of the path has found to be within its share.
        rule.acceleration[0] = rule.acceleration[0].min(super::SHARE);
        rule.jerk = rule.jerk.min(super::JERK_SHARE);
        rule
    }

    /// The fastest that the rate may fall \[1/s\], and how fast that may change \[1/s²\]. The path's jerk at a rate r is
    /// `r³ q''' + 3 r r' q'' + r'' q'`: of what the first term leaves, each of the others may have a half.
    fn fall_and_bend(&self, rate: f64) -> (f64, f64) {
        let left = PATH_SHARE - self.acceleration[0] * rate * rate;
        let rest = 0.5 * (PATH_SHARE - self.jerk * rate.powi(3));
        let fall = (left / self.speed[0]).min(rest / (3.0 * self.acceleration[1] * rate));
        (fall, rest / self.speed[1])
    }
}
