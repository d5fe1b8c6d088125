//! Where the axes and bodies of a tree are at given joint positions.
//!
//! All along the axes of the world, from the origin of the base: a spatial vector is then the same for every body, and what
//! a joint adds is added without any change of frame.

use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use nalgebra::{Matrix3, Rotation3, SVector, Vector3};

use super::tree::{Stage, Tree};

/// The most segments of a tree.
pub(super) const MOST: usize = Tree::<1>::MOST;

/// A spatial vector at the base's origin: of a motion the angular part and the velocity of what is at the origin; of a force
/// the torque about the origin and the force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spatial {
    pub(super) angular: Vector3<f64>,
    pub(super) linear: Vector3<f64>,
}

impl Spatial {
    pub(super) const ZERO: Self =
        Self { angular: Vector3::new(0.0, 0.0, 0.0), linear: Vector3::new(0.0, 0.0, 0.0) };

    /// The power of a force in a motion.
    pub(super) fn dot(&self, force: &Self) -> f64 {
        self.angular.dot(&force.angular) + self.linear.dot(&force.linear)
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        Self { angular: self.angular + other.angular, linear: self.linear + other.linear }
    }

    pub(super) fn times(&self, factor: f64) -> Self {
        Self { angular: self.angular * factor, linear: self.linear * factor }
    }

    /// How a motion vector that moves with `self` changes.
    pub(super) fn cross(&self, motion: &Self) -> Self {
        Self {
            angular: self.angular.cross(&motion.angular),
            linear: self.angular.cross(&motion.linear) + self.linear.cross(&motion.angular),
        }
    }

    /// How a force vector that moves with `self` changes.
    pub(super) fn cross_force(&self, force: &Self) -> Self {
        Self {
            angular: self.angular.cross(&force.angular) + self.linear.cross(&force.linear),
            linear: self.angular.cross(&force.linear),
        }
    }
}

/// A body's inertia: mass \[kg\], centre from the base's origin \[m\], inertia about the centre [kg m²].
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) mass: f64,
    pub(super) centre: Vector3<f64>,
    pub(super) inertia: Matrix3<f64>,
}

impl Placed {
    /// Momentum of the body in a motion; or the force that a spatial acceleration takes at rest.
    pub(super) fn times(&self, motion: &Spatial) -> Spatial {
        let linear = (motion.linear + motion.angular.cross(&self.centre)) * self.mass;
        Spatial { angular: self.inertia * motion.angular + self.centre.cross(&linear), linear }
    }
}

/// A tree at q.
pub(super) struct Posture {
    /// Orientations of the segments' frames.
    pub(super) turned: [Matrix3<f64>; MOST],
    /// Their origins from that of the base \[m\].
    pub(super) origins: [Vector3<f64>; MOST],
    /// What a unit of the joint's own position does.
    pub(super) axes: [Spatial; MOST],
}

impl Posture {
    pub(super) fn at<const N: usize>(tree: &Tree<N>, q: &SVector<f64, N>) -> Self {
        let mut posture = Self {
            turned: [Matrix3::zeros(); MOST],
            origins: [Vector3::zeros(); MOST],
            axes: [Spatial::ZERO; MOST],
        };
        for (i, stage) in tree.stages.iter().enumerate().take(MOST) {
            let (turned, origin) = if stage.is_root {
                (stage.turned, stage.moved)
            } else {
                let before = &posture.turned[stage.parent];
                (before * stage.turned, posture.origins[stage.parent] + before * stage.moved)
            };
            let value = stage.multiplier * q[stage.coordinate] + stage.offset;
            let axis = turned * stage.axis;
            match stage.kind {
                JointKind::Revolute => {
                    posture.turned[i] = turned * turn(&stage.axis, value);
                    posture.origins[i] = origin;
                    posture.axes[i] = Spatial { angular: axis, linear: origin.cross(&axis) };
                }
                JointKind::Prismatic => {
                    posture.turned[i] = turned;
                    posture.origins[i] = origin + axis * value;
                    posture.axes[i] = Spatial { angular: Vector3::zeros(), linear: axis };
                }
            }
        }
        posture
    }

    /// The body of segment `i`, whose stage is `stage`.
    pub(super) fn body(&self, i: usize, stage: &Stage) -> Placed {
        let turned = &self.turned[i];
        Placed {
            mass: stage.mass,
            centre: self.origins[i] + turned * stage.centre,
            inertia: turned * stage.inertia * turned.transpose(),
        }
    }
}

impl<const N: usize> Tree<N> {
    /// Pose of the tip in the world, `X_WF`, at `q` [rad or m].
    #[must_use]
    pub fn forward(&self, q: &SVector<f64, N>) -> Pose {
        let posture = Posture::at(self, q);
        let last = self.stages.len() - 1;
        let rotation = Rotation3::from_matrix_unchecked(posture.turned[last]);
        let frame =
            Pose::from_parts((posture.origins[last] + self.X_WB.translation.vector).into(), rotation.into());
        frame * self.X_tip
    }
}

/// The rotation by `angle` \[rad\] about an axis of length 1 (Rodrigues).
fn turn(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    let (x, y, z) = (axis.x, axis.y, axis.z);
    let v = 1.0 - c;
    Matrix3::new(
        c + x * x * v,
        x * y * v - z * s,
        x * z * v + y * s,
        x * y * v + z * s,
        c + y * y * v,
        y * z * v - x * s,
        x * z * v - y * s,
        y * z * v + x * s,
        c + z * z * v,
    )
}
