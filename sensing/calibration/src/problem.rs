//! A calibration problem: frames, arms, instruments, targets, and what was measured.
//!
//! Everything unknown is a block: a frame (six numbers, or three of a point), an arm's parameters, an instrument's constants. An instrument
//! and a target stand in the world or on an arm's flange, so a camera on a wrist that looks at a board, and a tracker that looks at a
//! ball on a tool, are one case:
//!
//! ```text
//! X_IT = (X_WB X_BF(q) X_FI)^-1  X_WB X_BF(q) X_FT      with X_WB X_BF = 1 of what stands in the world
//! residual = (what the instrument read - what it would read of X_IT) / sigma
//! ```

use std::rc::Rc;

use mrroc::pose::Pose;
use nalgebra::Vector6;

use crate::arm::Arm;
use crate::device::Device;
use crate::parameter::{Parameter, Unit};

/// Which numbers of a frame are unknown, and how well they were known before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Freedom {
    /// Whether x, y, z, and the turns about the frame's own x, y, z, are to be found.
    pub free: [bool; 6],
    /// The standard deviations of what is believed of them [m, rad], finite and > 0, where they are known.
    pub tolerance: [Option<f64>; 6],
}

impl Freedom {
    /// The frame is known.
    pub const FIXED: Self = Self { free: [false; 6], tolerance: [None; 6] };
    /// Its origin is to be found; its axes do not matter.
    pub const POINT: Self = Self { free: [true, true, true, false, false, false], tolerance: [None; 6] };
    /// All of it is to be found.
    pub const FRAME: Self = Self { free: [true; 6], tolerance: [None; 6] };

    /// The same with some numbers free, to within a standard deviation [m or rad].
    #[must_use]
    pub fn within(mut self, axes: core::ops::Range<usize>, tolerance: f64) -> Self {
        for axis in axes {
            self.free[axis] = true;
            self.tolerance[axis] = Some(tolerance);
        }
        self
    }
}

macro_rules! identities {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $name(pub(crate) usize);
    )*};
}

identities! {
    /// A frame of a problem.
    FrameId;
    /// An arm of a problem.
    ArmId;
    /// An instrument of a problem.
    InstrumentId;
    /// A target of a problem.
    TargetId;
    /// A posture of a problem.
    PostureId;
}

#[derive(Clone)]
pub(crate) struct Frame {
    pub(crate) name: String,
    pub(crate) start: Pose,
    pub(crate) freedom: Freedom,
    /// Which one is left where it is if several cannot be told apart.
    pub(crate) importance: u8,
}

#[derive(Clone)]
pub(crate) struct ArmPart {
    pub(crate) name: String,
    pub(crate) model: Rc<dyn Arm>,
    pub(crate) base: FrameId,
    /// By joint the standard deviation of what it is off by, anew in each posture; empty: by nothing.
    pub(crate) scatter: Vec<f64>,
    /// Joints that yield under torque, as parameters behind those of the model.
    pub(crate) soft: Vec<(usize, Parameter)>,
}

impl ArmPart {
    /// The parameters of the model, then the compliances.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = &Parameter> {
        self.model.parameters().iter().chain(self.soft.iter().map(|(_, parameter)| parameter))
    }

    /// The values of the model's parameters, and the compliances.
    pub(crate) fn parts<'v>(&self, values: &'v [f64]) -> (&'v [f64], &'v [f64]) {
        values.split_at(self.model.parameters().len())
    }

    /// The joint positions that its torques bend it to.
    pub(crate) fn bent(&self, q: &[f64], torques: &[f64], values: &[f64]) -> Vec<f64> {
        let mut bent = q.to_vec();
        for (((joint, _), compliance), torque) in self.soft.iter().zip(self.parts(values).1).zip(torques) {
            bent[*joint] += compliance * torque;
        }
        bent
    }
}

/// A joint that yields to a torque.
#[derive(Clone, Debug, PartialEq)]
pub struct Compliance {
    /// Which joint, from 0.
    pub joint: usize,
    /// Its name, such as `joint 2 compliance`.
    pub name: String,
    /// The standard deviation of what is believed of it [rad/(N m) or m/N], 0 before anything is measured; finite, > 0.
    pub tolerance: f64,
}

#[derive(Clone)]
pub(crate) struct Instrument {
    pub(crate) name: String,
    pub(crate) device: Rc<dyn Device>,
    /// In the world, or on the flange of an arm.
    pub(crate) on: Option<ArmId>,
    pub(crate) frame: FrameId,
    pub(crate) noise: Noise,
}

/// How well an instrument measures.
#[derive(Clone, Debug, PartialEq)]
pub enum Noise {
    /// The standard deviation of each of its residuals [m or rad], finite, > 0.
    Known(Vec<f64>),
    /// To be found from the residuals; about this to begin with.
    Unknown(Vec<f64>),
}

