//! Many axes that arrive at the same instant.
//!
//! The duration is the shortest that is possible for every axis. Where all axes are to move in proportion (states and
//! targets along one line, as from rest to rest), and the slowest axis' motion in that proportion is within the limits
//! of the others, they do so: the path is straight.

use mrroc::robot::{JointVector, MAX_JOINTS};

use super::{AxisLimits, AxisPlan, AxisPoint, AxisState, AxisTarget, JerkError, JerkProfile, Peaks};

/// Limits of all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits<J> {
    /// Velocity per joint [rad/s or m/s], in both directions, > 0.
    pub velocity: J,
    /// Acceleration per joint [rad/s^2 or m/s^2], in both directions, > 0.
    pub acceleration: J,
    /// Jerk per joint [rad/s^3 or m/s^3], > 0.
    pub jerk: J,
}

/// State of all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointState<J> {
    /// Positions [rad or m].
    pub position: J,
    /// Velocities [rad/s or m/s].
    pub velocity: J,
    /// Accelerations [rad/s^2 or m/s^2].
    pub acceleration: J,
}

/// Where all axes are to arrive together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointTarget<J> {
    /// Positions [rad or m].
    pub position: J,
    /// Velocities [rad/s or m/s].
    pub velocity: J,
    /// Accelerations [rad/s^2 or m/s^2].
    pub acceleration: J,
}

/// What the duration of a motion must keep to; by default it is the shortest that is possible for every axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MoveDuration {
    /// It is no shorter than this \[s\], finite, >= 0.
    pub minimum: f64,
    /// It is rounded up to a whole number of steps of this duration \[s\], finite, > 0: the end falls on a step.
    pub step: Option<f64>,
}

impl MoveDuration {
    fn validate(&self) -> Result<(), JerkError> {
        if !(self.minimum.is_finite() && self.minimum >= 0.0) {
            return Err(JerkError::MinimumDuration(self.minimum));
        }
        match self.step {
            Some(step) if !(step.is_finite() && step > 0.0) => {
                Err(JerkError::Limit { name: "step", value: step, sign: '>' })
            }
            Some(_) | None => Ok(()),
        }
    }
}

/// All axes at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointPoint<J> {
    /// Positions [rad or m].
    pub position: J,
    /// Velocities [rad/s or m/s].
    pub velocity: J,
    /// Accelerations [rad/s^2 or m/s^2].
    pub acceleration: J,
    /// Jerks [rad/s^3 or m/s^3].
    pub jerk: J,
}

impl<J: JointVector> JointState<J> {
    /// At rest.
    #[must_use]
    pub fn rest(position: J) -> Self {
        JointState { position, velocity: J::zeros(), acceleration: J::zeros() }
    }

    fn axis(&self, i: usize) -> AxisState {
        AxisState {
            position: self.position[i],
            velocity: self.velocity[i],
            acceleration: self.acceleration[i],
        }
    }
}

impl<J: JointVector> JointTarget<J> {
    /// At rest.
    #[must_use]
    pub fn rest(position: J) -> Self {
        JointTarget { position, velocity: J::zeros(), acceleration: J::zeros() }
    }

    fn axis(&self, i: usize) -> AxisTarget {
        AxisTarget {
            position: self.position[i],
            velocity: self.velocity[i],
            acceleration: self.acceleration[i],
        }
    }
}

impl<J: JointVector> JointLimits<J> {
    /// Those of joint `i`.
    #[must_use]
    pub fn axis(&self, i: usize) -> AxisLimits {
        AxisLimits::symmetric(self.velocity[i], self.acceleration[i], self.jerk[i])
    }
}

impl<J: JointVector> From<JointPoint<J>> for JointState<J> {
    fn from(point: JointPoint<J>) -> Self {
        let JointPoint { position, velocity, acceleration, .. } = point;
        JointState { position, velocity, acceleration }
    }
}

/// A motion of all axes, over path time; immutable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SynchronisedMove<J> {
    axes: [JerkProfile; MAX_JOINTS],
    end: JointTarget<J>,
    duration: f64,
}

impl<J: JointVector> SynchronisedMove<J> {
    /// The fastest motion from `start` to `target` within `limits` in which all axes arrive together.
    ///
    /// # Errors
    /// Of the first axis that cannot; see [`AxisPlan::new`].
    pub fn new(
        start: &JointState<J>,
        target: &JointTarget<J>,
        limits: &JointLimits<J>,
    ) -> Result<Self, JerkError> {
        Self::with_limits(start, target, |i| limits.axis(i), MoveDuration::default())
    }

    /// The fastest of those motions that take at least `minimum` \[s\], finite, >= 0: for an axis that is to arrive together
    /// with something else, a gripper, another robot, a process. From rest to rest it takes exactly that long, unless the
    /// limits require longer; an axis that moves at its start or its target may not be able to take just as long, see
    /// [`AxisPlan::blocked`], and then takes the next longer duration that is possible.
    ///
    /// # Errors
    /// A minimum out of range; and of the first axis that cannot, see [`AxisPlan::new`].
    pub fn with_minimum_duration(
        start: &JointState<J>,
        target: &JointTarget<J>,
        limits: &JointLimits<J>,
        minimum: f64,
    ) -> Result<Self, JerkError> {
        let duration = MoveDuration { minimum, ..MoveDuration::default() };
        Self::with_limits(start, target, |i| limits.axis(i), duration)
    }

