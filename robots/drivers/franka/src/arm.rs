//! The arm: kinematics and limits of a Franka Research 3.

use mrroc::pose::Pose;
use mrroc::robot::{CoupledLimit, JointKind, Limits, NoInverse, Robot, Tool};
use mrroc_robots::{Driven, Jacobian, Kinematics, MotorData, MotorLimits, Serial, Shafts, UrdfError};
use nalgebra::{SVector, Vector3};

use crate::inverse::{self, ELBOW, FLANGE, FOREARM, SHOULDER, UPPER_ARM, WRIST};
use crate::limits::{self, POSITIONS};
use crate::message::JOINTS;
use crate::rejoining::Joints;

/// Greatest acceleration that is demanded of a joint [rad/s²]: half of what the robot takes. The rest is for the return
/// after lost answers, and for a clock of the cell that is faster than the robot's.
const ACCELERATION: f64 = 5.0;

/// Greatest speed that is demanded of a joint [rad/s]: so a stop takes at most 0.6 s. The wrist's own limits are higher.
const SPEED: f64 = 2.62;

/// Sine of joint 2 below which the shoulder is near its singularity.
const SHOULDER_SINGULAR: f64 = 0.02;

/// A Franka Research 3, from its base to its flange.
///
/// **Limits** are those of libfranka's `rate_limiting.h`: positions, and speeds that fall towards the ends of the range
/// ([`velocities`](crate::velocities)). Of the wrist's speeds at most 2.62 rad/s
/// are demanded, and of the acceleration of 10 rad/s² half. The jerk of 5000 rad/s³ is
/// kept by the drives, not by demands.
///
/// **Inverse kinematics** is in closed form, with joint 7 as the redundancy: it stays as it is unless a demand says otherwise
/// (`Demand::with_redundancy`, \[rad\]), so a closed path of the flange is a closed path of the joints.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Fr3 {
    chain: Serial<JOINTS>,
    limits: Limits<Joints>,
    X_BW: Pose,
}

/// The joints by libfranka's Denavit-Hartenberg parameters, as a chain from `base` to `flange`.
fn urdf() -> String {
    const QUARTER: f64 = core::f64::consts::FRAC_PI_2;
    /// Where each joint is in the one before \[m\], and how far that is turned about its x \[rad\].
    const ORIGINS: [([f64; 3], f64); JOINTS] = [
        ([0.0, 0.0, SHOULDER], 0.0),
        ([0.0, 0.0, 0.0], -QUARTER),
        ([0.0, -UPPER_ARM, 0.0], QUARTER),
        ([ELBOW, 0.0, 0.0], QUARTER),
        ([-ELBOW, FOREARM, 0.0], -QUARTER),
        ([0.0, 0.0, 0.0], QUARTER),
        ([WRIST, 0.0, 0.0], QUARTER),
    ];
    /// Greatest torques [N m].
    const EFFORTS: [f64; JOINTS] = [87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0];
    let mut text = String::from(r#"<robot name="fr3"><link name="link0"/>"#);
    for (i, ([x, y, z], roll)) in ORIGINS.into_iter().enumerate() {
        let (n, (lower, upper)) = (i + 1, POSITIONS[i]);
        let (effort, speed) = (EFFORTS[i], limits::speed(i).min(SPEED));
        text += &format!(
            r#"<link name="link{n}"/><joint name="joint{n}" type="revolute"><parent link="link{i}"/><child link="link{n}"/>
            <origin xyz="{x} {y} {z}" rpy="{roll} 0 0"/><axis xyz="0 0 1"/>
            <limit lower="{lower}" upper="{upper}" velocity="{speed}" effort="{effort}"/></joint>"#
        );
    }
    text + &format!(
        r#"<link name="flange"/><joint name="flange" type="fixed"><parent link="link7"/><child link="flange"/>
        <origin xyz="0 0 {FLANGE}"/></joint></robot>"#
    )
}

impl Fr3 {
    /// With its base at the world's origin.
    #[must_use]
    pub fn new() -> Fr3 {
        let described = |()| -> Result<Serial<JOINTS>, UrdfError> {
            Serial::from_urdf(&urdf(), "link0", "flange")?.with_acceleration(Joints::repeat(ACCELERATION))
        };
        let chain = described(()).expect("the chain is always the same, and tests read it");
        let limits = *chain.limits();
        Fr3 { chain, limits, X_BW: Pose::identity() }
    }

    /// With its base at this pose in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_base(mut self, X_WB: Pose) -> Fr3 {
        self.chain = self.chain.with_base(X_WB);
        self.X_BW = X_WB.inverse();
        self
    }
}

