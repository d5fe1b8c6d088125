//! Demands become accepted demands here, through the limits, or are refused: never clamped.
//!
//! In: what a step function returned, decoded. Out: an [`AcceptedDemand`], the only thing that a drive is
//! given. Checked in this order: numbers finite, rotation valid, inverse kinematics, position (with the
//! distance that braking needs), velocity, acceleration, jerk, limits that joints share (here and where the robot would
//! stand if its demands were lost now).
//!
//! An [`Acceptor`] is put together from the robot with its limits ([`checks`]), the state demanded last ([`state`]), the path
//! and the return to it ([`path`]), the motion that is under way ([`motion`]) and its pace ([`rates`]). What it does in a
//! step is here for a demand, in [`missing`] where there is none, in [`out_of_step`] for one of another step, in [`resting`] while it brakes to a standstill; [`next_state`] finds
//! the state at the end of a step for all of them.

use core::marker::PhantomData;

use crate::model::beside::Goal;
use crate::model::demand::{Coordinates, Demand};
use crate::model::fault::{Fault, FaultKind};
use crate::model::joints::JointVector;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::safety::braking::BrakingLaw;
use crate::safety::common_twist::Bridging;
use crate::safety::rate::RateMargin;

use checks::{CheckedStep, Checks, Proposed, Standstill};
use curvature::Curvature;
pub(crate) use goals::GOAL;
use motion::Motion;
use next_state::NextState;
use path::Track;
pub(crate) use poses::{DISAGREEMENT, NOT_ATTAINABLE, NOT_FOUND, NOT_REDUNDANT};
use poses::{ToolPose, valid_frame};
use rates::Pace;
use state::JointState;

mod catching_up;
mod checks;
mod curvature;
mod goals;
mod missing;
mod motion;
mod next_state;
mod out_of_step;
mod path;
mod poses;
pub(crate) mod rates;
mod rejoining;
mod resting;
mod state;
#[cfg(test)]
mod tests;

/// The largest velocity of a tool at reduced speed \[m/s\].
pub const REDUCED_SPEED: f64 = 0.25;

/// The message of a tool that is too fast for reduced speed.
pub(crate) const AT_REDUCED_SPEED: &str = "the tool at reduced speed";

/// Relative excess over a limit that is round-off.
const RELATIVE: f64 = 1e-9;

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

/// The state demanded last and the checks of the step to the next one.
pub(crate) struct Acceptor<R: Robot> {
    checks: Checks<R>,
    state: JointState<R::Joints>,
    track: Track<R::Joints>,
    motion: Motion<R::Joints>,
    pace: Pace<R::Joints>,
    curvature: Curvature<R::Joints>,
    /// Whether the tool may go at reduced speed only.
    slow: bool,
}

/// What an acceptor knew before it accepted a demand.
#[derive(Clone, Copy)]
pub(crate) struct Before<J> {
    state: JointState<J>,
    track: Track<J>,
    motion: Motion<J>,
    pace: Pace<J>,
}

impl<R: Robot> Acceptor<R> {
    /// At rest at `position`; `reaction` \[s\] passes between a lost peer and the start of braking.
    pub fn new(robot: R, tool: Pose, position: R::Joints, reaction: f64) -> Self {
        Acceptor {
            checks: Checks { robot, reaction },
            state: JointState::at_rest(position),
            track: Track::at(position, R::Joints::zeros(), 0.0),
            motion: Motion::none(tool, position),
            pace: Pace::at_rest(),
            curvature: Curvature::none(),
            slow: false,
        }
    }

    /// Lets the tool go at reduced speed only, or at any.
    pub const fn slow_tool(&mut self, slow: bool) {
        self.slow = slow;
    }

    /// The robot whose demands it accepts.
    pub const fn robot(&self) -> &R {
        &self.checks.robot
    }

    /// What the drives are told: positions and velocities.
    pub const fn accepted(&self) -> (R::Joints, R::Joints) {
        (self.state.position, self.state.velocity)
    }

    /// The state demanded last: where the path is, for a robot that is still on its return to it.
    pub fn demanded(&self) -> (R::Joints, R::Joints) {
        self.track.demanded(&self.state)
    }

    /// Whether the robot is where its path is.
    #[cfg(test)]
    pub const fn is_on_path(&self) -> bool {
        self.track.is_followed()
    }

    /// The tool in force, `X_FE`.
    pub const fn tool(&self) -> &Pose {
        &self.motion.tool
    }

    /// Pose of the tool, `X_WE`, for joint positions `q`.
    pub fn tool_pose(&self, q: &R::Joints) -> Pose {
        self.checks.robot.forward(q) * self.motion.tool
    }

    /// The joints that put the flange at `pose`, for a servo period between two demands.
    pub fn flange_joints(&self, pose: &Pose, near: &R::Joints) -> Result<R::Joints, Fault> {
        poses::flange_joints(&self.checks.robot, pose, near)
    }