    /// The fastest motion whose duration is a whole number of steps of `dt` \[s\], > 0: the end falls on a step.
    ///
    /// # Errors
    /// Of the first axis that cannot; see [`AxisPlan::new`].
    pub fn in_whole_steps(
        start: &JointState<J>,
        target: &JointTarget<J>,
        limits: &JointLimits<J>,
        dt: f64,
    ) -> Result<Self, JerkError> {
        let duration = MoveDuration { step: Some(dt), ..MoveDuration::default() };
        Self::with_limits(start, target, |i| limits.axis(i), duration)
    }

    /// The fastest motion within limits of each joint that may differ by direction, whose duration keeps to `duration`.
    ///
    /// # Errors
    /// A minimum or a step out of range; and of the first axis that cannot, see [`AxisPlan::new`].
    pub fn with_limits(
        start: &JointState<J>,
        target: &JointTarget<J>,
        limits: impl Fn(usize) -> AxisLimits,
        duration: MoveDuration,
    ) -> Result<Self, JerkError> {
        duration.validate()?;
        let MoveDuration { minimum, step } = duration;
        let mut plans = [None; MAX_JOINTS];
        let mut duration = 0.0;
        let mut slowest = 0;
        for (i, slot) in plans[..J::LEN].iter_mut().enumerate() {
            let plan = AxisPlan::new(&start.axis(i), &target.axis(i), &limits(i))?;
            if plan.least() > duration {
                duration = plan.least();
                slowest = i;
            }
            *slot = Some(plan);
        }
        duration = duration.max(minimum);
        let plans = || plans.iter().flatten();
        // Every axis moves the duration on once at most.
        for _ in 0..=2 * J::LEN {
            let whole = match step {
                // A duration that is a whole number of steps, up to rounding, must not gain one.
                Some(dt) => ((duration / dt - 1e-9).ceil() * dt).max(duration),
                None => duration,
            };
            let possible = plans().fold(whole, |longest: f64, plan| longest.max(plan.possible_from(whole)));
            if possible == whole && possible == duration {
                break;
            }
            duration = possible;
        }
        let mut motion =
            SynchronisedMove { axes: [JerkProfile::default(); MAX_JOINTS], end: *target, duration };
        let Some(lead) = plans().nth(slowest) else { return Ok(motion) };
        lead.write_lasting(&mut motion.axes[slowest], duration)?;
        let peaks = motion.axes[slowest].peaks();
        let straight = (0..J::LEN).try_fold([0.0; MAX_JOINTS], |mut ratios, i| {
            ratios[i] = ratio(start, target, i, slowest)?;
            within(&peaks, ratios[i], &limits(i)).then_some(ratios)
        });
        let lead = straight.map(|_| motion.axes[slowest]);
        for (i, plan) in plans().enumerate().filter(|(i, _)| *i != slowest) {
            let axis = &mut motion.axes[i];
            if let (Some(ratios), Some(lead)) = (straight, &lead) {
                axis.set_scaled(lead, start.position[i], ratios[i]);
                axis.end_at(duration, &target.axis(i));
            } else {
                plan.write_lasting(axis, duration)?;
            }
        }
        Ok(motion)
    }

    /// Duration \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// All axes at path time `t` \[s\]; exactly at the target at the end, and on from there as it moves there.
    #[must_use]
    pub fn at(&self, t: f64) -> JointPoint<J> {
        let zeros = J::zeros();
        let mut all = JointPoint { position: zeros, velocity: zeros, acceleration: zeros, jerk: zeros };
        for (i, axis) in self.axes[..J::LEN].iter().enumerate() {
            let AxisPoint { position, velocity, acceleration, jerk } = axis.at(t);
            all.position[i] = position;
            all.velocity[i] = velocity;
            all.acceleration[i] = acceleration;
            all.jerk[i] = jerk;
        }
        all
    }

    /// The motion of joint `i`; `None` where there is no such joint.
    #[must_use]
    pub fn axis(&self, i: usize) -> Option<&JerkProfile> {
        self.axes[..J::LEN].get(i)
    }

    /// The extreme values that joint `i` takes.
    #[must_use]
    pub fn peaks(&self, i: usize) -> Option<Peaks> {
        self.axis(i).map(JerkProfile::peaks)
    }

    /// The target.
    #[must_use]
    pub fn target(&self) -> JointTarget<J> {
        self.end
    }
}

/// By what the motion of axis `i` is that of axis `lead` multiplied, if all its numbers agree on that.
fn ratio<J: JointVector>(
    start: &JointState<J>,
    target: &JointTarget<J>,
    i: usize,
    lead: usize,
) -> Option<f64> {
    let numbers = |i: usize| {
        let from = start.axis(i);
        let to = target.axis(i);
        [to.position - from.position, from.velocity, from.acceleration, to.velocity, to.acceleration]
    };
    let ours = numbers(i);
    let theirs = numbers(lead);
    let ratio = ours[0] / theirs[0];
    // A jump of the state as small as rounding makes it.
    let agree = ours.iter().zip(theirs).all(|(x, y)| (x - ratio * y).abs() <= 1e-13 * x.abs());
    (ratio.is_finite() && agree).then_some(ratio)
}

/// Whether a motion with `peaks`, multiplied by `ratio`, keeps `limits`.
fn within(peaks: &Peaks, ratio: f64, limits: &AxisLimits) -> bool {
    let keeps = |(high, low): (f64, f64), most: f64, least: f64| {
        let x = high * ratio;
        let y = low * ratio;
        x.max(y) <= most && x.min(y) >= least
    };
    keeps(peaks.velocity, limits.max_velocity, limits.min_velocity)
        && keeps(peaks.acceleration, limits.max_acceleration, limits.min_acceleration)
        && keeps(peaks.jerk, limits.jerk, -limits.jerk)
}
