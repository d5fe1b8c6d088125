//! Several conditions that are asked together.

use mrroc::generator::{Class, Condition, RobotList, SensorList};
use mrroc::prelude::*;

use super::group::{Group, Own, Shared};

/// Conditions in a tuple of two to four or in an array, which share their robots and sensors; or [`Separate`] ones.
#[diagnostic::on_unimplemented(
    message = "`{Self}` are no conditions that can be put together",
    label = "no conditions, or not of the same robots and sensors",
    note = "write two to four conditions as a tuple: `all((part_seen {{}}, gripper_closed {{}}))`",
    note = "conditions that have robots and sensors of their own each: `all(separate((a, b)))`"
)]
pub trait Parts: Sized {
    /// The robots that they look at.
    type Robots: RobotList;
    /// The sensors that they read.
    type Sensors: SensorList;
    /// The coordinator's order that the first of them reads.
    type Order: Payload;
    /// What they take together.
    const CLASS: Class;

    /// Asks every one of them whether it is met, in their order.
    ///
    /// # Errors
    /// The first [`Fault`] of one.
    fn ask(
        &mut self,
        order: &Order<Self::Order>,
        e: &State<Self::Robots>,
        v: &Reading<Self::Sensors>,
        t: Tick,
        answer: impl FnMut(bool),
    ) -> Result<(), Fault>;
}

/// Conditions that have robots and sensors of their own each: [`separate`].
#[derive(Clone, Copy, Debug)]
pub struct Separate<P>(P);

/// Parts for [`all`](super::all()) and [`any`](super::any()) that have robots and sensors of their own each. The list of the
/// whole is the robots of the first part, then those of the second, and so on, and likewise for the sensors: at most four of
/// each. In an ECP, which has one robot, all parts look at that one.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc::sensor::SensorImage;
/// use mrroc::generator::Condition;
/// use mrroc_generators::conditions::{all, separate};
/// # struct Camera;
/// # impl Sensor for Camera {
/// #     const KIND: &'static str = "camera";
/// #     type Reading = Parts;
/// #     type Configuration = ();
/// # }
/// # #[derive(Clone, Copy, Payload)]
/// # struct Parts { seen: u64 }
/// # #[derive(Clone, Copy, Payload)]
/// # struct Load { newtons: f64 }
/// # struct Scale;
/// # impl Sensor for Scale {
/// #     const KIND: &'static str = "scale";
/// #     type Reading = Load;
/// #     type Configuration = ();
/// # }
///
/// #[condition(ecp)]
/// fn part_seen(v: &Reading<(Camera,)>) -> bool {
///     v.0.reading().is_some_and(|parts| parts.seen > 0)
/// }
///
/// #[condition(ecp)]
/// fn loaded(v: &Reading<(Scale,)>) -> bool {
///     v.0.reading().is_some_and(|load| load.newtons > 2.0)
/// }
///
/// let mut both = all(separate((part_seen {}, loaded {})));
/// let images = (SensorImage::new(Parts { seen: 1 }, 0), SensorImage::new(Load { newtons: 2.5 }, 0));
/// let v = Reading::<(Camera, Scale)>::new(images);
/// let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
/// assert!(both.is_met(&Order::new(()), &State::new(()), &v, t)?);
/// # Ok::<(), Fault>(())
/// ```
#[must_use]
pub const fn separate<P>(parts: P) -> Separate<P>
where
    Separate<P>: Parts,
{
    Separate(parts)
}

impl<C: Condition, const N: usize> Parts for [C; N] {
    type Robots = C::Robots;
    type Sensors = C::Sensors;
    type Order = C::Order;
    const CLASS: Class = C::CLASS;

    fn ask(
        &mut self,
        order: &Order<C::Order>,
        e: &State<C::Robots>,
        v: &Reading<C::Sensors>,
        t: Tick,
        mut answer: impl FnMut(bool),
    ) -> Result<(), Fault> {
        for part in self {
            answer(part.is_met(order, e, v, t)?);
        }
        Ok(())
    }
}

/// `Parts` for a type that groups its conditions by a rule.
macro_rules! parts {
    ($([$($C:ident),+] $of:ty, $tuple:ty, $rule:ty, |$parts:ident| $group:expr;)*) => {$(
        #[diagnostic::do_not_recommend]
        impl<$($C),+> Parts for $of
        where
            $tuple: Group<$rule>,
        {
            type Robots = <$tuple as Group<$rule>>::Robots;
            type Sensors = <$tuple as Group<$rule>>::Sensors;
            type Order = <$tuple as Group<$rule>>::Order;
            const CLASS: Class = <$tuple as Group<$rule>>::CLASS;

            fn ask(
                &mut self,
                order: &Order<Self::Order>,
                e: &State<Self::Robots>,
                v: &Reading<Self::Sensors>,
                t: Tick,
                answer: impl FnMut(bool),
            ) -> Result<(), Fault> {
                let $parts = self;
                <$tuple as Group<$rule>>::ask_each($group, order, e, v, t, answer)
            }
        }
    )*};
}

parts! {
    [A, B] (A, B), (A, B), Shared, |parts| parts;
    [A, B, C] (A, B, C), (A, B, C), Shared, |parts| parts;
    [A, B, C, D] (A, B, C, D), (A, B, C, D), Shared, |parts| parts;
    [P] Separate<P>, P, Own, |parts| &mut parts.0;
}
