//! The drives of a robot, real or simulated, as an EDP uses them.
//!
//! Drives whose encoders do not know where the robot is begin as [`Homing`], and become a [`Driver`] when they know.
//! Only a `Driver` takes joint positions: before homing there is nothing that could move the robot by a demand.

use core::time::Duration;

use crate::model::drive_fault::DriveFault;
use crate::model::joints::MAX_JOINTS;
use crate::model::load::Load;
use crate::model::pace::{Pace, Pulse};
use crate::model::robot::Robot;
#[cfg(doc)]
use crate::model::robot_stop::{RobotStop, StopCause};
use crate::model::signals::{ANALOG, Channel, DIGITAL, Outputs, Signals};
use crate::model::time::Clock;
use crate::model::wrench::Wrench;

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

    /// Connects to the drives. Only the robot's EDP calls this: once before the cell begins, and before any method but
    /// [`period`](Driver::period), [`hardware`](Driver::hardware) and [`simulation`](Driver::simulation); and again at
    /// a reset, if the call has failed. It may take seconds: the cell begins when the drives of all robots are open. Until
    /// then a robot that [paces](Pace::Robot) itself is told in each of its periods to stay where it is. A constructor must not connect, because every process of a cell makes all
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

    /// Where the drives hold the robot by themselves when they have been opened or switched on, if they know that better than
    /// by what the encoders read: a controller that goes on from the position that it was told last, which differs from the
    /// measured one by what the arm sags. Demands begin there. `None`, the default: where the encoders say.
    fn held(&self) -> Option<R::Joints> {
        None
    }

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

    /// The inputs and outputs that the robot's controller has; by default none. Always the same, and known before
    /// [`open`](Driver::open).
    fn channels(&self) -> Channels {
        Channels::NONE
    }

    /// What its inputs read and its outputs are, at the end of the last servo period. It returns at once. Asked only of drives
    /// that have [channels](Driver::channels).
    fn signals(&self) -> Signals {
        Signals::default()
    }

    /// Tells the controller what programs have told its outputs so far, each the last value: an output that none has told
    /// anything stays as it was before the cell began. Called after [`open`](Driver::open), whenever a value changes; also
    /// when the robot has no power. It returns at once.
    fn switch_outputs(&mut self, _outputs: &Outputs) {}

    /// Which outputs programs may switch, and what outputs shall take when this process is lost: once before
    /// [`open`](Driver::open), of a robot with named signals. The controller itself must do the latter;
    /// [`Channels::when_lost`] says whether it does.
    fn declare_outputs(&mut self, _named: &Outputs, _when_lost: &Outputs) {}

    /// Tells the drives what the flange carries from now on, its tool included: mass \[kg\], centre of mass in the flange frame
    /// \[m\], inertia about that centre in the axes of the flange \[kg m²\]. The load is that of a body, and not
    /// [nothing](Load::NONE) before it was another one. Called at the beginning of a step, and again when drives that had no power
    /// are switched on. It returns at once; what the robot refuses is the fault of a later [`pulse`](Driver::pulse) or
    /// [`tick`](Driver::tick). Drives that need not know it do nothing.
    fn carry(&mut self, _load: &Load) {}

    /// For how long the robot must stand until it reckons with what [`carry`](Driver::carry) said: a motion that has told it and ends at
    /// standstill is over no sooner, so that nothing is lifted with the load of before. By default it does at once. Always the same,
    /// and known before [`open`](Driver::open): a replay counts with it.
    fn load_time(&self) -> Duration {
        Duration::ZERO
    }

    /// The currents of the motors at the end of the last servo period \[A\], in the order of the motors: for recordings,
    /// once in a step of a cell that is recorded. It neither waits nor allocates. `None`, the default: the drives do not
    /// measure them.
    fn motor_currents(&self) -> Option<R::Joints> {
        None
    }

    /// The wrench of the surroundings on the flange, `F_F`: at the origin of the flange frame and in its axes, without the
    /// weight of what the robot knows that it carries, as the robot measures or estimates it at the end of the last servo
    /// period. It returns at once, and is asked once in a step. `None`, the default: the robot does neither.
    fn wrench(&self) -> Option<Wrench> {
        None
    }

    /// The share of its demands' speed at which the robot goes now, 0 to 1, where its controller or a person at its pendant
    /// scales the speed: the path time of the whole cell goes no faster then, within the limits of all robots, so that each
    /// stays on its path. By default 1.
    fn speed_scaling(&self) -> f64 {
        1.0
    }

    /// A name of the hardware that is unique on this machine, such as `udp 10.0.0.7:30004` or the serial number of a
    /// controller. Only one cell at a time may run as processes with the hardware of a name, whatever the file of the
    /// cell. Hardware cannot follow the virtual clock: there, a cell with named hardware is refused, or simulated drives
    /// [stand in](crate::cell::RobotSetup::stand_in) for it, as in every dry run. Drives that any number of cells may use at
    /// once, such as simulated ones and those of tests, have no name: `None`, the default.
    fn hardware(&self) -> Option<String> {
        None
    }

    /// The calibration of this one robot, as the text of the file that its entry in `cell.toml` names as `calibration`, for kinds that
    /// read one. It is read from the robot's controller, before anything is [open](Driver::open), which may take seconds; it moves
    /// nothing. `None`, the default: the drives tell none.
    ///
    /// # Errors
    /// [`DriveFault`] when the controller cannot be reached.
    fn calibration(&mut self) -> Result<Option<String>, DriveFault> {
        Ok(None)
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

    /// Does what the robot needs after a [stop](RobotStop) of its own, when the operator has asked for a reset and the
    /// robot is without power here. Called in every step until it is [over](Recovery::Over) or fails, for one robot after
    /// the other, at most for [`RECOVERY`]; [`switch_on`](Driver::switch_on) follows, and says why the robot cannot go on, if
    /// it cannot. It returns at once. It never starts a motion, and clears nothing that
    /// [needs a person](StopCause::needs_a_person) at the robot. Drives that come on by themselves need not implement this.
    ///
    /// # Errors
    /// What the robot refuses: `switch_on` is asked all the same.
    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        Ok(Recovery::Over)
    }

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
    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R::Joints>> {
        None
    }

    /// Drives in a simulator that others wrote return themselves here, all others `None`, the default.
    fn stepped(&mut self) -> Option<&mut dyn Stepped<R::Joints>> {
        None
    }

    /// A Python module by which a program of another simulates this robot: `external NAME` on the command line prints it. `None`,
    /// the default, of drives that no such program has.
    fn python(&self) -> Option<String> {
        None
    }
}

