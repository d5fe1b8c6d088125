//! The motion of something that a drive moves in the world, servo period by servo period: a tool frame E, or a belt.
//!
//! In: its pose at the end of each servo period. Out: its place and its even motion between two of these.

use core::time::Duration;
use std::collections::VecDeque;

use mrroc::pose::Pose;
use nalgebra::{UnitQuaternion, Vector3};

use super::compliance::Deflection;
use super::error::{WorldError, positive};
use super::turn;

/// Time on the world's clock \[ns\].
pub(super) type Nanos = u64;

/// \[s\] of a time on the world's clock.
pub(super) fn seconds(time: Nanos) -> f64 {
    time as f64 * 1e-9
}

/// A servo period.
pub(super) fn nanos(period: Duration) -> Result<Nanos, WorldError> {
    positive("the servo period", period.as_secs_f64(), "s")?;
    Ok(Nanos::try_from(period.as_nanos()).unwrap_or(Nanos::MAX))
}

/// Where E is at a time.
#[derive(Clone, Copy, Debug)]
#[allow(non_snake_case)]
struct Knot {
    time: Nanos,
    X_WE: Pose,
}

/// The motion of a frame E, as its drive's servo periods tell it.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    pub period: Nanos,
    /// Servo periods that have begun.
    ticks: u64,
    /// Where E has come to, from the world's time on.
    knots: VecDeque<Knot>,
    /// E at the world's time, and its motion [m/s, rad/s].
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    pub velocity: Vector3<f64>,
    pub turning: Vector3<f64>,
}

impl Motion {
    #[allow(non_snake_case)]
    pub fn new(period: Nanos, now: Nanos, X_WE: Pose) -> Self {
        Self {
            period,
            ticks: now.div_ceil(period.max(1)),
            knots: VecDeque::from([Knot { time: now, X_WE }]),
            position: X_WE.translation.vector,
            rotation: X_WE.rotation,
            velocity: Vector3::zeros(),
            turning: Vector3::zeros(),
        }
    }

    /// Reserves memory for the knots of all periods by which the world may be behind, the longest period being `longest`.
    pub fn reserve(&mut self, longest: Nanos) {
        let periods = usize::try_from(longest.div_ceil(self.period)).unwrap_or(usize::MAX);
        self.knots.reserve(periods.saturating_add(3));
    }

    /// Begins a servo period, at the world's time `now` or later; returns the time at its beginning.
    pub fn begin(&mut self, now: Nanos) -> Nanos {
        // A drive that has stood still for a while goes on from now.
        self.ticks = self.ticks.max(now.div_ceil(self.period));
        self.ticks * self.period
    }

    /// The time to which this motion is known when a servo period of another, `period` long, begins at `time`. Ticks
    /// come half a period after its beginning. One at the same moment does not count, so that their order does not matter.
    pub fn known(&self, time: Nanos, period: Nanos) -> Nanos {
        let odd_multiples = ((2 * time + period - 1) / self.period).div_ceil(2);
        odd_multiples * self.period
    }

    /// Ends the servo period with E at `X_WE`.
    #[allow(non_snake_case)]
    pub fn end(&mut self, X_WE: Pose) {
        let begun = self.ticks * self.period;
        if let Some(last) = self.knots.back().copied().filter(|last| last.time < begun) {
            self.knots.push_back(Knot { time: begun, ..last });
        }
        self.ticks += 1;
        self.knots.push_back(Knot { time: begun + self.period, X_WE });
    }

    /// The next time at which the motion changes.
    pub fn next_change(&self, now: Nanos) -> Option<Nanos> {
        self.knots.iter().map(|knot| knot.time).find(|&time| time > now)
    }

    /// Sets E and its motion for an interval that begins at `now`.
    pub fn enter(&mut self, now: Nanos) {
        while self.knots.get(1).is_some_and(|next| next.time <= now) {
            self.knots.pop_front();
        }
        let Some(from) = self.knots.front() else { return };
        self.position = from.X_WE.translation.vector;
        self.rotation = from.X_WE.rotation;
        self.velocity = Vector3::zeros();
        self.turning = Vector3::zeros();
        if let Some(to) = self.knots.get(1) {
            let rate = seconds(to.time - from.time).recip();
            let change = Deflection::between(
                &self.position,
                &self.rotation,
                &to.X_WE.translation.vector,
                &to.X_WE.rotation,
            );
            self.velocity = change.displacement * rate;
            self.turning = change.turn * rate;
            if now > from.time {
                self.drift(seconds(now - from.time));
            }
        }
    }

    /// Moves E on for `h` \[s\].
    #[inline]
    pub fn drift(&mut self, h: f64) {
        self.position += self.velocity * h;
        self.rotation = turn::by(&(self.turning * h)) * self.rotation;
    }

    /// `X_WE` at the world's time.
    pub fn pose(&self) -> Pose {
        Pose::from_parts(self.position.into(), self.rotation)
    }
}
