//! The images of a list: `e` and `v` of the paper, as a step function takes them.

use core::ops::{Deref, DerefMut};

use super::{RobotList, SensorList, SensorsEach};
use crate::model::pose::Pose;

/// `e`: the images of the robots of the list `L`.
///
/// Dereferences to the images in the list's own form: `e.0.measured()`, `e[1].demanded()`, or for the single
/// robot of an ECP `e.measured()`.
pub struct State<L: RobotList> {
    images: L::Images,
}

impl<L: RobotList> State<L> {
    /// A state of these images, for calling a step function in a test.
    #[must_use]
    pub const fn new(images: L::Images) -> Self {
        State { images }
    }

    /// `X_WE` of every robot's tool as demanded last, in the list's order, whatever form the list has.
    #[must_use]
    pub fn demanded_poses(&self) -> L::Each<Pose> {
        let poses = L::poses(&self.images);
        L::array(|i| poses.as_ref()[i].1)
    }

    /// `X_WE` of every robot's tool as measured last, in the list's order, whatever form the list has.
    #[must_use]
    pub fn measured_poses(&self) -> L::Each<Pose> {
        let poses = L::poses(&self.images);
        L::array(|i| poses.as_ref()[i].0)
    }
}

impl<L: RobotList> Deref for State<L> {
    type Target = L::Images;
    fn deref(&self) -> &L::Images {
        &self.images
    }
}

impl<L: RobotList> DerefMut for State<L> {
    fn deref_mut(&mut self) -> &mut L::Images {
        &mut self.images
    }
}

/// `v`: the images of the virtual sensors of the list `L`.
///
/// Dereferences to the images in the list's own form: `v.0.reading()`.
pub struct Reading<L: SensorList> {
    images: L::Images,
}

impl<L: SensorList> Reading<L> {
    /// A reading of these images, for calling a step function in a test.
    #[must_use]
    pub const fn new(images: L::Images) -> Self {
        Reading { images }
    }

    /// The last reading of every sensor as a `T`, with its age when it was collected \[steps\], in the list's order;
    /// `None` before the first one of a sensor with delay has arrived.
    #[must_use]
    pub fn each<T: Copy>(&self) -> L::Each<Option<(T, u32)>>
    where
        L: SensorsEach<T>,
    {
        L::readings(&self.images)
    }
}

impl<L: SensorList> Deref for Reading<L> {
    type Target = L::Images;
    fn deref(&self) -> &L::Images {
        &self.images
    }
}

impl<L: SensorList> DerefMut for Reading<L> {
    fn deref_mut(&mut self) -> &mut L::Images {
        &mut self.images
    }
}
