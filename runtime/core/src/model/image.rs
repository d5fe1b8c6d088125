//! Images: what a process knows of robots and sensors, `e` and `v` of the paper.

use core::fmt;

use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::payload::Payload;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::model::signals::{SIGNAL_WORDS, Signal, Signals};
use crate::model::wire::{BadWords, Wire};

/// One state of a robot.
pub struct RobotState<R: Robot> {
    /// Joint positions [rad or m].
    pub joints: R::Joints,
    /// Joint velocities [rad/s or m/s].
    pub velocity: R::Joints,
    /// `X_WE`, the pose of the tool in the world, lengths in metres.
    pub pose: Pose,
}

/// The image of a robot: the state that it has, the state that it was last told to attain, and its inputs and outputs.
pub struct RobotImage<R: Robot> {
    measured: RobotState<R>,
    demanded: RobotState<R>,
    signals: Signals,
}

impl<R: Robot> RobotImage<R> {
    /// An image of the two states, for calling a step function in a test.
    #[must_use]
    pub const fn new(measured: RobotState<R>, demanded: RobotState<R>) -> Self {
        RobotImage { measured, demanded, signals: Signals::OFF }
    }

    /// The same with these inputs and outputs.
    #[must_use]
    pub const fn with_signals(mut self, signals: Signals) -> Self {
        self.signals = signals;
        self
    }

    /// An image of a robot whose state is not known yet: at the origin, at rest.
    pub(crate) fn unknown() -> Self {
        let state =
            RobotState { joints: R::Joints::zeros(), velocity: R::Joints::zeros(), pose: Pose::identity() };
        RobotImage { measured: state, demanded: state, signals: Signals::OFF }
    }

    /// The state that the encoders gave last.
    #[must_use]
    pub const fn measured(&self) -> &RobotState<R> {
        &self.measured
    }

    /// The state demanded last: where the next motion starts from. A robot that is on its way back to its path, after late
    /// demands, is told to be beside it.
    #[must_use]
    pub const fn demanded(&self) -> &RobotState<R> {
        &self.demanded
    }

    /// What an input of this robot reads, or an output is: `true` and `false` of a digital one, a number in the unit of the
    /// driver of an analog one. An output has the value that it was told as soon as the drives have been told it.
    #[must_use]
    pub fn value<S: Signal>(&self, signal: S) -> S::Value {
        signal.read(&self.signals)
    }

    /// All inputs and outputs of the robot.
    #[must_use]
    pub const fn signals(&self) -> &Signals {
        &self.signals
    }
}

// Derived, these would ask the same of `R`, which is only a name here.
impl<R: Robot> Clone for RobotState<R> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<R: Robot> Copy for RobotState<R> {}
impl<R: Robot> Clone for RobotImage<R> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<R: Robot> Copy for RobotImage<R> {}
impl<R: Robot> PartialEq for RobotState<R> {
    fn eq(&self, other: &Self) -> bool {
        (self.joints, self.velocity, self.pose) == (other.joints, other.velocity, other.pose)
    }
}
impl<R: Robot> fmt::Debug for RobotState<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RobotState")
            .field("joints", &self.joints.as_slice())
            .field("velocity", &self.velocity.as_slice())
            .field("pose", &self.pose)
            .finish()
    }
}
impl<R: Robot> fmt::Debug for RobotImage<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RobotImage")
            .field("measured", &self.measured)
            .field("demanded", &self.demanded)
            .field("signals", &self.signals)
            .finish()
    }
}

/// Words of the image of a robot of any kind, with its inputs and outputs.
pub(crate) const IMAGE_WORDS: usize = 2 * STATE_WORDS + SIGNAL_WORDS;

/// Words of one state of a robot of any kind.
pub const STATE_WORDS: usize = 2 * MAX_JOINTS + 7;

impl<R: Robot> Wire for RobotState<R> {
    const LEN: usize = STATE_WORDS;
    const LAYOUT: u64 = crate::model::wire::layout_hash(R::Joints::LEN as u64, "mrroc::robot::RobotState");

    fn put(&self, words: &mut [u64]) {
        for (word, x) in words.iter_mut().zip(self.joints.as_slice()) {
            *word = x.to_bits();
        }
        for (word, x) in words[MAX_JOINTS..].iter_mut().zip(self.velocity.as_slice()) {
            *word = x.to_bits();
        }
        self.pose.put(&mut words[2 * MAX_JOINTS..]);
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..STATE_WORDS).ok_or(BadWords)?;
        Ok(RobotState {
            joints: R::Joints::from_joints(|i| f64::from_bits(words[i])),
            velocity: R::Joints::from_joints(|i| f64::from_bits(words[MAX_JOINTS + i])),
            pose: Pose::get(&words[2 * MAX_JOINTS..])?,
        })
    }
}

impl<R: Robot> Wire for RobotImage<R> {
    const LEN: usize = IMAGE_WORDS;
    const LAYOUT: u64 = crate::model::wire::layout_hash(R::Joints::LEN as u64, "mrroc::robot::RobotImage");

    fn put(&self, words: &mut [u64]) {
        let (measured, demanded) = words.split_at_mut(STATE_WORDS);
        let (demanded, signals) = demanded.split_at_mut(STATE_WORDS);
        self.measured.put(measured);
        self.demanded.put(demanded);
        if !self.signals.are_off() {
            self.signals.put(signals);
        }
    }

    /// Its two states; its inputs and outputs, unless all are off.
    fn used(&self) -> usize {
        if self.signals.are_off() { 2 * STATE_WORDS } else { Self::LEN }
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let demanded = words.get(STATE_WORDS..).ok_or(BadWords)?;
        let signals = match words.get(2 * STATE_WORDS..) {
            None | Some([]) => Signals::OFF,
            Some(signals) => Signals::get(signals)?,
        };
        Ok(RobotImage { measured: RobotState::get(words)?, demanded: RobotState::get(demanded)?, signals })
    }
}

/// The virtual sensor of a kind: what it reads and how it is configured.
///
/// A unit type names the kind; [`VirtualSensor`](crate::sensor::VirtualSensor) computes its readings.
pub trait Sensor: 'static {
    /// The kind's name, for messages.
    const KIND: &'static str;
    /// The aggregated reading, `v_l` of the paper.
    type Reading: Payload;
    /// What a requester tells the sensor with each order, `c0` or `c_j` of eq. 14; `()` when it needs nothing.
    type Configuration: Payload;
}

/// The image of a virtual sensor: its last reading and how old that is.
pub struct SensorImage<S: Sensor> {
    reading: Option<S::Reading>,
    age: u32,
}

impl<S: Sensor> SensorImage<S> {
    /// An image of a reading of this age \[steps\], for calling a step function in a test.
    #[must_use]
    pub const fn new(reading: S::Reading, age: u32) -> Self {
        SensorImage { reading: Some(reading), age }
    }

    pub(crate) const fn unknown() -> Self {
        SensorImage { reading: None, age: u32::MAX }
    }

    /// The last reading; `None` before the first one of a sensor with delay has arrived.
    #[must_use]
    pub const fn reading(&self) -> Option<S::Reading> {
        self.reading
    }

    /// How old the reading was when it was collected \[steps\]: 0 for one taken in the step of its order.
    #[must_use]
    pub const fn age(&self) -> u32 {
        self.age
    }
}

impl<S: Sensor> Clone for SensorImage<S> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<S: Sensor> Copy for SensorImage<S> {}
