//! The virtual sensors of a belt: a gate of two light barriers, a range finder across it, a barrier between the fingers, a
//! camera over it and its encoder.
//!
//! | sensor | reading | mode that suits it |
//! |---|---|---|
//! | [`GateSensor`] | [`Gate`]: parts that have passed, speed, length | free running: its barriers are sampled at 1 kHz |
//! | [`RangeFinder`] | [`Across`]: where parts lie across the belt | with delay: a value takes 38 ms |
//! | [`CameraSensor`] | [`Spotted`]: parts, by class and place in the belt's frame | with delay: an image takes 60 ms |
//! | [`Encoder`] | [`Run`]: how far the belt has run | interactive |
//! | [`FingerBarrier`] | [`Between`]: whether something is between the fingers | interactive: in every step |
//!
//! Times in readings are ages at the reading's step, so that a program extrapolates without a clock of its own: what a gate saw
//! `since` seconds before the step of its reading.

mod camera;
mod encoder;
mod fingers;
mod gate;
mod range;
mod sampled;

pub use camera::{CameraSensor, OnBelt, Onlooker, PartCamera, Spotted, Trigger};
pub use encoder::{Encoder, Run};
pub use fingers::{Between, FingerBarrier, Fingers, Tool};
pub use gate::{Gate, GateReading, GateSensor};
pub use range::{Across, AcrossReading, RangeFinder};
pub use sampled::Sampled;
