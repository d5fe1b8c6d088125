//! Demands become accepted demands here, through the limits, or are refused: never clamped.
//!
//! In: what a step function returned, decoded. Out: an [`AcceptedDemand`], the only thing that a drive is
//! given. Checked in this order: numbers finite, rotation valid, inverse kinematics, position (with the
//! distance that braking needs), velocity, acceleration, jerk, limits that joints share (here and where the robot would
//! stand if its demands were lost now).

use core::marker::PhantomData;

use nalgebra::{Translation3, UnitQuaternion};

use crate::braking::{Braking, stopping_distance};
use crate::demand::{Coordinates, Demand};
use crate::fault::{Fault, FaultKind};
use crate::joints::JointVector;
use crate::pose::Pose;
use crate::robot::{CoupledLimit, Limits, NoInverse, Robot};
use crate::together::{self, BrakingLaw, Screw};

use catching_up::{CatchingUp, Late};
use rejoining::Rejoining;

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

/// Where a robot would stand if its demands were lost now.
#[derive(Clone, Copy, Debug)]
struct Standstill<J> {
    position: J,
    /// A time for the way there in which no joint is faster than at its beginning \[s\].
    time: f64,
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
}

impl<J> Path<J> {
    const fn after(position: J, velocity: J, span: f64) -> Self {
        Path { position, velocity, span, missing: 0.0, on_screw: false }
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

/// How fast the rate may change without breaking a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateHeadroom {
    /// Largest rise \[1/s\].
    pub rise: f64,
    /// Largest fall \[1/s\].
    pub fall: f64,
    /// Largest change of rise and fall \[1/s²\]; infinite where jerk has no limit.
    pub bend: f64,
}

impl RateHeadroom {
    /// Of what does not move.
    pub const UNLIMITED: RateHeadroom =
        RateHeadroom { rise: f64::INFINITY, fall: f64::INFINITY, bend: f64::INFINITY };

    /// What two robots both have.
    #[must_use]
    pub fn and(self, other: RateHeadroom) -> RateHeadroom {
        RateHeadroom {
            rise: self.rise.min(other.rise),
            fall: self.fall.min(other.fall),
            bend: self.bend.min(other.bend),
        }
    }
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
        if !self.is_on_path() {
            return self.next(&self.path.position, duration, false).is_ok();
        }
        let zeros = R::Joints::zeros();
        let acceleration = (zeros - self.velocity) * duration.recip();
        self.check(&self.position, &zeros, &zeros, &acceleration, duration).is_ok()
    }

    /// A new motion begins: displacements count from here.
    pub fn begin(&mut self) {
        (self.origin, self.start, self.starting) = (self.demanded().0, None, true);
        if self.is_at_rest() {
            self.path_speed = R::Joints::zeros();
        }
    }

