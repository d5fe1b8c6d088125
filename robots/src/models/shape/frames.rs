//! The frames that a robot's links carry, as its outline needs them.

use mrroc::prelude::*;
use nalgebra::Vector3;

use super::outline::Motion;

/// The most frames that an arm shows.
const FRAMES: usize = 8;

/// The frames that a robot shows at `q`, from base to flange, and how many they are.
pub(crate) fn frames<R: Robot>(robot: &R, q: &R::Joints) -> ([Pose; FRAMES], usize) {
    let mut frames = [Pose::identity(); FRAMES];
    let mut count = 0;
    robot.frames(q, &mut |frame| {
        if let Some(place) = frames.get_mut(count) {
            *place = *frame;
        }
        count += 1;
    });
    (frames, count)
}

/// Origin of a frame \[m\].
pub(crate) fn origin(frame: &Pose) -> Vector3<f64> {
    frame.translation.vector
}

/// A turn about an axis of a frame, through its origin.
pub(crate) fn turn(frame: &Pose, axis: Vector3<f64>, bound: f64) -> Motion {
    Motion::Turn { point: origin(frame), axis: Some(frame.rotation * axis), bound }
}