impl Default for Fr3 {
    fn default() -> Fr3 {
        Fr3::new()
    }
}

impl Robot for Fr3 {
    const KIND: &'static str = "fr3";

    type Joints = Joints;

    fn joint(&self, i: usize) -> JointKind {
        self.chain.joint(i)
    }

    fn limits(&self) -> &Limits<Joints> {
        &self.limits
    }

    fn coupled_limits(&self) -> Vec<String> {
        vec![
            "velocities become lower towards both ends of each joint's range, as the robot's own limits do"
                .to_owned(),
        ]
    }

    fn check_coupled(&self, from: &Joints, to: &Joints, duration: f64) -> Result<(), CoupledLimit> {
        limits::check_speed(from, to, duration)
    }

    /// Beside 0 of joint 2 joints 1 and 3 turn about nearly one axis.
    fn near_singularity(&self, q: &Joints) -> Option<&'static str> {
        (q[1].sin().abs() < SHOULDER_SINGULAR).then_some("near the shoulder singularity")
    }

    fn forward(&self, q: &Joints) -> Pose {
        self.chain.forward(q)
    }

    fn frames(&self, q: &Joints, visit: &mut dyn FnMut(&Pose)) {
        self.chain.frames(q, visit);
    }

    fn capsules_of_links(&self, q: &Joints, visit: &mut dyn FnMut([Vector3<f64>; 2], f64)) {
        self.chain.capsules_of_links(q, visit);
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Joints) -> Result<Joints, NoInverse> {
        self.inverse_at(X_WF, near[6], near)
    }

    /// The solution nearest to `near` with joint 7 at this position \[rad\].
    #[allow(non_snake_case)]
    fn inverse_at(&self, X_WF: &Pose, redundancy: f64, near: &Joints) -> Result<Joints, NoInverse> {
        let mut best = (f64::INFINITY, *near);
        inverse::solutions(&(self.X_BW * *X_WF), redundancy, near, &mut |q| {
            let distance = (q - near).norm_squared();
            if distance < best.0 {
                best = (distance, *q);
            }
        })?;
        Ok(best.1)
    }

    fn urdf(&self, name: &str, tool: &Tool) -> Option<String> {
        self.chain.urdf(name, tool)
    }
}

impl Kinematics<JOINTS> for Fr3 {
    fn reach(&self) -> f64 {
        self.chain.reach()
    }

    fn jacobian(&self, q: &Joints) -> Jacobian<JOINTS> {
        self.chain.jacobian(q)
    }

    /// All solutions with joint 7 as in `near`, at most eight.
    #[allow(non_snake_case)]
    fn solutions(&self, X_WF: &Pose, near: &Joints, visit: &mut dyn FnMut(&Joints)) -> Result<(), NoInverse> {
        inverse::solutions(&(self.X_BW * *X_WF), near[6], near, visit)
    }
}

impl Driven<JOINTS> for Fr3 {
    fn motor_data(&self) -> &[MotorData; JOINTS] {
        self.chain.motor_data()
    }

    fn motor_limits(&self) -> &MotorLimits<JOINTS> {
        self.chain.motor_limits()
    }

    fn motors(&self, q: &Joints) -> SVector<f64, JOINTS> {
        self.chain.motors(q)
    }

