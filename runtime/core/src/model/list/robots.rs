//! Lists of robots.

use core::fmt;
use core::ops::Deref;
use core::sync::atomic::{AtomicU64, Ordering};
use std::rc::Rc;

use crate::model::demand::Demand;
use crate::model::fault::{Fault, FaultKind};
use crate::model::image::RobotImage;
use crate::model::name::Name;
use crate::model::named::SignalNames;
use crate::model::payload::Payload;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::model::shape::Shape;
use crate::model::signals::{Input, Level, Output};
use crate::model::wire::{BadWords, Wire};

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

    /// One value per robot, whatever form the list has: an array of [`LEN`](RobotList::LEN).
    type Each<T: Copy>: Copy + AsRef<[T]> + AsMut<[T]>;

    /// One value per robot, from the robot's place in the list.
    fn array<T: Copy>(value: impl FnMut(usize) -> T) -> Self::Each<T>;

    /// Images of robots whose states are not known yet.
    #[doc(hidden)]
    fn unknown() -> Self::Images;

    /// Reads the image of robot `i` from a reply.
    #[doc(hidden)]
    fn read(images: &mut Self::Images, i: usize, words: &[u64]) -> Result<(), BadWords>;

    /// The poses of the tools, as measured and as demanded last.
    #[doc(hidden)]
    fn poses(images: &Self::Images) -> Self::Each<(Pose, Pose)>;
}

/// What is demanded of a robot of kind `R`: a language of motions.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no language of motions for `{R}`",
    label = "neither `Motion` nor an order's payload",
    note = "leave it out to demand states, or derive `Payload` for your order: `#[derive(Clone, Copy, mrroc::payload::Payload)]`"
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

/// A language in which robots can be told something.
#[doc(hidden)]
pub trait Spoken {}

impl Spoken for Motion {}

impl<P: Payload> Spoken for P {}

impl<R: Robot> Payload for Demand<R> {
    const NAME: &'static str = "Demand";
    const TIGHT: bool = {
        assert!(
            R::MOVES,
            "a lower cell takes loose orders, no demands: return an order's `enum`, `Step<L, Job>` or `Always<L, Job>`"
        );
        true
    };
}

/// A list of robots that are told something in the language `O`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no list of robots that can be told `{O}`",
    label = "not a list of robots, or not what they can be told",
    note = "an MP's list is a tuple or an array of robots, a list of one robot needs a comma: `(Rnt,)`; an ECP's list is its robot: `Rnt`",
    note = "`Step<L>` tells them what to attain; for `Step<L, Phase>` derive the payload: `#[derive(Clone, Copy, mrroc::payload::Payload)]`"
)]
pub trait Robots<O = Motion>: RobotList {
    /// One demand or order per robot, in the list's form.
    type Demands: Copy;

    /// Writes what is demanded of robot `i`; returns how many words say it.
    #[doc(hidden)]
    fn write(demands: &Self::Demands, i: usize, words: &mut [u64]) -> usize;

    /// The identity of the payload of robot `i`.
    #[doc(hidden)]
    fn payload(i: usize) -> PayloadType;
}

/// A list of robots each of which can be told a `T` in the language `O`: what a generator for any number of robots asks
/// of its list. Every list can be told a [`Pose`] per robot, and a payload `P` per robot in the language `P`.
///
/// ```
/// use mrroc::generator::RobotsEach;
/// use mrroc::prelude::*;
/// use mrroc_robots::{Irp6, Rnt};
///
/// let up = |i: usize| Pose::translation(0.0, 0.0, 0.1 * i as f64);
/// let demands = <(Irp6, Rnt) as RobotsEach<Pose>>::each(up);
/// assert_eq!(demands.1, Demand::pose(up(1)));
/// let demands = <[Irp6; 3] as RobotsEach<Pose>>::each(up);
/// assert_eq!(demands[2], Demand::pose(up(2)));
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no list of robots each of which can be told a `{T}`",
    label = "not a list of robots, or not what they can be told"
)]
pub trait RobotsEach<T, O = Motion>: Robots<O> {
    /// What is demanded of each robot, from its place in the list.
    fn each(told: impl FnMut(usize) -> T) -> Self::Demands;
}

/// What identifies a payload on the wire and in messages.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PayloadType {
    pub id: u64,
    pub tight: bool,
    pub name: &'static str,
    pub shape: &'static Shape,
}

impl PayloadType {
    #[must_use]
    pub const fn of<P: Payload>() -> PayloadType {
        PayloadType { id: P::ID, tight: P::TIGHT, name: P::NAME, shape: P::SHAPE }
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

    type Each<T: Copy> = [T; 1];

    fn array<T: Copy>(mut value: impl FnMut(usize) -> T) -> [T; 1] {
        [value(0)]
    }

    fn poses(images: &Self::Images) -> [(Pose, Pose); 1] {
        [poses(images)]
    }
}

/// The poses of the tool, as measured and as demanded last.
pub(super) fn poses<R: Robot>(image: &RobotImage<R>) -> (Pose, Pose) {
    (image.measured().pose, image.demanded().pose)
}

impl<R: Robot, O: Language<R>> Robots<O> for R {
    type Demands = O::Item;

    fn write(demands: &Self::Demands, _: usize, words: &mut [u64]) -> usize {
        demands.put(words);
        demands.used()
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

    type Each<T: Copy> = [T; N];

    fn array<T: Copy>(value: impl FnMut(usize) -> T) -> [T; N] {
        core::array::from_fn(value)
    }

    fn poses(images: &Self::Images) -> [(Pose, Pose); N] {
        images.each_ref().map(poses)
    }
}

impl<R: Robot, O: Language<R>, const N: usize> Robots<O> for [R; N] {
    type Demands = [O::Item; N];

