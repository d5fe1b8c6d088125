//! Where things are in the cell with the camera, besides those of [`places`](crate::places).
//!
//! Frame F: that of the belt, x along it, z up, its origin where s = 0 on the middle of the belt.

use core::f64::consts::{FRAC_PI_2, PI};

use mrroc::pose::Pose;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_sensors::camera::{Camera, Plane};
use nalgebra::Vector3;

use crate::places::{BELT, TRAY, TRAYS};

/// Where the camera is, along s, and over the belt \[m\].
pub const CAMERA: [f64; 2] = [-0.42, 0.85];
/// Where the barrier that triggers it is, along s, and over the belt \[m\].
pub const TRIGGER: [f64; 2] = [-0.375, 0.012];
/// Where parts are put on the belt, along s \[m\].
pub const FEED: f64 = -0.68;
/// Parts lie so far off the middle of the belt at most \[m\].
pub const ACROSS: f64 = 0.035;
/// The arm goes down onto parts from here on, along s \[m\] ..
pub const FIRST: f64 = 0.0;
/// .. and not beyond \[m\].
pub const LAST: f64 = 0.85;
/// How far the beam between the fingers is before the middle of their pads \[m\].
pub const BEAM: f64 = 0.008;
/// How many bins there are: four in each tray.
pub const BINS: usize = 4 * TRAYS.len();

/// What an arm at the belt is called, and where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// How far along the belt from the first one, with its bins \[m\].
    pub along: f64,
    /// Names of the arm and of its hand ..
    pub robots: [&'static str; 2],
    /// .. of the belt's encoder as this arm reads it ..
    pub encoder: &'static str,
    /// .. and of the barrier between its fingers.
    pub fingers: &'static str,
}

/// Where arms stand at the belt, as it runs: the files of the cells say the same.
pub const STATIONS: [Station; 2] = [
    Station { along: 0.0, robots: ["arm", "hand"], encoder: "encoder", fingers: "fingers" },
    Station { along: 2.1, robots: ["arm-2", "hand-2"], encoder: "encoder-2", fingers: "fingers-2" },
];

/// `X_WF`.
#[must_use]
#[allow(non_snake_case)]
pub fn X_WF() -> Pose {
    Pose::translation(BELT[0], BELT[1], 0.0) * Pose::rotation(Vector3::z() * FRAC_PI_2)
}

/// The camera, as its calibration says it is: it looks down, its columns along the belt.
#[must_use]
pub fn camera() -> Plane {
    let down = Pose::translation(CAMERA[0], 0.0, CAMERA[1]) * Pose::rotation(Vector3::x() * PI);
    Plane::new(Camera::MRROCPP, down)
}

/// The middle of a bin, across and along the world \[m, W\], and half of its edges.
#[must_use]
pub fn bin(number: usize) -> ([f64; 2], [f64; 2]) {
    let [x, y, _] = TRAYS[number / 4 % TRAYS.len()];
    let half = [0.25 * TRAY[0], 0.25 * TRAY[1]];
    let side = |bit: usize, half: f64| if number & bit == 0 { -half } else { half };
    ([x + side(1, half[0]), y + side(2, half[1])], half)
}

/// How fast the tool may move on straight lines: as fast as the wrist can keep its angle while the column turns.
#[must_use]
pub const fn limits() -> ToolLimits {
    ToolLimits {
        translation: ProfileLimits { velocity: 0.48, acceleration: 1.5 },
        rotation: ProfileLimits { velocity: 0.5, acceleration: 1.0 },
    }
}
