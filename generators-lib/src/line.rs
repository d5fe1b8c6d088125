//! Straight lines: of the joints, and of the tool.
//!
//! In: two ends and limits. Out: the path over a scalar `s` in 0..=1, and the one profile of `s` that keeps every
//! joint (or translation and rotation alike) within its limits: with `|dq_j|` the distance of joint `j`,
//! `V = min_j V_j / |dq_j|`, `A = min_j A_j / |dq_j|`. Along a line of the tool, the limits' type says which kind of
//! profile that is: [`MotionLimits`].

use crate::profile::{JerkLimits, Profile, ProfileError, ProfileLimits, ProfilePoint, SevenPhase, Trapezoid};
use mrroc::robot::JointVector;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// A straight line in joint space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLine<J> {
    from: J,
    to: J,
}

impl<J: JointVector> JointLine<J> {
    /// The line between two joint vectors [rad or m].
    #[must_use]
    pub fn new(from: J, to: J) -> Self {
        Self { from, to }
    }

    /// Joints at `s` in 0..=1; the ends are met exactly.
    #[must_use]
    pub fn joints(&self, s: f64) -> J {
        if s >= 1.0 { self.to } else { self.from + (self.to - self.from) * s }
    }

    /// The fastest profile of `s` from 0 to 1 within per-joint limits of velocity [rad/s or m/s] and acceleration
    /// [rad/s^2 or m/s^2]. A line without length has a profile of no distance and no duration.
    ///
    /// # Errors
    /// An end that is not finite or a limit that is not positive.
    pub fn profile(&self, velocity: &J, acceleration: &J) -> Result<Trapezoid, ProfileError> {
        let displacement = self.to - self.from;
        unit_profile((0..J::LEN).map(|i| {
            (displacement[i].abs(), ProfileLimits { velocity: velocity[i], acceleration: acceleration[i] })
        }))
    }
}

/// Limits of a tool's motion along a path, whose type decides by which kind of profile it moves: [`ToolLimits`] by a
/// trapezoidal one, [`SmoothToolLimits`] by one with limited jerk.
pub trait MotionLimits: Copy + 'static {
    /// The profile of the scalar `s`.
    type Profile: Profile + 'static;

    /// The fastest profile of `s` from 0 to 1 along a path of this `length` \[m\] and turn `angle` \[rad\], both >= 0,
    /// within the limits of translation and of rotation at once. A path without length and turn has a profile of no
    /// distance and no duration.
    ///
    /// # Errors
    /// A length or an angle that is negative or not finite, or a limit that is out of range.
    fn profile(&self, length: f64, angle: f64) -> Result<Self::Profile, ProfileError>;
}

/// Limits of a tool's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolLimits {
    /// Of translation [m/s], [m/s^2].
    pub translation: ProfileLimits,
    /// Of rotation [rad/s], [rad/s^2].
    pub rotation: ProfileLimits,
}

impl MotionLimits for ToolLimits {
    type Profile = Trapezoid;

    fn profile(&self, length: f64, angle: f64) -> Result<Trapezoid, ProfileError> {
        unit_profile([(length, self.translation), (angle, self.rotation)])
    }
}

/// Limits of a tool's motion, with jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothToolLimits {
    /// Of translation [m/s], [m/s^2], [m/s^3].
    pub translation: JerkLimits,
    /// Of rotation [rad/s], [rad/s^2], [rad/s^3].
    pub rotation: JerkLimits,
}

impl MotionLimits for SmoothToolLimits {
    type Profile = SevenPhase;

    fn profile(&self, length: f64, angle: f64) -> Result<SevenPhase, ProfileError> {
        smooth_unit_profile([(length, self.translation), (angle, self.rotation)])
    }
}

/// A tool at an instant of its motion, seen from the frame W of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPoint {
    /// `X_WE` \[m\].
    pub pose: Isometry3<f64>,
    /// `v_WE`, of the tool's origin [m/s].
    pub velocity: Vector3<f64>,
    /// `w_WE`, angular [rad/s].
    pub turning: Vector3<f64>,
    /// `a_WE`, of the tool's origin [m/s^2].
    pub acceleration: Vector3<f64>,
    /// `alpha_WE`, angular [rad/s^2].
    pub turning_acceleration: Vector3<f64>,
}

/// A straight line of the tool frame: its origin moves linearly, its orientation turns at a constant rate about a
/// constant axis, through the smaller angle (spherical linear interpolation, Shoemake 1985).
///
/// ```text
/// q(s) = q0 exp(s theta u / 2) = q0 cos(s theta / 2) + (q0 u) sin(s theta / 2)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinePath {
    from: Isometry3<f64>,
    to: Isometry3<f64>,
    displacement: Vector3<f64>,
    /// `q0 u`, for the unit axis `u` in the frame of the start.
    across: Quaternion<f64>,
    /// `theta u` in the frame of the path \[rad\].
    turn: Vector3<f64>,
    /// `theta / 2` \[rad\].
    half_angle: f64,
}

