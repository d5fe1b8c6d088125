//! What is calibrated of an arm: where its flange is, as a function of the joint positions and of parameters.

use mrroc::pose::Pose;
use nalgebra::{UnitQuaternion, Vector3, Vector6};

use crate::parameter::Parameter;

/// An arm with parameters. All that a calibration must know of a robot is in here.
pub trait Arm {
    /// Its parameters.
    fn parameters(&self) -> &[Parameter];

    /// Number of joint positions.
    fn joints(&self) -> usize;

    /// `X_BF`, the flange in the arm's base, at what the encoders read `q` [rad or m], with these values of the parameters.
    #[allow(non_snake_case)]
    fn flange(&self, q: &[f64], values: &[f64]) -> Pose;

    /// The flange, and by parameter its twist at the flange's origin for a unit of that parameter: linear \[m\], then angular \[rad\],
    /// along the base's axes. By default by central differences.
    fn linearise(&self, q: &[f64], values: &[f64], twists: &mut [Vector6<f64>]) -> Pose {
        let mut values = values.to_vec();
        for (i, twist) in twists.iter_mut().enumerate() {
            let h = self.parameters()[i].tolerance.map_or(1e-6, |tolerance| 1e-3 * tolerance);
            let at = values[i];
            values[i] = at + h;
            let ahead = self.flange(q, &values);
            values[i] = at - h;
            let back = self.flange(q, &values);
            values[i] = at;
            *twist = between(&back, &ahead) / (2.0 * h);
        }
        self.flange(q, &values)
    }

    /// The flange's twist for a unit of each joint position, along the base's axes as those of [`Arm::linearise`]. By default by central differences.
    fn joint_twists(&self, q: &[f64], values: &[f64], twists: &mut [Vector6<f64>]) {
        const H: f64 = 1e-5;
        let mut q = q.to_vec();
        for (i, twist) in twists.iter_mut().enumerate() {
            let at = q[i];
            q[i] = at + H;
            let ahead = self.flange(&q, values);
            q[i] = at - H;
            let back = self.flange(&q, values);
            q[i] = at;
            *twist = between(&back, &ahead) / (2.0 * H);
        }
    }
}

/// The small displacement from one pose to another, at their origins and along the axes that both are told in.
#[must_use]
pub fn between(from: &Pose, to: &Pose) -> Vector6<f64> {
    let linear = to.translation.vector - from.translation.vector;
    let angular = (to.rotation * from.rotation.inverse()).scaled_axis();
    twist(&linear, &angular)
}

/// A pose moved by a small displacement in its own axes: the linear part, then a turn about the moved origin.
#[must_use]
pub fn displaced(pose: &Pose, by: &Vector6<f64>) -> Pose {
    let linear = Vector3::new(by[0], by[1], by[2]);
    let angular = Vector3::new(by[3], by[4], by[5]);
    pose * Pose::from_parts(linear.into(), UnitQuaternion::from_scaled_axis(angular))
}

pub(crate) fn twist(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// The same twist, told at a point that lies `arm` from the old one.
pub(crate) fn at(of: &Vector6<f64>, arm: &Vector3<f64>) -> Vector6<f64> {
    let (linear, angular) = (Vector3::new(of[0], of[1], of[2]), Vector3::new(of[3], of[4], of[5]));
    twist(&(linear + angular.cross(arm)), &angular)
}

/// The same twist along axes that are turned.
pub(crate) fn turned(of: &Vector6<f64>, by: &UnitQuaternion<f64>) -> Vector6<f64> {
    let (linear, angular) = (Vector3::new(of[0], of[1], of[2]), Vector3::new(of[3], of[4], of[5]));
    twist(&(by * linear), &(by * angular))
}
