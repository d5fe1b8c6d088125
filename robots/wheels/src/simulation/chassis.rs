//! The body on its tyres: planar dynamics.
//!
//! ```text
//! slip of a tyre        s = (r omega - u_w, -w)                 u_w, w: speed of its hub ahead and to the left [m/s]
//! force on the body     F = mu N g(|s| / v_s) s / |s|,          g(x) = x / sqrt(1 + x^2): linear at first, never more than mu N
//!                       v_s = 0.05 max(|r omega|, 0.25 m/s)     so that 2 % of slip take 0.37 of what friction gives
//! body                  M (u' - w r) = sum F_x,  M (w' + u r) = sum F_y,  I r' = b/2 (F_xR - F_xL) + castor + walls
//! ```
//!
//! The centre of mass is on the axle, and each wheel carries the same load: what a load leans over in bends and in braking is left out.
//! The castor, a ball behind the axle, carries a tenth of the weight and rubs. Integrated in steps of [`Chassis::STEP`], speeds before
//! places; a tyre answers within 0.4 ms or more, so that these steps are small enough for it.

use nalgebra::{Rotation2, Vector2};

use super::ground::Ground;
use crate::model::DiffDrive;
use crate::sensing::Planar;

/// Gravity [m/s²].
const GRAVITY: f64 = 9.80665;

/// A body on two tyres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chassis {
    /// Where it is, and how it moves.
    pub motion: Motion,
    /// How far it pressed into a wall in the last step \[m\]; 0 where it touches none.
    pub pressed: f64,
}

/// Where a body is and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Its pose on the floor.
    pub pose: Planar,
    /// Its speed ahead [m/s].
    pub ahead: f64,
    /// Its speed to the left [m/s].
    pub left: f64,
    /// How fast it turns, counterclockwise [rad/s].
    pub turning: f64,
}

impl Chassis {
    /// Length of an integration step \[s\].
    pub const STEP: f64 = 1e-4;
    /// Mass \[kg\].
    pub const MASS: f64 = 0.30;
    /// Moment of inertia about the upright axis [kg m²].
    pub const INERTIA: f64 = 2.5e-4;
    /// Share of the weight on the castor, how far that is behind the axle \[m\], and its friction.
    const CASTOR: (f64, f64, f64) = (0.1, 0.030, 0.05);
    /// Slip at which a tyre gives 0.71 of what friction allows, as a share of the wheel's speed ..
    const SLIP: f64 = 0.05;
    /// .. which counts as so much at least [m/s].
    const SLOW: f64 = 0.25;
    /// A wall yields by this stiffness [N/m], and damps by so much [N s/m].
    const WALL: (f64, f64) = (1.5e4, 25.0);
    /// Friction of the body along a wall.
    const RUBBING: f64 = 0.3;

    /// At rest there.
    #[must_use]
    pub fn at(pose: Planar) -> Self {
        Self { motion: Motion { pose, ..Motion::default() }, pressed: 0.0 }
    }

    /// One integration step with wheels at these speeds [rad/s]; returns how hard each tyre pushes the body ahead \[N\].
    pub fn step(&mut self, wheels: [f64; 2], ground: &Ground) -> [f64; 2] {
        let Motion { pose, ahead, left, turning } = self.motion;
        let weight = Self::MASS * GRAVITY;
        let load = 0.5 * (1.0 - Self::CASTOR.0) * weight;
        let arm = 0.5 * DiffDrive::TRACK;
        let mut force = Vector2::zeros();
        let mut torque = 0.0;
        let mut pushes = [0.0; 2];
        for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
            let rim = DiffDrive::WHEEL * ground.rims[i] * wheels[i];
            let slip = Vector2::new(rim - (ahead + side * arm * turning), -left);
            let scale = Self::SLIP * rim.abs().max(Self::SLOW);
            let push = slip * (ground.friction * load / (scale * scale + slip.norm_squared()).sqrt());
            force += push;
            torque += side * arm * push.x;
            pushes[i] = push.x;
        }
        // The castor rubs against its motion, and what drags does so at the axle.
        let (share, behind, rubs) = Self::CASTOR;
        let castor = rubbing(&Vector2::new(ahead, left - behind * turning), rubs * share * weight);
        force += castor + rubbing(&Vector2::new(ahead, left), ground.drag);
        torque -= behind * castor.y;
        let (pushed, twisted) = self.walls(ground);
        force += Rotation2::new(-pose.heading) * pushed;
        torque += twisted;

