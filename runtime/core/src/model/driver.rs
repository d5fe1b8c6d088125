//! The drives of a robot, real or simulated, as an EDP uses them.
//!
//! Drives whose encoders do not know where the robot is begin as [`Homing`], and become a [`Driver`] when they know.
//! Only a `Driver` takes joint positions: before homing there is nothing that could move the robot by a demand.

use core::fmt;
use core::time::Duration;

use crate::model::excess::Excess;
use crate::model::joints::MAX_JOINTS;
use crate::model::pace::{Pace, Pulse};
use crate::model::robot::Robot;

/// Joint state as the encoders give it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured<J> {
    /// Joint positions [rad or m].
    pub position: J,
    /// Joint velocities [rad/s or m/s].
    pub velocity: J,
}

/// The drives of one robot. The EDP calls [`tick`](Driver::tick) once per servo period.
pub trait Driver<R: Robot> {
    /// The servo period; it divides the step, or the step divides it, unless the [robot](Pace::Robot) says when it begins.
    fn period(&self) -> Duration;

    /// Who says when the servo periods begin; by default the cell. Known before [`open`](Driver::open), and always the
    /// same.
    fn pace(&self) -> Pace {
        Pace::Cell
    }

    /// What the robot has told of the beginning of its present period, if that has come by `now`, the time since the cell
    /// started. It returns at once. Of several that have come it is the last. Asked when the next one should be there, and
    /// then again until it is; [`tick`](Driver::tick) follows, except while the robot is without power.
    /// Only drives that are paced by their [robot](Pace::Robot) implement this.
    ///
    /// # Errors
    /// [`DriveFault`] when the connection is lost, or the robot has stopped for a reason of its own.
    fn pulse(&mut self, _now: Duration) -> Result<Option<Pulse>, DriveFault> {
        Ok(None)
    }

    /// Connects to the drives. Only the robot's EDP calls this: once when it starts, before any method but
    /// [`period`](Driver::period), [`hardware`](Driver::hardware) and [`simulation`](Driver::simulation); and again at
    /// a reset, if the call has failed. A constructor must not connect, because every process of a cell makes all
    /// drivers for their names and periods, and so does a check or a dry run. If it cannot be helped, wrap the drives in
    /// [`Connecting`](crate::robot::Connecting). Simulated drives need not implement this.
    ///
    /// # Errors
    /// [`DriveFault`] with the reason: the cell stops with it, and nothing moves.
    fn open(&mut self) -> Result<(), DriveFault> {
        Ok(())
    }

    /// Disconnects from the drives. Called after the last servo period, when the robot stands or has no power.
    fn close(&mut self) {}

    /// What the encoders read now, without moving anything.
    ///
    /// # Errors
    /// [`DriveFault`] when they cannot be read: the robot stays where it is, the cell stops with the reason, and a reset
    /// reads them again.
    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault>;

    /// Runs one servo period: gives the drives the joint position `demanded` [rad or m] for the end of the period, and
    /// returns what the encoders read then.
    ///
    /// In real time an EDP that wakes late leaves out the periods that are over. Then `demanded` is the position for
    /// the end of the present period: on the same curve, as many periods further as were left out.
    ///
    /// # Errors
    /// [`DriveFault`] when a drive trips; the drives then apply their brakes.
    fn tick(&mut self, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault>;

    /// The currents of the motors at the end of the last servo period \[A\], in the order of the motors: for recordings,
    /// once in a step of a cell that is recorded. It neither waits nor allocates. `None`, the default: the drives do not
    /// measure them.
    fn motor_currents(&self) -> Option<R::Joints> {
        None
    }

    /// A name of the hardware that is unique on this machine, such as `udp 10.0.0.7:30004` or the serial number of a
    /// controller. Only one cell at a time may run as processes with the hardware of a name, whatever the file of the
    /// cell. Hardware cannot follow the virtual clock: there, a cell with named hardware is refused, or simulated drives
    /// [stand in](crate::cell::RobotSetup::stand_in) for it, as in every dry run. Drives that any number of cells may use at
    /// once, such as simulated ones and those of tests, have no name: `None`, the default.
    fn hardware(&self) -> Option<String> {
        None
    }

    /// Whether brakes hold the robot when its drives have no power; by default they do not. Drives without brakes are
    /// not switched off after a fault stop: they hold, and [`tick`](Driver::tick) is still called. So a gripper, which
    /// holds a body by its drives alone, does not let go.
    fn has_brakes(&self) -> bool {
        false
    }

    /// Switches the power off and applies the [brakes](Driver::has_brakes), after a fault stop, when the robot stands.
    /// The next call is [`switch_on`](Driver::switch_on).
    fn switch_off(&mut self) {}

    /// Switches the power on at a reset, after a trip or a [`switch_off`](Driver::switch_off). The robot stays where it
    /// stands: the next tick demands the position that [`measured`](Driver::measured) returns after this call. Drives
    /// that come on by themselves need not implement this.
    ///
    /// # Errors
    /// [`DriveFault`] while a drive cannot come on: the cell stays latched.
    fn switch_on(&mut self) -> Result<(), DriveFault> {
        Ok(())
    }

    /// Whether the regulator of `joint` has a parameter set of this number. Set 0, the usual one, is always there.
    fn has_regulator(&self, _joint: usize, set: u8) -> bool {
        set == 0
    }

    /// Chooses the parameter sets of the regulators from the next tick on. Called only with sets that
    /// [`has_regulator`](Self::has_regulator) knows.
    fn choose_regulators(&mut self, _sets: &Regulators) {}

    /// Simulated drives return themselves here, real ones `None`, the default. If a cell runs as processes of the
    /// operating system, all its simulated drives are in one process, `plant`, which outlives the EDPs as real drives
    /// do.
    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R>> {
        None
    }
}

/// Simulated drives of one robot. They must be told what real drives do by themselves.
pub trait SimulatedDrives<R: Robot> {
    /// Runs one servo period without power and with the brakes applied, after demands have been missing for too long.
    /// Returns what the encoders read at its end.
    fn brake(&mut self) -> Measured<R::Joints>;
}

/// Which parameter set the regulator of each joint works with: the dynamic behaviour of a robot.
///
/// Set 0 is the usual one; each driver documents its others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Regulators([u8; MAX_JOINTS]);

impl Regulators {
    /// The same set for every joint.
    #[must_use]
    pub const fn uniform(set: u8) -> Self {
        Regulators([set; MAX_JOINTS])
    }

