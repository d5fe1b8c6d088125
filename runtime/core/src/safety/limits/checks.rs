//! Limits that a state must keep, and where the robot would stand if its demands were lost there.
//!
//! In: a state for the end of a step. Out: the first limit that it breaks, by joint and value.

use crate::model::fault::{Fault, FaultKind};
use crate::model::joints::JointVector;
use crate::model::robot::{CoupledLimit, Limits, POSITION_ROUND_OFF, Robot};
use crate::safety::braking::{Release, stopping_distance};
use crate::safety::rate::larger;

use super::RELATIVE;
use super::state::JointState;

/// Where a robot would stand if its demands were lost now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standstill<J> {
    pub position: J,
    /// A time for the displacement in which no joint is faster than at its beginning \[s\].
    pub time: f64,
}

/// A state that is to be checked, for the end of a step.
#[derive(Clone, Copy)]
pub(super) struct Proposed<'a, J> {
    pub position: &'a J,
    pub velocity: &'a J,
    /// The velocity that is held when the next demands are lost.
    pub held: &'a J,
    pub acceleration: &'a J,
}

/// The step that is to be checked.
#[derive(Clone, Copy)]
pub(super) struct CheckedStep<'a, J> {
    /// The state at its beginning.
    pub from: &'a JointState<J>,
    /// Its length \[s\].
    pub duration: f64,
    /// Whether its demand is the first one of a motion that begins at a standstill.
    pub starting: bool,
}

/// A robot, whose limits are checked.
pub(super) struct Checks<R> {
    pub robot: R,
    /// Time that passes between a lost peer and the start of braking \[s\].
    pub reaction: f64,
}

impl<R: Robot> Checks<R> {
    /// The velocity of a step to a position, within all limits. `held` is the velocity that is held when the demands after it
    /// are lost; `None`: the step's own.
    #[inline]
    pub fn velocity_to(
        &self,
        position: &R::Joints,
        held: Option<&R::Joints>,
        step: &CheckedStep<'_, R::Joints>,
    ) -> Result<R::Joints, Fault> {
        // The joints may be those of a robot's own `inverse`.
        if let Some(joint) = position.as_slice().iter().position(|q| !q.is_finite()) {
            return Err(Fault::new(FaultKind::DemandNotFinite).at_joint(joint));
        }
        let velocity = (*position - step.from.position) * step.duration.recip();
        let acceleration = step.from.acceleration_to(&velocity, step.duration);
        let held = held.unwrap_or(&velocity);
        let next = Proposed { position, velocity: &velocity, held, acceleration: &acceleration };
        let stop = self.check(&next, step)?;
        self.check_coupled(position, &stop, step)?;
        Ok(velocity)
    }

    /// Limits that joints share, on the displacement to a position and from there to the standstill.
    fn check_coupled(
        &self,
        position: &R::Joints,
        stop: &Standstill<R::Joints>,
        step: &CheckedStep<'_, R::Joints>,
    ) -> Result<(), Fault> {
        let coupled = |limit: CoupledLimit| {
            let fault = Fault::new(FaultKind::DemandOutOfRange).at_joint(limit.joint).text(limit.what);
            fault.exceeds_by(limit.excess)
        };
        let (from, motion) = (&step.from.position, (position, step.duration));
        let checked = if stop.time > 0.0 {
            self.robot.check_coupled_to_stop(from, motion, (&stop.position, stop.time))
        } else {
            self.robot.check_coupled(from, motion.0, motion.1)
        };
        checked.map_err(coupled)
    }

    /// Whether the joints may go by this displacement [rad or m] in `duration` \[s\].
    pub fn check_displacement(&self, displacement: &R::Joints, duration: f64) -> Result<(), Fault> {
        for i in 0..R::Joints::LEN {
            let speed = displacement[i].abs() / duration;
            let limit = self.robot.limits().velocity[i];
            // A NaN is no small speed.
            let is_small = speed <= limit * (1.0 + RELATIVE) + POSITION_ROUND_OFF / duration;
            if !is_small {
                let fault = Fault::new(FaultKind::DemandedVelocity).at_joint(i).text("between two demands");
                return Err(fault.exceeds(speed, limit, self.robot.joint(i).unit(1)));
            }
        }
        Ok(())
    }

