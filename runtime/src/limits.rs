//! Demands become accepted demands here, through the limits, or are refused: never clamped.
//!
//! In: what a step function returned, decoded. Out: an [`AcceptedDemand`], the only thing that a drive is
//! given. Checked in this order: numbers finite, rotation valid, inverse kinematics, position (with the
//! distance that braking needs), velocity, acceleration, jerk, limits that joints share.

use core::marker::PhantomData;

use nalgebra::UnitQuaternion;

use crate::braking::{Braking, stopping_distance};
use crate::demand::{Coordinates, Demand};
use crate::fault::{Fault, FaultKind};
use crate::joints::JointVector;
use crate::pose::Pose;
use crate::robot::{Limits, NoInverse, Robot};

/// Deviation of a quaternion's norm from 1 below which a rotation is taken, normalised.
const FRAME_TOLERANCE: f64 = 1e-6;
/// Relative excess over a limit that is round-off.
const RELATIVE: f64 = 1e-9;
/// Round-off of a difference of positions of order 1 [rad or m].
const ROUND_OFF: f64 = 1e-12;

/// Joint positions that a drive may be given: the limits have been checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AcceptedDemand<R: Robot> {
    joints: R::Joints,
    // Nothing outside this file can make one.
    checked: PhantomData<()>,
}

impl<R: Robot> AcceptedDemand<R> {
    const fn new(joints: R::Joints) -> Self {
        AcceptedDemand { joints, checked: PhantomData }
    }

    /// The joint positions [rad or m].
    pub const fn joints(&self) -> &R::Joints {
        &self.joints
    }
}

/// How fast the rate may change without breaking an acceleration limit [1/s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RateHeadroom {
    /// Largest rise per second.
    pub rise: f64,
    /// Largest fall per second.
    pub fall: f64,
}

/// The state demanded last and the checks on the way to the next one.
pub(crate) struct Acceptor<R: Robot> {
    robot: R,
    tool: Pose,
    position: R::Joints,
    velocity: R::Joints,
    acceleration: R::Joints,
    /// Pose of the tool at the start of the instruction, for displacements.
    start: Option<Pose>,
    /// Largest acceleration of the path in this motion, per unit of path time squared.
    path_peak: R::Joints,
    rate: f64,
    /// Time that passes between a lost peer and the start of braking \[s\].
    reaction: f64,
}

impl<R: Robot> Acceptor<R> {
    /// At rest at `position`.
    pub fn new(robot: R, tool: Pose, position: R::Joints, reaction: f64) -> Self {
        let zeros = R::Joints::zeros();
        Acceptor {
            robot,
            tool,
            position,
            velocity: zeros,
            acceleration: zeros,
            start: None,
            path_peak: zeros,
            rate: 1.0,
            reaction,
        }
    }

    pub const fn position(&self) -> &R::Joints {
        &self.position
    }

    pub const fn velocity(&self) -> &R::Joints {
        &self.velocity
    }

    pub const fn tool(&self) -> &Pose {
        &self.tool
    }

    /// Pose of the tool, `X_WE`, for joint positions `q`.
    pub fn tool_pose(&self, q: &R::Joints) -> Pose {
        self.robot.forward(q) * self.tool
    }

    /// Whether the demand stands still.
    pub fn is_at_rest(&self) -> bool {
        // 1e-9 rad/s is round-off of positions over a step; a standstill by safety.md is 1e-3 rad/s.
        self.velocity.as_slice().iter().all(|v| v.abs() <= 1e-9)
    }

    /// Whether the robot may simply stay at the state demanded last: a motion that ends at rest leaves the
    /// velocity of its last step, which one step takes away within the limits.
    pub fn can_hold(&self, duration: f64) -> bool {
        let zeros = R::Joints::zeros();
        self.check(&self.position, &zeros, &((zeros - self.velocity) * duration.recip()), duration).is_ok()
    }

    /// A new motion begins: displacements count from here.
    pub fn begin(&mut self) {
        self.start = None;
        self.path_peak = R::Joints::zeros();
    }

