//! What the drives of a robot are told in each servo period, and what their encoders read.
//!
//! In: accepted demands, one per step. Out: a joint position per servo period, interpolated in joints or in the task space;
//! faults of drives, and of joints that do not follow.

use core::time::Duration;

use crate::control::drive::Drive;
use crate::control::guarded::guarded;
use crate::control::interpolation::Interpolation;
use crate::control::task_space::TaskSpace;
use crate::link::Waiter;
use crate::model::demand::Coordinates;
use crate::model::driver::{Measured, Regulators};
use crate::model::fault::{Fault, FaultKind};
use crate::model::joints::JointVector;
use crate::model::pace::Pulse;
use crate::model::pose::Pose;
use crate::model::robot::{InterpolationSpace, Robot};
use crate::model::time::Nanos;
use crate::model::wrench::Wrench;
use crate::safety::limits::Acceptor;

/// Where a robot's drives are interpolated, and when.
pub(super) struct Timing {
    /// The step whose demand comes next.
    pub due: u64,
    /// Length of a step.
    pub period: Duration,
    /// The cell's delay between demands and drives; `None`: drives take each demand as it is.
    pub delay: Option<Duration>,
}

/// The drives of a robot.
pub(super) struct Servo<R: Robot> {
    pub drive: Drive<R>,
    /// What the encoders read at the end of the last servo period.
    pub measured: Measured<R::Joints>,
    /// What the servo periods make of the demands.
    pub interpolation: Interpolation<R::Joints>,
    pub task_space: TaskSpace<R::Joints>,
    pub space: InterpolationSpace,
    /// What the drives were told last.
    pub commanded: R::Joints,
    /// Largest difference between demanded and measured joint positions [rad or m].
    pub following_error: R::Joints,
    /// The regulators that are chosen when the next step begins.
    regulators: Option<Regulators>,
    /// Steps for which the demands have stood still.
    still: u64,
    /// The driver has panicked: what it still does is unknown.
    pub lost: bool,
    period: Duration,
    delay: Option<Duration>,
}

impl<R: Robot> Servo<R> {
    /// Drives that hold where they are.
    pub fn new(
        drive: Drive<R>,
        space: InterpolationSpace,
        following_error: R::Joints,
        timing: &Timing,
    ) -> Self {
        let (drive, measured) = drive.begin();
        let rest = drive.held().unwrap_or(measured.position);
        let interpolation = Interpolation::new(rest, timing.due, timing.period, timing.delay);
        Servo {
            drive,
            measured,
            still: interpolation.settling_steps(),
            interpolation,
            task_space: TaskSpace::new(),
            space,
            commanded: rest,
            following_error,
            regulators: None,
            lost: false,
            period: timing.period,
            delay: timing.delay,
        }
    }

    /// Where drives that have been opened or switched on hold the robot.
    pub fn rest(&self) -> R::Joints {
        self.drive.held().unwrap_or(self.measured.position)
    }

    /// Holds a position from step `due` on, as drives do that have just been set up there.
    pub fn begin_at(&mut self, position: R::Joints, due: u64) {
        self.interpolation = Interpolation::new(position, due, self.period, self.delay);
        self.task_space = TaskSpace::new();
        self.commanded = position;
        self.still = self.interpolation.settling_steps();
        self.regulators = None;
    }

    /// Whether the drives have come to the last demand.
    pub fn has_settled(&self) -> bool {
        self.still >= self.interpolation.settling_steps()
    }

    /// Whether the joints of `robot` are where they were told to be.
    ///
    /// # Errors
    /// A fault of this kind for the first joint that is not.
    pub fn check_following(&self, robot: &R, demanded: &R::Joints, kind: FaultKind) -> Result<(), Fault> {
        for i in 0..R::Joints::LEN {
            let error = (self.measured.position[i] - demanded[i]).abs();
            let limit = self.following_error[i];
            if !self.measured.velocity[i].is_finite() {
                return Err(Fault::new(kind)
                    .at_joint(i)
                    .text("the drives measure a velocity that is no number"));
            }
            // A NaN from an encoder is no small error.
            let is_small = error <= limit;
            if !is_small {
                return Err(Fault::new(kind).at_joint(i).exceeds(error, limit, robot.joint(i).unit(0)));
            }
        }
        Ok(())
    }

    /// Chooses these regulators when the next step begins.
    ///
    /// # Errors
    /// `NoRegulator` for a set that a drive does not have.
    pub fn order_regulators(&mut self, sets: &Regulators) -> Result<(), Fault> {
        let drive = &self.drive;
        if let Some(joint) = (0..R::Joints::LEN).find(|&joint| !drive.has_regulator(joint, sets.set(joint))) {
            let text = format!("parameter set {}", sets.set(joint));
            return Err(Fault::new(FaultKind::NoRegulator).at_joint(joint).text(&text));
        }
        self.regulators = Some(*sets);
        Ok(())
    }

    /// A demand in these coordinates has been accepted.
    pub fn accept(&mut self, coordinates: &Coordinates<R>) {
        let stands = self.space == InterpolationSpace::Task && self.interpolation.stands();
        match coordinates {
            Coordinates::Hold => {}
            Coordinates::Joints(_) => self.task_space.accept(false, stands),
            Coordinates::Pose(_) | Coordinates::Displacement(_) => self.task_space.accept(true, stands),
        }
    }