    /// Where a robot without a jerk limit would stand, in a state that keeps all limits with the larger of its velocities and
    /// without allowance for round-off: then no closer look is needed, as in nearly every step.
    #[inline]
    pub fn well_within(&self, next: &Proposed<'_, R::Joints>) -> Option<Standstill<R::Joints>> {
        let limits = self.robot.limits();
        if limits.jerk.is_some() {
            return None;
        }
        let fastest = R::Joints::from_joints(|i| larger(next.velocity[i].abs(), next.held[i].abs()));
        let longest =
            (0..R::Joints::LEN).fold(0.0, |time, i| larger(time, fastest[i] / limits.acceleration[i]));
        let time = 0.5 * longest + self.reaction;
        let mut stop = Standstill { position: *next.position, time: if longest > 0.0 { time } else { 0.0 } };
        let mut is_within = true;
        for i in 0..R::Joints::LEN {
            let q = next.position[i];
            let travel = fastest[i] * time;
            let faster =
                if next.held[i].abs() > next.velocity[i].abs() { next.held[i] } else { next.velocity[i] };
            stop.position[i] = q + faster * time;
            // All four are looked at, without a branch for each.
            is_within &= (fastest[i] <= limits.velocity[i])
                & (next.acceleration[i].abs() <= limits.acceleration[i])
                & (q - travel >= limits.lower[i])
                & (q + travel <= limits.upper[i]);
        }
        is_within.then_some(stop)
    }

    /// A state against the limits.
    #[inline]
    pub fn check(
        &self,
        next: &Proposed<'_, R::Joints>,
        step: &CheckedStep<'_, R::Joints>,
    ) -> Result<Standstill<R::Joints>, Fault> {
        match self.well_within(next) {
            Some(stop) => Ok(stop),
            None => self.look_closer(next, step),
        }
    }

