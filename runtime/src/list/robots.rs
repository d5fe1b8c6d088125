//! Lists of robots.

use core::fmt;
use core::ops::Deref;

use crate::demand::Demand;
use crate::image::RobotImage;
use crate::name::Name;
use crate::payload::Payload;
use crate::robot::Robot;
use crate::wire::{BadWords, Wire};

/// A list of robots as a step function names it: `Rnt`, `(Rnt, Polycrank)`, `[Irp6; 3]`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no list of robots",
    label = "not a list of robots",
    note = "an MP's list is a tuple or an array of robots, a list of one robot needs a comma: `(Rnt,)`; an ECP's list is its robot: `Rnt`"
)]
pub trait RobotList: 'static {
    /// Robots in the list.
    const LEN: usize;

    /// The images of the robots in the list's form.
    type Images: Copy;

    /// Images of robots whose states are not known yet.
    #[doc(hidden)]
    fn unknown() -> Self::Images;

    /// Reads the image of robot `i` from a reply.
    #[doc(hidden)]
    fn read(images: &mut Self::Images, i: usize, words: &[u64]) -> Result<(), BadWords>;
}

/// What is demanded of a robot of kind `R`: a language of motions.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no language of motions for `{R}`",
    label = "neither `Motion` nor an order's payload",
    note = "leave it out to demand states, or derive `Payload` for your order: `#[derive(Clone, Copy, mrroc::Payload)]`"
)]
pub trait Language<R>: 'static {
    /// One demand or order.
    type Item: Payload;
}

/// The default language: a [`Demand`] for each robot.
#[derive(Clone, Copy, Debug)]
pub struct Motion;

impl<R: Robot> Language<R> for Motion {
    type Item = Demand<R>;
}

impl<R: Robot, P: Payload> Language<R> for P {
    type Item = P;
}

impl<R: Robot> Payload for Demand<R> {
    const NAME: &'static str = "Demand";
    const TIGHT: bool = true;
}

/// A list of robots that are told something in the language `O`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no list of robots that can be told `{O}`",
    label = "not a list of robots, or not what they can be told",
    note = "an MP's list is a tuple or an array of robots, a list of one robot needs a comma: `(Rnt,)`; an ECP's list is its robot: `Rnt`",
    note = "`Step<L>` tells them what to attain; for `Step<L, Phase>` derive the payload: `#[derive(Clone, Copy, mrroc::Payload)]`"
)]
pub trait Robots<O = Motion>: RobotList {
    /// One demand or order per robot, in the list's form.
    type Demands: Copy;

    /// Writes what is demanded of robot `i`; returns the identity and tightness of its payload.
    #[doc(hidden)]
    fn write(demands: &Self::Demands, i: usize, words: &mut [u64]);

    /// The identity of the payload of robot `i`.
    #[doc(hidden)]
    fn payload(i: usize) -> PayloadType;
}

/// What identifies a payload on the wire and in messages.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PayloadType {
    pub id: u64,
    pub tight: bool,
    pub name: &'static str,
}

impl PayloadType {
    #[must_use]
    pub const fn of<P: Payload>() -> PayloadType {
        PayloadType { id: P::ID, tight: P::TIGHT, name: P::NAME }
    }
}

impl<R: Robot> RobotList for R {
    const LEN: usize = 1;
    type Images = RobotImage<R>;

    fn unknown() -> Self::Images {
        RobotImage::unknown()
    }

    fn read(images: &mut Self::Images, _: usize, words: &[u64]) -> Result<(), BadWords> {
        *images = RobotImage::get(words)?;
        Ok(())
    }
}

impl<R: Robot, O: Language<R>> Robots<O> for R {
    type Demands = O::Item;

    fn write(demands: &Self::Demands, _: usize, words: &mut [u64]) {
        demands.put(words);
    }

    fn payload(_: usize) -> PayloadType {
        PayloadType::of::<O::Item>()
    }
}