    /// Whether the joints may be displaced by this [rad or m] in `duration` \[s\].
    ///
    /// # Errors
    /// The velocity limit that they would break.
    pub fn check_displacement(&self, displacement: &R::Joints, duration: f64) -> Result<(), Fault> {
        self.checks.check_displacement(displacement, duration)
    }

    /// How fast the rate may change now.
    pub fn rate_margin(&self) -> RateMargin {
        self.pace.rate_margin(self.checks.robot.limits())
    }

    /// How fast the robot may slow down on its twist from here, in steps of `period` \[s\].
    pub fn braking_law(&self, period: f64) -> BrakingLaw {
        rates::braking_law(&self.state, &self.curvature(), self.checks.robot.limits(), period)
    }

    /// How the robot goes on with those that it moves together with while demands are missing.
    pub fn bridging(&self, duration: f64) -> Bridging {
        self.track.bridging(&self.state, &self.checks.robot, duration)
    }

    /// How it would go on from what it knew before.
    pub fn bridging_before(&self, before: &Before<R::Joints>, duration: f64) -> Bridging {
        before.track.bridging(&before.state, &self.checks.robot, duration)
    }

    /// What it knows now.
    pub const fn before(&self) -> Before<R::Joints> {
        Before { state: self.state, track: self.track, motion: self.motion, pace: self.pace }
    }

    /// The same, in the place of what it knew earlier.
    pub fn keep(&self, before: &mut Before<R::Joints>) {
        before.state = self.state;
        before.track.path = self.track.path;
        match &self.track.off_path {
            None => before.track.off_path = None,
            Some(off_path) => before.track.off_path = Some(*off_path),
        }
        before.motion = self.motion;
        before.pace = self.pace;
    }

    /// Takes back the demand that was accepted since then: no drive has been told of it.
    pub fn take_back(&mut self, before: &Before<R::Joints>) {
        self.state = before.state;
        self.track = before.track;
        self.motion = before.motion;
        self.pace = before.pace;
    }

    /// A new motion begins: displacements count from here.
    pub fn begin(&mut self) {
        self.motion.begin(self.demanded().0);
        self.track.path.late = None;
        if self.state.is_at_rest() {
            self.pace.begin();
        }
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
        let tool = self.tool_of(demand)?;
        let position = self.position_of(demand, &tool)?;
        if let Some(goal) = demand.goal() {
            self.check_goal(&goal, demand, &tool)?;
        }
        let missing = self.track.path.missing;
        // In step with its path, as nearly always, a robot has nothing to come back to.
        let accepted = if self.track.is_in_step() {
            self.follow(&position, &tool, duration)
        } else {
            self.come_back(&position, &tool, duration, all_missed)
        };
        let accepted = match accepted {
            Ok(accepted) => accepted,
            Err(fault) => return Err(self.explained(fault, demand, &position, &tool)),
        };
        self.pace.accept(dt, duration, missing);
        self.motion.starting = false;
        if demand.tool.is_some() {
            self.motion.tool = tool;
        }
        self.pace.learn_path_speed(&self.demanded().1);
        Ok(accepted)
    }

    /// The fault of a demand that breaks a limit with the joints at `position` \[rad or m\], and why it does where that is known.
    #[cold]
    fn explained(&self, fault: Fault, demand: &Demand<R>, position: &R::Joints, tool: &Pose) -> Fault {
        let robot = &self.checks.robot;
        poses::disagreement(robot, demand, position, tool)
            .unwrap_or_else(|| poses::beside_singularity(robot, demand, &self.state.position, fault))
    }

    /// Where the robot moves at reduced speed, the velocity of its tool in the step to `position` \[rad or m\] in
    /// `duration` \[s\].
    ///
    /// # Errors
    /// The tool is faster.
    fn check_tool(&self, tool: &Pose, position: &R::Joints, duration: f64) -> Result<(), Fault> {
        if !self.slow {
            return Ok(());
        }
        let place = |joints: &R::Joints| (self.checks.robot.forward(joints) * tool).translation.vector;
        let speed = (place(position) - place(&self.state.position)).norm() / duration;
        let keeps = speed <= REDUCED_SPEED * (1.0 + RELATIVE);
        if keeps {
            return Ok(());
        }
        let fault = Fault::new(FaultKind::DemandedVelocity).text(AT_REDUCED_SPEED);
        Err(fault.exceeds(speed, REDUCED_SPEED, "m/s"))
    }

    /// Whether the robot can be where the motion leads that a demand belongs to.
    ///
    /// # Errors
    /// It certainly cannot.
    #[cold]
    fn check_goal(&mut self, goal: &Goal<R::Joints>, demand: &Demand<R>, tool: &Pose) -> Result<(), Fault> {
        let robot = &self.checks.robot;
        let start = self.motion.start(robot);
        let near = &self.track.path.position;
        goals::check(robot, goal, &goals::Setting { start, tool, redundancy: demand.redundancy, near })
    }

