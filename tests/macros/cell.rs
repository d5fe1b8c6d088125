//! The robots, sensors and payloads of the macro tests: no kinematics, only types.

use mrroc::nalgebra::SVector;
use mrroc::prelude::*;
use mrroc::robot::{Limits, NoInverse};

macro_rules! robots {
    ($($(#[$doc:meta])* $name:ident, $joints:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name;

        impl Robot for $name {
            const KIND: &'static str = stringify!($name);
            type Joints = SVector<f64, $joints>;
            fn limits(&self) -> &Limits<Self::Joints> {
                unimplemented!("the tests of the macros move no robot")
            }
            fn forward(&self, _: &Self::Joints) -> Pose {
                Pose::identity()
            }
            fn inverse(&self, _: &Pose, _: &Self::Joints) -> Result<Self::Joints, NoInverse> {
                Ok(SVector::zeros())
            }
        }
    )*};
}

robots! {
    /// A robot of six joints.
    Rnt, 6;
    /// A robot of seven joints.
    Polycrank, 7;
}

/// A force sensor in the wrist.
#[derive(Clone, Copy, Debug)]
pub struct WristForce;

impl Sensor for WristForce {
    const KIND: &'static str = "wrist force";
    type Reading = Force;
    type Configuration = ();
}

/// A camera.
#[derive(Clone, Copy, Debug)]
pub struct Camera;

impl Sensor for Camera {
    const KIND: &'static str = "camera";
    type Reading = Force;
    type Configuration = ();
}

/// A force [N].
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Force {
    /// Along x, y, z [N].
    pub along: [f64; 3],
}

/// Which part of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Payload)]
pub enum Phase {
    /// Go to the grasp.
    Grasp,
    /// Close the gripper.
    Close,
}

/// A displacement for every step.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Displacement {
    /// The displacement.
    pub pose: Pose,
    /// Its step.
    pub step: u64,
}