        let h = Self::STEP;
        let motion = &mut self.motion;
        motion.ahead += h * (force.x / Self::MASS + left * turning);
        motion.left += h * (force.y / Self::MASS - ahead * turning);
        motion.turning += h * torque / Self::INERTIA;
        let heading = pose.heading + 0.5 * h * motion.turning;
        let moved = Rotation2::new(heading) * Vector2::new(motion.ahead, motion.left) * h;
        motion.pose =
            Planar { x: pose.x + moved.x, y: pose.y + moved.y, heading: pose.heading + h * motion.turning };
        pushes
    }

    /// What walls do to the body: a force [N, floor] and a torque [N m].
    fn walls(&mut self, ground: &Ground) -> (Vector2<f64>, f64) {
        self.pressed = 0.0;
        let Some(walls) = &ground.walls else { return (Vector2::zeros(), 0.0) };
        let Motion { pose, ahead, left, turning } = self.motion;
        let at = Vector2::new(pose.x, pose.y);
        let moving = Rotation2::new(pose.heading) * Vector2::new(ahead, left);
        let (mut force, mut torque) = (Vector2::zeros(), 0.0);
        for wall in walls.near(&at) {
            let away = at - wall.nearest(&at);
            let depth = DiffDrive::BODY - away.norm();
            if depth <= 0.0 || away.norm() < 1e-9 {
                continue;
            }
            self.pressed = self.pressed.max(depth);
            let normal = away.normalize();
            let along = Vector2::new(-normal.y, normal.x);
            // Of the body's rim where it touches: -normal from its middle.
            let sliding = moving.dot(&along) - DiffDrive::BODY * turning;
            let press = (Self::WALL.0 * depth - Self::WALL.1 * moving.dot(&normal)).max(0.0);
            let rub = -Self::RUBBING * press * (sliding / 0.01).clamp(-1.0, 1.0);
            force += normal * press + along * rub;
            torque -= DiffDrive::BODY * rub;
        }
        (force, torque)
    }
}

/// Dry friction of so many newtons against a velocity.
fn rubbing(velocity: &Vector2<f64>, newtons: f64) -> Vector2<f64> {
    const CREEPING: f64 = 0.01;
    -velocity * (newtons / (CREEPING * CREEPING + velocity.norm_squared()).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settled(wheels: [f64; 2], ground: &Ground, seconds: f64) -> Chassis {
        let mut chassis = Chassis::at(Planar::default());
        for _ in 0..(seconds / Chassis::STEP) as usize {
            chassis.step(wheels, ground);
        }
        chassis
    }

    #[test]
    fn wheels_of_equal_speed_drive_straight_and_slip_by_what_drags() {
        let drag = 0.8;
        let ground = Ground { drag, ..Ground::default() };
        let speed = 0.5;
        let body = settled([speed / DiffDrive::WHEEL; 2], &ground, 2.0);
        // mu N x / sqrt(1 + x^2) = F per tyre, with the castor's friction: x follows.
        let weight = Chassis::MASS * GRAVITY;
        let each = 0.5 * (drag + 0.05 * 0.1 * weight) / (ground.friction * 0.45 * weight);
        let slip = 0.05 * speed * each / (1.0 - each * each).sqrt();
        assert!((speed - body.motion.ahead - slip).abs() < 2e-5, "{} {slip}", speed - body.motion.ahead);
        assert!(body.motion.left.abs() < 1e-12 && body.motion.turning.abs() < 1e-12);
    }

    #[test]
    fn no_wheel_can_push_harder_than_friction_and_so_it_speeds_up_no_faster() {
        let ground = Ground::default();
        let body = settled([50.0 / DiffDrive::WHEEL; 2], &ground, 0.1);
        let friction = ground.friction * 0.9 * GRAVITY - 0.05 * 0.1 * GRAVITY;
        assert!(body.motion.ahead < friction * 0.1 && body.motion.ahead > 0.98 * friction * 0.1);
    }

    #[test]
    fn in_a_bend_it_slides_outwards_by_what_the_tyres_need_for_it() {
        // At rest in its own frame on a circle: the tyres give M v omega to the left, by a slip of the same share.
        let ground = Ground::default();
        let (v, turning) = (0.4, 4.0);
        let wheels = DiffDrive::wheels(v, turning);
        let body = settled([wheels[0], wheels[1]], &ground, 1.0).motion;
        let each = 0.5 * Chassis::MASS * body.ahead * body.turning;
        let load = ground.friction * 0.45 * Chassis::MASS * GRAVITY;
        let mut pull = 0.0;
        for (i, side) in [-0.5, 0.5].into_iter().enumerate() {
            let rim = DiffDrive::WHEEL * wheels[i];
            let slip = Vector2::new(rim - body.ahead - side * DiffDrive::TRACK * body.turning, -body.left);
            let scale = 0.05 * rim.max(0.25);
            pull += load * slip.y / (scale * scale + slip.norm_squared()).sqrt();
        }
        assert!(body.left < 0.0, "to the right, outwards: {}", body.left);
        // Beside the castor's friction, 0.015 N.
        assert!((pull - 2.0 * each).abs() < 0.016, "{pull} {}", 2.0 * each);
        assert!((body.turning - turning).abs() < 0.03 * turning, "{}", body.turning);
    }
}