    /// A step begins, with this demand.
    ///
    /// # Errors
    /// The panic of a driver that was to choose regulators.
    pub fn begin_step(&mut self, demand: R::Joints) -> Result<(), Fault> {
        self.still = if demand == *self.interpolation.goal() { self.still + 1 } else { 0 };
        self.interpolation.push(demand);
        let Some(sets) = self.regulators.take() else { return Ok(()) };
        let chosen = guarded(|| self.drive.choose_regulators(&sets));
        self.lost |= chosen.is_err();
        chosen
    }

    /// Whether servo periods are interpolated in poses.
    pub fn is_in_task_space(&self) -> bool {
        self.space != InterpolationSpace::Joints && !self.interpolation.is_direct()
    }

    /// Learns by how much the joints of the pose for the end of a servo period of `servo` \[ns\] differ from `joints`, the
    /// spline's, where that counts.
    ///
    /// # Errors
    /// A pose that has no joints, or joints that are too far away: the difference fades from now on.
    pub fn learn_difference(
        &mut self,
        end: Nanos,
        joints: &R::Joints,
        servo: Nanos,
        acceptor: &Acceptor<R>,
    ) -> Result<(), Fault> {
        let seconds = servo as f64 * 1e-9;
        if !self.task_space.advance(seconds) {
            return Ok(());
        }
        match guarded(|| self.beside_spline(end, joints, seconds, acceptor)).and_then(|difference| difference)
        {
            Ok(difference) => {
                self.task_space.set_difference(difference);
                Ok(())
            }
            Err(fault) => {
                self.task_space.fail();
                Err(fault)
            }
        }
    }

    /// By how much the joints of the pose between the demands differ from those of the spline.
    fn beside_spline(
        &self,
        end: Nanos,
        joints: &R::Joints,
        seconds: f64,
        acceptor: &Acceptor<R>,
    ) -> Result<R::Joints, Fault> {
        let robot = acceptor.robot();
        let pose = self.interpolation.pose_at(end, |joints| robot.forward(joints));
        let difference = acceptor.flange_joints(&pose, joints)? - *joints;
        // On another branch, or where the pose turns about a singularity that the joints do not.
        acceptor.check_displacement(&difference, self.period.as_secs_f64())?;
        let displacement = *joints + difference - self.commanded;
        acceptor.check_displacement(&displacement, seconds)?;
        Ok(difference)
    }

    /// The wrench of the surroundings on the flange, `F_F`. A driver that says what is no wrench, or panicked, says nothing.
    pub fn wrench(&self) -> Option<Wrench> {
        if self.lost { None } else { self.drive.wrench().filter(Wrench::is_finite) }
    }

    /// The share of its demands' speed at which the robot goes, 0 to 1. A driver that says something else, or panicked, says
    /// nothing.
    pub fn speed_scaling(&self) -> f64 {
        let scaling = if self.lost { 1.0 } else { self.drive.speed_scaling() };
        if (0.0..=1.0).contains(&scaling) { scaling } else { 1.0 }
    }

    /// The beginning of a servo period that the robot has told by `now`.
    ///
    /// # Errors
    /// The fault of drives that have no power now. One that panicked is asked nothing more.
    pub fn pulse(&mut self, now: Nanos) -> Result<Option<Pulse>, Fault> {
        if self.lost {
            return Ok(None);
        }
        let pulse = guarded(|| self.drive.pulse(now));
        self.lost = pulse.is_err();
        pulse?
    }

    /// One servo period, which begins at `now`, with the tool in force. The position that the drives had been told for what
    /// the encoders now read.
    ///
    /// # Errors
    /// The fault of drives that have no power now. One that panicked is told nothing more: what it still does is unknown.
    #[allow(non_snake_case)]
    pub fn tick(
        &mut self,
        now: Nanos,
        demanded: &R::Joints,
        X_FE: &Pose,
        waiter: &dyn Waiter,
    ) -> Result<R::Joints, Fault> {
        self.commanded = *demanded;
        match guarded(|| self.drive.tick(now, demanded, X_FE, waiter)) {
            Ok(followed) => {
                let followed = followed?;
                self.measured = followed.measured;
                Ok(followed.demanded)
            }
            Err(panic) => {
                self.lost = true;
                Err(panic)
            }
        }
    }

    /// A servo period, which begins at `now`, passes without power.
    ///
    /// # Errors
    /// The driver's panic.
    pub fn stand_by(&mut self, now: Nanos) -> Result<(), Fault> {
        if self.lost {
            return Ok(());
        }
        let stood = guarded(|| self.drive.stand_by(now));
        self.lost = stood.is_err();
        stood
    }

    /// Takes the power away.
    ///
    /// # Errors
    /// The driver's panic.
    pub fn switch_off(&mut self, waiter: &dyn Waiter) -> Result<(), Fault> {
        let off = guarded(|| self.drive.switch_off(waiter));
        self.lost |= off.is_err();
        off
    }

    /// Power for drives that have none, with the regulators that they began with.
    ///
    /// # Errors
    /// A fault while a drive cannot come on.
    pub fn switch_on(&mut self, waiter: &dyn Waiter) -> Result<(), Fault> {
        self.drive.switch_on(waiter)?;
        self.drive.choose_regulators(&Regulators::default());
        self.measured = self.drive.measured()?;
        Ok(())
    }
}
