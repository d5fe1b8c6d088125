//! The sensors of two parts of a motion as one list.

use mrroc::generator::SensorList;
use mrroc::prelude::*;

/// A list of sensors with another behind it: of none or one each.
pub trait Joined<B: SensorList>: SensorList + Sized {
    /// The sensors of the first list, then those of the second.
    type All: SensorList;

    /// What the sensors of either list read.
    fn split(all: &Reading<Self::All>) -> (Reading<Self>, Reading<B>);
}

impl Joined<()> for () {
    type All = ();
    fn split(_: &Reading<()>) -> (Reading<()>, Reading<()>) {
        (Reading::new(()), Reading::new(()))
    }
}

impl<S: Sensor> Joined<()> for (S,) {
    type All = (S,);
    fn split(all: &Reading<(S,)>) -> (Reading<(S,)>, Reading<()>) {
        (Reading::new((all.0,)), Reading::new(()))
    }
}

impl<S: Sensor> Joined<(S,)> for () {
    type All = (S,);
    fn split(all: &Reading<(S,)>) -> (Reading<()>, Reading<(S,)>) {
        (Reading::new(()), Reading::new((all.0,)))
    }
}

impl<S: Sensor, T: Sensor> Joined<(T,)> for (S,) {
    type All = (S, T);
    fn split(all: &Reading<(S, T)>) -> (Reading<(S,)>, Reading<(T,)>) {
        (Reading::new((all.0,)), Reading::new((all.1,)))
    }
}
