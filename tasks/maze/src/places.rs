//! Where things are, and how fast the arm may move: what the programs know of the cell besides its robots.
//!
//! Frames: W world, z up, at the arm's shoulder; M the maze, from its lower left post, z up from its floor. Where the maze is said to
//! stand it does stand to [`LOOSE`], and is turned by up to [`TURNED`]: programs find it by touches.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// Posts are so far apart, and walls so thick and so high \[m\].
pub const PITCH: f64 = 0.025;
/// See [`PITCH`].
pub const THICKNESS: f64 = 0.002;
/// See [`PITCH`].
pub const HEIGHT: f64 = 0.012;
/// Radius of the stylus's ball \[m\].
pub const BALL: f64 = 0.002;
/// Where the middle of the maze is said to be [m, W].
pub const MIDDLE: [f64; 3] = [0.86, 0.0, 0.1];
/// How far off the maze stands at most, along x and along y \[m\] ..
pub const LOOSE: f64 = 0.003;
/// .. and how it is turned \[rad\].
pub const TURNED: f64 = PI / 180.0;
/// The ball between the walls, and over them [m, over the floor].
pub const LOW: f64 = 0.006;
/// See [`LOW`].
pub const HIGH: f64 = 0.03;
/// How far the ball goes back from a wall that it touched \[m\].
pub const BACK: f64 = 1.5e-3;

/// The tool at a place in the world, straight down.
#[must_use]
pub fn tool(x: f64, y: f64, over: f64) -> Pose {
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    Pose::from_parts(Translation3::new(x, y, MIDDLE[2] + over), down)
}

/// `X_WM` of a maze of this size \[m\] where it is said to stand.
#[must_use]
pub fn said(size: [f64; 2]) -> Pose {
    Pose::translation(MIDDLE[0] - 0.5 * size[0], MIDDLE[1] - 0.5 * size[1], MIDDLE[2])
}

/// How fast the ball may move where it may touch: so that it stops on the spring of the stylus.
#[must_use]
pub fn careful() -> ToolLimits {
    limits(0.06, 0.8)
}

/// How fast it may move over the walls.
#[must_use]
pub fn free() -> ToolLimits {
    limits(0.25, 0.8)
}

fn limits(velocity: f64, acceleration: f64) -> ToolLimits {
    let translation = ProfileLimits { velocity, acceleration };
    ToolLimits { translation, rotation: ProfileLimits { velocity: 0.5, acceleration: 1.0 } }
}
