//! What an EDP drives: a real robot's drives or a simulated plant.
//!
//! Drives begin as [`Homing`] where their encoders do not know where the robot is, and become a [`Driver`] once they do.
//! Only a `Driver` takes joint positions: before homing there is nothing that could move the robot by a demand.

use core::fmt;
use core::time::Duration;

use crate::model::excess::Excess;
use crate::model::joints::MAX_JOINTS;
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
    /// The servo period; it divides the step, or the step divides it.
    fn period(&self) -> Duration;

    /// Connects to the drives. The robot's EDP, which alone drives it, calls this once when it starts, before anything but
    /// [`period`](Driver::period), [`hardware`](Driver::hardware) and [`simulation`](Driver::simulation); and again at a
    /// reset, if it has failed. Making a driver connects to nothing: every process of a cell makes all of them, and so does
    /// a check or a dry run, for their names and periods; drives whose making connects are made by
    /// [`Connecting`](crate::robot::Connecting). Simulated drives need not say more.
    ///
    /// # Errors
    /// [`DriveFault`] with the reason: the cell stops with it, and nothing moves.
    fn open(&mut self) -> Result<(), DriveFault> {
        Ok(())
    }

    /// Lets the drives go, after the last period of a robot that stands or has no power.
    fn close(&mut self) {}

    /// What the encoders read now, without moving anything.
    ///
    /// # Errors
    /// [`DriveFault`] when they cannot be read: the robot stays where it is, the cell stops with the reason, and a reset
    /// reads them again.
    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault>;

    /// One servo period: the drives take the joint position `demanded` for its end [rad or m];
    /// returns what the encoders read at its end.
    ///
    /// In real time an EDP that wakes late leaves out the periods that are over: the position is then the one that is due
    /// for the end of the present period, on the same curve and so many periods further.
    ///
    /// # Errors
    /// [`DriveFault`] when a drive trips; the drives then apply their brakes.
    fn tick(&mut self, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault>;

    /// What the drives are, for the whole machine, if they are real ones: such as `udp 10.0.0.7:30004` or the serial number
    /// of a controller. Where cells run as processes, one cell at a time has the hardware of a name, whatever its file.
    /// Hardware cannot follow the virtual clock: there a cell with drives that name any is refused, or simulated drives
    /// [stand in](crate::cell::RobotSetup::stand_in) for them, as in every dry run. Drives that any number of cells may have
    /// at once, such as simulated ones and those of tests, have no name.
    fn hardware(&self) -> Option<String> {
        None
    }

    /// Whether the robot holds by brakes when its drives have no power. Drives without them, and that is what a driver is
    /// taken for that does not say otherwise, go on holding after a fault stop and are ticked on: what holds a body by its
    /// drives alone, as a gripper does, must not let go.
    fn has_brakes(&self) -> bool {
        false
    }

    /// Takes the power away from a robot that stands and applies its [brakes](Driver::has_brakes), after a fault stop; the
    /// next call is [`switch_on`](Driver::switch_on).
    fn switch_off(&mut self) {}

    /// Powers the drives at a reset, after a trip or a [`switch_off`](Driver::switch_off), where the robot stands: the next
    /// tick's position is what [`measured`](Driver::measured) gives after it. Drives that come on by themselves need not
    /// say more.
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

    /// Chooses the parameter sets of the regulators from the next tick on: only sets that [`has_regulator`](Self::has_regulator) knows.
    fn choose_regulators(&mut self, _sets: &Regulators) {}

    /// Themselves, if they are simulated. Where a cell runs as processes of the operating system, all its simulated drives
    /// are in one of their own, `plant`, which outlives their EDPs as real drives do; real ones are reached by their EDP
    /// itself, and need not say more.
    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R>> {
        None
    }
}

/// Simulated drives of one robot: what real ones do by themselves they have to be told.
pub trait SimulatedDrives<R: Robot> {
    /// One servo period without power and with the brakes applied, after demands have stayed away for too long; returns
    /// what the encoders read at its end.
    fn brake(&mut self) -> Measured<R::Joints>;
}

/// Which parameter set the regulator of each joint works with: the dynamic behaviour of a robot.
///
/// Set 0 is the usual one; what the others are, the driver says.
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
    /// The drives once they know.
    type Drives: Driver<R>;

    /// The servo period, also that of the drives; it divides the step, or the step divides it.
    fn period(&self) -> Duration;

    /// What the drives are, as [`Driver::hardware`] says it.
    fn hardware(&self) -> Option<String> {
        None
    }

    /// One servo period of the search; the call that returns the drives moves nothing: their own first period begins with
    /// it. A search that is called no more must come to rest by itself within a period, as drives must whose demands stop;
    /// after a suspension it is called again.
    ///
    /// # Errors
    /// [`DriveFault`] when a mark is not where it should be or a drive trips; the drives then apply their brakes.
    fn search(self) -> Result<Search<Self, Self::Drives>, DriveFault>;
}

/// What a servo period of homing came to.
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
        /// What it is, for the message: `"motor current"`.
        what: &'static str,
        /// The value met, and the value allowed.
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
