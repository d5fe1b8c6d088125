//! Lists of virtual sensors.

use core::fmt;
use core::ops::Deref;

use crate::model::image::{Sensor, SensorImage};
use crate::model::name::Name;
use crate::model::wire::{BadWords, Wire};

use super::robots::{Owner, PayloadType};

/// A list of virtual sensors as a step function names it: `()`, `(WristForce,)`, `(Camera, WristForce)`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no list of virtual sensors",
    label = "not a list of virtual sensors",
    note = "a list of sensors is a tuple of kinds of sensors; a list of one sensor needs a comma: `(WristForce,)`"
)]
pub trait SensorList: 'static {
    /// Sensors in the list.
    const LEN: usize;

    /// The images of the sensors, in the list's form.
    type Images: Copy;

    /// Images of sensors that have not been read yet.
    #[doc(hidden)]
    fn unknown() -> Self::Images;

    /// Reads the image of sensor `i` from a reply that is `age` steps old.
    #[doc(hidden)]
    fn read(images: &mut Self::Images, i: usize, words: &[u64], age: u32) -> Result<(), BadWords>;
}

/// A list of sensors each of which reads a `T`: what a generator for any number of sensors of one meaning asks of its
/// list. A reading counts that is one, or that converts into one.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no list of sensors that all read a `{T}`",
    label = "not a list of sensors, or not what all of them read"
)]
pub trait SensorsEach<T: Copy>: SensorList {
    /// One value per sensor: an array of [`LEN`](SensorList::LEN).
    type Each<U: Copy>: Copy + AsRef<[U]>;

    /// The readings with their ages \[steps\].
    #[doc(hidden)]
    fn readings(images: &Self::Images) -> Self::Each<Option<(T, u32)>>;
}

/// A program's handle of a virtual sensor: its configuration for the next orders, and its image between
/// instructions.
///
/// Dereferences to the [`SensorImage`] of the end of the last Move or Wait that named the sensor.
pub struct SensorHandle<S: Sensor> {
    pub(crate) owner: Owner,
    pub(crate) index: usize,
    pub(crate) name: Name,
    pub(crate) configuration: S::Configuration,
    pub(crate) image: SensorImage<S>,
}

impl<S: Sensor> SensorHandle<S> {
    /// The sensor's name in the cell.
    #[must_use]
    pub const fn name(&self) -> Name {
        self.name
    }

    /// Configures the sensor: goes with every order of a reading from now on.
    pub fn configure(&mut self, configuration: S::Configuration) {
        self.configuration = configuration;
    }
}

impl<S: Sensor> Deref for SensorHandle<S> {
    type Target = SensorImage<S>;
    fn deref(&self) -> &SensorImage<S> {
        &self.image
    }
}

impl<S: Sensor> fmt::Debug for SensorHandle<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SensorHandle").field("name", &self.name).field("age", &self.image.age()).finish()
    }
}

/// Handles of the sensors of the list `L`, in its order: `(&mut force,)` for `(WristForce,)`.
#[diagnostic::on_unimplemented(
    message = "expected one `&mut` handle for each sensor of the list, or `()` for none",
    label = "these are `{Self}`",
    note = "the list is `{L}`: pass the handles in its order",
    note = "a list of one sensor needs a comma: `(&mut force,)`",
    note = "a handle is asked for once, by `let mut force = mp.sensor::<WristForce>(\"force\")?`"
)]
pub trait SensorsOf<L: SensorList> {
    /// An array as long as the list.
    #[doc(hidden)]
    type Indices: AsRef<[usize]> + 'static;

    /// Places of the sensors among those of the process, in the list's order.
    #[doc(hidden)]
    fn indices(&self) -> Self::Indices;

    /// The first sensor of which this is another process's handle.
    #[doc(hidden)]
    fn stranger(&self, owner: Owner) -> Option<Name>;

    /// Writes the configuration of sensor `i`; returns its type.
    #[doc(hidden)]
    fn configuration(&self, i: usize, words: &mut [u64]) -> PayloadType;

    /// Keeps the images for the time between instructions.
    #[doc(hidden)]
    fn store(&mut self, images: &L::Images);

    /// The images between instructions.
    #[doc(hidden)]
    fn images(&self) -> L::Images;
}

#[diagnostic::do_not_recommend]
impl SensorList for () {
    const LEN: usize = 0;
    type Images = ();

    fn unknown() {}

    fn read(_: &mut (), _: usize, _: &[u64], _: u32) -> Result<(), BadWords> {
        Ok(())
    }
}

