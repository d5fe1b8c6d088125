//! What a camera sees of a world: forms that move, over a belt that runs.

use mrroc::pose::{AngleAxis, Pose};
use nalgebra::{Translation3, Vector3};

use crate::form::Form;
use crate::scene::Scene;

/// A thing that is seen, and how it moves.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'f> {
    /// Its form, in its frame P.
    pub form: &'f Form,
    /// `X_FP` at the scene's time, in the frame F of the belt's surface.
    pub pose: Pose,
    /// Velocity of the origin of P [m/s, F].
    pub velocity: Vector3<f64>,
    /// [rad/s, F].
    pub angular_velocity: Vector3<f64>,
    /// How much light it scatters: 0 to 1.
    pub reflectance: f64,
}

impl Seen<'_> {
    /// Where it was `before` \[s\] ago, a short time.
    #[must_use]
    pub fn pose_before(&self, before: f64) -> Pose {
        let turn = AngleAxis(self.angular_velocity * -before).rotation();
        let place = self.pose.translation.vector - self.velocity * before;
        Pose::from_parts(Translation3::from(place), turn * self.pose.rotation)
    }
}

/// A scene that a camera looks at. Frame F: z = 0 is the surface of the belt, x the direction in which it runs, z up.
pub trait View: Scene {
    /// Visits every thing over the belt: parts, and what else is in the way.
    fn each_form(&self, visit: &mut dyn FnMut(&Seen<'_>));

    /// How far the belt's surface has truly run \[m\], `before` \[s\] ago.
    fn surface(&self, before: f64) -> f64;
}
