//! The virtual sensors of a belt: a gate of two light barriers, a range finder across it, a barrier between the fingers, a
//! camera or an ultrasonic matrix over it, and its encoder.
//!
//! | sensor | reading | mode that suits it |
//! |---|---|---|
//! | [`GateSensor`] | [`Gate`]: parts that have passed, speed, length | free running: its barriers are sampled at 1 kHz |
//! | [`RangeFinder`] | [`Across`]: where parts lie across the belt | with delay: a value takes 38 ms |
//! | [`CameraSensor`] | [`Spotted`]: parts, by class and place in the belt's frame | with delay: an image takes 60 ms |
//! | [`PhotoSensor`] | [`Spotted`], by images of a real camera or of files | with delay |
//! | [`MatrixSensor`] | [`Spotted`], as of a camera | with delay: a part takes 60 ms; it pings by itself, whoever asks |
//! | [`Encoder`] | [`Run`]: how far the belt has run | interactive |
//! | [`FingerBarrier`] | [`Between`]: whether something is between the fingers | interactive: in every step |
//!
//! Times in readings are ages at the reading's step, so that a program extrapolates without a clock of its own: what a gate saw
//! `since` seconds before the step of its reading.

mod camera;
mod encoder;
mod fingers;
mod gate;
mod matrix;
mod parts;
mod photos;
mod range;
mod sampled;
mod sighting;
#[cfg(all(feature = "v4l", target_os = "linux"))]
mod video;

pub use camera::{CameraSensor, ImageObserver, Trigger};
pub use encoder::{Encoder, Run};
pub use fingers::{Between, FingerBarrier, Fingers, Tool};
pub use gate::{Gate, GateReading, GateSensor};
pub use matrix::{Listener, MatrixSensor};
pub use parts::{OnBelt, PartSensor, Spotted};
pub use photos::{Photo, PhotoSensor, PhotoSource};
pub use range::{Across, AcrossReading, RangeFinder};
pub use sampled::Sampled;
#[cfg(all(feature = "v4l", target_os = "linux"))]
pub use video::VideoCamera;