    /// The same, limit by limit and with an allowance for round-off.
    #[inline(never)]
    pub fn look_closer(
        &self,
        next: &Proposed<'_, R::Joints>,
        step: &CheckedStep<'_, R::Joints>,
    ) -> Result<Standstill<R::Joints>, Fault> {
        let Proposed { position: q, velocity: v, held, acceleration: a } = *next;
        let duration = step.duration;
        let mut stop = Standstill { position: *q, time: 0.0 };
        let limits: &Limits<R::Joints> = self.robot.limits();
        let per_second = duration.recip();
        let slack = |limit: f64, round_off: f64| limit * (1.0 + RELATIVE) + round_off;
        // At the beginning of a motion that is how far its first demand is away.
        let first_of = |fault: Fault, i: usize| {
            if !step.starting {
                return fault;
            }
            let away = (q[i] - step.from.position[i]).abs();
            fault.text(&format!("its first demand is {away:.6} {} away", self.robot.joint(i).unit(0)))
        };
        // Without a jerk limit all joints brake in the time that the slowest to stop needs.
        let faster = |i: usize| v[i].abs().max(held[i].abs());
        let stop_time = (0..R::Joints::LEN).map(|i| faster(i) / limits.acceleration[i]).fold(0.0, f64::max);
        for i in 0..R::Joints::LEN {
            let round_off = POSITION_ROUND_OFF * q[i].abs().max(1.0);
            let excess = |kind, actual: f64, limit: f64, unit| {
                Fault::new(kind).at_joint(i).exceeds(actual, limit, unit)
            };
            let speed_limit = limits.velocity[i];
            if v[i].abs() > slack(speed_limit, round_off * per_second) {
                if step.starting {
                    // A first demand a whole jump away is not a fast motion but a wrong start.
                    let jump = v[i].abs() * duration;
                    let travel = speed_limit * duration;
                    let fault =
                        excess(FaultKind::StartPoseMismatch, jump, travel, self.robot.joint(i).unit(0));
                    return Err(
                        fault.text("the first demand jumps; begin at `e.demanded()`, as in `first = ..`")
                    );
                }
                return Err(excess(
                    FaultKind::DemandedVelocity,
                    v[i].abs(),
                    speed_limit,
                    self.robot.joint(i).unit(1),
                ));
            }
            let jerk_limit = limits.jerk.map(|jerk| jerk[i]);
            let limit = limits.acceleration[i];
            // Once its demands are lost: an acceleration fades, or the path's velocity is held.
            let release = jerk_limit.map(|jerk| Release::new(a[i], jerk, duration));
            let kept = release.map_or(held[i], |release| v[i] + release.gain);
            if release.is_some() && kept.abs() > slack(speed_limit, 4.0 * round_off * per_second) {
                let fault =
                    excess(FaultKind::DemandedVelocity, kept.abs(), speed_limit, self.robot.joint(i).unit(1));
                return Err(fault.text("by the time that its acceleration is taken away"));
            }
            // How far it goes up and down until it stands. The velocity may be the other way round once demands are lost, as
            // where a joint is just about to turn.
            let (up, down) = match (jerk_limit, release) {
                (Some(jerk), Some(release)) => {
                    let from = |v, a| stopping_distance(v, a, limit, jerk, duration);
                    let travel = |v: f64, kept: f64, a: f64| {
                        let at_once = if v > 0.0 { from(v, a) } else { 0.0 };
                        let later = if kept > 0.0 { from(kept, release.left.copysign(a)) } else { 0.0 };
                        // An acceleration in this direction may take longer to fade than a lost peer to be noticed.
                        let fading = if a > 0.0 { release.time } else { 0.0 };
                        at_once.max(later) + v.max(kept).max(0.0) * self.reaction.max(fading)
                    };
                    (travel(v[i], kept, a[i]), travel(-v[i], -kept, -a[i]))
                }
                _ => {
                    let time = 0.5 * stop_time + self.reaction;
                    (v[i].max(kept).max(0.0) * time, (-v[i]).max(-kept).max(0.0) * time)
                }
            };
            // One that a reset has found outside of its range may stay where it is, and come back.
            let lower = limits.lower[i].min(step.from.position[i]) - round_off;
            let upper = limits.upper[i].max(step.from.position[i]) + round_off;
            let faster = if kept.abs() > v[i].abs() { kept } else { v[i] };
            stop.position[i] = q[i] + if faster > 0.0 { up } else { -down };
            if faster != 0.0 {
                stop.time = stop.time.max(up.max(down) / faster.abs());
            }
            let highest = q[i] + up;
            let lowest = q[i] - down;
            let out_of_range =
                |reach, limit| excess(FaultKind::DemandOutOfRange, reach, limit, self.robot.joint(i).unit(0));
            if highest > upper {
                return Err(out_of_range(highest, limits.upper[i]));
            }
            if lowest < lower {
                return Err(out_of_range(lowest, limits.lower[i]));
            }
            if a[i].abs() > slack(limit, 4.0 * round_off * per_second * per_second) {
                let fault =
                    excess(FaultKind::DemandedAcceleration, a[i].abs(), limit, self.robot.joint(i).unit(2));
                return Err(first_of(fault, i));
            }
            if let Some(limit) = jerk_limit {
                let jerk = (a[i] - step.from.acceleration[i]) * per_second;
                if jerk.abs() > slack(limit, 8.0 * round_off * per_second * per_second * per_second) {
                    let fault =
                        excess(FaultKind::DemandedJerk, jerk.abs(), limit, self.robot.joint(i).unit(3));
                    return Err(first_of(fault, i));
                }
            }
        }
        Ok(stop)
    }
}
