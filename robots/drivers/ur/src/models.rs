//! The arms of Universal Robots: kinematics, limits, and what may be asked of them.
//!
//! In: a model. Out: its arm, a [`Serial`] of six joints whose inverse kinematics is in closed form. That of one arm with its
//! [`Calibration`](crate::Calibration) is [`UrModel::calibrated`].

use core::f64::consts::{FRAC_PI_2, TAU};
use core::fmt::Write;

use mrroc::pose::Pose;
use mrroc_robots::{Serial, Six, UrdfError};
use nalgebra::{Translation3, UnitQuaternion};

/// Joints of an arm.
pub const JOINTS: usize = 6;

/// Time in which every joint could come to its velocity limit \[s\]: this says what the accelerations are (assumed, for UR
/// publishes none).
const RISE: f64 = 0.35;

/// A model of Universal Robots.
///
/// Denavit-Hartenberg parameters \[m\] of UR's published table (nominal: every arm has a calibration of its own, which differs by
/// up to some millimetres), in `R_z(q) T_z(d) T_x(a) R_x(alpha)` with alpha = 90°, 0, 0, 90°, -90°, 0. All joints turn by
/// 360° in either direction. Velocity limits are those of UR's manuals. The accelerations are a choice: every joint comes to its
/// velocity limit in 0.35 s.
///
/// | model | d1 | a2 | a3 | d4 | d5 | d6 | velocities [°/s] |
/// |---|---|---|---|---|---|---|---|
/// | UR3e | 0.15185 | -0.24355 | -0.2132 | 0.13105 | 0.08535 | 0.0921 | 180, 180, 180, 360, 360, 360 |
/// | UR5e | 0.1625 | -0.425 | -0.3922 | 0.1333 | 0.0997 | 0.0996 | 180 |
/// | UR10e | 0.1807 | -0.6127 | -0.57155 | 0.17415 | 0.11985 | 0.11655 | 120, 120, 180, 180, 180, 180 |
/// | UR16e | 0.1807 | -0.4784 | -0.36 | 0.17415 | 0.11985 | 0.11655 | 120, 120, 180, 180, 180, 180 |
/// | UR20 | 0.2363 | -0.8620 | -0.7287 | 0.2010 | 0.1593 | 0.1543 | 120, 120, 150, 210, 210, 210 |
/// | UR30 | 0.2363 | -0.6370 | -0.5037 | 0.2010 | 0.1593 | 0.1543 | 120, 120, 150, 210, 210, 210 |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names of the arms")]
pub enum UrModel {
    Ur3e,
    Ur5e,
    Ur10e,
    Ur16e,
    Ur20,
    Ur30,
}

/// What the table says of a model.
struct Row {
    d1: f64,
    a2: f64,
    a3: f64,
    d4: f64,
    d5: f64,
    d6: f64,
    /// [°/s]
    velocities: [f64; JOINTS],
    /// Largest torques of the joints [N m], by UR's list.
    efforts: [f64; JOINTS],
}

impl UrModel {
    /// All models.
    pub const ALL: [UrModel; 6] =
        [UrModel::Ur3e, UrModel::Ur5e, UrModel::Ur10e, UrModel::Ur16e, UrModel::Ur20, UrModel::Ur30];