#[diagnostic::do_not_recommend]
impl SensorsOf<()> for () {
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

    fn store(&mut self, _: &()) {}

    fn images(&self) {}
}

#[diagnostic::do_not_recommend]
impl<S: Sensor, const N: usize> SensorList for [S; N] {
    const LEN: usize = N;
    type Images = [SensorImage<S>; N];

    fn unknown() -> Self::Images {
        [SensorImage::unknown(); N]
    }

    fn read(images: &mut Self::Images, i: usize, words: &[u64], age: u32) -> Result<(), BadWords> {
        images[i] = SensorImage::new(S::Reading::get(words)?, age);
        Ok(())
    }
}

#[diagnostic::do_not_recommend]
impl<S: Sensor, const N: usize> SensorsOf<[S; N]> for [&mut SensorHandle<S>; N] {
    type Indices = [usize; N];

    fn indices(&self) -> [usize; N] {
        self.each_ref().map(|sensor| sensor.index)
    }

    fn stranger(&self, owner: Owner) -> Option<Name> {
        self.iter().find_map(|handle| owner.not_its_own(handle.owner, handle.name))
    }

    fn configuration(&self, i: usize, words: &mut [u64]) -> PayloadType {
        self[i].configuration.put(words);
        PayloadType::of::<S::Configuration>()
    }

    fn store(&mut self, images: &[SensorImage<S>; N]) {
        for (sensor, image) in self.iter_mut().zip(images) {
            sensor.image = *image;
        }
    }

    fn images(&self) -> [SensorImage<S>; N] {
        self.each_ref().map(|sensor| sensor.image)
    }
}

#[diagnostic::do_not_recommend]
impl<T: Copy, S: Sensor<Reading: Into<T>>, const N: usize> SensorsEach<T> for [S; N] {
    type Each<U: Copy> = [U; N];

    fn readings(images: &[SensorImage<S>; N]) -> [Option<(T, u32)>; N] {
        images.each_ref().map(reading)
    }
}

fn reading<T, S: Sensor<Reading: Into<T>>>(image: &SensorImage<S>) -> Option<(T, u32)> {
    image.reading().map(|reading| (reading.into(), image.age()))
}

macro_rules! tuple_lists {
    ($($len:literal: $($S:ident $i:tt),+;)*) => {$(
        #[diagnostic::do_not_recommend]
        impl<$($S: Sensor),+> SensorList for ($($S,)+) {
            const LEN: usize = $len;
            type Images = ($(SensorImage<$S>,)+);

            fn unknown() -> Self::Images {
                ($(SensorImage::<$S>::unknown(),)+)
            }

            fn read(images: &mut Self::Images, i: usize, words: &[u64], age: u32) -> Result<(), BadWords> {
                match i {
                    $($i => images.$i = SensorImage::new(<$S as Sensor>::Reading::get(words)?, age),)+
                    _ => {}
                }
                Ok(())
            }
        }

        #[diagnostic::do_not_recommend]
        impl<T: Copy, $($S: Sensor<Reading: Into<T>>),+> SensorsEach<T> for ($($S,)+) {
            type Each<U: Copy> = [U; $len];

            fn readings(images: &Self::Images) -> [Option<(T, u32)>; $len] {
                [$(reading(&images.$i)),+]
            }
        }

        #[diagnostic::do_not_recommend]
        impl<$($S: Sensor),+> SensorsOf<($($S,)+)> for ($(&mut SensorHandle<$S>,)+) {
            type Indices = [usize; $len];

            fn indices(&self) -> [usize; $len] {
                [$(self.$i.index),+]
            }

            fn stranger(&self, owner: Owner) -> Option<Name> {
                None$(.or_else(|| owner.not_its_own(self.$i.owner, self.$i.name)))+
            }

            fn configuration(&self, i: usize, words: &mut [u64]) -> PayloadType {
                match i {
                    $($i => {
                        self.$i.configuration.put(words);
                        PayloadType::of::<<$S as Sensor>::Configuration>()
                    })+
                    _ => PayloadType::of::<()>(),
                }
            }

            fn store(&mut self, images: &($(SensorImage<$S>,)+)) {
                $(self.$i.image = images.$i;)+
            }

            fn images(&self) -> ($(SensorImage<$S>,)+) {
                ($(self.$i.image,)+)
            }
        }
    )*};
}

tuple_lists! {
    1: A 0;
    2: A 0, B 1;
    3: A 0, B 1, C 2;
    4: A 0, B 1, C 2, D 3;
}
