//! Two lists as one, for what looks at both: the same robots or sensors, or those of one list and then those of the other.

use super::{AnyRobots, Reading, RobotList, SensorList, State};
use crate::model::image::Sensor;
use crate::model::robot::Robot;

/// Lists of robots that can be looked at as one: they are the same, or one of them is empty.
#[diagnostic::on_unimplemented(
    message = "these look at different robots: `{Self}` and `{B}`",
    label = "not the same robots",
    note = "write both for the same list of robots; one that looks at no robot goes with any list",
    note = "conditions that have robots and sensors of their own each are put together by `separate((a, b))`"
)]
pub trait SharedRobots<B: RobotList>: RobotList + Sized {
    /// The list that is not empty, if one is not.
    type All: RobotList;

    /// What each of them looks at.
    fn split(all: &State<Self::All>) -> (State<Self>, State<B>);
}

/// Lists of sensors that can be read as one: they are the same, or one of them is empty.
#[diagnostic::on_unimplemented(
    message = "these read different sensors: `{Self}` and `{B}`",
    label = "not the same sensors",
    note = "write both for the same list of sensors; one that reads no sensor goes with any list",
    note = "conditions that have robots and sensors of their own each are put together by `separate((a, b))`"
)]
pub trait SharedSensors<B: SensorList>: SensorList + Sized {
    /// The list that is not empty, if one is not.
    type All: SensorList;

    /// What each of them reads.
    fn split(all: &Reading<Self::All>) -> (Reading<Self>, Reading<B>);
}

/// A list of robots that another one can follow: four robots in all at most.
#[diagnostic::on_unimplemented(
    message = "the robots `{Self}` and `{B}` make no list",
    label = "too many robots, or not a tuple of them",
    note = "the robots of all parts together are a tuple of at most four"
)]
pub trait JoinedRobots<B: RobotList>: RobotList + Sized {
    /// The robots of the first list, then those of the second.
    type All: RobotList;

    /// What each of them looks at.
    fn split(all: &State<Self::All>) -> (State<Self>, State<B>);
}

impl<L: RobotList> SharedRobots<L> for L {
    type All = L;

    fn split(all: &State<L>) -> (State<L>, State<L>) {
        (State::new(**all), State::new(**all))
    }
}

impl<L: SensorList> SharedSensors<L> for L {
    type All = L;

    fn split(all: &Reading<L>) -> (Reading<L>, Reading<L>) {
        (Reading::new(**all), Reading::new(**all))
    }
}

/// `$Trait` of a list of robots and of none, in both orders.
macro_rules! with_no_robots {
    ($Trait:ident: [$($generics:tt)*] $list:ty) => {
        #[diagnostic::do_not_recommend]
        impl<$($generics)*> $Trait<AnyRobots> for $list {
            type All = $list;

            fn split(all: &State<$list>) -> (State<$list>, State<AnyRobots>) {
                (State::new(**all), State::new(()))
            }
        }

        #[diagnostic::do_not_recommend]
        impl<$($generics)*> $Trait<$list> for AnyRobots {
            type All = $list;

            fn split(all: &State<$list>) -> (State<AnyRobots>, State<$list>) {
                (State::new(()), State::new(**all))
            }
        }
    };
}

/// `SharedSensors` of a list of sensors and of none, in both orders.
macro_rules! with_no_sensors {
    ([$($generics:tt)*] $list:ty) => {
        #[diagnostic::do_not_recommend]
        impl<$($generics)*> SharedSensors<()> for $list {
            type All = $list;

            fn split(all: &Reading<$list>) -> (Reading<$list>, Reading<()>) {
                (Reading::new(**all), Reading::new(()))
            }
        }

        #[diagnostic::do_not_recommend]
        impl<$($generics)*> SharedSensors<$list> for () {
            type All = $list;

            fn split(all: &Reading<$list>) -> (Reading<()>, Reading<$list>) {
                (Reading::new(()), Reading::new(**all))
            }
        }
    };
}

with_no_robots! { SharedRobots: [R: Robot] R }
with_no_robots! { SharedRobots: [R: Robot, const N: usize] [R; N] }
with_no_robots! { JoinedRobots: [R: Robot] R }
with_no_robots! { JoinedRobots: [R: Robot, const N: usize] [R; N] }
with_no_sensors! { [S: Sensor, const N: usize] [S; N] }

macro_rules! tuples_of_robots {
    ($(($($R:ident),+))*) => {$(
        with_no_robots! { SharedRobots: [$($R: Robot),+] ($($R,)+) }
        with_no_robots! { JoinedRobots: [$($R: Robot),+] ($($R,)+) }
    )*};
}

macro_rules! tuples_of_sensors {
    ($(($($S:ident),+))*) => {$(
        with_no_sensors! { [$($S: Sensor),+] ($($S,)+) }
    )*};
}

tuples_of_robots! { (A) (A, B) (A, B, C) (A, B, C, D) (A, B, C, D, E) (A, B, C, D, E, F) (A, B, C, D, E, F, G) (A, B, C, D, E, F, G, H) }
tuples_of_sensors! { (A) (A, B) (A, B, C) (A, B, C, D) }

impl JoinedRobots<AnyRobots> for AnyRobots {
    type All = AnyRobots;

    fn split(_: &State<AnyRobots>) -> (State<AnyRobots>, State<AnyRobots>) {
        (State::new(()), State::new(()))
    }
}

/// The robot of an ECP is the only one that it has.
impl<R: Robot> JoinedRobots<R> for R {
    type All = R;

    fn split(all: &State<R>) -> (State<R>, State<R>) {
        (State::new(**all), State::new(**all))
    }
}

macro_rules! joined {
    ($(($($R:ident $i:tt),+) ($($T:ident $j:tt),+);)*) => {$(
        #[diagnostic::do_not_recommend]
        impl<$($R: Robot,)+ $($T: Robot,)+> JoinedRobots<($($T,)+)> for ($($R,)+) {
            type All = ($($R,)+ $($T,)+);

            fn split(all: &State<Self::All>) -> (State<($($R,)+)>, State<($($T,)+)>) {
                (State::new(($(all.$i,)+)), State::new(($(all.$j,)+)))
            }
        }
    )*};
}

joined! {
    (R 0) (T 1);
    (R 0) (T 1, U 2);
    (R 0) (T 1, U 2, V 3);
    (R 0, T 1) (U 2);
    (R 0, T 1) (U 2, V 3);
    (R 0, T 1, U 2) (V 3);
}