impl<R: Robot, const N: usize> RobotList for [R; N] {
    const LEN: usize = N;
    type Images = [RobotImage<R>; N];

    fn unknown() -> Self::Images {
        [RobotImage::unknown(); N]
    }

    fn read(images: &mut Self::Images, i: usize, words: &[u64]) -> Result<(), BadWords> {
        images[i] = RobotImage::get(words)?;
        Ok(())
    }
}

impl<R: Robot, O: Language<R>, const N: usize> Robots<O> for [R; N] {
    type Demands = [O::Item; N];

    fn write(demands: &Self::Demands, i: usize, words: &mut [u64]) {
        demands[i].put(words);
    }

    fn payload(_: usize) -> PayloadType {
        PayloadType::of::<O::Item>()
    }
}

/// The list of a condition that does not look at the robots: it goes with any handles.
#[derive(Clone, Copy, Debug)]
pub struct AnyRobots;

impl RobotList for AnyRobots {
    const LEN: usize = 0;
    type Images = ();

    fn unknown() {}

    fn read(_: &mut (), _: usize, _: &[u64]) -> Result<(), BadWords> {
        Ok(())
    }
}

/// The MP's handle of a robot: what a program passes to Move and Wait, and the robot's image between them.
///
/// Dereferences to the [`RobotImage`] of the end of the last Move or Wait that named the robot.
pub struct RobotHandle<R: Robot> {
    pub(crate) index: usize,
    pub(crate) name: Name,
    pub(crate) image: RobotImage<R>,
}

impl<R: Robot> RobotHandle<R> {
    /// The robot's name in the cell.
    #[must_use]
    pub const fn name(&self) -> Name {
        self.name
    }
}

impl<R: Robot> Deref for RobotHandle<R> {
    type Target = RobotImage<R>;
    fn deref(&self) -> &RobotImage<R> {
        &self.image
    }
}

impl<R: Robot> fmt::Debug for RobotHandle<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RobotHandle").field("name", &self.name).field("image", &self.image).finish()
    }
}

/// Handles of the robots of the list `L`, in its order: `(&mut rnt, &mut polycrank)` for `(Rnt, Polycrank)`.
#[diagnostic::on_unimplemented(
    message = "these are not the robots of the list `{L}`",
    label = "the list asks for `{L}`",
    note = "pass one `&mut` handle for each robot of the list, in its order: `(&mut rnt, &mut polycrank)` for `(Rnt, Polycrank)`; a single robot needs a comma: `(&mut rnt,)`",
    note = "a handle is asked for once, by `let mut rnt = mp.robot::<Rnt>(\"rnt\")?`; a motion of an ECP, whose list is `Rnt` alone, is moved by `ecp.move_robot`"
)]
pub trait RobotsOf<L: RobotList> {
    /// An array as long as the list.
    #[doc(hidden)]
    type Indices: AsRef<[usize]> + 'static;

    /// Places of the robots in the cell, in the list's order.
    #[doc(hidden)]
    fn indices(&self) -> Self::Indices;

    /// The images between instructions.
    #[doc(hidden)]
    fn images(&self) -> L::Images;

    /// Reads the image of robot `i` of the list from the last reply.
    #[doc(hidden)]
    fn refresh(&mut self, i: usize, words: &[u64]) -> Result<(), BadWords>;
}

#[diagnostic::do_not_recommend]
impl<R: Robot, const N: usize> RobotsOf<[R; N]> for [&mut RobotHandle<R>; N] {
    type Indices = [usize; N];

    fn indices(&self) -> [usize; N] {
        core::array::from_fn(|i| self[i].index)
    }

    fn images(&self) -> [RobotImage<R>; N] {
        core::array::from_fn(|i| self[i].image)
    }

    fn refresh(&mut self, i: usize, words: &[u64]) -> Result<(), BadWords> {
        self[i].image = RobotImage::get(words)?;
        Ok(())
    }
}

