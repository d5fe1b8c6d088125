//! Goes where a behaviour wants to, in every step anew.

use mrroc::prelude::*;
use nalgebra::Vector2;

use crate::arm::Arm;
use crate::touch::{Near, Touch};

/// FILL IN: how fast the tool goes [m/s] ..
pub const SPEED: f64 = 0.05;
/// .. and how fast that changes [m/s²].
const ACCELERATION: f64 = 0.3;

/// Moves the tool level, from rest, with the velocity [m/s, world] that is wanted where it is by what it feels; done when none is.
pub struct Steer<F> {
    wanted: F,
    pose: Pose,
    velocity: Vector2<f64>,
}

impl<F: FnMut(Vector2<f64>, &Near) -> Option<Vector2<f64>> + 'static> Steer<F> {
    pub fn by(wanted: F) -> Self {
        Steer { wanted, pose: Pose::identity(), velocity: Vector2::zeros() }
    }
}

#[generator(ecp)]
impl<F: FnMut(Vector2<f64>, &Near) -> Option<Vector2<f64>> + 'static> Steer<F> {
    fn first_step(&mut self, e: &State<Arm>, v: &Reading<(Touch,)>, t: Tick) -> Step<Arm> {
        self.pose = e.demanded().pose;
        self.velocity = Vector2::zeros();
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(Touch,)>, t: Tick) -> Step<Arm> {
        let Some(near) = v.0.reading() else { return Step::Next(Demand::pose(self.pose)) };
        let Some(wanted) = (self.wanted)(self.pose.translation.vector.xy(), &near) else { return Step::Done };
        self.velocity += (wanted - self.velocity).cap_magnitude(ACCELERATION * t.dt);
        let step = self.velocity * t.dt;
        self.pose.translation.x += step.x;
        self.pose.translation.y += step.y;
        Step::Next(Demand::pose(self.pose))
    }
}
