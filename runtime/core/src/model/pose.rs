//! Poses in space and the orientation coordinates of the field: ZYZ Euler angles, roll, pitch and yaw, and angle-axis vectors.
//!
//! A pose is a [`Pose`]; the three other types hold the orientation alone. All conversions go through
//! the half-angle (quaternion) form, so none of them loses digits near its singularity:
//!
//! ```text
//! R_z(alpha) R_y(beta) R_z(gamma):   w =  cos(beta/2) cos((alpha + gamma)/2)
//!                                    z =  cos(beta/2) sin((alpha + gamma)/2)
//!                                    y =  sin(beta/2) cos((alpha - gamma)/2)
//!                                    x = -sin(beta/2) sin((alpha - gamma)/2)
//!
//! R_z(yaw) R_y(pitch) R_x(roll):     w + y = sqrt(2) cos(pi/4 - pitch/2) cos((yaw - roll)/2)
//!                                    z - x = sqrt(2) cos(pi/4 - pitch/2) sin((yaw - roll)/2)
//!                                    w - y = sqrt(2) sin(pi/4 - pitch/2) cos((yaw + roll)/2)
//!                                    z + x = sqrt(2) sin(pi/4 - pitch/2) sin((yaw + roll)/2)
//! ```

use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI, TAU};

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// A rigid-body transform. `X_AB` is the pose of frame B in frame A; lengths in metres.
pub type Pose = nalgebra::Isometry3<f64>;

/// Sine or cosine of `beta/2` below which `alpha` and `gamma` are not told apart, and of `pi/4 - pitch/2` below which roll and
/// yaw are not: a few units of round-off.
const SINGULAR: f64 = 1e-15;

/// An orientation as ZYZ Euler angles: `R_AB = R_z(alpha) R_y(beta) R_z(gamma)`, turning about the moved axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zyz {
    /// First turn, about z \[rad\]; from a rotation: above -pi, up to pi.
    pub alpha: f64,
    /// Second turn, about the moved y \[rad\]; from a rotation: 0 to pi.
    pub beta: f64,
    /// Third turn, about the moved z \[rad\]; from a rotation: above -pi, up to pi.
    pub gamma: f64,
}

impl Zyz {
    /// The angles of a rotation.
    ///
    /// At the singularities (`beta` 0 or pi, to round-off) `gamma` is 0, as in MRROC++. Near them only the
    /// sum (the difference) of `alpha` and `gamma` is well determined; the angles still give the rotation
    /// back to 1e-14.
    #[must_use]
    pub fn of(rotation: &UnitQuaternion<f64>) -> Self {
        let q = rotation.quaternion();
        let (sine, cosine) = (q.i.hypot(q.j), q.k.hypot(q.w));
        let beta = 2.0 * sine.atan2(cosine);
        let sum = 2.0 * q.k.atan2(q.w);
        let difference = 2.0 * (-q.i).atan2(q.j);
        if sine <= SINGULAR {
            return Self { alpha: wrapped(sum), beta, gamma: 0.0 };
        }
        if cosine <= SINGULAR {
            return Self { alpha: wrapped(difference), beta, gamma: 0.0 };
        }
        Self { alpha: wrapped(0.5 * (sum + difference)), beta, gamma: wrapped(0.5 * (sum - difference)) }
    }

    /// The rotation of the angles, which may have any finite value.
    #[must_use]
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        let (sine, cosine) = (0.5 * self.beta).sin_cos();
        let (sum_sine, sum_cosine) = (0.5 * (self.alpha + self.gamma)).sin_cos();
        let (difference_sine, difference_cosine) = (0.5 * (self.alpha - self.gamma)).sin_cos();
        UnitQuaternion::new_unchecked(Quaternion::new(
            cosine * sum_cosine,
            -sine * difference_sine,
            sine * difference_cosine,
            cosine * sum_sine,
        ))
    }
}

/// An orientation as roll, pitch and yaw, the `rpy` of URDF: turns about the fixed axes x, y and z in this order,
/// `R_AB = R_z(yaw) R_y(pitch) R_x(roll)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rpy {
    /// First turn, about x \[rad\]; from a rotation: above -pi, up to pi.
    pub roll: f64,
    /// Second turn, about the fixed y \[rad\]; from a rotation: -pi/2 to pi/2.
    pub pitch: f64,
    /// Third turn, about the fixed z \[rad\]; from a rotation: above -pi, up to pi.
    pub yaw: f64,
}

