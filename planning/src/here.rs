//! Where robots are: what a plan begins with.

use mrroc::generator::RobotList;
use mrroc::prelude::*;
use mrroc::robot::JointVector;
use mrroc::robot::RobotImage;

/// A condition of an ECP that is met at once, and knows where its robot is demanded to be. For the MP there is [`HereAll`].
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_planning::Here;
/// use mrroc_robots::Irp6;
///
/// fn start(ecp: &mut Ecp<Irp6>) -> Result<Vec<f64>, Fault> {
///     Ok(ecp.wait_until((), Here::<Irp6>::default())?.joints())
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Here<R: Robot> {
    joints: Option<R::Joints>,
}

impl<R: Robot> Default for Here<R> {
    fn default() -> Self {
        Here { joints: None }
    }
}

impl<R: Robot> Here<R> {
    /// The joint positions demanded [rad or m]; empty before a Wait has met it.
    #[must_use]
    pub fn joints(&self) -> Vec<f64> {
        self.joints.as_ref().map_or_else(Vec::new, |joints| joints.as_slice().to_vec())
    }
}

#[condition(ecp)]
impl<R: Robot> Here<R> {
    fn is_met(&mut self, e: &State<R>) -> bool {
        self.joints = Some(e.demanded().joints);
        true
    }
}

/// A condition of the MP that is met at once, and knows where the robots of the list `L` are demanded to be: a tuple of up to four, or an
/// array.
///
/// ```
/// use mrroc::generator::RobotHandle;
/// use mrroc::prelude::*;
/// use mrroc_planning::HereAll;
/// use mrroc_robots::{Irp6, Rnt};
///
/// fn start(mp: &mut Mp, a: &mut RobotHandle<Irp6>, b: &mut RobotHandle<Rnt>) -> Result<Vec<f64>, Fault> {
///     Ok(mp.wait_until((a, b), (), HereAll::<(Irp6, Rnt)>::default())?.joints())
/// }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct HereAll<L> {
    joints: Vec<f64>,
    of: core::marker::PhantomData<L>,
}

impl<L> Default for HereAll<L> {
    fn default() -> Self {
        HereAll { joints: Vec::new(), of: core::marker::PhantomData }
    }
}

impl<L> HereAll<L> {
    /// The joint positions demanded [rad or m] of all robots, one behind the other; empty before a Wait has met it.
    #[must_use]
    pub fn joints(&self) -> Vec<f64> {
        self.joints.clone()
    }
}

#[condition(mp)]
impl<L: Standing> HereAll<L> {
    fn is_met(&mut self, e: &State<L>) -> bool {
        self.joints.clear();
        L::joints(e, &mut self.joints);
        true
    }
}

/// A list of robots whose joint positions can be told one behind the other.
pub trait Standing: RobotList + 'static {
    /// Appends the positions demanded [rad or m].
    fn joints(images: &Self::Images, joints: &mut Vec<f64>);
}

fn append<R: Robot>(image: &RobotImage<R>, joints: &mut Vec<f64>) {
    joints.extend_from_slice(image.demanded().joints.as_slice());
}

macro_rules! standing {
    ($($R:ident $i:tt),+) => {
        impl<$($R: Robot),+> Standing for ($($R,)+) {
            fn joints(images: &Self::Images, joints: &mut Vec<f64>) {
                $(append(&images.$i, joints);)+
            }
        }
    };
}

standing!(A 0);
standing!(A 0, B 1);
standing!(A 0, B 1, C 2);
standing!(A 0, B 1, C 2, D 3);

impl<R: Robot, const N: usize> Standing for [R; N]
where
    [R; N]: RobotList<Images = [RobotImage<R>; N]>,
{
    fn joints(images: &Self::Images, joints: &mut Vec<f64>) {
        images.iter().for_each(|image| append(image, joints));
    }
}
