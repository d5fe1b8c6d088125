//! The generators' own source text: what is copied into a project to be changed there.

use mrroc::{Class, Generator, Limits, NoInverse, Pose, Robot, Sensor};
use nalgebra::{Vector1, Vector3};

use crate::generators::{GuardedApproach, JointMove, SplineTrack, StraightLine};

/// One generator of the library.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Name of its module and, with `.rs`, of its file.
    pub name: &'static str,
    /// Name of its type.
    pub type_name: &'static str,
    /// Its class, which does not depend on the kinds of robot and sensor.
    pub class: Class,
    /// The text of its file, on the public interface alone.
    pub source: &'static str,
}

impl Entry {
    /// What it does: the first line of its file.
    #[must_use]
    pub fn summary(&self) -> &'static str {
        self.source.lines().next().unwrap_or_default().trim_start_matches("//!").trim()
    }
}

macro_rules! entry {
    ($name:literal, $type_name:literal, $generator:ty) => {
        Entry {
            name: $name,
            type_name: $type_name,
            class: <$generator as Generator>::CLASS,
            source: include_str!(concat!("generators/", $name, ".rs")),
        }
    };
}

/// All generators of the library, by name.
pub const CATALOGUE: &[Entry] = &[
    entry!("guarded_approach", "GuardedApproach", GuardedApproach<Any, Any>),
    entry!("joint_move", "JointMove", JointMove<Any>),
    entry!("spline_track", "SplineTrack", SplineTrack<Any, core::iter::Empty<Vector3<f64>>>),
    entry!("straight_line", "StraightLine", StraightLine<Any>),
];

/// Any kind of robot or sensor: there is none of it.
#[derive(Clone, Copy, Debug)]
enum Any {}

impl Robot for Any {
    const KIND: &'static str = "any";
    type Joints = Vector1<f64>;

    fn limits(&self) -> &Limits<Self::Joints> {
        match *self {}
    }

    fn forward(&self, _: &Self::Joints) -> Pose {
        match *self {}
    }

    fn inverse(&self, _: &Pose, _: &Self::Joints) -> Result<Self::Joints, NoInverse> {
        match *self {}
    }
}

impl Sensor for Any {
    const KIND: &'static str = "any";
    type Reading = ();
    type Configuration = ();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_generator_of_the_library_is_in_the_catalogue() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/generators");
        let mut files: Vec<_> = std::fs::read_dir(folder)
            .expect("the folder of the generators")
            .map(|entry| entry.expect("an entry").file_name().into_string().expect("a plain name"))
            .filter(|file| file != "mod.rs")
            .collect();
        files.sort();
        assert_eq!(files, CATALOGUE.iter().map(|entry| format!("{}.rs", entry.name)).collect::<Vec<_>>());
    }

    #[test]
    fn every_entry_says_what_it_does_and_is_short() {
        for entry in CATALOGUE {
            assert!(entry.source.starts_with("//! ") && entry.summary().ends_with('.'), "{}", entry.name);
            assert!(entry.source.contains(&format!("pub struct {}", entry.type_name)), "{}", entry.name);
            let (generator, tests) = entry.source.split_once("#[cfg(test)]").expect("its test");
            assert!(generator.lines().count() < 100 && tests.contains("#[test]"), "{}", entry.name);
        }
    }
}