    /// Another set for `joint`, from 0; a joint beyond [`MAX_JOINTS`] is ignored.
    #[must_use]
    pub const fn with(mut self, joint: usize, set: u8) -> Self {
        if joint < MAX_JOINTS {
            self.0[joint] = set;
        }
        self
    }

    /// The set of `joint`; 0 beyond [`MAX_JOINTS`].
    #[must_use]
    pub const fn set(&self, joint: usize) -> u8 {
        if joint < MAX_JOINTS { self.0[joint] } else { 0 }
    }

    pub(crate) const fn to_word(self) -> u64 {
        u64::from_le_bytes(self.0)
    }

    pub(crate) const fn from_word(word: u64) -> Self {
        Regulators(word.to_le_bytes())
    }
}

/// The drives of a robot that does not know where it is: they can look for their reference marks and nothing else.
pub trait Homing<R: Robot>: Sized {
    /// The drives after the search.
    type Drives: Driver<R>;

    /// The servo period, also that of the drives; it divides the step, or the step divides it.
    fn period(&self) -> Duration;

    /// The name of the hardware, as for [`Driver::hardware`].
    fn hardware(&self) -> Option<String> {
        None
    }

    /// Runs one servo period of the search. The call that returns the drives moves nothing: their own first period
    /// begins then. If this is no longer called, the drives must come to rest by themselves within a period, as for
    /// demands that stop. After a suspension the calls go on.
    ///
    /// # Errors
    /// [`DriveFault`] when a mark is not where it should be or a drive trips; the drives then apply their brakes.
    fn search(self) -> Result<Search<Self, Self::Drives>, DriveFault>;
}

/// The outcome of one servo period of homing.
#[derive(Debug)]
pub enum Search<H, D> {
    /// The search goes on.
    Searching(H),
    /// All marks are found, and the robot stands.
    Found(D),
}

/// Why a drive gave up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveFault {
    /// A value of one joint is beyond its limit.
    Exceeded {
        /// Index of the joint, from 0.
        joint: usize,
        /// The quantity, for the message: `"motor current"`.
        what: &'static str,
        /// The actual value, and the value allowed.
        excess: Excess,
    },
    /// The hardware does not answer.
    NoAnswer,
    /// Something else, for the message: `"the enabling switch is open"`.
    Other(&'static str),
}

impl DriveFault {
    /// `what` of a joint, from 0, is beyond its limit.
    #[must_use]
    pub const fn exceeded(joint: usize, what: &'static str, excess: Excess) -> Self {
        DriveFault::Exceeded { joint, what, excess }
    }

    /// The joint concerned, from 0, if it is one joint's fault.
    #[must_use]
    pub const fn joint(&self) -> Option<usize> {
        match *self {
            DriveFault::Exceeded { joint, .. } => Some(joint),
            DriveFault::NoAnswer | DriveFault::Other(_) => None,
        }
    }

    /// What went wrong, for the message.
    #[must_use]
    pub const fn what(&self) -> &'static str {
        match *self {
            DriveFault::Exceeded { what, .. } | DriveFault::Other(what) => what,
            DriveFault::NoAnswer => "no answer",
        }
    }

    /// The value that is beyond its limit, if one is.
    #[must_use]
    pub const fn excess(&self) -> Option<Excess> {
        match *self {
            DriveFault::Exceeded { excess, .. } => Some(excess),
            DriveFault::NoAnswer | DriveFault::Other(_) => None,
        }
    }
}

impl fmt::Display for DriveFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.what())?;
        match self.excess() {
            Some(Excess { actual, limit, unit }) => write!(f, ": {actual} {unit}, limit {limit} {unit}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for DriveFault {}