impl Noise {
    pub(crate) fn sigma(&self) -> &[f64] {
        match self {
            Noise::Known(sigma) | Noise::Unknown(sigma) => sigma,
        }
    }
}

#[derive(Clone)]
pub(crate) struct Target {
    pub(crate) on: Option<ArmId>,
    pub(crate) frame: FrameId,
}

#[derive(Clone)]
pub(crate) struct Posture {
    pub(crate) arm: ArmId,
    pub(crate) q: Vec<f64>,
    /// By compliance of the arm what bends it [N m or N]; empty: nothing does.
    pub(crate) torques: Vec<f64>,
}

#[derive(Clone)]
pub(crate) struct Measurement {
    pub(crate) instrument: InstrumentId,
    pub(crate) target: TargetId,
    /// Where the arms are that carry the target, and the instrument.
    pub(crate) postures: Vec<PostureId>,
    pub(crate) read: Vec<f64>,
    /// What reads it, if not the instrument's usual device.
    pub(crate) device: Option<Rc<dyn Device>>,
}

/// A known distance of two targets.
#[derive(Clone)]
pub(crate) struct Bar {
    pub(crate) ends: [TargetId; 2],
    pub(crate) length: f64,
    pub(crate) sigma: f64,
}

/// A calibration problem.
///
/// ```
/// use mrroc::pose::Pose;
/// use mrroc_calibration::*;
/// use nalgebra::Vector3;
///
/// // A turntable of which nothing is known but its axis: where is it, seen by a tracker?
/// let row = DhRow { name: "turn".into(), kind: mrroc::robot::JointKind::Revolute, theta: 0.0, d: 0.0, a: 0.0, alpha: 0.0 };
/// let turntable = Chain::distal(&[row]).with(Detail::Frames, &Tolerances::default());
/// let mut problem = Problem::new();
/// let table = problem.arm("table", turntable, Pose::translation(0.9, 0.1, 0.0), Freedom::FRAME);
/// let ball = problem.target("ball", Some(table), Pose::translation(0.2, 0.0, 0.1), Freedom::POINT);
/// let tracker = problem.instrument("tracker", Points::new(), None, Pose::identity(), Freedom::FIXED, Noise::Known(vec![1e-5; 3]));
/// for i in 0..8 {
///     let q = f64::from(i);
///     let place = problem.posture(table, &[q]);
///     problem.measure(tracker, ball, &[place], &[1.0 + 0.25 * q.cos(), 0.25 * q.sin(), 0.12]);
/// }
/// let fit = problem.fit(&Settings::default())?;
/// let radius = fit.frame(problem.frame_of(ball)).translation.vector.xy().norm();
/// assert!((radius - 0.25).abs() < 1e-9);
/// // How the table is turned, and how high it is, cannot be told from where the ball is on it.
/// assert_eq!(fit.unseen().len(), 2);
/// # Ok::<(), NoFit>(())
/// ```
#[derive(Clone, Default)]
pub struct Problem {
    pub(crate) frames: Vec<Frame>,
    pub(crate) arms: Vec<ArmPart>,
    pub(crate) instruments: Vec<Instrument>,
    pub(crate) targets: Vec<Target>,
    pub(crate) postures: Vec<Posture>,
    pub(crate) measurements: Vec<Measurement>,
    pub(crate) bars: Vec<Bar>,
}

impl Problem {
    /// A problem with nothing in it.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// An arm with its base at `X_WB`, as far as that is known.
    #[allow(non_snake_case)]
    pub fn arm(&mut self, name: &str, model: impl Arm + 'static, X_WB: Pose, freedom: Freedom) -> ArmId {
        let base = self.frame(&format!("{name} base"), X_WB, freedom, 10);
        let model = Rc::new(model);
        self.arms.push(ArmPart { name: name.to_owned(), model, base, scatter: Vec::new(), soft: Vec::new() });
        ArmId(self.arms.len() - 1)
    }

    /// Says that an arm's joints are not quite where their encoders read, by other amounts in each posture, with these standard deviations [rad
    /// or m], one for each joint: what friction winds up between motor and joint, backlash. All measurements in a posture share them, so that
    /// they count less than as many measurements in as many postures.
    ///
    /// The standard deviations are those of the arm's data sheet, or are found by going to the same places from different sides.
    pub fn scatter(&mut self, arm: ArmId, sigma: &[f64]) {
        self.arms[arm.0].scatter = sigma.to_owned();
    }

    /// Says that joints of an arm yield, each to a torque of its own that [`Problem::loaded_posture`] tells. A joint may be named more than once, such as under
    /// what it carries, and under a weight of its own that is not known well.
    pub fn compliant(&mut self, arm: ArmId, compliances: &[Compliance]) {
        let soft = |one: &Compliance| {
            let parameter = Parameter::new(one.name.clone(), Unit::RadianPerNewtonMetre);
            (one.joint, parameter.within(one.tolerance))
        };
        self.arms[arm.0].soft = compliances.iter().map(soft).collect();
    }