    /// As `cell.toml` writes it.
    #[must_use]
    pub const fn kind(self) -> &'static str {
        match self {
            UrModel::Ur3e => "ur3e",
            UrModel::Ur5e => "ur5e",
            UrModel::Ur10e => "ur10e",
            UrModel::Ur16e => "ur16e",
            UrModel::Ur20 => "ur20",
            UrModel::Ur30 => "ur30",
        }
    }

    /// The largest payload, by UR's data sheets \[kg\].
    #[must_use]
    pub const fn payload(self) -> f64 {
        match self {
            UrModel::Ur3e => 3.0,
            UrModel::Ur5e => 5.0,
            UrModel::Ur10e => 12.5,
            UrModel::Ur16e => 16.0,
            UrModel::Ur20 => 20.0,
            UrModel::Ur30 => 30.0,
        }
    }

    const fn row(self) -> Row {
        const LARGE: [f64; JOINTS] = [120.0, 120.0, 180.0, 180.0, 180.0, 180.0];
        const LARGE_EFFORTS: [f64; JOINTS] = [330.0, 330.0, 150.0, 56.0, 56.0, 56.0];
        const LARGEST: [f64; JOINTS] = [120.0, 120.0, 150.0, 210.0, 210.0, 210.0];
        const LARGEST_EFFORTS: [f64; JOINTS] = [738.0, 738.0, 433.0, 107.0, 107.0, 107.0];
        match self {
            UrModel::Ur3e => Row {
                d1: 0.15185,
                a2: -0.24355,
                a3: -0.2132,
                d4: 0.13105,
                d5: 0.08535,
                d6: 0.0921,
                velocities: [180.0, 180.0, 180.0, 360.0, 360.0, 360.0],
                efforts: [56.0, 56.0, 28.0, 12.0, 12.0, 12.0],
            },
            UrModel::Ur5e => Row {
                d1: 0.1625,
                a2: -0.425,
                a3: -0.3922,
                d4: 0.1333,
                d5: 0.0997,
                d6: 0.0996,
                velocities: [180.0; JOINTS],
                efforts: [150.0, 150.0, 150.0, 28.0, 28.0, 28.0],
            },
            UrModel::Ur10e => Row {
                d1: 0.1807,
                a2: -0.6127,
                a3: -0.57155,
                d4: 0.17415,
                d5: 0.11985,
                d6: 0.11655,
                velocities: LARGE,
                efforts: LARGE_EFFORTS,
            },
            UrModel::Ur16e => Row {
                d1: 0.1807,
                a2: -0.4784,
                a3: -0.36,
                d4: 0.17415,
                d5: 0.11985,
                d6: 0.11655,
                velocities: LARGE,
                efforts: LARGE_EFFORTS,
            },
            UrModel::Ur20 => Row {
                d1: 0.2363,
                a2: -0.8620,
                a3: -0.7287,
                d4: 0.2010,
                d5: 0.1593,
                d6: 0.1543,
                velocities: LARGEST,
                efforts: LARGEST_EFFORTS,
            },
            UrModel::Ur30 => Row {
                d1: 0.2363,
                a2: -0.6370,
                a3: -0.5037,
                d4: 0.2010,
                d5: 0.1593,
                d6: 0.1543,
                velocities: LARGEST,
                efforts: LARGEST_EFFORTS,
            },
        }
    }

    /// Velocity limits of the joints [rad/s].
    #[must_use]
    pub fn velocities(self) -> Six {
        Six::from(self.row().velocities.map(f64::to_radians))
    }

    /// Acceleration limits of the joints [rad/s²] (assumed).
    #[must_use]
    pub fn accelerations(self) -> Six {
        self.velocities() / RISE
    }

    /// The arm with its base at `X_WB` in the world. Its base frame is that of UR's own poses (`actual_TCP_pose`, the frame
    /// "Base" of the pendant), with z along joint 1.
    ///
    /// ```
    /// use mrroc::robot::Robot;
    /// use mrroc_robots::Six;
    /// use mrroc_ur::UrModel;
    ///
    /// let arm = UrModel::Ur5e.arm(mrroc::pose::Pose::identity())?;
    /// assert!(arm.is_closed_form());
    /// // Stretched out along -x: a2 + a3, and d5 below joint 2.
    /// let p = arm.forward(&Six::zeros()).translation.vector;
    /// assert!((p.x + 0.8172).abs() < 1e-12 && (p.z - (0.1625 - 0.0997)).abs() < 1e-12);
    /// # Ok::<(), mrroc_robots::UrdfError>(())
    /// ```
    ///
    /// # Errors
    /// None for these models: what the URDF of an arm may be refused for.
    #[allow(non_snake_case)]
    pub fn arm(self, X_WB: Pose) -> Result<Serial<JOINTS>, UrdfError> {
        let urdf = self.urdf();
        Ok(Serial::from_urdf(&urdf, "base", "tool0")?
            .with_acceleration(self.accelerations())?
            .with_base(X_WB))
    }

    /// The arm as a URDF, with masses left out. Angles have all digits, so that it is recognised as one with a closed form.
    #[must_use]
    pub fn urdf(self) -> String {
        self.urdf_of(&self.origins())
    }

    /// d1, a2, a3, d4, d5, d6 \[m\].
    pub(crate) const fn dimensions(self) -> [f64; JOINTS] {
        let Row { d1, a2, a3, d4, d5, d6, .. } = self.row();
        [d1, a2, a3, d4, d5, d6]
    }

    /// Where each joint is in the one before \[m\], and how it is turned there (roll, pitch, yaw) \[rad\]; the flange last.
    fn origins(self) -> [Origin; JOINTS + 1] {
        let [d1, a2, a3, d4, d5, d6] = self.dimensions();
        [
            ([0.0, 0.0, d1], [0.0; 3]),
            ([0.0, 0.0, 0.0], [FRAC_PI_2, 0.0, 0.0]),
            ([a2, 0.0, 0.0], [0.0; 3]),
            ([a3, 0.0, d4], [0.0; 3]),
            ([0.0, -d5, 0.0], [FRAC_PI_2, 0.0, 0.0]),
            ([0.0, d6, 0.0], [-FRAC_PI_2, 0.0, 0.0]),
            ([0.0; 3], [0.0; 3]),
        ]
    }

    /// The frames of the joints in the base where all joints are at 0, z along their axes.
    pub(crate) fn joint_frames(self) -> [Pose; JOINTS] {
        let mut frame = Pose::identity();
        let origins = self.origins();
        core::array::from_fn(|i| {
            let ([x, y, z], [roll, pitch, yaw]) = origins[i];
            let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            frame *= Pose::from_parts(Translation3::new(x, y, z), rotation);
            frame
        })
    }

    /// The arm as a URDF whose joints, and whose flange, are in the one before as these say.
    pub(crate) fn urdf_of(self, origins: &[Origin; JOINTS + 1]) -> String {
        let Row { velocities, efforts, .. } = self.row();
        let names = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"];
        let mut urdf = format!("<robot name=\"{}\">\n  <link name=\"base\"/>\n", self.kind());
        let mut parent = "base";
        let origin = |([x, y, z], [roll, pitch, yaw]): Origin| {
            format!("<origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>")
        };
        for (i, name) in names.iter().enumerate() {
            let (velocity, effort) = (velocities[i].to_radians(), efforts[i]);
            // Writing into a text does not fail.
            let _ = write!(
                urdf,
                "  <link name=\"{name}\"/>\n  <joint name=\"{name}_joint\" type=\"revolute\">\n    \
                 {}\n    <parent link=\"{parent}\"/>\n    \
                 <child link=\"{name}\"/>\n    <axis xyz=\"0 0 1\"/>\n    <limit lower=\"{}\" upper=\"{TAU}\" \
                 effort=\"{effort}\" velocity=\"{velocity}\"/>\n  </joint>\n",
                origin(origins[i]),
                -TAU
            );
            parent = name;
        }
        let _ = write!(
            urdf,
            "  <link name=\"tool0\"/>\n  <joint name=\"flange\" type=\"fixed\">\n    {}\n    \
             <parent link=\"wrist_3\"/>\n    <child link=\"tool0\"/>\n  </joint>\n</robot>\n",
            origin(origins[JOINTS])
        );
        urdf
    }
}

