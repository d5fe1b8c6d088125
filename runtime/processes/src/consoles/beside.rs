//! What a picture of a running cell shows beside its robots' joints: what they carry, their inputs and outputs, readings, bodies.
//!
//! In: what the entries of the state board say. Out: the same as a part of a picture.

use serde::{Deserialize, Serialize};

use super::as_words;
use mrroc_core::pose::Pose;
use mrroc_core::robot::{Load, Signals};

/// What a robot carries, and its inputs and outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CarriedPicture {
    /// The robot.
    pub robot: String,
    /// The tool in force, `X_FE` \[m\].
    #[serde(with = "as_words")]
    pub tool: Pose,
    /// What its drives were told last that the flange carries; `None`: they were told nothing.
    #[serde(with = "as_words")]
    pub load: Option<Load>,
    /// What its inputs read, and what its outputs are.
    #[serde(with = "as_words")]
    pub signals: Signals,
}

/// The newest reading of a virtual sensor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReadingPicture {
    /// The sensor.
    pub sensor: String,
    /// The step in which it was taken.
    pub step: u64,
    /// The words of the reading; `None`: there was a fault instead.
    pub words: Option<Vec<u64>>,
}

/// Where a body is that the robots handle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyPicture {
    /// Its place among the bodies of the cell's layout.
    pub place: usize,
    /// Its pose in the world, `X_WB` \[m\].
    #[serde(with = "as_words")]
    pub pose: Pose,
}