/// The inputs and outputs of a robot's controller: channels below these numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channels {
    /// Digital inputs, at most 32.
    pub digital_inputs: u8,
    /// Digital outputs, at most 32.
    pub digital_outputs: u8,
    /// Analog inputs, at most 4.
    pub analog_inputs: u8,
    /// Analog outputs, at most 4.
    pub analog_outputs: u8,
    /// What its outputs do when nobody tells the controller anything any more.
    pub when_lost: WhenLost,
}

/// What the outputs of a controller do when it is told nothing any more, because the connection or its EDP is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhenLost {
    /// They take the values that the cell [declares](Driver::declare_outputs) for a stop; the others hold.
    AsDeclared,
    /// All hold.
    Hold,
    /// All drop: off, and 0.
    Drop,
}

impl Channels {
    /// No inputs and no outputs.
    pub const NONE: Channels = Channels {
        digital_inputs: 0,
        digital_outputs: 0,
        analog_inputs: 0,
        analog_outputs: 0,
        when_lost: WhenLost::AsDeclared,
    };

    /// As many as there may be, of which each output does as the cell declares: those of simulated drives.
    pub const ALL: Channels = Channels {
        digital_inputs: DIGITAL as u8,
        digital_outputs: DIGITAL as u8,
        analog_inputs: ANALOG as u8,
        analog_outputs: ANALOG as u8,
        when_lost: WhenLost::AsDeclared,
    };

    /// Inputs of this type.
    #[must_use]
    pub const fn inputs(&self, channel: Channel) -> u8 {
        match channel {
            Channel::Digital(_) => self.digital_inputs,
            Channel::Analog(_) => self.analog_inputs,
        }
    }

    /// Outputs of this type.
    #[must_use]
    pub const fn outputs(&self, channel: Channel) -> u8 {
        match channel {
            Channel::Digital(_) => self.digital_outputs,
            Channel::Analog(_) => self.analog_outputs,
        }
    }
}

/// How far a robot's own recovery has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recovery {
    /// There is nothing more to do.
    Over,
    /// The robot is busy: ask again.
    GoesOn,
}

/// How long the recovery of one robot may take.
pub const RECOVERY: Duration = Duration::from_secs(20);

/// Simulated drives of one robot. They must be told what real drives do by themselves.
pub trait SimulatedDrives<J> {
    /// Runs one servo period without power and with the brakes applied, after demands have been missing for too long.
    /// Returns what the encoders read at its end.
    fn brake(&mut self) -> Measured<J>;
}

/// Drives of one robot in a simulator that others wrote. It makes a step when it is told to, with several robots at a time: so it must
/// be told by which clock the cell runs, and of every servo period, by its number.
pub trait Stepped<J> {
    /// Says by which clock the cell runs, before they are opened.
    fn run_by(&mut self, clock: Clock);

    /// As [`Driver::tick`], in the servo period with this number, counted from the cell's start.
    ///
    /// # Errors
    /// [`DriveFault`] when the simulator is lost.
    fn tick_in(&mut self, period: u64, demanded: &J) -> Result<Measured<J>, DriveFault>;

    /// The servo period with this number passes without power. A simulator that is lost meanwhile is told of when the robot
    /// gets power again.
    fn stand_by(&mut self, period: u64);
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
