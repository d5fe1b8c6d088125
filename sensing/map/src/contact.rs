//! Touches of walls, and what is known of mazes before the first one.

use nalgebra::Vector2;

use crate::walls::Place;

/// Squares of the occupancy map to the length of a wall.
const SQUARES: f64 = 25.0;

/// What is known beforehand of mazes, in \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knowledge {
    /// Side lengths of the frame, along x and y.
    pub size: [f64; 2],
    /// The ball's radius.
    pub radius: f64,
    /// The walls' thickness.
    pub thickness: f64,
    /// No passage is narrower than this.
    pub passage: f64,
    /// Walls are about so long at least: how far on a wall is believed to go from where it was touched.
    pub wall: f64,
}

impl Knowledge {
    /// Side length of a square of the occupancy map \[m\].
    #[must_use]
    pub fn square(&self) -> f64 {
        self.wall / SQUARES
    }
}

/// A touch of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// On the wall's surface \[m\].
    pub at: Place,
    /// From the ball into the wall, level or upright.
    pub into: Vector2<f64>,
    /// How the ball moved; zero of what was seen and not touched, whose `into` is sure.
    pub moving: Vector2<f64>,
    /// Where the ball's middle was; of what was seen, where it would be if it touched there squarely \[m\].
    pub ball: Place,
}

impl Contact {
    /// Whether two contacts may be of one wall, by their lines; walls are about `wall` long at least \[m\].
    #[must_use]
    pub fn is_of_the_wall_of(&self, other: &Self, wall: f64) -> bool {
        let apart = other.at - self.at;
        self.into.dot(&other.into).abs() > 0.5 && apart.dot(&self.into).abs() < 0.06 * wall
    }
}