    /// An instrument in the world, or on an arm's flange, with its frame there.
    pub fn instrument(
        &mut self,
        name: &str,
        device: impl Device + 'static,
        on: Option<ArmId>,
        frame: Pose,
        freedom: Freedom,
        noise: Noise,
    ) -> InstrumentId {
        let frame = self.frame(name, frame, freedom, 9);
        self.instruments.push(Instrument {
            name: name.to_owned(),
            device: Rc::new(device),
            on,
            frame,
            noise,
        });
        InstrumentId(self.instruments.len() - 1)
    }

    /// A target in the world, or on an arm's flange.
    pub fn target(&mut self, name: &str, on: Option<ArmId>, frame: Pose, freedom: Freedom) -> TargetId {
        let frame = self.frame(name, frame, freedom, 10);
        self.targets.push(Target { on, frame });
        TargetId(self.targets.len() - 1)
    }

    /// The centre of an instrument as a target, which another one sights.
    pub fn target_at(&mut self, instrument: InstrumentId) -> TargetId {
        let Instrument { on, frame, .. } = self.instruments[instrument.0];
        self.targets.push(Target { on, frame });
        TargetId(self.targets.len() - 1)
    }

    /// A posture of an arm: what its encoders read [rad or m].
    pub fn posture(&mut self, arm: ArmId, q: &[f64]) -> PostureId {
        self.loaded_posture(arm, q, &[])
    }

    /// The same, with the torque that bends each compliance of the arm, in their order, in the direction in which its joint's position grows
    /// [N m or N].
    pub fn loaded_posture(&mut self, arm: ArmId, q: &[f64], torques: &[f64]) -> PostureId {
        self.postures.push(Posture { arm, q: q.to_owned(), torques: torques.to_owned() });
        PostureId(self.postures.len() - 1)
    }

    /// What an instrument read of a target, with the postures of the arms that carry them (none if both stand in the world).
    pub fn measure(
        &mut self,
        instrument: InstrumentId,
        target: TargetId,
        postures: &[PostureId],
        read: &[f64],
    ) {
        let postures = postures.to_owned();
        self.measurements.push(Measurement {
            instrument,
            target,
            postures,
            read: read.to_owned(),
            device: None,
        });
    }

    /// The same read by other means, such as by a camera that sees the whole pose of a board and single points: `device` has the constants of
    /// the instrument's own, and its residuals are the first ones of that.
    pub fn measure_by(
        &mut self,
        instrument: InstrumentId,
        device: Rc<dyn Device>,
        target: TargetId,
        postures: &[PostureId],
        read: &[f64],
    ) {
        let (postures, read) = (postures.to_owned(), read.to_owned());
        self.measurements.push(Measurement { instrument, target, postures, read, device: Some(device) });
    }

    /// A bar of known length \[m\] between two targets that stand in the world, with its standard deviation \[m\].
    pub fn bar(&mut self, ends: [TargetId; 2], length: f64, sigma: f64) {
        self.bars.push(Bar { ends, length, sigma });
    }

    /// The same blocks with nothing measured.
    #[must_use]
    pub fn without_measurements(&self) -> Self {
        Self { postures: Vec::new(), measurements: Vec::new(), bars: Vec::new(), ..self.clone() }
    }

    fn frame(&mut self, name: &str, start: Pose, freedom: Freedom, importance: u8) -> FrameId {
        self.frames.push(Frame { name: name.to_owned(), start, freedom, importance });
        FrameId(self.frames.len() - 1)
    }

    /// The frame of a target.
    #[must_use]
    pub fn frame_of(&self, target: TargetId) -> FrameId {
        self.targets[target.0].frame
    }

    /// The frame of an arm's base.
    #[must_use]
    pub fn base_of(&self, arm: ArmId) -> FrameId {
        self.arms[arm.0].base
    }

    /// The frame of an instrument.
    #[must_use]
    pub fn place_of(&self, instrument: InstrumentId) -> FrameId {
        self.instruments[instrument.0].frame
    }

    /// Believes that a frame is elsewhere, to begin with.
    pub fn place(&mut self, frame: FrameId, pose: Pose) {
        self.frames[frame.0].start = pose;
    }

    /// Says anew what of a frame is to be found.
    pub fn free(&mut self, frame: FrameId, freedom: Freedom) {
        self.frames[frame.0].freedom = freedom;
    }