/// Where a joint is in the one before \[m\], and how it is turned there: roll, pitch, yaw \[rad\].
pub(crate) type Origin = ([f64; 3], [f64; 3]);

#[cfg(test)]
mod tests {
    use mrroc::robot::{Load, Robot, Tool};
    use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

    use super::*;

    fn chain(model: UrModel, q: &Six) -> Isometry3<f64> {
        let Row { d1, a2, a3, d4, d5, d6, .. } = model.row();
        let table = [
            (0.0, d1, FRAC_PI_2),
            (a2, 0.0, 0.0),
            (a3, 0.0, 0.0),
            (0.0, d4, FRAC_PI_2),
            (0.0, d5, -FRAC_PI_2),
            (0.0, d6, 0.0),
        ];
        table.iter().zip(q.iter()).fold(Isometry3::identity(), |pose, ((a, d, alpha), q)| {
            let turn = |axis: Vector3<f64>, angle: f64| UnitQuaternion::from_scaled_axis(axis * angle);
            pose * turn(Vector3::z(), *q) * Translation3::new(*a, 0.0, *d) * turn(Vector3::x(), *alpha)
        })
    }

    #[test]
    fn every_arm_is_read_back_from_the_urdf_that_it_is_exported_as() {
        let tool = Tool { frame: Pose::translation(0.0, 0.1, 0.2), load: Load::NONE };
        for model in UrModel::ALL {
            let arm = model.arm(Pose::translation(0.1, 0.2, 0.3)).expect("an arm");
            let urdf = arm.urdf("arm", &tool).expect("it has a URDF");
            let read = Serial::<JOINTS>::from_urdf(&urdf, "world", "tool").expect("a chain");
            let read = read.with_acceleration(model.accelerations()).expect("an arm");
            let q = Six::new(0.1, -1.2, 1.3, -0.4, 1.5, 0.6);
            let off = read.forward(&q).inverse() * (arm.forward(&q) * tool.frame);
            assert!(off.translation.vector.norm() < 1e-12 && off.rotation.angle() < 1e-7, "{model:?}: {off}");
            assert_eq!(read.limits().upper, arm.limits().upper);
        }
    }

    #[test]
    fn every_arm_has_the_poses_of_its_denavit_hartenberg_parameters_and_a_closed_form() {
        for model in UrModel::ALL {
            let arm = model.arm(Pose::identity()).expect("an arm");
            assert!(arm.is_closed_form(), "{model:?}");
            for k in 0..50 {
                let q = Six::from_fn(|i, _| 2.9 * f64::sin(f64::from(k) * 1.7 + i as f64 * 2.3));
                let expected = chain(model, &q);
                let pose = arm.forward(&q);
                let off = (pose.translation.vector - expected.translation.vector).norm();
                let turned = (pose.rotation.inverse() * expected.rotation).angle();
                assert!(off < 1e-12 && turned < 1e-7, "{model:?}: {off} m, {turned} rad");
                let found = arm.inverse(&pose, &q).expect("it is there");
                assert!((found - q).amax() < 1e-6, "{model:?} {q} {found}");
            }
        }
    }
}
