//! What the coordinator tells the effector: loosely, with the place that it is to go to; and what came of it.

use mrroc::prelude::*;
use nalgebra::Vector2;

use crate::feeling::Seen;

/// A task of the effector.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Task {
    /// Straight to a place between the walls, until something is touched; then back by a little.
    Go {
        /// [m, W].
        x: f64,
        /// [m, W].
        y: f64,
    },
    /// Out of the maze, to a place, by touch and without a map: only a reactive controller is told so.
    Leave {
        /// The middle of the exit [m, W].
        x: f64,
        /// See `x`.
        y: f64,
        /// It is there when it is so near \[m\].
        near: f64,
    },
    /// Over the walls to a place, and down. Only arms are told so.
    Hop {
        /// [m, W].
        x: f64,
        /// [m, W].
        y: f64,
    },
}

/// What came of a task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskOutcome {
    /// Where the middle of the ball is now [m, W].
    pub at: Vector2<f64>,
    /// Where it was when it touched, if it did [m, W].
    pub touched: Option<Vector2<f64>>,
    /// Which place of a wall that was, of a sensor that knows it [m, W].
    pub met: Option<Vector2<f64>>,
    /// What it has seen of walls.
    pub seen: Seen,
}

/// Runs a task on the effector, and tells what came of it.
pub type TaskRunner<'a> = dyn FnMut(Task) -> Result<TaskOutcome, Fault> + 'a;
