//! What an EDP drives: a real robot's drives or a simulated plant.

use core::time::Duration;

use crate::robot::Robot;

/// Joint state as the encoders give it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured<J> {
    /// Joint positions [rad or m].
    pub position: J,
    /// Joint velocities [rad/s or m/s].
    pub velocity: J,
}

/// The drives of one robot. The EDP calls [`tick`](Driver::tick) once per servo period.
pub trait Driver<R: Robot> {
    /// The servo period; it divides the step, or the step divides it.
    fn period(&self) -> Duration;

    /// What the encoders read now, without moving anything.
    fn measured(&self) -> Measured<R::Joints>;

    /// One servo period: the drives take the joint position `demanded` for its end [rad or m];
    /// returns what the encoders read at its end.
    ///
    /// # Errors
    /// [`DriveFault`] when a drive trips; the drives then apply their brakes.
    fn tick(&mut self, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault>;
}

/// A drive that gave up.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{what}: {actual} {unit}, limit {limit} {unit}")]
pub struct DriveFault {
    /// Index of the joint, from 0.
    pub joint: usize,
    /// What went wrong, for the message: `"motor current"`.
    pub what: &'static str,
    /// The value met.
    pub actual: f64,
    /// The value allowed.
    pub limit: f64,
    /// Unit of both.
    pub unit: &'static str,
}
