//! All generators of the library: each keeps what a generator must keep, and others go through them row by row.
//!
//! In: `rows.rs`, and `kit.rs` of the conformance for what its rows are made of. Out: the tests of each row, and the rows.

use std::f64::consts::TAU;

use mrroc::fault::FaultKind;
use mrroc::generator::{Class, Generator};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc_generators::conformance::{DT, Given};
use mrroc_generators::cooperation::{BodyFrame, Displacement, FreeDirection, StraightBody};
use mrroc_generators::curve::Helix;
use mrroc_generators::force::{Bound, Give};
use mrroc_generators::generator_conformance;
use mrroc_generators::generators::*;
use mrroc_generators::jogging::JogLimits;
use mrroc_generators::profile::JerkLimits;
use mrroc_generators::teach::{Jogging, Space, Taught};
use mrroc_robots::{Irp6, Irp6FiveDof, Six};
use nalgebra::Vector3;

use super::conformance::kit::*;
use super::goals::moved;

/// A motion to a goal that the arm does not reach: the fault in which it ends, and how far any joint was demanded to go [rad].
pub type OutOfReach = fn() -> (Fault, f64);

/// A generator of the library.
pub struct Row {
    /// Names of its module and of its type.
    pub name: &'static str,
    pub type_name: &'static str,
    /// Its class, which does not depend on the kinds of robot and sensor.
    pub class: Class,
    /// The text of its file.
    pub source: &'static str,
    /// Whether its first step allocates, as it solves a path or lists its goals; and the bytes that it allocates.
    pub allocates: bool,
    pub first_step: fn() -> usize,
    /// What it is refused for, where its goal is out of reach.
    pub out_of_reach: Vec<(FaultKind, OutOfReach)>,
}

/// Bytes that the first step of a generator allocates.
fn first_step<G: Generator>(mut generator: G, given: fn(u64) -> Given<G>) -> usize {
    let Given { order, e, v } = given(0);
    let before = bytes();
    let step = generator.first_step(&order, &e, &v, Tick { step: 0, dt: DT, duration: DT });
    let allocated = bytes() - before;
    assert!(step.is_ok());
    allocated
}

macro_rules! registry {
    ($($list:ident: {
        $($name:ident: $generator:ident<$($parameter:ty),*> {
            class: $class:literal,
            make: $make:expr,
            given: $given:expr,
            odd: $odd:expr,
            $(allocates: $allocates:literal,)?
            $(out_of_reach: [$($kind:ident: $goal:expr),* $(,)?],)?
        })*
    })*) => {
        $($(generator_conformance! {
            $name: $generator<$($parameter),*>,
            class: $class,
            make: $make,
            given: $given,
            odd: $odd,
            allocated: bytes,
        })*)*

        /// All generators of the library, by name.
        pub fn rows() -> Vec<Row> {
            let mut rows = vec![$($(Row {
                name: stringify!($name),
                type_name: stringify!($generator),
                class: <$generator<$($parameter),*> as Generator>::CLASS,
                source: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/generators/", stringify!($name), ".rs")),
                allocates: [$($allocates,)? false][0],
                first_step: || first_step::<$generator<$($parameter),*>>($make, $given),
                out_of_reach: vec![$($((FaultKind::$kind, (|| moved($goal)) as OutOfReach)),*)?],
            }),*),*];
            rows.sort_by_key(|row| row.name);
            rows
        }
    };
}

include!("rows.rs");

#[test]
fn every_generator_of_the_folder_is_in_the_registry() {
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/src/generators"));
    let files = files.expect("the folder of the generators");
    let files = files.map(|entry| entry.expect("an entry").file_name().into_string().expect("a plain name"));
    let mut names: Vec<_> = files.filter_map(|file| Some(file.strip_suffix(".rs")?.to_owned())).collect();
    names.retain(|name| name != "mod");
    names.sort();
    assert_eq!(names, rows().iter().map(|row| row.name).collect::<Vec<_>>());
}