    /// Stay: the state demanded last is demanded again.
    pub fn hold(&mut self, duration: f64) -> AcceptedDemand<R> {
        let zeros = R::Joints::zeros();
        self.acceleration = (zeros - self.velocity) * duration.recip();
        self.velocity = zeros;
        AcceptedDemand::new(self.position)
    }

    /// A demand was lost: the velocity is held.
    pub fn extrapolate(&mut self, duration: f64) -> AcceptedDemand<R> {
        self.position = self.position + self.velocity * duration;
        self.acceleration = R::Joints::zeros();
        AcceptedDemand::new(self.position)
    }

    /// The way to a standstill from here.
    pub fn braking(&self) -> Braking<R::Joints> {
        Braking::new(self.position, self.velocity, self.acceleration, self.robot.limits())
    }

    /// The next state on that way.
    pub fn brake(&mut self, braking: &mut Braking<R::Joints>, duration: f64) -> AcceptedDemand<R> {
        let (position, velocity) = braking.advance(duration);
        self.acceleration = (velocity - self.velocity) * duration.recip();
        (self.position, self.velocity) = (position, velocity);
        AcceptedDemand::new(position)
    }

    /// Checks a demand for the end of a step of `duration` \[s\], of which `dt` \[s\] is path time.
    ///
    /// # Errors
    /// The first limit that it breaks; nothing is changed then.
    pub fn accept(&mut self, demand: &Demand<R>, dt: f64, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        let tool = match &demand.tool {
            Some(tool) => valid_frame(tool)?,
            None => self.tool,
        };
        let position = match &demand.coordinates {
            Coordinates::Hold => self.position,
            Coordinates::Joints(joints) => *joints,
            Coordinates::Pose(pose) => self.joints_at(&valid_frame(pose)?, &tool)?,
            Coordinates::Displacement(displacement) => {
                let displacement = valid_frame(displacement)?;
                let position = self.position;
                let start = *self.start.get_or_insert_with(|| self.robot.forward(&position) * tool);
                self.joints_at(&(start * displacement), &tool)?
            }
        };
        if let Some(joint) = position.as_slice().iter().position(|q| !q.is_finite()) {
            return Err(Fault::new(FaultKind::DemandNotFinite).at_joint(joint));
        }
        let per_second = duration.recip();
        let velocity = (position - self.position) * per_second;
        let acceleration = (velocity - self.velocity) * per_second;
        self.check(&position, &velocity, &acceleration, duration)?;
        self.robot.check_coupled(&self.position, &position, duration).map_err(|limit| {
            let fault = Fault::new(FaultKind::DemandOutOfRange).at_joint(limit.joint).text(limit.what);
            fault.exceeds(limit.actual, limit.limit, limit.unit)
        })?;
        self.note_path(&velocity, &acceleration, dt / duration, per_second);
        (self.position, self.velocity, self.acceleration, self.tool) =
            (position, velocity, acceleration, tool);
        Ok(AcceptedDemand::new(position))
    }

    fn joints_at(&self, pose: &Pose, tool: &Pose) -> Result<R::Joints, Fault> {
        self.robot.inverse(&(pose * tool.inverse()), &self.position).map_err(|error| {
            let fault = Fault::new(FaultKind::NoInverseKinematics);
            match error {
                NoInverse::OutOfReach { distance, min, max } => {
                    let limit = if distance > max { max } else { min };
                    fault.text("the pose is out of reach").exceeds(distance, limit, "m")
                }
                NoInverse::Singular { name } => fault.text(name),
            }
        })
    }

