//! Where things are, and how fast the arm may move: what the programs know of the cell besides its robots.
//!
//! Frames: W world, z up, at the arm's shoulder; M the maze, from its lower left post, z up from its floor. Where the maze is said to
//! stand it does stand to [`LOOSE`], and is turned by up to [`TURNED`]: programs find it by touches.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_map::Layout;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// Lengths of a maze and of what goes through it, and how fast that may go where it may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Posts are so far apart \[m\].
    pub pitch: f64,
    /// How thick walls are \[m\].
    pub thickness: f64,
    /// Radius of the stylus's ball, or of a robot \[m\].
    pub radius: f64,
    /// How far planned paths keep from walls that are known \[m\].
    pub margin: f64,
    /// How far it goes back from a wall that it touched \[m\].
    pub back: f64,
    /// It is in the goal when its middle is so far within the goal's cells \[m\].
    pub within: f64,
    /// No passage is said to be narrower \[m\].
    pub passage: f64,
    /// [m/s].
    pub velocity: f64,
    /// [m/s²].
    pub acceleration: f64,
}

impl Sizes {
    /// A ball of 4 mm in cells of 25 mm: contests' classic mazes of 16 by 16 cells are 0.4 m square, which an IRp-6 reaches.
    pub const CLASSIC: Self = Self {
        pitch: 0.025,
        thickness: 0.002,
        radius: 0.002,
        margin: 1.2e-3,
        back: 1.5e-3,
        within: 4e-3,
        passage: 0.015,
        velocity: 0.06,
        acceleration: 0.8,
    };
    /// A ball of 2 mm in cells of 12.5 mm: half-size mazes of 32 by 32 cells are as large. It goes more slowly, because what it
    /// overshoots a wall by is short of the ball and the wall behind it.
    pub const HALF: Self = Self {
        pitch: 0.0125,
        thickness: 0.001,
        radius: 0.001,
        margin: 0.6e-3,
        back: 0.8e-3,
        within: 2e-3,
        passage: 0.0075,
        velocity: 0.04,
        acceleration: 0.8,
    };

    /// Those with which a maze is within an arm's reach: [`Self::CLASSIC`] up to 16 cells along a side, else [`Self::HALF`].
    #[must_use]
    pub fn within_reach(maze: &Layout) -> Self {
        if maze.columns().max(maze.rows()) <= 16 { Self::CLASSIC } else { Self::HALF }
    }

    /// The maze's sides, from post to post \[m\].
    #[must_use]
    pub fn sides(&self, maze: &Layout) -> [f64; 2] {
        [maze.columns() as f64 * self.pitch, maze.rows() as f64 * self.pitch]
    }

    /// How fast the ball may move where it may touch: so that it stops on the spring of the stylus.
    #[must_use]
    pub fn careful(&self) -> ToolLimits {
        limits(self.velocity, self.acceleration)
    }
}

/// How high walls are \[m\].
pub const HEIGHT: f64 = 0.012;
/// Where the middle of the maze is said to be [m, W]: all of a maze that is 0.4 m square is within reach, also where it stands off and is turned.
pub const MIDDLE: [f64; 3] = [0.84, 0.0, 0.1];
/// How far off the maze stands at most, along x and along y \[m\] ..
pub const LOOSE: f64 = 0.003;
/// .. and how it is turned \[rad\].
pub const TURNED: f64 = PI / 180.0;
/// The ball between the walls, and over them [m, over the floor].
pub const LOW: f64 = 0.006;
/// See [`LOW`].
pub const HIGH: f64 = 0.03;
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

/// How fast it may move over the walls.
#[must_use]
pub fn free() -> ToolLimits {
    limits(0.25, 0.8)
}

fn limits(velocity: f64, acceleration: f64) -> ToolLimits {
    let translation = ProfileLimits { velocity, acceleration };
    ToolLimits { translation, rotation: ProfileLimits { velocity: 0.5, acceleration: 1.0 } }
}
