//! Forces and torques as one value: what a wrist sensor reads, what a controller keeps within bounds.

use core::ops::{Add, Mul, Neg, Sub};

use nalgebra::Vector3;

use crate::model::payload::Payload;
use crate::model::pose::Pose;
use crate::model::shape::Shape;
use crate::model::wire::{BadWords, Wire};

/// A force and a torque, `F_E`: acting at the origin of a frame E and written in its axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Force \[N\].
    pub force: Vector3<f64>,
    /// Torque about the origin [N m].
    pub torque: Vector3<f64>,
}

impl Wrench {
    /// A force \[N\] and a torque [N m].
    #[must_use]
    pub const fn new(force: Vector3<f64>, torque: Vector3<f64>) -> Self {
        Wrench { force, torque }
    }

    /// `F_A` of `F_B`, where `self` acts at the frame B and `X_AB` is its pose in A: the same load on a rigid body.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn moved(self, X_AB: &Pose) -> Wrench {
        let force = X_AB.rotation * self.force;
        Wrench { force, torque: X_AB.rotation * self.torque + X_AB.translation.vector.cross(&force) }
    }

    /// Whether no number is NaN or infinite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.force.iter().chain(self.torque.iter()).all(|x| x.is_finite())
    }
}

impl Add for Wrench {
    type Output = Wrench;
    #[inline]
    fn add(self, other: Wrench) -> Wrench {
        Wrench { force: self.force + other.force, torque: self.torque + other.torque }
    }
}

impl Sub for Wrench {
    type Output = Wrench;
    #[inline]
    fn sub(self, other: Wrench) -> Wrench {
        Wrench { force: self.force - other.force, torque: self.torque - other.torque }
    }
}

impl Neg for Wrench {
    type Output = Wrench;
    #[inline]
    fn neg(self) -> Wrench {
        Wrench { force: -self.force, torque: -self.torque }
    }
}

impl Mul<f64> for Wrench {
    type Output = Wrench;
    #[inline]
    fn mul(self, factor: f64) -> Wrench {
        Wrench { force: self.force * factor, torque: self.torque * factor }
    }
}

impl Wire for Wrench {
    const LEN: usize = 6;
    const LAYOUT: u64 = crate::model::wire::layout_hash(0, "mrroc::pose::Wrench");
    const SHAPE: &'static Shape =
        &Shape::Fields(&[("force", Vector3::<f64>::SHAPE), ("torque", Vector3::<f64>::SHAPE)]);

    fn put(&self, words: &mut [u64]) {
        self.force.put(words);
        self.torque.put(&mut words[3..]);
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..Self::LEN).ok_or(BadWords)?;
        Ok(Wrench { force: Wire::get(words)?, torque: Wire::get(&words[3..])? })
    }
}

impl Payload for Wrench {
    const NAME: &'static str = "Wrench";
    const TIGHT: bool = true;
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    #[test]
    fn a_moved_wrench_does_the_same_work_on_every_twist_of_the_body() {
        // Virtual work: F_A . V_A = F_B . V_B, with the twist of B's origin v_B = v_A + w x p, turned into B.
        let pose = Pose::from_parts(
            nalgebra::Translation3::new(0.3, -0.2, 0.5),
            UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0),
        );
        let wrench = Wrench::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.4, 0.5, -0.6));
        let moved = wrench.moved(&pose);
        for i in 0..6 {
            let unit = |from| Vector3::from_fn(|j, _| if i == from + j { 1.0 } else { 0.0 });
            let (v_a, w_a) = (unit(0), unit(3));
            let v_b = pose.rotation.inverse() * (v_a + w_a.cross(&pose.translation.vector));
            let w_b = pose.rotation.inverse() * w_a;
            let (work_a, work_b) = (
                moved.force.dot(&v_a) + moved.torque.dot(&w_a),
                wrench.force.dot(&v_b) + wrench.torque.dot(&w_b),
            );
            assert!((work_a - work_b).abs() < 1e-14, "{work_a} and {work_b}");
        }
    }
}