    fn check(&self, q: &R::Joints, v: &R::Joints, a: &R::Joints, duration: f64) -> Result<(), Fault> {
        let limits: &Limits<R::Joints> = self.robot.limits();
        let per_second = duration.recip();
        let slack = |limit: f64, round_off: f64| limit * (1.0 + RELATIVE) + round_off;
        let standing = self.is_at_rest();
        for i in 0..R::Joints::LEN {
            let round_off = ROUND_OFF * q[i].abs().max(1.0);
            let excess = |kind, actual: f64, limit: f64, unit| {
                Fault::new(kind).at_joint(i).exceeds(actual, limit, unit)
            };
            let speed_limit = limits.velocity[i];
            if v[i].abs() > slack(speed_limit, round_off * per_second) {
                // A first demand a whole jump away is not a fast motion but a wrong start.
                let kind = if standing { FaultKind::StartPoseMismatch } else { FaultKind::DemandedVelocity };
                return Err(excess(kind, v[i].abs(), speed_limit, R::joint(i).unit(1)));
            }
            let jerk_limit = limits.jerk.map(|jerk| jerk[i]);
            let distance = stopping_distance(v[i], a[i], limits.acceleration[i], jerk_limit, self.reaction);
            let (lower, upper) = (limits.lower[i] - round_off, limits.upper[i] + round_off);
            let reach = q[i] + distance.copysign(v[i]);
            if q[i] > upper || (v[i] > 0.0 && reach > upper) {
                return Err(excess(
                    FaultKind::DemandOutOfRange,
                    reach.max(q[i]),
                    limits.upper[i],
                    R::joint(i).unit(0),
                ));
            }
            if q[i] < lower || (v[i] < 0.0 && reach < lower) {
                return Err(excess(
                    FaultKind::DemandOutOfRange,
                    reach.min(q[i]),
                    limits.lower[i],
                    R::joint(i).unit(0),
                ));
            }
            let limit = limits.acceleration[i];
            if a[i].abs() > slack(limit, 4.0 * round_off * per_second * per_second) {
                return Err(excess(FaultKind::DemandedAcceleration, a[i].abs(), limit, R::joint(i).unit(2)));
            }
            if let Some(limit) = jerk_limit {
                let jerk = (a[i] - self.acceleration[i]) * per_second;
                if jerk.abs() > slack(limit, 8.0 * round_off * per_second * per_second * per_second) {
                    return Err(excess(FaultKind::DemandedJerk, jerk.abs(), limit, R::joint(i).unit(3)));
                }
            }
        }
        Ok(())
    }

    /// Keeps the largest acceleration of the path itself, without the part that the rate's change adds.
    fn note_path(&mut self, v: &R::Joints, a: &R::Joints, rate: f64, per_second: f64) {
        if rate > 1e-3 {
            let rate_change = if self.is_at_rest() { 0.0 } else { (rate - self.rate) * per_second };
            let per_rate_squared = (rate * rate).recip();
            for i in 0..R::Joints::LEN {
                let path = (a[i] - v[i] / rate * rate_change) * per_rate_squared;
                self.path_peak[i] = self.path_peak[i].max(path.abs());
            }
        }
        self.rate = rate;
    }

    /// How fast the rate may change now: what the acceleration limits leave beside the path's own peak.
    ///
    /// A path that uses a limit to the full leaves nothing; a floor of [`RATE_RESERVE`] keeps every motion
    /// stoppable, and is why a generator should plan with nine tenths of the limits.
    pub fn headroom(&self) -> RateHeadroom {
        let limits = self.robot.limits();
        let mut change = f64::INFINITY;
        for i in 0..R::Joints::LEN {
            let along = self.velocity[i].abs() / self.rate.max(1e-3);
            if along > 1e-9 {
                let limit = limits.acceleration[i];
                let left =
                    (0.98 * limit - self.path_peak[i] * self.rate * self.rate).max(RATE_RESERVE * limit);
                change = change.min(left / along);
            }
        }
        RateHeadroom { rise: change, fall: change }
    }
}

/// The share of an acceleration limit that a change of the rate may always use.
pub(crate) const RATE_RESERVE: f64 = 0.08;

/// A pose whose numbers are finite and whose quaternion is a rotation, normalised.
fn valid_frame(pose: &Pose) -> Result<Pose, Fault> {
    let q = pose.rotation.coords;
    if !(pose.translation.vector.iter().chain(q.iter()).all(|x| x.is_finite())) {
        return Err(Fault::new(FaultKind::DemandNotFinite));
    }
    let norm = q.norm();
    if (norm - 1.0).abs() > FRAME_TOLERANCE {
        return Err(Fault::new(FaultKind::DemandInvalidFrame).exceeds(
            (norm - 1.0).abs(),
            FRAME_TOLERANCE,
            "",
        ));
    }
    Ok(Pose::from_parts(pose.translation, UnitQuaternion::new_normalize(pose.rotation.into_inner())))
}
