//! Where the camera is, what kind it is, and how well that is known.
//!
//! Frames: F has its origin on the maze's floor where the middle of the maze is said to be, with axes as those of W; C the camera, z ahead.

use core::f64::consts::PI;
use std::sync::OnceLock;

use mrroc::pose::{AngleAxis, Pose};
use mrroc::random::Noise;
use mrroc_sensors::camera::{Camera, Lens, Plane};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::places::MIDDLE;

/// How high the camera is over the maze's floor \[m\].
const OVER: f64 = 1.2;
/// Its intrinsics: about 60 pixels in 25 mm of the walls' tops.
const CAMERA: Camera = Camera {
    size: [1056, 1056],
    focal: [2851.0, 2853.0],
    centre: [529.3, 525.1],
    lens: Lens { radial: [-0.08, 0.02, 0.0], tangential: [3e-4, -2e-4] },
};
/// By calibration its place is known to so much along each axis \[m\] ..
pub const PLACED: f64 = 1e-4;
/// .. and its attitude about each \[rad\].
pub const TILTED: f64 = 5e-5;

/// `X_WF`.
#[must_use]
pub fn floor() -> Pose {
    Pose::translation(MIDDLE[0], MIDDLE[1], MIDDLE[2])
}

/// The camera as it truly is, over F. All runs share it.
pub fn truly() -> &'static Plane {
    static PLANE: OnceLock<Plane> = OnceLock::new();
    PLANE.get_or_init(|| {
        let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
        Plane::new(CAMERA, Pose::from_parts(Translation3::new(0.0, 0.0, OVER), down))
    })
}

/// The camera as a calibration tells it, which is off by chance.
#[must_use]
#[allow(non_snake_case)]
pub fn believed(seed: u64) -> Plane {
    let mut chance = Noise::seeded(seed ^ 0x6579_6521);
    let mut off = |most: f64| Vector3::from_fn(|_, _| chance.between(-most, most));
    let (place, turn) = (off(PLACED), off(TILTED));
    let X_FC = truly().X_FC;
    let turn = AngleAxis(turn).rotation() * X_FC.rotation;
    truly().at(Pose::from_parts(Translation3::from(X_FC.translation.vector + place), turn))
}