    fn shafts(&self, angles: &SVector<f64, JOINTS>, speeds: &SVector<f64, JOINTS>) -> Shafts<JOINTS> {
        self.chain.shafts(angles, speeds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Joints spread evenly over the range.
    fn drawn(number: u32) -> Joints {
        const PRIMES: [f64; JOINTS] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0];
        Joints::from_fn(|i, _| {
            let (lower, upper) = POSITIONS[i];
            lower + (upper - lower) * (f64::from(number) * PRIMES[i].sqrt()).fract()
        })
    }

    #[test]
    fn it_is_read_back_from_the_urdf_that_it_is_exported_as() {
        let tool = Tool { frame: Pose::translation(0.0, 0.1, 0.2), load: mrroc::robot::Load::NONE };
        let arm = Fr3::new().with_base(Pose::translation(0.1, 0.2, 0.3));
        let urdf = arm.urdf("arm", &tool).expect("it has a URDF");
        let read = Serial::<JOINTS>::from_urdf(&urdf, "world", "tool").expect("a chain");
        let read = read.with_acceleration(Joints::repeat(ACCELERATION)).expect("an arm");
        for number in 0..10 {
            let q = drawn(number);
            let off = read.forward(&q).inverse() * (arm.forward(&q) * tool.frame);
            assert!(off.translation.vector.norm() < 1e-12 && off.rotation.angle() < 1e-7, "{off}");
        }
    }

    #[test]
    fn the_flange_is_where_franka_s_table_puts_it() {
        // Stretched upwards: 0.333 + 0.316 + 0.384 - 0.107 m above the base, 0.088 m before it.
        let up = Fr3::new().forward(&Joints::zeros());
        assert!((up.translation.vector - Vector3::new(0.088, 0.0, 0.926)).norm() < 1e-12, "{up}");
        // As the product of the table's rows in Craig's convention: T(alpha) T(a) R(theta) T(d).
        let rows = [
            (0.0, 0.0, 0.333),
            (0.0, -1.0, 0.0),
            (0.0, 1.0, 0.316),
            (0.0825, 1.0, 0.0),
            (-0.0825, -1.0, 0.384),
            (0.0, 1.0, 0.0),
            (0.088, 1.0, 0.0),
        ];
        for number in 1..50 {
            let q = drawn(number);
            let mut pose = Pose::identity();
            for (i, (a, quarters, d)) in rows.into_iter().enumerate() {
                pose *= Pose::rotation(Vector3::x() * (quarters * core::f64::consts::FRAC_PI_2));
                pose *= Pose::translation(a, 0.0, 0.0);
                pose *= Pose::rotation(Vector3::z() * q[i]) * Pose::translation(0.0, 0.0, d);
            }
            pose *= Pose::translation(0.0, 0.0, 0.107);
            let here = Fr3::new().forward(&q);
            assert!((here.translation.vector - pose.translation.vector).norm() < 1e-12, "{number}");
            assert!(here.rotation.angle_to(&pose.rotation) < 1e-7, "{number}");
        }
    }

    #[test]
    #[allow(non_snake_case)]
    fn every_solution_has_the_pose_and_one_of_them_is_where_it_came_from() {
        let arm = Fr3::new()
            .with_base(Pose::translation(0.3, -0.2, 0.1) * Pose::rotation(Vector3::new(0.2, 0.5, -1.0)));
        for number in 1..2000 {
            let q = drawn(number);
            let X_WF = arm.forward(&q);
            let (mut count, mut nearest) = (0, f64::INFINITY);
            arm.solutions(&X_WF, &q, &mut |solution| {
                let pose = arm.forward(solution);
                let off = (pose.translation.vector - X_WF.translation.vector).norm();
                assert!(off < 1e-9, "{number}: {off} m off");
                assert!(pose.rotation.angle_to(&X_WF.rotation) < 1e-6, "{number}: turned");
                assert_eq!(solution[6], q[6]);
                (count, nearest) = (count + 1, nearest.min((solution - q).amax()));
            })
            .expect("a solution");
            assert!((2..=8).contains(&count) && count % 2 == 0, "{number}: {count} solutions");
            assert!(nearest < 1e-6, "{number}: {nearest} rad");
            assert!((arm.inverse(&X_WF, &q).expect("a solution") - q).amax() < 1e-6, "{number}");
        }
    }

    #[test]
    #[allow(non_snake_case)]
    fn what_is_out_of_reach_is_told_and_joint_7_moves_the_elbow_alone() {
        let arm = Fr3::new();
        let q = Joints::from([0.1, -0.4, 0.2, -1.9, 0.3, 1.8, 0.6]);
        let far = Pose::translation(1.5, 0.0, 0.0);
        assert!(
            matches!(arm.inverse(&far, &q), Err(NoInverse::OutOfReach { max, .. }) if (max - 0.7196).abs() < 1e-3)
        );
        let X_WF = arm.forward(&q);
        let mut near = q;
        for step in 1..60 {
            let redundancy = 0.6 + 0.01 * f64::from(step);
            let moved = arm.inverse_at(&X_WF, redundancy, &near).expect("a solution");
            assert!((moved - near).amax() < 0.05, "{step}: it jumps");
            assert!((arm.forward(&moved).translation.vector - X_WF.translation.vector).norm() < 1e-9);
            near = moved;
        }
        // And back: the same joints.
        for step in (0..60).rev() {
            near = arm.inverse_at(&X_WF, 0.6 + 0.01 * f64::from(step), &near).expect("a solution");
        }
        assert!((near - q).amax() < 1e-9, "{near}");
    }
}