impl Rpy {
    /// The angles of a rotation.
    ///
    /// At the singularities (`pitch` -pi/2 or pi/2, to round-off) `roll` is 0. Near them only the sum (the difference) of `roll`
    /// and `yaw` is well determined; the angles still give the rotation back to 1e-14.
    #[must_use]
    pub fn of(rotation: &UnitQuaternion<f64>) -> Self {
        let q = rotation.quaternion();
        // Both are divided by sqrt(2), after which they are the cosine and the sine of `pi/4 - pitch/2`.
        let cosine = (q.w + q.j).hypot(q.k - q.i) * FRAC_1_SQRT_2;
        let sine = (q.w - q.j).hypot(q.k + q.i) * FRAC_1_SQRT_2;
        let pitch = FRAC_PI_2 - 2.0 * sine.atan2(cosine);
        let difference = 2.0 * (q.k - q.i).atan2(q.w + q.j);
        let sum = 2.0 * (q.k + q.i).atan2(q.w - q.j);
        if sine <= SINGULAR {
            return Self { roll: 0.0, pitch, yaw: wrapped(difference) };
        }
        if cosine <= SINGULAR {
            return Self { roll: 0.0, pitch, yaw: wrapped(sum) };
        }
        Self { roll: wrapped(0.5 * (sum - difference)), pitch, yaw: wrapped(0.5 * (sum + difference)) }
    }

    /// The rotation of the angles, which may have any finite value.
    #[must_use]
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_euler_angles(self.roll, self.pitch, self.yaw)
    }
}

/// An orientation as one turn about one axis: the unit axis times the angle \[rad\], zero for no turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleAxis(
    /// Axis times angle \[rad\]; from a rotation: at most pi long.
    pub Vector3<f64>,
);

impl AngleAxis {
    /// The shortest turn of a rotation.
    ///
    /// Tiny angles keep all their digits. At pi the two opposite vectors mean the same rotation: which of
    /// them comes out is decided by round-off.
    #[must_use]
    pub fn of(rotation: &UnitQuaternion<f64>) -> Self {
        let q = rotation.quaternion();
        let axis = if q.w < 0.0 { -q.imag() } else { q.imag() };
        let sine = axis.x.hypot(axis.y).hypot(axis.z);
        let factor = if sine > 0.0 { 2.0 * sine.atan2(q.w.abs()) / sine } else { 2.0 };
        Self(axis * factor)
    }

    /// The rotation of the vector, which may have any finite length.
    #[must_use]
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        let angle = self.angle();
        let (sine, cosine) = (0.5 * angle).sin_cos();
        let factor = if angle > 0.0 { sine / angle } else { 0.5 };
        UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, self.0 * factor))
    }

    /// Length of the turn \[rad\], at least 0.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.0.x.hypot(self.0.y).hypot(self.0.z)
    }
}

