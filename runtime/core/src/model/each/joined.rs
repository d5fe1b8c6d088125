//! The sensors of several motions as one list.

use crate::model::image::Sensor;
use crate::model::list::{Reading, SensorList};

/// A list of sensors that another one can follow: four sensors in all at most.
#[diagnostic::on_unimplemented(
    message = "the sensors `{Self}` and `{B}` make no list",
    label = "too many sensors, or not a tuple of them",
    note = "the sensors of all motions together are a tuple of at most four"
)]
pub trait Joined<B: SensorList>: SensorList + Sized {
    /// The sensors of the first list, then those of the second.
    type All: SensorList;

    /// What the sensors of either list read.
    fn split(all: &Reading<Self::All>) -> (Reading<Self>, Reading<B>);
}

macro_rules! joined {
    ($(($($S:ident $i:tt),*) ($($T:ident $j:tt),*);)*) => {$(
        impl<$($S: Sensor,)* $($T: Sensor,)*> Joined<($($T,)*)> for ($($S,)*) {
            type All = ($($S,)* $($T,)*);

            #[allow(unused_variables, clippy::unused_unit)] // of lists without sensors
            fn split(all: &Reading<Self::All>) -> (Reading<($($S,)*)>, Reading<($($T,)*)>) {
                (Reading::new(($(all.$i,)*)), Reading::new(($(all.$j,)*)))
            }
        }
    )*};
}

joined! {
    () ();
    () (S 0);
    () (S 0, T 1);
    () (S 0, T 1, U 2);
    () (S 0, T 1, U 2, V 3);
    (S 0) ();
    (S 0) (T 1);
    (S 0) (T 1, U 2);
    (S 0) (T 1, U 2, V 3);
    (S 0, T 1) ();
    (S 0, T 1) (U 2);
    (S 0, T 1) (U 2, V 3);
    (S 0, T 1, U 2) ();
    (S 0, T 1, U 2) (V 3);
    (S 0, T 1, U 2, V 3) ();
}

/// A list of sensors that each of `N` motions of one kind has: none, or one.
#[diagnostic::on_unimplemented(
    message = "motions in an array have at most one sensor each, not `{Self}`",
    label = "more than one sensor",
    note = "put the motions into a tuple"
)]
pub trait Repeated<const N: usize>: SensorList + Sized {
    /// The sensors of all motions.
    type All: SensorList;

    /// What the sensors of motion `i` read.
    fn one(all: &Reading<Self::All>, i: usize) -> Reading<Self>;
}

impl<const N: usize> Repeated<N> for () {
    type All = ();

    fn one(_: &Reading<()>, _: usize) -> Reading<()> {
        Reading::new(())
    }
}

impl<S: Sensor, const N: usize> Repeated<N> for (S,) {
    type All = [S; N];

    fn one(all: &Reading<[S; N]>, i: usize) -> Reading<(S,)> {
        Reading::new((all[i],))
    }
}
