//! Virtual sensors: what one computes, and what it is told with each order, `v_l = f_v(c0, c_j, e_j, r)` (eq. 14).

use core::time::Duration;

use crate::model::fault::Fault;
use crate::model::frames::Frames;
use crate::model::image::{STATE_WORDS, Sensor};
use crate::model::joints::MAX_JOINTS;
use crate::model::pose::Pose;
use crate::model::shape::Shape;
use crate::model::wire::{BadWords, WORDS, Wire};
use crate::model::wrench::Wrench;

/// Words of a reading order that the configuration may take.
pub(crate) const CONFIGURATION_WORDS: usize = 16;

/// Steps after which a reading is too old to move by.
pub(crate) const MAX_AGE: u32 = 20;

/// A virtual sensor: holds the raw sensors and computes one reading from them.
pub trait VirtualSensor: 'static {
    /// What it reads.
    type Kind: Sensor;

    /// One aggregated reading for an order.
    ///
    /// # Errors
    /// A [`Fault`] when the raw sensors give nothing to aggregate: the Move or Wait that reads it ends with it.
    fn aggregate(
        &mut self,
        order: &ReadingOrder<<Self::Kind as Sensor>::Configuration>,
    ) -> Result<<Self::Kind as Sensor>::Reading, Fault>;

    /// Whether it senses a simulated world. Where a cell runs as processes of the operating system, that is in one of its
    /// own, `plant`, with all simulated drives, and so is this sensor: its VSP passes orders on.
    fn is_simulated(&self) -> bool {
        false
    }

    /// What it opens in the world, by a name that tells it from all others, such as `camera /dev/video0` or `tcp 10.0.0.7:5000`:
    /// no two cells of this machine may have it at once. It cannot follow the virtual clock, so that a run under that clock, a
    /// dry run and a check do not open it. `None`, the default, of what opens nothing.
    fn hardware(&self) -> Option<String> {
        None
    }

    /// Opens its hardware, in the process that aggregates and before the cell begins: it may take seconds.
    ///
    /// # Errors
    /// Why it could not be opened: each order is answered with that, and a second later it is tried again.
    fn open(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    /// When what it would aggregate for this order was taken: a reading of a free-running sensor is as old as that. By default in the
    /// order's step.
    fn taken(&mut self, order: &ReadingOrder<<Self::Kind as Sensor>::Configuration>) -> Taken {
        Taken::In(order.step)
    }

    /// A Python module by which a program of another sends what this sensor reads: `external NAME` on the command line prints
    /// it. `None`, the default, of sensors that read no program.
    fn python(&self) -> Option<String> {
        None
    }

    /// What it hands its images or echoes to, if it has any: they are recorded, and drawn, outside of the control step.
    fn frames(&mut self) -> Option<&mut Frames> {
        None
    }
}

/// When what a virtual sensor would aggregate was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// Nothing has been taken yet: there is no reading.
    NotYet,
    /// In this step, at the latest that of the order: the reading gets older from then on.
    In(u64),
    /// Nothing new has come and the sensor lives, as a bar-code scanner does between two parts: the reading is as good as new.
    NothingNew,
}

/// What a virtual sensor is told with each order.
#[derive(Clone, Copy, Debug)]
pub struct ReadingOrder<C> {
    /// The requester's configuration, `c0` or `c_j`.
    pub configuration: C,
    /// `e_j`: the measured state of the robot that the requester has for this sensor.
    pub robot: Option<EffectorState>,
    /// Index of the step.
    pub step: u64,
}

/// The measured state of a robot of any kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectorState {
    /// Joint positions [rad or m]; entries beyond the robot's joints are 0.
    pub joints: [f64; MAX_JOINTS],
    /// Joint velocities [rad/s or m/s].
    pub velocity: [f64; MAX_JOINTS],
    /// `X_WE`, the pose of the tool in the world.
    pub pose: Pose,
    /// `F_E`, the wrench of the surroundings on the tool, at its frame's origin and in its axes, without the weight of what
    /// the robot carries; `None` of a robot that neither measures nor estimates it.
    pub wrench: Option<Wrench>,
}

impl Wire for EffectorState {
    const LEN: usize = STATE_WORDS + Wrench::LEN;
    const LAYOUT: u64 = crate::model::wire::layout_hash(0, "mrroc::sensor::EffectorState");
    const SHAPE: &'static Shape = &Shape::Fields(&[
        ("joints", <[f64; MAX_JOINTS]>::SHAPE),
        ("velocity", <[f64; MAX_JOINTS]>::SHAPE),
        ("pose", Shape::POSE),
        ("wrench", Wrench::SHAPE),
    ]);

    fn put(&self, words: &mut [u64]) {
        self.joints.put(words);
        self.velocity.put(&mut words[MAX_JOINTS..]);
        self.pose.put(&mut words[2 * MAX_JOINTS..]);
        if let Some(wrench) = &self.wrench {
            wrench.put(&mut words[STATE_WORDS..]);
        }
    }

    fn used(&self) -> usize {
        if self.wrench.is_some() { Self::LEN } else { STATE_WORDS }
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        if words.len() < STATE_WORDS {
            return Err(BadWords);
        }
        let wrench = words.get(STATE_WORDS..).filter(|wrench| !wrench.is_empty());
        Ok(EffectorState {
            joints: Wire::get(words)?,
            velocity: Wire::get(&words[MAX_JOINTS..])?,
            pose: Wire::get(&words[2 * MAX_JOINTS..])?,
            wrench: wrench.map(Wrench::get).transpose()?,
        })
    }
}

const _: () = assert!(CONFIGURATION_WORDS + EffectorState::LEN <= WORDS);

/// How a virtual sensor and its requesters keep step, as in MRROC++.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VspMode {
    /// The requester waits for the reading that it ordered.
    Interactive,
    /// The order is taken at once and its reading collected in a later step; unanswered means the older reading.
    WithDelay,
    /// The sensor runs freely with this period; each requester takes the latest reading of its own configuration,
    /// and until it has ordered one, of the default configuration.
    NonInteractive(Duration),
}