    /// The tool that a demand names, or the one in force, `X_FE`.
    #[inline]
    fn tool_of(&self, demand: &Demand<R>) -> Result<Pose, Fault> {
        demand.tool.as_ref().map_or(Ok(self.motion.tool), valid_frame)
    }

    /// The joint positions \[rad or m\] that a demand asks for with this tool, `X_FE`.
    fn position_of(&mut self, demand: &Demand<R>, tool: &Pose) -> Result<R::Joints, Fault> {
        let redundancy = demand.redundancy;
        let robot = &self.checks.robot;
        // Beside the path: a redundant robot that has been elsewhere must not bend the path that it comes back to.
        let near = &self.track.path.position;
        let position = match &demand.coordinates {
            Coordinates::Hold | Coordinates::Joints(_) if redundancy.is_some() => {
                let text = "a redundancy is chosen for a pose or a displacement, not for joint positions";
                return Err(Fault::thrown(text));
            }
            Coordinates::Hold => self.track.path.late.unwrap_or_else(|| self.demanded().0),
            Coordinates::Joints(joints) => *joints,
            Coordinates::Pose(pose) => {
                let pose = valid_frame(pose)?;
                poses::joints_at(robot, &ToolPose { pose: &pose, tool, redundancy }, near)?
            }
            Coordinates::Displacement(displacement) => {
                let displacement = valid_frame(displacement)?;
                let pose = self.motion.start(robot) * tool * displacement;
                poses::joints_at(robot, &ToolPose { pose: &pose, tool, redundancy }, near)?
            }
        };
        match position.as_slice().iter().position(|q| !q.is_finite()) {
            Some(joint) => Err(Fault::new(FaultKind::DemandNotFinite).at_joint(joint)),
            None => Ok(position),
        }
    }

    /// Goes to a demand, of a robot in step with its path.
    ///
    /// # Errors
    /// The first limit that it breaks; nothing is changed then.
    #[inline]
    fn follow(&mut self, demand: &R::Joints, tool: &Pose, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        let (of_path, span) = self.track.mean_to(demand, duration);
        let velocity = self.velocity_to(demand, Some(&of_path), duration)?;
        self.check_tool(tool, demand, duration)?;
        self.state.go_to(*demand, velocity, duration);
        self.track.follow(demand, &of_path, span);
        Ok(AcceptedDemand::new(*demand))
    }

    /// Comes nearer to the path that a demand belongs to, of a robot that is elsewhere or has missed demands.
    ///
    /// # Errors
    /// The first limit that it breaks; nothing is changed then.
    fn come_back(
        &mut self,
        demand: &R::Joints,
        tool: &Pose,
        duration: f64,
        all_missed: bool,
    ) -> Result<AcceptedDemand<R>, Fault> {
        let next = self.next(demand, duration, all_missed).map_err(|fault| {
            // Who reads it would look for a jump in the program's demands.
            if fault.message().is_empty() { fault.text("after late demands") } else { fault }
        })?;
        self.check_tool(tool, &next.position, duration)?;
        Ok(self.take(next, duration))
    }

    /// A state that has been checked is the present one.
    fn take(&mut self, next: NextState<R::Joints>, duration: f64) -> AcceptedDemand<R> {
        self.state.go_to(next.position, next.velocity, duration);
        self.track = next.track;
        AcceptedDemand::new(next.position)
    }

    /// Where a path ends that goes no farther, for a robot that is elsewhere.
    fn end_of_path(&self) -> Option<R::Joints> {
        self.track.end(self.checks.robot.limits())
    }

    /// The step of `duration` \[s\] that is to be checked.
    fn checked_step(&self, duration: f64) -> CheckedStep<'_, R::Joints> {
        let starting = self.motion.starting && self.state.is_at_rest();
        CheckedStep { from: &self.state, duration, starting }
    }

    /// The velocity of a step to a position, within all limits. `held` is the velocity that is held when the demands after it
    /// are lost; `None`: the step's own.
    #[inline]
    fn velocity_to(
        &self,
        position: &R::Joints,
        held: Option<&R::Joints>,
        duration: f64,
    ) -> Result<R::Joints, Fault> {
        self.checks.velocity_to(position, held, &self.checked_step(duration))
    }

    /// Position `q`, velocity `v` and acceleration `a` against the limits; `held` is the velocity that is held when
    /// the next demands are lost.
    fn check(
        &self,
        q: &R::Joints,
        v: &R::Joints,
        held: &R::Joints,
        a: &R::Joints,
        duration: f64,
    ) -> Result<Standstill<R::Joints>, Fault> {
        let next = Proposed { position: q, velocity: v, held, acceleration: a };
        self.checks.check(&next, &self.checked_step(duration))
    }
}
