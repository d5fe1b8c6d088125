//! What the expansion of the macros names and nobody else should: versioned with the macros, so that a
//! mismatch of the two crates fails at the first use and not in a subtle manner.

use crate::model::image::Sensor;
use crate::model::list::{
    Owner, RobotHandle, RobotList, Robots, RobotsOf, SensorHandle, SensorList, SensorsOf,
};
use crate::model::name::Name;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::model::wire::{BadWords, WORDS, Wire};

pub use crate::model::list::PayloadType;
pub use crate::model::moved::AnyLanguage;
pub use crate::model::shape::Shape;
pub use crate::model::step::{IntoStep, IntoVerdict};
pub use crate::model::step_fn::{first_in_ecp, first_in_mp, until};
pub use crate::model::wire::layout_hash;

/// A field of a payload: how its type becomes words, found out once for each field.
#[derive(Debug)]
pub struct Field<T> {
    /// Words that it takes.
    pub len: usize,
    /// The layout of its type.
    pub layout: u64,
    /// What its words say.
    pub shape: &'static Shape,
    put: fn(&T, &mut [u64]),
    get: fn(&[u64]) -> Result<T, BadWords>,
}

/// A field of type `T`.
#[must_use]
pub const fn field<T: Wire>() -> Field<T> {
    Field { len: T::LEN, layout: T::LAYOUT, shape: T::SHAPE, put: T::put, get: T::get }
}

impl<T> Field<T> {
    /// Writes the field; returns the words behind it.
    pub fn put<'w>(&self, value: &T, words: &'w mut [u64]) -> &'w mut [u64] {
        let (own, rest) = words.split_at_mut(self.len);
        (self.put)(value, own);
        rest
    }

    /// Reads the field, and moves on to the words behind it.
    ///
    /// # Errors
    /// [`BadWords`] when there are too few, or they spell no value of the type.
    pub fn get(&self, words: &mut &[u64]) -> Result<T, BadWords> {
        let (own, rest) = words.split_at_checked(self.len).ok_or(BadWords)?;
        *words = rest;
        (self.get)(own)
    }
}

/// The largest of the numbers of words that an enum's variants take.
#[must_use]
pub const fn longest(lengths: &[usize]) -> usize {
    let mut longest = 0;
    let mut i = 0;
    while i < lengths.len() {
        if lengths[i] > longest {
            longest = lengths[i];
        }
        i += 1;
    }
    longest
}

/// Whether a payload of `len` words fits a message; the compiler asks.
///
/// # Panics
/// When it does not.
pub const fn fits_a_message(len: usize) {
    assert!(
        len <= WORDS,
        "a message holds at most 64 words, this payload takes more: send less, or in parts"
    );
}

/// The lists of a generator whose attribute reported a mistake: goes with all handles, so that the calls of
/// the motion are not reported as well. Never runs, since the program does not compile.
#[derive(Clone, Copy, Debug)]
pub struct Anything;

impl RobotList for Anything {
    const LEN: usize = 0;
    type Images = ();
    type Each<T: Copy> = [T; 0];
    fn array<T: Copy>(_: impl FnMut(usize) -> T) -> [T; 0] {
        []
    }
    fn unknown() {}
    fn read(_: &mut (), _: usize, _: &[u64]) -> Result<(), BadWords> {
        Err(BadWords)
    }
    fn poses((): &()) -> [(Pose, Pose); 0] {
        []
    }
}

impl<O> Robots<O> for Anything {
    type Demands = ();
    fn write((): &(), _: usize, _: &mut [u64]) -> usize {
        0
    }
    fn payload(_: usize) -> PayloadType {
        PayloadType::of::<()>()
    }
}

impl SensorList for Anything {
    const LEN: usize = 0;
    type Images = ();
    fn unknown() {}
    fn read(_: &mut (), _: usize, _: &[u64], _: u32) -> Result<(), BadWords> {
        Err(BadWords)
    }
}

macro_rules! goes_with {
    ($($handles:ty $(, $R:ident)*;)*) => {$(
        #[diagnostic::do_not_recommend]
        impl<$($R: Robot),*> RobotsOf<Anything> for $handles {
            type Indices = [usize; 0];
            fn indices(&self) -> [usize; 0] {
                []
            }
            fn stranger(&self, _: Owner) -> Option<Name> {
                None
            }
            fn images(&self) {}
            fn refresh(&mut self, _: usize, _: &[u64]) -> Result<(), BadWords> {
                Err(BadWords)
            }
        }
    )*};
}

goes_with! {
    ();
    (&mut RobotHandle<A>,), A;
    (&mut RobotHandle<A>, &mut RobotHandle<B>), A, B;
    (&mut RobotHandle<A>, &mut RobotHandle<B>, &mut RobotHandle<C>), A, B, C;
    (&mut RobotHandle<A>, &mut RobotHandle<B>, &mut RobotHandle<C>, &mut RobotHandle<D>), A, B, C, D;
}

macro_rules! goes_with_sensors {
    ($($handles:ty $(, $S:ident)*;)*) => {$(
        #[diagnostic::do_not_recommend]
        impl<$($S: Sensor),*> SensorsOf<Anything> for $handles {
            type Indices = [usize; 0];
            fn indices(&self) -> [usize; 0] {
                []
            }
            fn stranger(&self, _: Owner) -> Option<Name> {
                None
            }
            fn configuration(&self, _: usize, _: &mut [u64]) -> PayloadType {
                PayloadType::of::<()>()
            }
            fn store(&mut self, (): &()) {}
            fn images(&self) {}
        }
    )*};
}

goes_with_sensors! {
    ();
    (&mut SensorHandle<A>,), A;
    (&mut SensorHandle<A>, &mut SensorHandle<B>), A, B;
    (&mut SensorHandle<A>, &mut SensorHandle<B>, &mut SensorHandle<C>), A, B, C;
}