    /// Stay: the state demanded last is demanded again. The path's speed is kept: a robot whose ECP transmits orders is
    /// held so in a suspension. One that is off its path comes back to it.
    ///
    /// # Errors
    /// The limit that the way back would break; nothing is changed then.
    pub fn hold(&mut self, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        if !self.is_on_path() {
            let next = self.next(&self.path.position, duration, false)?;
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
            None if !self.is_on_path() => R::Joints::zeros(),
            // The robot's own velocity, after earlier losses, is that of catching up: held, it would swing to
            // and fro. Back to the path's takes (n - 1) / n of the acceleration that catching up took in n steps.
            None => (self.path.velocity - self.velocity) * duration.recip(),
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
            Coordinates::Hold => self.demanded().0,
            Coordinates::Joints(joints) => *joints,
            Coordinates::Pose(pose) => self.joints_at(&valid_frame(pose)?, &tool, redundancy)?,
            Coordinates::Displacement(displacement) => {
                let displacement = valid_frame(displacement)?;
                let start = *self.start.get_or_insert_with(|| self.robot.forward(&self.origin));
                self.joints_at(&(start * tool * displacement), &tool, redundancy)?
            }
        };
        if let Some(joint) = position.as_slice().iter().position(|q| !q.is_finite()) {
            return Err(Fault::new(FaultKind::DemandNotFinite).at_joint(joint));
        }
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

    /// The state at the end of a step in which the path goes to `demand`: there, or, where demands were late and the limits
    /// do not allow that, on the way back to the path.
    fn next(
        &self,
        demand: &R::Joints,
        duration: f64,
        all_missed: bool,
    ) -> Result<Next<R::Joints>, Fault> {
        let missed = (self.path.missing / duration).round();
        let way = match &self.off_path {
            Some(OffPath::Together(way)) if missed == 0.0 || self.path.on_screw => Some(way),
            Some(_) | None => None,
        };
        let rejoin = || {
            let over = Screw::between(&self.robot.forward(&self.path.position), &self.robot.forward(demand));
            let way = Rejoining::after(way, self.path_screw(duration), over, missed);
            self.beside(demand, way, duration)
        };
        if all_missed && self.path.on_screw {
            return rejoin();
        }
        let there = match way.and_then(|way| way.advanced(missed + 1.0)) {
            Some(way) => self.beside(demand, way, duration),
            None => self.there(demand, duration),
        };
        match there {
            Ok(next) if self.is_on_path() || way.is_some() => Ok(next),
            // Whether the others missed a demand, too, is not known: at worst this one is beside them for a while.
            Err(_) if self.path.on_screw => rejoin(),
            Err(fault) if way.is_some() => Err(fault),
            there if self.robot.limits().jerk.is_none() && (!self.is_on_path() || self.path.missing > 0.0) => {
                self.back(demand, duration)?.map_or(there, Ok)
            }
            there => there,
        }
    }

    /// The state beside a demand, where all robots that this one moves together with are beside theirs.
    #[allow(non_snake_case)]
    fn beside(
        &self,
        demand: &R::Joints,
        rejoining: Rejoining,
        duration: f64,
    ) -> Result<Next<R::Joints>, Fault> {
        let X_WF = rejoining.displacement() * self.robot.forward(demand);
        let position = self.flange_joints(&X_WF, demand)?;
        let velocity = (position - self.position) * duration.recip();
        let off_path = Some(OffPath::Together(rejoining));
        let next = Next { position, velocity, path: self.path_to(demand, duration), off_path };
        self.check_next(&next, &velocity, duration)?;
        Ok(next)
    }

    /// The state at a demand.
    fn there(&self, demand: &R::Joints, duration: f64) -> Result<Next<R::Joints>, Fault> {
        let velocity = (*demand - self.position) * duration.recip();
        let path = self.path_to(demand, duration);
        let next = Next { position: *demand, velocity, path, off_path: None };
        self.check_next(&next, &path.velocity, duration)?;
        Ok(next)
    }

    /// A state on the way back to the path; none where that is too far.
    fn back(&self, demand: &R::Joints, duration: f64) -> Result<Option<Next<R::Joints>>, Fault> {
        let path = self.path_to(demand, duration);
        // Both velocities are those of the middles of their times.
        let acceleration = (path.velocity - self.path.velocity) * (0.5 * (path.span + self.path.span)).recip();
        self.check(demand, &path.velocity, &path.velocity, &acceleration, duration)?;
        let late = Late {
            position: &self.position,
            velocity: &self.velocity,
            demand,
            before: &self.path.position,
            path_velocity: &path.velocity,
            path_acceleration: &acceleration,
            time: path.span,
            duration,
        };
        let known = match &self.off_path {
            Some(OffPath::Joints(known)) => Some(known),
            Some(OffPath::Together(_)) | None => None,
        };
        let Some((position, off_path)) = CatchingUp::next(known, &late, self.robot.limits()) else {
            return Ok(None);
        };
        let off_path = off_path.map(OffPath::Joints);
        let velocity = (position - self.position) * duration.recip();
        let next = Next { position, velocity, path, off_path };
        self.check_next(&next, &velocity, duration)?;
        Ok(Some(next))
    }

    /// The path once it has come to `demand`.
    fn path_to(&self, demand: &R::Joints, duration: f64) -> Path<R::Joints> {
        let span = self.path.missing + duration;
        Path::after(*demand, (*demand - self.path.position) * span.recip(), span)
    }

    /// The limits of a state; `held` is the velocity that is held when the demands after it are lost.
    fn check_next(&self, next: &Next<R::Joints>, held: &R::Joints, duration: f64) -> Result<(), Fault> {
        let acceleration = (next.velocity - self.velocity) * duration.recip();
        let stop = self.check(&next.position, &next.velocity, held, &acceleration, duration)?;
        self.check_coupled(&next.position, &stop, duration)
    }

    /// A state that has been checked is the present one.
    fn take(&mut self, next: Next<R::Joints>, duration: f64) -> AcceptedDemand<R> {
        self.acceleration = (next.velocity - self.velocity) * duration.recip();
        (self.position, self.velocity) = (next.position, next.velocity);
        (self.path, self.off_path) = (next.path, next.off_path);
        AcceptedDemand::new(next.position)
    }

    /// Limits that joints share, on the way to a position and from there to the standstill.
    fn check_coupled(
        &self,
        position: &R::Joints,
        stop: &Standstill<R::Joints>,
        duration: f64,
    ) -> Result<(), Fault> {
        let coupled = |limit: CoupledLimit| {
            let fault = Fault::new(FaultKind::DemandOutOfRange).at_joint(limit.joint).text(limit.what);
            fault.exceeds(limit.actual, limit.limit, limit.unit)
        };
        self.robot.check_coupled(&self.position, position, duration).map_err(coupled)?;
        if stop.time > 0.0 {
            self.robot.check_coupled(position, &stop.position, stop.time).map_err(coupled)?;
        }
        Ok(())
    }

    /// The displacement of the last step in the world: the path's, and that of the way back to it.
    pub fn screw(&self, duration: f64) -> Screw {
        match &self.off_path {
            Some(OffPath::Together(way)) => self.path_screw(duration) + way.change(),
            Some(OffPath::Joints(_)) | None => self.path_screw(duration),
        }
    }

    /// The displacement of the path's last step in the world, as its mean velocity makes it.
    fn path_screw(&self, duration: f64) -> Screw {
        let before = self.path.position - self.path.velocity * duration;
        let of_joints = || Screw::between(&self.robot.forward(&before), &self.robot.forward(&self.path.position));
        match &self.off_path {
            Some(OffPath::Together(way)) => way.path_screw().unwrap_or_else(of_joints),
            Some(OffPath::Joints(_)) | None => of_joints(),
        }
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

    /// The joints, and their velocity, that displace the flange by `D` in the world.
    #[allow(non_snake_case)]
    fn displaced(&self, D: &Pose, duration: f64) -> Result<(R::Joints, R::Joints), Fault> {
        let X_WF = D * self.robot.forward(&self.position);
        let position = self.flange_joints(&X_WF, &self.position)?;
        if let Some(joint) = position.as_slice().iter().position(|q| !q.is_finite()) {
            return Err(Fault::new(FaultKind::DemandNotFinite).at_joint(joint));
        }
        let velocity = (position - self.position) * duration.recip();
        let acceleration = (velocity - self.velocity) * duration.recip();
        let stop = self.check(&position, &velocity, &velocity, &acceleration, duration)?;
        self.check_coupled(&position, &stop, duration)?;
        Ok((position, velocity))
    }

    /// How fast the robot may slow down on its screw from here: within [`together::SHARE`] of the acceleration limits, and
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
            let bend = limits.jerk.map_or(f64::INFINITY, |jerk| 0.5 * together::SHARE * jerk[i] / faster);
            law = law.and(BrakingLaw { fall: together::SHARE * a / faster, bend });
            longest = longest.max(limits.velocity[i] / a);
        }
        BrakingLaw { fall: law.fall.max(longest.recip()), ..law }
    }