    /// The device that took a measurement, from 0 in the order in which they were told.
    #[must_use]
    pub fn device_of(&self, measurement: usize) -> &dyn Device {
        let measurement = &self.measurements[measurement];
        measurement.device.as_deref().unwrap_or(&*self.instruments[measurement.instrument.0].device)
    }

    /// How many measurements there are.
    #[must_use]
    pub fn measurements(&self) -> usize {
        self.measurements.len()
    }

    /// Where everything is believed to be before anything is measured.
    pub(crate) fn start(&self) -> Values {
        Values {
            frames: self.frames.iter().map(|frame| frame.start).collect(),
            arms: self.arms.iter().map(|arm| vec![0.0; arm.parameters().count()]).collect(),
            instruments: self.instruments.iter().map(|one| vec![0.0; one.device.constants().len()]).collect(),
        }
    }

    /// All that is to be found.
    pub(crate) fn slots(&self) -> Vec<Slot> {
        let mut slots = Vec::new();
        for (frame, of) in self.frames.iter().enumerate() {
            slots
                .extend((0..6).filter(|axis| of.freedom.free[*axis]).map(|axis| Slot::Frame { frame, axis }));
        }
        for (arm, of) in self.arms.iter().enumerate() {
            slots.extend((0..of.parameters().count()).map(|i| Slot::Arm { arm, i }));
        }
        for (instrument, of) in self.instruments.iter().enumerate() {
            slots.extend((0..of.device.constants().len()).map(|i| Slot::Constant { instrument, i }));
        }
        slots
    }

    /// What is known of a slot.
    pub(crate) fn parameter(&self, slot: Slot) -> Parameter {
        match slot {
            Slot::Frame { frame, axis } => {
                let of = &self.frames[frame];
                let name = ["x", "y", "z", "turn x", "turn y", "turn z"][axis];
                let unit = if axis < 3 { Unit::Metre } else { Unit::Radian };
                let tolerance = of.freedom.tolerance[axis];
                Parameter { name: format!("{} {name}", of.name), unit, tolerance, importance: of.importance }
            }
            Slot::Arm { arm, i } => {
                let of = &self.arms[arm];
                let all = of.model.parameters();
                let parameter = all.get(i).unwrap_or_else(|| &of.soft[i - all.len()].1).clone();
                // One arm needs no name.
                match self.arms.len() {
                    1 => parameter,
                    _ => Parameter { name: format!("{} {}", of.name, parameter.name), ..parameter },
                }
            }
            Slot::Constant { instrument, i } => {
                let of = &self.instruments[instrument];
                let parameter = of.device.constants()[i].clone();
                Parameter { name: format!("{} {}", of.name, parameter.name), ..parameter }
            }
        }
    }
}

/// One number to be found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    Frame { frame: usize, axis: usize },
    Arm { arm: usize, i: usize },
    Constant { instrument: usize, i: usize },
}

/// Values of all blocks.
#[derive(Clone, Debug)]
pub(crate) struct Values {
    pub(crate) frames: Vec<Pose>,
    pub(crate) arms: Vec<Vec<f64>>,
    pub(crate) instruments: Vec<Vec<f64>>,
}

impl Values {
    /// Moves what the slots name.
    pub(crate) fn moved(&self, slots: &[Slot], step: &[f64]) -> Self {
        let mut moved = self.clone();
        let mut frames: Vec<Option<Vector6<f64>>> = vec![None; self.frames.len()];
        for (slot, by) in slots.iter().zip(step) {
            match *slot {
                Slot::Frame { frame, axis } => frames[frame].get_or_insert_with(Vector6::zeros)[axis] = *by,
                Slot::Arm { arm, i } => moved.arms[arm][i] += by,
                Slot::Constant { instrument, i } => moved.instruments[instrument][i] += by,
            }
        }
        for (frame, by) in moved.frames.iter_mut().zip(frames) {
            if let Some(by) = by {
                *frame = crate::arm::displaced(frame, &by);
            }
        }
        moved
    }

    /// The value of a slot: of a frame's number how far it is from the start, in the start's axes.
    pub(crate) fn get(&self, slot: Slot, start: &Values) -> f64 {
        match slot {
            Slot::Frame { frame, axis } => {
                let from = start.frames[frame].inv_mul(&self.frames[frame]);
                if axis < 3 { from.translation.vector[axis] } else { from.rotation.scaled_axis()[axis - 3] }
            }
            Slot::Arm { arm, i } => self.arms[arm][i],
            Slot::Constant { instrument, i } => self.instruments[instrument][i],
        }
    }

    /// Puts a slot back to what was believed before; a frame's number stays.
    pub(crate) fn reset(&mut self, slot: Slot) {
        match slot {
            Slot::Frame { .. } => {}
            Slot::Arm { arm, i } => self.arms[arm][i] = 0.0,
            Slot::Constant { instrument, i } => self.instruments[instrument][i] = 0.0,
        }
    }
}