impl LinePath {
    /// The line between two poses of the tool in one common frame \[m\]. Half a turn goes about the axis that the
    /// relative quaternion names.
    #[must_use]
    pub fn new(from: Isometry3<f64>, to: Isometry3<f64>) -> Self {
        let displacement = to.translation.vector - from.translation.vector;
        let turn = (from.rotation.inverse() * to.rotation).scaled_axis();
        let axis = turn.try_normalize(0.0).unwrap_or_default();
        let across = from.rotation.into_inner() * Quaternion::from_imag(axis);
        Self { from, to, displacement, across, turn: from.rotation * turn, half_angle: 0.5 * turn.norm() }
    }

    /// Length of the origin's path \[m\].
    #[must_use]
    pub fn length(&self) -> f64 {
        self.displacement.norm()
    }

    /// Angle of the turn \[rad\], 0..=pi.
    #[must_use]
    pub fn angle(&self) -> f64 {
        2.0 * self.half_angle
    }

    /// Pose at `s` in 0..=1; the ends are met exactly.
    #[inline]
    #[must_use]
    pub fn pose(&self, s: f64) -> Isometry3<f64> {
        if s <= 0.0 {
            return self.from;
        }
        if s >= 1.0 {
            return self.to;
        }
        let translation = Translation3::from(self.from.translation.vector + self.displacement * s);
        Isometry3::from_parts(translation, self.rotation(s))
    }

    /// Orientation at `s` in 0..=1; the ends are met exactly.
    #[inline]
    #[must_use]
    pub fn rotation(&self, s: f64) -> UnitQuaternion<f64> {
        if s <= 0.0 {
            return self.from.rotation;
        }
        if s >= 1.0 {
            return self.to.rotation;
        }
        let (sin, cos) = (self.half_angle * s).sin_cos();
        // Of length 1, up to rounding, because both quaternions are, and are perpendicular to each other.
        UnitQuaternion::new_unchecked(self.from.rotation.into_inner() * cos + self.across * sin)
    }

    /// The turn as a vector in the frame of the path \[rad\]: the angular velocity per rate of `s`.
    #[must_use]
    pub const fn turning(&self) -> Vector3<f64> {
        self.turn
    }

    /// Pose, velocity and acceleration where a profile of `s` from 0 to 1 is at `point`.
    #[inline]
    #[must_use]
    pub fn at(&self, point: &ProfilePoint) -> ToolPoint {
        ToolPoint {
            pose: self.pose(point.s),
            velocity: self.displacement * point.v,
            turning: self.turn * point.v,
            acceleration: self.displacement * point.a,
            turning_acceleration: self.turn * point.a,
        }
    }

    /// The fastest profile of `s` from 0 to 1 within `limits` of translation and of rotation at once, of the kind that
    /// goes with them. A line without length and turn has a profile of no distance and no duration.
    ///
    /// # Errors
    /// A pose that is not finite or a limit that is not positive.
    pub fn profile<L: MotionLimits>(&self, limits: L) -> Result<L::Profile, ProfileError> {
        self.check_turn()?;
        limits.profile(self.length(), self.angle())
    }

    /// A turn that is not a number has no angle; it must not pass as none.
    fn check_turn(&self) -> Result<(), ProfileError> {
        let is_finite = |pose: &Isometry3<f64>| pose.rotation.coords.iter().all(|x| x.is_finite());
        if is_finite(&self.from) && is_finite(&self.to) {
            Ok(())
        } else {
            Err(ProfileError::Distance(f64::NAN))
        }
    }
}

/// The jerk-limited profile of `s` in 0..=1 whose every share `distance * s` keeps its limits.
fn smooth_unit_profile(shares: [(f64, JerkLimits); 2]) -> Result<SevenPhase, ProfileError> {
    let mut unit_length = 0.0;
    let mut unit = JerkLimits { velocity: f64::MAX, acceleration: f64::MAX, jerk: f64::MAX };
    for (distance, share) in shares {
        SevenPhase::new(distance, share)?;
        if distance > 0.0 {
            unit_length = 1.0;
            unit.velocity = unit.velocity.min(share.velocity / distance);
            unit.acceleration = unit.acceleration.min(share.acceleration / distance);
            unit.jerk = unit.jerk.min(share.jerk / distance);
        }
    }
    SevenPhase::new(unit_length, if unit_length > 0.0 { unit } else { shares[0].1 })
}