    /// Names the singularity beside which a demanded pose asks too much of the joints.
    fn beside_singularity(&self, demand: &Demand<R>, fault: Fault) -> Fault {
        match (&demand.coordinates, self.robot.near_singularity(&self.position)) {
            (Coordinates::Pose(_) | Coordinates::Displacement(_), Some(name))
                if fault.message().is_empty() =>
            {
                fault.text(name)
            }
            (Coordinates::Pose(_) | Coordinates::Displacement(_), Some(name)) => {
                let text = format!("{}, {name}", fault.message());
                fault.text(&text)
            }
            (Coordinates::Hold | Coordinates::Joints(_), _) | (_, None) => fault,
        }
    }

    /// Whether a pose that breaks a limit does so because the robot's `inverse` is none of its `forward`.
    fn disagreement(&self, demand: &Demand<R>, q: &R::Joints, tool: &Pose) -> Option<Fault> {
        let Coordinates::Pose(pose) = &demand.coordinates else { return None };
        let off = (self.robot.forward(q) * tool).translation.vector - pose.translation.vector;
        (off.norm() > AGREEMENT).then(|| {
            Fault::new(FaultKind::NoInverseKinematics).text(DISAGREEMENT).exceeds(off.norm(), AGREEMENT, "m")
        })
    }

