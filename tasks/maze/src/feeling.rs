//! What the coordinator asks of an effector and its sensor, whatever their kinds.

use mrroc::prelude::*;
use mrroc::robot::RobotImage;
use nalgebra::Vector2;

/// A kind of sensor that feels walls, carried by the robot `R`.
pub trait Feeling<R: Robot>: Sensor<Configuration: Default> {
    /// Whether it feels in which direction a wall lies: then each touch is one of the stretches that it has [`seen`](Self::seen), and nothing must
    /// be guessed.
    const TELLS_FACES: bool = false;

    /// Whether a wall is touched, how many times one was, and where the last time.
    fn touch(reading: &Self::Reading) -> Touch;

    /// The place on a wall that was touched last, of a sensor that knows it [m, W].
    fn met(_reading: &Self::Reading) -> Option<Vector2<f64>> {
        None
    }

    /// Where the middle of the ball, or of what else is to go through the maze, is now [m, W].
    fn place(reading: &Self::Reading, robot: &RobotImage<R>) -> Vector2<f64>;

    /// The stretches of walls that it has seen of late, if it sees any.
    fn seen(_reading: &Self::Reading) -> Seen {
        Seen::default()
    }
}

/// The stretches of walls that were seen of late: as many as there are.
pub type Seen = [Option<Stretch>; 10];

/// A stretch of a wall's face that was seen without a touch, or that the ball slid along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Its ends [m, W]: on the face; where the ball slid, those of the path of its middle.
    pub ends: [Vector2<f64>; 2],
    /// From the effector into it \[W\].
    pub into: Vector2<f64>,
}

impl Stretch {
    /// `into` in a maze at `X_WM`, where walls are level or upright: along one of its axes \[M\].
    #[must_use]
    pub fn inward(&self, maze: &Pose) -> Vector2<f64> {
        let into = maze.rotation.inverse() * self.into.push(0.0);
        if into.x.abs() > into.y.abs() {
            Vector2::new(into.x.signum(), 0.0)
        } else {
            Vector2::new(0.0, into.y.signum())
        }
    }
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
