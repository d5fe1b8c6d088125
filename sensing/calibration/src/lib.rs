//! Calibrates any robot with any device.
//!
//! In: joint positions as encoders read them, and what instruments read of targets there. Out: where bases, instruments and targets
//! are, what the arm's dimensions truly are, how sure all that is, and what the measurements say nothing of.
//!
//! | part | what it is |
//! |---|---|
//! | [`minimise`], [`LeastSquares`], [`Loss`] | Levenberg-Marquardt for dense problems, with robust losses |
//! | [`Information`], [`covariance`] | rank, what cannot be told apart, covariance |
//! | [`Arm`], [`ChainArm`], [`Irp6Arm`], [`RntArm`] | robots by displacements behind their joints, or by physical parameters |
//! | [`Device`]: [`Points`], [`Angles`], [`Distance`], [`Plane`], [`Touch`], [`FullPose`], [`Pixels`] | what instruments read |
//! | [`Problem`], [`Fit`] | blocks and measurements; what came of them |
//! | [`choose`], [`Aim`] | which postures to measure |
//! | [`Postures`], [`data::Plan`] | the same from the header of a table alone |
//! | [`Fit::local`], [`LocalTrial`] | what dimensions cannot say of an arm, corrected where it was measured, if that helps |
//! | [`data`], [`trials`] | tables of measurements of others; how much of an arm they can tell |
//! | [`tip`], [`hand_eye`], [`eye`] | the tip of a tool, and a camera, on a flange; a camera beside an arm |
//! | [`intrinsics`], [`photo`] | a camera, from photos of a chessboard, a grid of circles or a ChArUco board |
//! | [`known`], [`likely`] | what is known too badly; why poses do not fit |
//! | [`Touches`] | one base in another, from points that both arms touch |
//! | [`file`](mod@file) | the file that is written for `cell.toml` |
//!
//! The command `calibrate` does all this from a table of measurements, without a cell and without a program: see the book,
//! *Calibration*.

mod arm;
mod chain;
mod choice;
pub mod columns;
pub mod data;
mod device;
mod equations;
mod eye;
pub mod file;
mod fit;
mod hand;
mod information;
mod intrinsics;
mod irp6;
pub mod known;
mod least_squares;
pub mod likely;
mod local;
mod loss;
mod parameter;
pub mod photo;
mod pixels;
mod pose_text;
mod postures;
mod problem;
mod quick;
pub mod report;
mod rnt;
mod scatter;
mod start;
pub mod text_file;
mod touches;
pub mod trials;

pub use arm::{Arm, between, displaced};
pub use chain::{Chain, ChainArm, Detail, DhRow, Joint, Tolerances};
pub use choice::{Aim, Choice, choose, evaluate};
pub use device::{Angles, Device, Distance, FullPose, Plane, Points, Touch};
pub use eye::{Eye, Seen, eye, square_seen};
pub use fit::{Fit, FoundParameter, Indistinct, NoFit};
pub use hand::{InHand, PoseArm, hand_eye, tip, turned};
pub use information::{Information, Unseen, covariance};
pub use intrinsics::{Held, Intrinsics, board_in_camera, camera_of, intrinsics};
pub use irp6::Irp6Arm;
pub use least_squares::{LeastSquares, Minimum, NoMinimum, Settings, minimise};
pub use local::{LocalTrial, bent};
pub use loss::Loss;
pub use parameter::{Parameter, Unit};
pub use pixels::Pixels;
pub use postures::{NoPostures, Postures, Told, Wanted};
pub use problem::{ArmId, Compliance, FrameId, Freedom, InstrumentId, Noise, PostureId, Problem, TargetId};
pub use rnt::RntArm;
pub use touches::{TouchedBase, Touches, WrongTouches};

// The files in `tests/` use this crate by its name, as its users do.
#[cfg(test)]
extern crate self as mrroc_calibration;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod usage;
