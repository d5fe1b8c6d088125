//! What the expansion of the macros names and nobody else should: versioned with the macros, so that a
//! mismatch of the two crates fails at the first use and not in a subtle way.

use core::marker::PhantomData;

use crate::list::{RobotList, Robots, RobotsOf, SensorList, SensorsOf};
use crate::wire::{BadWords, Wire};

pub use crate::list::PayloadType;
pub use crate::step::{IntoStep, IntoVerdict};
pub use crate::step_fn::{first_in_ecp, first_in_mp, until};
pub use crate::wire::layout_hash;

/// A field of a payload.
#[derive(Debug)]
pub struct Field<T> {
    /// Words that it takes.
    pub len: usize,
    /// The layout of its type.
    pub layout: u64,
    of: PhantomData<fn() -> T>,
}

/// A field of type `T`.
#[must_use]
pub const fn field<T: Wire>() -> Field<T> {
    Field { len: T::LEN, layout: T::LAYOUT, of: PhantomData }
}

impl<T: Wire> Field<T> {
    /// Writes the field; returns the words behind it.
    pub fn put<'w>(&self, value: &T, words: &'w mut [u64]) -> &'w mut [u64] {
        let (own, rest) = words.split_at_mut(T::LEN);
        value.put(own);
        rest
    }

    /// Reads the field, and moves on to the words behind it.
    ///
    /// # Errors
    /// [`BadWords`] when there are too few, or they spell no value of the type.
    pub fn get(&self, words: &mut &[u64]) -> Result<T, BadWords> {
        let (own, rest) = words.split_at_checked(T::LEN).ok_or(BadWords)?;
        *words = rest;
        T::get(own)
    }
}

/// The lists of a generator whose attribute reported a mistake: goes with all handles, so that the calls of
/// the motion are not reported as well. Never runs, since the program does not compile.
#[derive(Clone, Copy, Debug)]
pub struct Anything;

impl RobotList for Anything {
    const LEN: usize = 0;
    type Images = ();
    fn unknown() {}
    fn read(_: &mut (), _: usize, _: &[u64]) -> Result<(), BadWords> {
        Err(BadWords)
    }
}

impl<O> Robots<O> for Anything {
    type Demands = ();
    fn write((): &(), _: usize, _: &mut [u64]) {}
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

#[diagnostic::do_not_recommend]
impl<T> RobotsOf<Anything> for T {
    type Indices = [usize; 0];

    fn indices(&self) -> [usize; 0] {
        []
    }
    fn images(&self) {}
    fn refresh(&mut self, _: usize, _: &[u64]) -> Result<(), BadWords> {
        Err(BadWords)
    }
}

#[diagnostic::do_not_recommend]
impl<T> SensorsOf<Anything> for T {
    type Indices = [usize; 0];

    fn indices(&self) -> [usize; 0] {
        []
    }
    fn configuration(&self, _: usize, _: &mut [u64]) -> PayloadType {
        PayloadType::of::<()>()
    }
    fn store(&mut self, (): &()) {}
    fn images(&self) {}
}
