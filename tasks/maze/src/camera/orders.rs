//! What the coordinator tells the arm: a place to begin at, loosely; then places on the path, in every step.

use mrroc::prelude::*;

/// What the arm does on its own.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Errand {
    /// Over the walls to a place, and down.
    Hop {
        /// [m, W].
        x: f64,
        /// [m, W].
        y: f64,
    },
}

/// Where the ball is to be next, between the walls.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Along {
    /// [m, W].
    pub x: f64,
    /// [m, W].
    pub y: f64,
}
