//! What the coordinator asks of an effector and its sensor, whatever their kinds.

use mrroc::prelude::*;
use mrroc::robot::RobotImage;
use nalgebra::Vector2;

/// A kind of sensor that feels walls, carried by the robot `R`.
pub trait Feeling<R: Robot>: Sensor<Configuration = ()> {
    /// Whether a wall is touched, how many times one was, and where the last time.
    fn touch(reading: &Self::Reading) -> Touch;

    /// Where the middle of the ball, or of what else is to go through the maze, is now [m, W].
    fn place(reading: &Self::Reading, robot: &RobotImage<R>) -> Vector2<f64>;
}

/// What is felt of walls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Touch {
    /// Whether it touches: the switch is closed, or has been within the time in which it bounces.
    pub touching: bool,
    /// How many touches there were.
    pub touches: u32,
    /// Where the last one was, as the encoders saw the ball's seat when the switch closed first [m, W].
    pub x: f64,
    /// See `x`.
    pub y: f64,
    /// How long ago that was \[s\].
    pub since: f64,
}