/// The profile of `s` in 0..=1 whose every share `distance * s` keeps its limits.
fn unit_profile(shares: impl IntoIterator<Item = (f64, ProfileLimits)>) -> Result<Trapezoid, ProfileError> {
    let mut unit_length = 0.0;
    let mut limits = ProfileLimits { velocity: f64::INFINITY, acceleration: f64::MAX };
    for (distance, share) in shares {
        Trapezoid::new(distance, share)?;
        if distance > 0.0 {
            unit_length = 1.0;
            limits.velocity = limits.velocity.min(share.velocity / distance);
            limits.acceleration = limits.acceleration.min(share.acceleration / distance);
        }
    }
    Trapezoid::new(unit_length, limits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn limits(velocity: f64, acceleration: f64) -> ProfileLimits {
        ProfileLimits { velocity, acceleration }
    }

    #[test]
    fn the_slowest_joint_sets_the_pace_of_a_joint_line() {
        let line = JointLine::new(Vector2::new(0.0, 1.0), Vector2::new(10.0, 0.0));
        // Joint 0: (10, 2, 1) needs 7 s; joint 1 needs less.
        let profile = line.profile(&Vector2::new(2.0, 5.0), &Vector2::new(1.0, 5.0)).unwrap();
        assert!((profile.duration() - 7.0).abs() < 1e-12);
        assert_eq!(line.joints(1.0), Vector2::new(10.0, 0.0));
        assert_eq!(line.joints(0.5), Vector2::new(5.0, 0.5));
        assert!(line.profile(&Vector2::new(0.0, 5.0), &Vector2::new(1.0, 5.0)).is_err());
    }

    #[test]
    fn a_line_without_length_takes_no_time() {
        let line = LinePath::new(Isometry3::identity(), Isometry3::identity());
        let tool = ToolLimits { translation: limits(1.0, 1.0), rotation: limits(1.0, 1.0) };
        assert_eq!(line.profile(tool).unwrap().duration(), 0.0);
        assert_eq!(line.pose(0.0), Isometry3::identity());
    }

    #[test]
    fn half_a_turn_has_an_axis_and_is_traversed() {
        let to = Isometry3::rotation(Vector3::z() * PI);
        let line = LinePath::new(Isometry3::identity(), to);
        assert!((line.angle() - PI).abs() < 1e-12);
        assert!((line.pose(0.5).rotation.angle() - PI / 2.0).abs() < 1e-12);
    }

    fn poses() -> impl Strategy<Value = Isometry3<f64>> {
        proptest::array::uniform6(-1.5..1.5f64)
            .prop_map(|x| Isometry3::new(Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5])))
    }

    proptest! {
        #[test]
        fn neither_translation_nor_rotation_exceeds_its_limits(from in poses(), to in poses()) {
            let line = LinePath::new(from, to);
            let dt = 2e-3;
            let tool = ToolLimits { translation: limits(0.3, 1.0), rotation: limits(0.5, 2.0) };
            let profile = line.profile(tool).unwrap();
            let pose = |i: i32| line.pose(profile.at(f64::from(i) * dt).s);
            prop_assert!(line.angle() <= PI + 1e-12);
            for i in 0..(profile.duration() / dt) as i32 + 2 {
                let a = pose(i - 1);
                let b = pose(i);
                let c = pose(i + 1);
                let v = (b.translation.vector - a.translation.vector) / dt;
                let dv = (c.translation.vector - b.translation.vector) / dt - v;
                let w = (a.rotation.inverse() * b.rotation).scaled_axis() / dt;
                let dw = (b.rotation.inverse() * c.rotation).scaled_axis() / dt - w;
                prop_assert!(v.norm() <= 0.3 + 1e-9 && dv.norm() <= 1.0 * dt + 1e-9);
                prop_assert!(w.norm() <= 0.5 + 1e-9 && dw.norm() <= 2.0 * dt + 1e-9);
            }
            prop_assert_eq!(line.pose(0.0), from);
            prop_assert_eq!(line.pose(1.0), to);
        }

        #[test]
        fn velocities_and_accelerations_are_the_derivatives_of_the_pose(from in poses(), to in poses(), x in 0.05..0.95f64) {
            let line = LinePath::new(from, to);
            let h = 1e-5;
            let tool = ToolLimits { translation: limits(0.3, 1.0), rotation: limits(0.5, 2.0) };
            let profile = line.profile(tool).unwrap();
            let at = |t: f64| line.at(&profile.at(t));
            let before = at(x * profile.duration() - h);
            let here = at(x * profile.duration());
            let after = at(x * profile.duration() + h);
            let v = (after.pose.translation.vector - before.pose.translation.vector) / (2.0 * h);
            // In the frame of the path: exp(2 h w) q = q'.
            let w = (after.pose.rotation * before.pose.rotation.inverse()).scaled_axis() / (2.0 * h);
            prop_assert!((v - here.velocity).norm() < 1e-5 && (w - here.turning).norm() < 2e-5);
            // Constant between the corners of the trapezoid, and nowhere above the limits.
            prop_assert!(here.acceleration.norm() <= 1.0 + 1e-12 && here.turning_acceleration.norm() <= 2.0 + 1e-12);
            if (before.acceleration - after.acceleration).norm() < 1e-12 {
                prop_assert!(((after.velocity - before.velocity) / (2.0 * h) - here.acceleration).norm() < 1e-8);
                prop_assert!(((after.turning - before.turning) / (2.0 * h) - here.turning_acceleration).norm() < 1e-8);
            }
            prop_assert!((here.pose.rotation.coords.norm() - 1.0).abs() < 1e-15);
        }

        #[test]
        fn orientations_agree_with_nalgebra_slerp(from in poses(), to in poses(), s in 0.0..1.0f64) {
            let expected = from.rotation.try_slerp(&to.rotation, s, 1e-9);
            prop_assume!(expected.is_some());
            prop_assert!(LinePath::new(from, to).pose(s).rotation.angle_to(&expected.unwrap()) < 1e-7);
        }
    }
}