    fn write(demands: &Self::Demands, i: usize, words: &mut [u64]) -> usize {
        demands[i].put(words);
        demands[i].used()
    }

    fn payload(_: usize) -> PayloadType {
        PayloadType::of::<O::Item>()
    }
}

impl<R: Robot, T: Into<O::Item>, O: Language<R>, const N: usize> RobotsEach<T, O> for [R; N] {
    fn each(mut told: impl FnMut(usize) -> T) -> [O::Item; N] {
        core::array::from_fn(|i| told(i).into())
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

    type Each<T: Copy> = [T; 0];

    fn array<T: Copy>(_: impl FnMut(usize) -> T) -> [T; 0] {
        []
    }

    fn poses((): &()) -> [(Pose, Pose); 0] {
        []
    }
}

/// Whose handle it is: that of one MP, or of one program's sensors.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner(u64);

impl Owner {
    /// One that is no other's.
    pub(crate) fn unique() -> Owner {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Owner(NEXT.fetch_add(1, Ordering::Relaxed))
    }

    /// The name of a thing whose handle is another's.
    pub(crate) fn not_its_own(self, owner: Owner, name: Name) -> Option<Name> {
        (self != owner).then_some(name)
    }

    /// Refuses a handle, if there is one, that is another's.
    ///
    /// # Errors
    /// `Config`, before anything moves.
    pub(crate) fn refuse(what: &str, stranger: Option<Name>) -> Result<(), Fault> {
        let Some(name) = stranger else { return Ok(()) };
        let text =
            format!("the handle of {what} `{name}` is of another cell or program: ask this one for its own");
        Err(Fault::new(FaultKind::Config).text(&text))
    }
}

/// The MP's handle of a robot: what a program passes to Move and Wait, and the robot's image between them.
///
/// Dereferences to the [`RobotImage`] of the end of the last Move or Wait that named the robot; before the first one, to the
/// robot's state when the handle was asked for.
pub struct RobotHandle<R: Robot> {
    pub(crate) owner: Owner,
    pub(crate) index: usize,
    pub(crate) name: Name,
    pub(crate) image: RobotImage<R>,
    pub(crate) signals: Rc<SignalNames>,
}

impl<R: Robot> RobotHandle<R> {
    /// The input of the robot's controller that the cell calls `name`: `bool` of a digital one, `f64` of an analog one. Its value
    /// is looked up in the robot's image, [`RobotImage::value`], in a condition, a generator, or here after a Move or Wait.
    ///
    /// # Errors
    /// `Config`: the robot has no input of that name and type.
    pub fn input<T: Level>(&self, name: &str) -> Result<Input<T>, Fault> {
        self.signals.input(self.name.as_str(), name)
    }

    /// The output of the robot's controller that the cell calls `name`: `bool` of a digital one, `f64` of an analog one. A demand
    /// tells it a value, [`Demand::with_output`].
    ///
    /// # Errors
    /// `Config`: the robot has no output of that name and type.
    pub fn output<T: Level>(&self, name: &str) -> Result<Output<T>, Fault> {
        self.signals.output(self.name.as_str(), name)
    }

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
    message = "expected one `&mut` handle for each robot of the list",
    label = "these are `{Self}`",
    note = "the list is `{L}`: pass the handles in its order",
    note = "a list of one robot needs a comma: `(&mut rnt,)`; a handle is asked for once, by `let mut rnt = mp.robot::<Rnt>(\"rnt\")?`"
)]
pub trait RobotsOf<L: RobotList> {
    /// An array as long as the list.
    #[doc(hidden)]
    type Indices: AsRef<[usize]> + 'static;

    /// Places of the robots in the cell, in the list's order.
    #[doc(hidden)]
    fn indices(&self) -> Self::Indices;

    /// The first robot of which this is another MP's handle.
    #[doc(hidden)]
    fn stranger(&self, owner: Owner) -> Option<Name>;

    /// The images between instructions.
    #[doc(hidden)]
    fn images(&self) -> L::Images;

    /// Reads the image of robot `i` of the list from the last reply.
    #[doc(hidden)]
    fn refresh(&mut self, i: usize, words: &[u64]) -> Result<(), BadWords>;
}

/// Handles that are of one list and no other: from these the compiler learns the list of a generator that is for any.
#[doc(hidden)]
pub trait ListOf<L: RobotList>: RobotsOf<L> {}

#[diagnostic::do_not_recommend]
impl<R: Robot, const N: usize> ListOf<[R; N]> for [&mut RobotHandle<R>; N] {}

#[diagnostic::do_not_recommend]
impl<R: Robot, const N: usize> RobotsOf<[R; N]> for [&mut RobotHandle<R>; N] {
    type Indices = [usize; N];

    fn indices(&self) -> [usize; N] {
        core::array::from_fn(|i| self[i].index)
    }

    fn stranger(&self, owner: Owner) -> Option<Name> {
        self.iter().find_map(|handle| owner.not_its_own(handle.owner, handle.name))
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

    fn stranger(&self, owner: Owner) -> Option<Name> {
        self.iter().find_map(|handle| owner.not_its_own(handle.owner, handle.name))
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

    fn stranger(&self, _: Owner) -> Option<Name> {
        None
    }

    fn images(&self) {}

    fn refresh(&mut self, _: usize, _: &[u64]) -> Result<(), BadWords> {
        Ok(())
    }
}
