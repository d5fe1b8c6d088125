//! Where things are, and how fast the arm may move: what the programs know of the cell besides its robots.
//!
//! Frames: W world, z up, at the arm's shoulder; the belt runs along y. s: along the belt from the second barrier on; E: between the
//! fingertips, z down, x across the belt, along which the fingers close.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// Where the middle of the belt is across \[m, x of W\], and the second barrier along it \[m, y of W\].
pub const BELT: [f64; 2] = [0.78, -0.45];
/// The belt's surface, from s to s, and its width \[m\]. It lies at z = 0.
pub const SURFACE: [f64; 3] = [-0.75, 1.15, 0.24];
/// The two barriers are so far apart \[m\] ..
pub const SPACING: f64 = 0.15;
/// .. and their beams so high over the belt \[m\].
pub const BEAMS: f64 = 0.015;
/// Where the range finder looks across, along s \[m\] ..
pub const RANGE_AT: f64 = -0.03;
/// .. and from how far beside the middle of the belt \[m\].
pub const RANGE_FROM: f64 = 0.25;
/// How wide parts are, across the belt, and how high \[m\].
pub const PART: [f64; 2] = [0.05, 0.04];
/// Parts of this length and more are long \[m\].
pub const LIMIT: f64 = 0.08;

/// Over the belt, where nothing is in the way \[m\] ..
pub const HIGH: f64 = 0.14;
/// .. and where the fingers are beside a part \[m\].
pub const LOW: f64 = 0.02;
/// Where the arm waits, along s \[m\].
pub const HOME: f64 = 0.13;
/// A part whose middle is farther is no longer followed, along s \[m\] ..
pub const LATEST: f64 = 0.2;
/// .. and beyond this the arm does not go \[m\].
pub const END: f64 = 0.95;
/// The middle of each tray \[m, W\].
pub const TRAYS: [[f64; 3]; 2] = [[0.53, 0.5, -0.02], [0.53, -0.5, -0.02]];
/// The edges of a tray \[m\].
pub const TRAY: [f64; 3] = [0.16, 0.2, 0.12];
/// How high the tool is over a tray when it lets go \[m\].
pub const OVER_TRAY: f64 = 0.1;

/// The beam between the fingers is so far before the middle of their pads, as the belt runs \[m\]: a part that lags behind the tool
/// by more than half of its length less this is no longer in the beam, while the pads would still lie on it.
pub const BEAM: f64 = 0.02;

/// Openings of the hand \[m\]: around a part, and pressing on it.
pub const OPEN: f64 = 0.08;
/// See [`OPEN`].
pub const CLOSED: f64 = 0.04;
/// Speed and acceleration of the fingers [m/s, m/s²].
pub const FINGERS: [f64; 2] = [0.09, 0.35];

/// The tool at a place along the belt, across it from its middle, and over it \[m\].
#[must_use]
pub fn tool(s: f64, across: f64, over: f64) -> Pose {
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    Pose::from_parts(Translation3::new(BELT[0] + across, BELT[1] + s, over), down)
}

/// Over the middle of a tray, `over` \[m\] above the belt.
///
/// # Panics
/// There are two trays.
#[must_use]
pub fn over_tray(tray: usize, over: f64) -> Pose {
    let [x, y, _] = TRAYS[tray];
    tool(y - BELT[1], x - BELT[0], over)
}

/// How fast the tool may move on straight lines.
#[must_use]
pub fn limits() -> ToolLimits {
    ToolLimits {
        translation: ProfileLimits { velocity: 0.4, acceleration: 1.0 },
        rotation: ProfileLimits { velocity: 0.5, acceleration: 1.0 },
    }
}
