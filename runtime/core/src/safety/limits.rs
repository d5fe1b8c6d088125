//! Demands become accepted demands here, through the limits, or are refused: never clamped.
//!
//! In: what a step function returned, decoded. Out: an [`AcceptedDemand`], the only thing that a drive is
//! given. Checked in this order: numbers finite, rotation valid, inverse kinematics, position (with the
//! distance that braking needs), velocity, acceleration, jerk, limits that joints share (here and where the robot would
//! stand if its demands were lost now).

use core::marker::PhantomData;

use crate::model::demand::{Coordinates, Demand};
use crate::model::fault::{Fault, FaultKind};
use crate::model::joints::JointVector;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::safety::braking::Braking;

use catching_up::CatchingUp;
use poses::valid_frame;
pub(crate) use poses::{DISAGREEMENT, NOT_ATTAINABLE, NOT_FOUND, NOT_REDUNDANT};
use rejoining::Rejoining;

mod catching_up;
mod checks;
mod poses;
mod rates;
mod rejoining;
mod ways;

/// Relative excess over a limit that is round-off.
const RELATIVE: f64 = 1e-9;
/// Round-off of a difference of positions of order 1 [rad or m].
const ROUND_OFF: f64 = 1e-12;

/// Joint positions that a drive may be given: the limits have been checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AcceptedDemand<R: Robot> {
    joints: R::Joints,
    // Nothing outside this module can make one.
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

/// The path as its demands tell it.
#[derive(Clone, Copy, Debug)]
struct Path<J> {
    /// Demanded last.
    position: J,
    /// The mean velocity up to there, and of which time it is the mean \[s\].
    velocity: J,
    span: f64,
    /// For how long demands have been missing since \[s\], and whether that was bridged on a screw.
    missing: f64,
    on_screw: bool,
    /// Where the path went meanwhile, as a demand says that came too late to be followed.
    late: Option<J>,
}

impl<J> Path<J> {
    const fn after(position: J, velocity: J, span: f64) -> Self {
        Path { position, velocity, span, missing: 0.0, on_screw: false, late: None }
    }
}

/// A state for the end of a step.
struct Next<J> {
    position: J,
    velocity: J,
    path: Path<J>,
    off_path: Option<OffPath<J>>,
}

/// What is known of the path while a robot is not on it: late demands leave it so.
#[derive(Clone, Copy, Debug)]
enum OffPath<J> {
    /// It comes back by its joints.
    Joints(CatchingUp<J>),
    /// It comes back with all robots that it moves together with.
    Together(Rejoining),
}

