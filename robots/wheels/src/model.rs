//! The base as a robot: two wheels on one axle, a ball that follows them.
//!
//! ```text
//!            x ^   heading            q = (left, right)  angles of the wheels [rad], positive: forwards
//!       |==|   |   |==|
//!       |L |---A---|R |   A: the middle of the axle, frame of the base; y to the left, z up
//!       |==|       |==|
//!              o castor               s = r (q_R + q_L) / 2      how far it has rolled [m]
//!                                     theta = r (q_R - q_L) / b  how far it has turned [rad]
//! ```
//!
//! **Forward.** Where a base stands is no function of its wheels' angles: it depends on the path on which they came about. Two
//! numbers are functions of them as long as no wheel slips, how far it has rolled and how far it has turned. So [`DiffDrive::forward`]
//! is the axle's frame on the *unrolled* path: `s` along x, turned by `theta` about z. Displacements of the tool mean what one
//! expects: 0.1 m along x is 0.1 m ahead on the present path, a turn about z is a turn on the spot. Where the base stands is a
//! reading of a virtual sensor, see [`Whereabouts`](crate::Whereabouts).

use mrroc::pose::Pose;
use mrroc::robot::{Limits, NoInverse, Robot};
use nalgebra::{Translation3, UnitQuaternion, Vector2, Vector3};

/// Angles of the left and the right wheel \[rad\], or what belongs to them.
pub type Two = Vector2<f64>;

/// A base with two driven wheels, as small as the robots of maze contests.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffDrive {
    limits: Limits<Two>,
}

impl DiffDrive {
    /// Radius of the wheels \[m\].
    pub const WHEEL: f64 = 0.016;
    /// From wheel to wheel \[m\].
    pub const TRACK: f64 = 0.074;
    /// Radius of the round body about the middle of the axle \[m\]: so it can turn wherever it can stand.
    pub const BODY: f64 = 0.045;
    /// Farthest that a demanded pose may be off the unrolled path [m or rad].
    pub const OFF: f64 = 1e-6;

    /// The base.
    #[must_use]
    pub fn new() -> Self {
        Self {
            limits: Limits {
                lower: Two::repeat(-1e5),
                upper: Two::repeat(1e5),
                velocity: Two::repeat(50.0),
                acceleration: Two::repeat(250.0),
                jerk: None,
            },
        }
    }

    /// How far the base has rolled \[m\] and turned \[rad\] at these angles of the wheels.
    #[must_use]
    pub fn rolled(q: &Two) -> (f64, f64) {
        (0.5 * Self::WHEEL * (q[0] + q[1]), Self::WHEEL / Self::TRACK * (q[1] - q[0]))
    }

    /// The angles of the wheels for a distance \[m\] and a turn \[rad\]; speeds for speeds, too.
    ///
    /// ```
    /// use mrroc_wheels::DiffDrive;
    /// let q = DiffDrive::wheels(0.3, -0.7);
    /// let (distance, turn) = DiffDrive::rolled(&q);
    /// assert!((distance - 0.3).abs() < 1e-15 && (turn + 0.7).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn wheels(distance: f64, turn: f64) -> Two {
        let more = 0.5 * Self::TRACK * turn;
        Two::new(distance - more, distance + more) / Self::WHEEL
    }
}

impl Default for DiffDrive {
    fn default() -> Self {
        Self::new()
    }
}

impl Robot for DiffDrive {
    const KIND: &'static str = "diff-drive";

    type Joints = Two;

    fn limits(&self) -> &Limits<Two> {
        &self.limits
    }

    /// The axle's frame on the unrolled path: see the [module](self).
    fn forward(&self, q: &Two) -> Pose {
        let (distance, turn) = Self::rolled(q);
        Pose::from_parts(
            Translation3::new(distance, 0.0, 0.0),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn),
        )
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Two) -> Result<Two, NoInverse> {
        let (at, turned) = (X_WF.translation.vector, X_WF.rotation);
        let lean = (turned * Vector3::z()).xy().norm();
        let beside = at.yz().norm();
        let off = |what, actual, unit| NoInverse::NotAttainable { what, actual, tolerance: Self::OFF, unit };
        if !(beside <= Self::OFF && at.x.is_finite()) {
            return Err(off("the place beside the unrolled path", beside, "m"));
        }
        if lean.is_nan() || lean > Self::OFF {
            return Err(off("lean of the base", lean, "rad"));
        }
        let ahead = turned * Vector3::x();
        let (_, before) = Self::rolled(near);
        let turn = before + angle(ahead.y.atan2(ahead.x) - before);
        Ok(Self::wheels(at.x, turn))
    }
}

/// An angle, within half a turn of 0 \[rad\].
#[must_use]
pub fn angle(turned: f64) -> f64 {
    turned - core::f64::consts::TAU * (turned / core::f64::consts::TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::random::Random;

    #[test]
    fn its_unrolled_pose_gives_the_wheels_back_after_any_number_of_turns() {
        let base = DiffDrive::new();
        let mut chance = Random::seeded(3);
        for _ in 0..1000 {
            let q = Two::new(chance.within(5e3), chance.within(5e3));
            let near = q + Two::new(chance.within(1.0), chance.within(1.0));
            let again = base.inverse(&base.forward(&q), &near).expect("it is on its path");
            assert!((again - q).amax() < 1e-9, "{q} {again}");
        }
    }

    #[test]
    fn its_frame_moves_as_a_body_that_rolls() {
        // Euler's formula: with equal wheels it goes straight, with opposite ones it turns about A by the arc of a wheel over its lever.
        let base = DiffDrive::new();
        let ahead = base.forward(&Two::new(2.0, 2.0));
        assert!((ahead.translation.x - 2.0 * DiffDrive::WHEEL).abs() < 1e-15);
        let turned = base.forward(&Two::new(-1.0, 1.0));
        let arc = DiffDrive::WHEEL / (0.5 * DiffDrive::TRACK);
        assert!((turned.rotation.angle() - arc).abs() < 1e-12 && turned.translation.x.abs() < 1e-15);
    }

    #[test]
    fn a_pose_beside_its_path_is_refused_with_how_far() {
        let base = DiffDrive::new();
        let beside = base.inverse(&Pose::translation(0.1, 0.02, 0.0), &Two::zeros());
        assert!(
            matches!(beside, Err(NoInverse::NotAttainable { actual, .. }) if (actual - 0.02).abs() < 1e-12)
        );
    }
}
