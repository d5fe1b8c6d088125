//! What the coordinator tells the arm: loosely, with the place that it is to go to.

use mrroc::prelude::*;

/// A task of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Task {
    /// Straight to a place between the walls, until something is touched; then back by a little.
    Go {
        /// [m, W].
        x: f64,
        /// [m, W].
        y: f64,
    },
    /// Over the walls to a place, and down.
    Hop {
        /// [m, W].
        x: f64,
        /// [m, W].
        y: f64,
    },
}