    fn joints_at(&self, pose: &Pose, tool: &Pose, redundancy: Option<f64>) -> Result<R::Joints, Fault> {
        let flange = pose * tool.inverse();
        // Beside the path: a redundant robot that is off it must not bend the path that it comes back to.
        let (near, _) = self.demanded();
        let joints = match redundancy {
            None => self.robot.inverse(&flange, &near),
            Some(value) if value.is_finite() => self.robot.inverse_at(&flange, value, &near),
            Some(_) => return Err(Fault::new(FaultKind::DemandNotFinite).text("the redundancy")),
        };
        joints.map_err(|error| no_inverse(&error, pose, "tool"))
    }

    /// The tool of a demand that came too late to be followed is in force from now on.
    pub fn choose_tool(&mut self, demand: &Demand<R>) -> Result<(), Fault> {
        if let Some(tool) = &demand.tool {
            self.tool = valid_frame(tool)?;
        }
        Ok(())
    }

    /// The joints that put the flange at `pose`, for a servo period between two demands.
    pub fn flange_joints(&self, pose: &Pose, near: &R::Joints) -> Result<R::Joints, Fault> {
        self.robot.inverse(pose, near).map_err(|error| no_inverse(&error, pose, "flange"))
    }

    /// Whether the joints may go this way [rad or m] in `duration` \[s\].
    pub fn check_way(&self, way: &R::Joints, duration: f64) -> Result<(), Fault> {
        for i in 0..R::Joints::LEN {
            let (speed, limit) = (way[i].abs() / duration, self.robot.limits().velocity[i]);
            // A NaN is no small speed.
            let is_small = speed <= limit * (1.0 + RELATIVE) + ROUND_OFF / duration;
            if !is_small {
                let fault = Fault::new(FaultKind::DemandedVelocity).at_joint(i).text("between two demands");
                return Err(fault.exceeds(speed, limit, self.robot.joint(i).unit(1)));
            }
        }
        Ok(())
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
        let mut stop = Standstill { position: *q, time: 0.0 };
        let limits: &Limits<R::Joints> = self.robot.limits();
        let per_second = duration.recip();
        let slack = |limit: f64, round_off: f64| limit * (1.0 + RELATIVE) + round_off;
        let starting = self.starting && self.is_at_rest();
        // Without a jerk limit all joints brake in the time that the slowest to stop needs.
        let faster = |i: usize| v[i].abs().max(held[i].abs());
        let stop_time = (0..R::Joints::LEN).map(|i| faster(i) / limits.acceleration[i]).fold(0.0, f64::max);
        for i in 0..R::Joints::LEN {
            let round_off = ROUND_OFF * q[i].abs().max(1.0);
            let excess = |kind, actual: f64, limit: f64, unit| {
                Fault::new(kind).at_joint(i).exceeds(actual, limit, unit)
            };
            let speed_limit = limits.velocity[i];
            if v[i].abs() > slack(speed_limit, round_off * per_second) {
                if starting {
                    // A first demand a whole jump away is not a fast motion but a wrong start.
                    let (jump, way) = (v[i].abs() * duration, speed_limit * duration);
                    let fault = excess(FaultKind::StartPoseMismatch, jump, way, self.robot.joint(i).unit(0));
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
            // The velocity once its demands have been lost: an acceleration fades, or the path's is held. It may be the
            // other way round than the velocity now, as where a joint is just about to turn.
            let kept = jerk_limit.map_or(held[i], |jerk| v[i] + a[i] * a[i].abs() / (2.0 * jerk));
            let lost = v[i].abs().max(kept.abs());
            let braking = match jerk_limit {
                Some(jerk) => {
                    let from = |v, a| stopping_distance(v, a, limit, jerk, duration);
                    from(v[i], a[i]).max(from(kept, 0.0))
                }
                None => 0.5 * lost * stop_time,
            };
            let distance = braking + lost * self.reaction;
            let (lower, upper) = (limits.lower[i] - round_off, limits.upper[i] + round_off);
            stop.position[i] = q[i] + distance.copysign(if kept.abs() > v[i].abs() { kept } else { v[i] });
            if lost > 0.0 {
                stop.time = stop.time.max(distance / lost);
            }
            let highest = if v[i].max(kept) > 0.0 { q[i] + distance } else { q[i] };
            let lowest = if v[i].min(kept) < 0.0 { q[i] - distance } else { q[i] };
            let out_of_range =
                |reach, limit| excess(FaultKind::DemandOutOfRange, reach, limit, self.robot.joint(i).unit(0));
            if highest > upper {
                return Err(out_of_range(highest, limits.upper[i]));
            }
            if lowest < lower {
                return Err(out_of_range(lowest, limits.lower[i]));
            }
            if a[i].abs() > slack(limit, 4.0 * round_off * per_second * per_second) {
                return Err(excess(
                    FaultKind::DemandedAcceleration,
                    a[i].abs(),
                    limit,
                    self.robot.joint(i).unit(2),
                ));
            }
            if let Some(limit) = jerk_limit {
                let jerk = (a[i] - self.acceleration[i]) * per_second;
                if jerk.abs() > slack(limit, 8.0 * round_off * per_second * per_second * per_second) {
                    return Err(excess(
                        FaultKind::DemandedJerk,
                        jerk.abs(),
                        limit,
                        self.robot.joint(i).unit(3),
                    ));
                }
            }
        }
        Ok(stop)
    }

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
        let raised = (self.rate + crate::feed::DEFAULT_CHANGE * self.period).min(1.0);
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
}

/// The fault that a pose without joint positions is; `frame` is what was to go there.
fn no_inverse(error: &NoInverse, pose: &Pose, frame: &str) -> Fault {
    let fault = Fault::new(FaultKind::NoInverseKinematics);
    let Translation3 { vector: p } = pose.translation;
    let at = format!("{frame} demanded at ({:.4}, {:.4}, {:.4}) m", p.x, p.y, p.z);
    match *error {
        NoInverse::OutOfReach { distance, min, max } => {
            let limit = if distance > max { max } else { min };
            let text = format!("out of reach, {at}: wrist to shoulder");
            fault.text(&text).exceeds(distance, limit, "m")
        }
        NoInverse::Singular { name } => fault.text(&format!("at a singularity ({name}), {at}")),
        NoInverse::NotAttainable { what, actual, tolerance, unit } => {
            fault.text(&format!("{NOT_ATTAINABLE}, {at}: {what}")).exceeds(actual, tolerance, unit)
        }
        NoInverse::NotRedundant => fault.text(NOT_REDUNDANT),
        NoInverse::NotConverged { error, tolerance } => {
            fault.text(&format!("{NOT_FOUND}, {at}: off by {error:.1e}, at most {tolerance:.0e}"))
        }
    }
}

/// The share of an acceleration limit that a generator may plan with: what is left keeps every motion stoppable
/// on its path.
pub(crate) const PATH_SHARE: f64 = 0.9;

/// The share of an acceleration limit that a path and the change of its rate use together.
const USABLE_SHARE: f64 = 0.98;

/// How far from a demanded pose `forward` of its `inverse` may be \[m\].
const AGREEMENT: f64 = 1e-3;

/// What a robot is told of whose `inverse` and `forward` are not of one arm.
pub(crate) const DISAGREEMENT: &str = "`forward` of the joints that `inverse` gives is another pose";

/// How the message of [`NoInverse::NotAttainable`] begins.
pub(crate) const NOT_ATTAINABLE: &str = "not attainable";

/// The message of [`NoInverse::NotRedundant`].
pub(crate) const NOT_REDUNDANT: &str = "a redundancy is demanded of a robot that has none";

/// How the message of [`NoInverse::NotConverged`] begins.
pub(crate) const NOT_FOUND: &str = "no joints found from here";

/// A pose whose numbers are finite and whose quaternion is a rotation, normalised.
fn valid_frame(pose: &Pose) -> Result<Pose, Fault> {
    let q = pose.rotation.coords;
    if !(pose.translation.vector.iter().chain(q.iter()).all(|x| x.is_finite())) {
        return Err(Fault::new(FaultKind::DemandNotFinite));
    }
    let norm = q.norm();
    if (norm - 1.0).abs() > FRAME_TOLERANCE {
        let fault =
            Fault::new(FaultKind::DemandInvalidFrame).text("the norm of its quaternion differs from 1");
        return Err(fault.exceeds((norm - 1.0).abs(), FRAME_TOLERANCE, ""));
    }
    Ok(Pose::from_parts(pose.translation, UnitQuaternion::new_normalize(pose.rotation.into_inner())))
}

mod catching_up;
mod rejoining;

#[cfg(test)]
mod tests;