#[diagnostic::do_not_recommend]
impl<R: Robot, const N: usize> RobotsOf<AnyRobots> for [&mut RobotHandle<R>; N] {
    type Indices = [usize; N];

    fn indices(&self) -> [usize; N] {
        core::array::from_fn(|i| self[i].index)
    }

    fn images(&self) {}

    fn refresh(&mut self, i: usize, words: &[u64]) -> Result<(), BadWords> {
        self[i].image = RobotImage::get(words)?;
        Ok(())
    }
}

#[diagnostic::do_not_recommend]
impl RobotsOf<AnyRobots> for () {
    type Indices = [usize; 0];

    fn indices(&self) -> [usize; 0] {
        []
    }

    fn images(&self) {}

    fn refresh(&mut self, _: usize, _: &[u64]) -> Result<(), BadWords> {
        Ok(())
    }
}

macro_rules! tuple_lists {
    ($($len:literal: $($R:ident $i:tt),+;)*) => {$(
        impl<$($R: Robot),+> RobotList for ($($R,)+) {
            const LEN: usize = $len;
            type Images = ($(RobotImage<$R>,)+);

            fn unknown() -> Self::Images {
                ($(RobotImage::<$R>::unknown(),)+)
            }

            fn read(images: &mut Self::Images, i: usize, words: &[u64]) -> Result<(), BadWords> {
                match i {
                    $($i => images.$i = RobotImage::get(words)?,)+
                    _ => {}
                }
                Ok(())
            }
        }

        impl<O, $($R: Robot),+> Robots<O> for ($($R,)+)
        where
            $(O: Language<$R>,)+
        {
            type Demands = ($(<O as Language<$R>>::Item,)+);

            fn write(demands: &Self::Demands, i: usize, words: &mut [u64]) {
                match i {
                    $($i => demands.$i.put(words),)+
                    _ => {}
                }
            }

            fn payload(i: usize) -> PayloadType {
                match i {
                    $($i => PayloadType::of::<<O as Language<$R>>::Item>(),)+
                    _ => PayloadType::of::<()>(),
                }
            }
        }

        #[diagnostic::do_not_recommend]
        impl<$($R: Robot),+> RobotsOf<($($R,)+)> for ($(&mut RobotHandle<$R>,)+) {
            type Indices = [usize; $len];

            fn indices(&self) -> [usize; $len] {
                [$(self.$i.index),+]
            }

            fn images(&self) -> ($(RobotImage<$R>,)+) {
                ($(self.$i.image,)+)
            }

            fn refresh(&mut self, i: usize, words: &[u64]) -> Result<(), BadWords> {
                match i {
                    $($i => self.$i.image = RobotImage::get(words)?,)+
                    _ => {}
                }
                Ok(())
            }
        }

        #[diagnostic::do_not_recommend]
        impl<$($R: Robot),+> RobotsOf<AnyRobots> for ($(&mut RobotHandle<$R>,)+) {
            type Indices = [usize; $len];

            fn indices(&self) -> [usize; $len] {
                [$(self.$i.index),+]
            }

            fn images(&self) {}

            fn refresh(&mut self, i: usize, words: &[u64]) -> Result<(), BadWords> {
                match i {
                    $($i => self.$i.image = RobotImage::get(words)?,)+
                    _ => {}
                }
                Ok(())
            }
        }
    )*};
}

tuple_lists! {
    1: A 0;
    2: A 0, B 1;
    3: A 0, B 1, C 2;
    4: A 0, B 1, C 2, D 3;
    5: A 0, B 1, C 2, D 3, E 4;
    6: A 0, B 1, C 2, D 3, E 4, F 5;
    7: A 0, B 1, C 2, D 3, E 4, F 5, G 6;
    8: A 0, B 1, C 2, D 3, E 4, F 5, G 6, H 7;
}