/// The state demanded last and the checks on the way to the next one.
pub(crate) struct Acceptor<R: Robot> {
    robot: R,
    tool: Pose,
    position: R::Joints,
    velocity: R::Joints,
    acceleration: R::Joints,
    path: Path<R::Joints>,
    off_path: Option<OffPath<R::Joints>>,
    /// Joint positions at the start of the motion, and the flange's pose there once a displacement asks for it.
    origin: R::Joints,
    start: Option<Pose>,
    /// Whether the motion's first demand is still to be accepted.
    starting: bool,
    /// Rate and duration \[s\] of the step accepted last, and how many such steps before it had no demand of their own.
    rate: f64,
    period: f64,
    bridged: f64,
    /// The path's speed at rate 1, kept while the robot is suspended: it will be resumed into it.
    path_speed: R::Joints,
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
            path: Path::after(position, zeros, 0.0),
            off_path: None,
            origin: position,
            start: None,
            starting: false,
            rate: 1.0,
            period: 0.0,
            bridged: 0.0,
            path_speed: zeros,
            reaction,
        }
    }

    /// What the drives are told.
    pub const fn accepted(&self) -> (R::Joints, R::Joints) {
        (self.position, self.velocity)
    }

    /// The state demanded last: where the path is, for a robot that is still on its way back to it.
    pub fn demanded(&self) -> (R::Joints, R::Joints) {
        let velocity = match &self.off_path {
            Some(OffPath::Joints(path)) => path.velocity,
            Some(OffPath::Together(_)) => self.path.velocity,
            None => return (self.position, self.velocity),
        };
        (self.path.position + velocity * self.path.missing, velocity)
    }

    pub const fn is_on_path(&self) -> bool {
        self.off_path.is_none()
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

    /// Whether the path may simply stay at the state demanded last: a motion that ends at rest leaves the
    /// velocity of its last step, which one step takes away within the limits.
    pub fn can_hold(&self, duration: f64) -> bool {
        match self.end_of_path() {
            Some(end) => self.next(&end, duration, false).is_ok(),
            None => self.can_stand(duration),
        }
    }

    /// A stop ends the path where the robot is, if one step can take its velocity away; whether it does.
    pub fn stop_at_once(&mut self, duration: f64) -> bool {
        let can_stand = self.is_on_path() && self.can_stand(duration);
        if can_stand {
            self.path = Path::after(self.position, self.velocity, duration);
        }
        can_stand
    }

    fn can_stand(&self, duration: f64) -> bool {
        let zeros = R::Joints::zeros();
        let acceleration = (zeros - self.velocity) * duration.recip();
        self.check(&self.position, &zeros, &zeros, &acceleration, duration).is_ok()
    }

    /// Where a path ends that goes no farther, for a robot that is elsewhere: at its last demand, late or not.
    fn end_of_path(&self) -> Option<R::Joints> {
        let comes_back = !self.is_on_path() || self.path.missing > 0.0 && self.robot.limits().jerk.is_none();
        comes_back.then(|| self.path.late.unwrap_or(self.path.position))
    }

    /// Whether the robot is where its path ends, if that goes no farther.
    pub fn is_at_its_end(&self) -> bool {
        self.end_of_path().is_none()
    }

    /// A new motion begins: displacements count from here.
    pub fn begin(&mut self) {
        (self.origin, self.start, self.starting) = (self.demanded().0, None, true);
        self.path.late = None;
        if self.is_at_rest() {
            self.path_speed = R::Joints::zeros();
        }
    }

    /// Stay: the state demanded last is demanded again. The path's speed is kept: a robot whose ECP transmits orders is
    /// held so in a suspension. One that is off its path comes back to it, and to where it ends: the last demand of a motion
    /// may have been late.
    ///
    /// # Errors
    /// The limit that the way back would break; nothing is changed then.
    pub fn hold(&mut self, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        if let Some(end) = self.end_of_path() {
            let next = self.next(&end, duration, false)?;
            return Ok(self.take(next, duration));
        }
        let zeros = R::Joints::zeros();
        self.acceleration = (zeros - self.velocity) * duration.recip();
        self.velocity = zeros;
        self.path = Path::after(self.position, zeros, duration);
        Ok(AcceptedDemand::new(self.position))
    }

    /// A demand was lost: the path's velocity is held, an acceleration fades as fast as the jerk limit allows.
    pub fn extrapolate(&mut self, duration: f64) -> AcceptedDemand<R> {
        self.acceleration = match self.robot.limits().jerk {
            Some(jerk) => R::Joints::from_joints(|i| {
                let a = self.acceleration[i];
                a - a.signum() * a.abs().min(jerk[i] * duration)
            }),
            // On its way back to the path, a robot is not as fast as that.
            None if !self.is_on_path() && self.position != self.path.position => R::Joints::zeros(),
            // The robot's own velocity, after earlier losses, is that of catching up: held, it would swing to
            // and fro. Back to the path's takes (n - 1) / n of the acceleration that catching up took in n steps.
            None => {
                let (limit, wanted) = (&self.robot.limits().acceleration, self.path.velocity - self.velocity);
                R::Joints::from_joints(|i| (wanted[i] / duration).clamp(-limit[i], limit[i]))
            }
        };
        self.path.missing += duration;
        self.velocity = self.velocity + self.acceleration * duration;
        self.position = self.position + self.velocity * duration;
        self.period = duration;
        AcceptedDemand::new(self.position)
    }

    /// The way to a standstill from here.
    pub fn braking(&self) -> Braking<R::Joints> {
        let limits = self.robot.limits();
        // The velocity is the mean of the last step; where jerk counts, so does what it has become since.
        let since = if limits.jerk.is_some() { 0.5 * self.period } else { 0.0 };
        Braking::new(self.position, self.velocity + self.acceleration * since, self.acceleration, limits)
    }

    /// The next state on that way.
    pub fn brake(&mut self, braking: &mut Braking<R::Joints>, duration: f64) -> AcceptedDemand<R> {
        let (position, velocity) = braking.advance(duration);
        self.acceleration = (velocity - self.velocity) * duration.recip();
        (self.position, self.velocity) = (position, velocity);
        (self.path, self.off_path) = (Path::after(position, velocity, duration), None);
        AcceptedDemand::new(position)
    }

    /// Checks a demand for the end of a step of `duration` \[s\], of which `dt` \[s\] is path time.
    ///
    /// # Errors
    /// The first limit that it breaks; nothing is changed then.
    pub fn accept(&mut self, demand: &Demand<R>, dt: f64, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        self.accept_after(demand, dt, duration, false)
    }

    /// The same after steps in which all robots that this one moves together with had no demand, either.
    ///
    /// # Errors
    /// As of [`accept`](Acceptor::accept).
    pub fn rejoin(&mut self, demand: &Demand<R>, dt: f64, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        self.accept_after(demand, dt, duration, true)
    }

    fn accept_after(
        &mut self,
        demand: &Demand<R>,
        dt: f64,
        duration: f64,
        all_missed: bool,
    ) -> Result<AcceptedDemand<R>, Fault> {
        let (tool, position) = self.target(demand)?;
        let next = self.next(&position, duration, all_missed).map_err(|fault| {
            let disagreement = self.disagreement(demand, &position, &tool);
            disagreement.unwrap_or_else(|| self.beside_singularity(demand, fault))
        })?;
        (self.rate, self.period, self.starting) = (dt / duration, duration, false);
        self.bridged = self.path.missing / duration;
        self.tool = tool;
        let accepted = self.take(next, duration);
        // Near rate 0 the quotient is round-off.
        if self.rate > 1e-3 {
            let (_, velocity) = self.demanded();
            self.path_speed = R::Joints::from_joints(|i| velocity[i].abs() / self.rate);
        }
        Ok(accepted)
    }

    /// The tool of a demand, and the joint positions that it asks for.
    fn target(&mut self, demand: &Demand<R>) -> Result<(Pose, R::Joints), Fault> {
        let tool = match &demand.tool {
            Some(tool) => valid_frame(tool)?,
            None => self.tool,
        };
        let redundancy = demand.redundancy;
        let position = match &demand.coordinates {
            Coordinates::Hold | Coordinates::Joints(_) if redundancy.is_some() => {
                let text = "a redundancy is chosen for a pose or a displacement, not for joint positions";
                return Err(Fault::thrown(text));
            }
            Coordinates::Hold => self.path.late.unwrap_or_else(|| self.demanded().0),
            Coordinates::Joints(joints) => *joints,
            Coordinates::Pose(pose) => self.joints_at(&valid_frame(pose)?, &tool, redundancy)?,
            Coordinates::Displacement(displacement) => {
                let displacement = valid_frame(displacement)?;
                let start = *self.start.get_or_insert_with(|| self.robot.forward(&self.origin));
                self.joints_at(&(start * tool * displacement), &tool, redundancy)?
            }
        };
        match position.as_slice().iter().position(|q| !q.is_finite()) {
            Some(joint) => Err(Fault::new(FaultKind::DemandNotFinite).at_joint(joint)),
            None => Ok((tool, position)),
        }
    }

    /// A state that has been checked is the present one.
    fn take(&mut self, next: Next<R::Joints>, duration: f64) -> AcceptedDemand<R> {
        self.acceleration = (next.velocity - self.velocity) * duration.recip();
        (self.position, self.velocity) = (next.position, next.velocity);
        (self.path, self.off_path) = (next.path, next.off_path);
        AcceptedDemand::new(next.position)
    }

    /// A demand was lost: the flange is displaced by `D` in the world, where that keeps all limits.
    ///
    /// # Errors
    /// The first limit that it breaks; nothing is changed then.
    #[allow(non_snake_case)]
    pub fn go_on(&mut self, D: &Pose, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        let (position, velocity) = self.displaced(D, duration)?;
        self.acceleration = (velocity - self.velocity) * duration.recip();
        (self.path.missing, self.path.on_screw) = (self.path.missing + duration, true);
        (self.position, self.velocity, self.period) = (position, velocity, duration);
        Ok(AcceptedDemand::new(position))
    }

    /// The same on the way to a standstill: no demand is to come.
    ///
    /// # Errors
    /// As of [`go_on`](Acceptor::go_on).
    #[allow(non_snake_case)]
    pub fn slow_down(&mut self, D: &Pose, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        let accepted = self.go_on(D, duration)?;
        (self.path, self.off_path) = (Path::after(self.position, self.velocity, duration), None);
        Ok(accepted)
    }

    /// The first demand of a motion, after so many steps in which the robot stood, and those that it moves together with:
    /// its path has begun.
    ///
    /// # Errors
    /// As of [`accept`](Acceptor::accept).
    pub fn begin_late(
        &mut self,
        demand: &Demand<R>,
        duration: f64,
        missed: f64,
        together: bool,
    ) -> Result<(), Fault> {
        let (tool, position) = self.target(demand)?;
        self.next(&position, duration, false)?;
        (self.tool, self.starting) = (tool, false);
        self.path = Path {
            missing: missed * duration,
            on_screw: together,
            late: Some(position),
            ..Path::after(self.position, R::Joints::zeros(), duration)
        };
        Ok(())
    }

    /// Whether the robot stands, and so does its path.
    pub fn stands(&self) -> bool {
        let still = |velocity: &R::Joints| *velocity == R::Joints::zeros();
        self.is_on_path() && still(&self.velocity) && still(&self.path.velocity)
    }

    /// A demand was lost in a standstill: of robots that move together all stand then.
    pub fn stand_by(&mut self, duration: f64) -> AcceptedDemand<R> {
        (self.path.missing, self.path.on_screw) = (self.path.missing + duration, true);
        self.period = duration;
        AcceptedDemand::new(self.position)
    }

    /// A demand that came too late to be followed: its tool is in force from now on, and a path that goes no farther ends
    /// where it says. Robots with a jerk limit do not come back to their path.
    ///
    /// # Errors
    /// What is wrong with the demand itself; nothing is changed then.
    pub fn note_late(&mut self, demand: &Demand<R>) -> Result<(), Fault> {
        let (tool, position) = self.target(demand)?;
        self.tool = tool;
        if self.path.missing > 0.0 && self.robot.limits().jerk.is_none() {
            self.path.late = Some(position);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