/// The same angle above -pi and up to pi, for angles of at most a few turns \[rad\].
fn wrapped(angle: f64) -> f64 {
    if angle > PI {
        angle - TAU
    } else if angle <= -PI {
        angle + TAU
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Rotation3};

    /// Elementary rotations multiplied as matrices: the definition, independent of the half-angle form.
    fn zyz_by_definition(alpha: f64, beta: f64, gamma: f64) -> Matrix3<f64> {
        let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle).into_inner();
        about(Vector3::z_axis(), alpha) * about(Vector3::y_axis(), beta) * about(Vector3::z_axis(), gamma)
    }

    fn matrix(rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
        rotation.to_rotation_matrix().into_inner()
    }

    /// Angles that matter: none, all but none, round, and half a turn less next to nothing.
    const ANGLES: [f64; 17] = [
        0.0,
        1e-300,
        1e-17,
        1e-12,
        1e-8,
        1e-6,
        2.65e-6,
        1e-3,
        0.7,
        PI / 2.0,
        2.9,
        PI - 1e-3,
        PI - 1e-6,
        PI - 1e-8,
        PI - 1e-12,
        PI - 1e-15,
        PI,
    ];

    #[test]
    fn zyz_angles_mean_the_product_of_three_turns() {
        for alpha in [-3.0, -0.4, 0.0, 1.3, 5.0] {
            for beta in ANGLES {
                for gamma in [-7.0, -2.1, 0.0, 0.2, PI] {
                    let error = matrix(&Zyz { alpha, beta, gamma }.rotation())
                        - zyz_by_definition(alpha, beta, gamma);
                    assert!(error.amax() < 3e-15, "{alpha} {beta} {gamma}: {error}");
                }
            }
        }
    }

    #[test]
    fn zyz_angles_give_the_rotation_back_at_and_near_both_singularities() {
        for alpha in [-PI, -3.0, -0.4, 0.0, 1e-9, 1.3, PI] {
            for beta in ANGLES {
                for gamma in [-2.1, -1e-9, 0.0, 0.2, PI] {
                    let rotation = Zyz { alpha, beta, gamma }.rotation();
                    for rotation in [rotation, UnitQuaternion::new_unchecked(-rotation.into_inner())] {
                        let zyz = Zyz::of(&rotation);
                        let error = matrix(&zyz.rotation()) - matrix(&rotation);
                        assert!(error.amax() < 1e-14, "{alpha} {beta} {gamma}: {error}");
                        assert!((zyz.beta - beta).abs() < 2e-15, "{} for {beta}", zyz.beta);
                        assert!(zyz.alpha > -PI && zyz.alpha <= PI && zyz.gamma > -PI && zyz.gamma <= PI);
                    }
                }
            }
        }
    }

    #[test]
    fn zyz_angles_come_back_to_1e_12_away_from_the_singularities() {
        for beta in [1e-3, 0.7, 2.9, PI - 1e-3] {
            let (alpha, gamma) = (-2.5, 1.9);
            let zyz = Zyz::of(&Zyz { alpha, beta, gamma }.rotation());
            assert!((zyz.alpha - alpha).abs() < 1e-12, "{zyz:?}");
            assert!((zyz.gamma - gamma).abs() < 1e-12, "{zyz:?}");
        }
    }

    #[test]
    fn zyz_gamma_is_zero_at_the_singularities() {
        let upright = Zyz::of(&Zyz { alpha: 0.3, beta: 0.0, gamma: 0.5 }.rotation());
        assert_eq!((upright.beta, upright.gamma), (0.0, 0.0));
        assert!((upright.alpha - 0.8).abs() < 1e-15);
        let inverted = Zyz::of(&Zyz { alpha: 0.3, beta: PI, gamma: 0.5 }.rotation());
        assert_eq!((inverted.beta, inverted.gamma), (PI, 0.0));
        assert!((inverted.alpha + 0.2).abs() < 1e-15);
        let turned_over = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
        let zyz = Zyz::of(&turned_over);
        assert_eq!(zyz.gamma, 0.0, "{zyz:?}");
        assert!((zyz.alpha.abs() - PI).abs() < 1e-15, "{zyz:?}");
    }

    /// MRROC++: beta = atan2(hypot(r31, r32), r33), alpha = atan2(r23, r13), gamma = atan2(r32, -r31).
    #[test]
    fn zyz_angles_are_those_of_the_matrix_formulas_where_these_hold() {
        for (alpha, beta, gamma) in [(0.3, 0.9, -2.0), (-2.9, 2.2, 3.1), (1.0, 1e-2, 1.0)] {
            let r = zyz_by_definition(alpha, beta, gamma);
            let zyz = Zyz::of(&UnitQuaternion::from_matrix(&r));
            assert!((zyz.alpha - r[(1, 2)].atan2(r[(0, 2)])).abs() < 1e-12);
            assert!((zyz.beta - r[(2, 0)].hypot(r[(2, 1)]).atan2(r[(2, 2)])).abs() < 1e-12);
            assert!((zyz.gamma - r[(2, 1)].atan2(-r[(2, 0)])).abs() < 1e-12);
        }
    }

    /// Roll, pitch and yaw by URDF's definition: elementary rotations about the fixed axes, multiplied as matrices.
    fn rpy_by_definition(roll: f64, pitch: f64, yaw: f64) -> Matrix3<f64> {
        let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle).into_inner();
        about(Vector3::z_axis(), yaw) * about(Vector3::y_axis(), pitch) * about(Vector3::x_axis(), roll)
    }

    #[test]
    fn roll_pitch_and_yaw_mean_turns_about_the_fixed_axes_x_y_and_z() {
        for roll in [-3.0, -0.4, 0.0, 1.3, 5.0] {
            for pitch in ANGLES {
                for yaw in [-7.0, -2.1, 0.0, 0.2, PI] {
                    let error =
                        matrix(&Rpy { roll, pitch, yaw }.rotation()) - rpy_by_definition(roll, pitch, yaw);
                    assert!(error.amax() < 3e-15, "{roll} {pitch} {yaw}: {error}");
                }
            }
        }
    }

    #[test]
    fn roll_pitch_and_yaw_give_the_rotation_back_at_and_near_both_singularities() {
        for roll in [-PI, -3.0, -0.4, 0.0, 1e-9, 1.3, PI] {
            for from_the_singularity in ANGLES {
                for yaw in [-2.1, -1e-9, 0.0, 0.2, PI] {
                    let pitch = FRAC_PI_2 - from_the_singularity;
                    let rotation = Rpy { roll, pitch, yaw }.rotation();
                    for rotation in [rotation, UnitQuaternion::new_unchecked(-rotation.into_inner())] {
                        let rpy = Rpy::of(&rotation);
                        let error = matrix(&rpy.rotation()) - matrix(&rotation);
                        assert!(error.amax() < 1e-14, "{roll} {pitch} {yaw}: {error}");
                        assert!((rpy.pitch - pitch).abs() < 2e-15, "{} for {pitch}", rpy.pitch);
                        assert!(rpy.roll > -PI && rpy.roll <= PI && rpy.yaw > -PI && rpy.yaw <= PI);
                    }
                }
            }
        }
    }

    #[test]
    fn roll_is_zero_at_the_singularities() {
        // Pitch pi/2: R depends on yaw - roll alone. Pitch -pi/2: on yaw + roll alone.
        let up = Rpy::of(&Rpy { roll: 0.5, pitch: FRAC_PI_2, yaw: 0.3 }.rotation());
        assert_eq!(up.roll, 0.0, "{up:?}");
        assert!((up.yaw + 0.2).abs() < 1e-15 && (up.pitch - FRAC_PI_2).abs() < 1e-15, "{up:?}");
        let down = Rpy::of(&Rpy { roll: 0.5, pitch: -FRAC_PI_2, yaw: 0.3 }.rotation());
        assert_eq!(down.roll, 0.0, "{down:?}");
        assert!((down.yaw - 0.8).abs() < 1e-15 && (down.pitch + FRAC_PI_2).abs() < 1e-15, "{down:?}");
    }

    /// pitch = asin(-r31), roll = atan2(r32, r33), yaw = atan2(r21, r11).
    #[test]
    fn roll_pitch_and_yaw_are_those_of_the_matrix_formulas_where_these_hold() {
        for (roll, pitch, yaw) in [(0.3, 0.9, -2.0), (-2.9, -1.2, 3.1), (1.0, 1e-2, 1.0)] {
            let r = rpy_by_definition(roll, pitch, yaw);
            let rpy = Rpy::of(&UnitQuaternion::from_matrix(&r));
            assert!((rpy.roll - r[(2, 1)].atan2(r[(2, 2)])).abs() < 1e-12);
            assert!((rpy.pitch - (-r[(2, 0)]).asin()).abs() < 1e-12);
            assert!((rpy.yaw - r[(1, 0)].atan2(r[(0, 0)])).abs() < 1e-12);
        }
    }

    #[test]
    fn angle_axis_comes_back_for_every_angle_up_to_half_a_turn() {
        for axis in
            [Vector3::x(), -Vector3::z(), Vector3::new(0.6, -0.48, 0.64), Vector3::new(1e-9, 0.0, 1.0)]
        {
            for angle in ANGLES {
                let turn = AngleAxis(axis * angle);
                let again = AngleAxis::of(&turn.rotation());
                let error = (again.0 - turn.0).norm().min(if angle > PI - 1e-14 {
                    (again.0 + turn.0).norm()
                } else {
                    f64::INFINITY
                });
                assert!(error <= 1e-15 * angle.max(1e-300) * 4.0, "{angle}: {error}");
                let matrix_error = matrix(&again.rotation()) - matrix(&turn.rotation());
                assert!(matrix_error.amax() < 3e-15, "{angle}");
            }
        }
    }

    /// Rodrigues: R = I + sin(t) K + (1 - cos(t)) K^2.
    #[test]
    fn angle_axis_means_the_formula_of_rodrigues() {
        let axis = Vector3::new(0.6, -0.48, 0.64);
        let k = axis.cross_matrix();
        for angle in ANGLES.iter().copied().chain([4.0, 7.0, 100.0]) {
            let half_sine = (0.5 * angle).sin();
            let expected = Matrix3::identity() + k * angle.sin() + k * k * (2.0 * half_sine * half_sine);
            let error = matrix(&AngleAxis(axis * angle).rotation()) - expected;
            assert!(error.amax() < 4e-15, "{angle}: {error}");
        }
    }

    #[test]
    fn angle_axis_of_a_rotation_is_the_shortest_turn_for_both_quaternions() {
        let rotation = AngleAxis(Vector3::new(0.0, 0.0, 5.0)).rotation();
        for rotation in [rotation, UnitQuaternion::new_unchecked(-rotation.into_inner())] {
            let turn = AngleAxis::of(&rotation);
            assert!((turn.0.z - (5.0 - TAU)).abs() < 2e-15, "{turn:?}");
            assert!((turn.angle() - (TAU - 5.0)).abs() < 2e-15);
        }
    }
}
