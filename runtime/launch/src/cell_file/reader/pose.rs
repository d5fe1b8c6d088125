//! Poses: a position `xyz`, and an orientation as `rpy`, `quat_xyzw` or `zyz`.
//!
//! In: a table of the cell file, or of a file that a calibration has written. Out: the [`Pose`]; a part that is left out is zero.

use core::ops::Range;

use mrroc_core::nalgebra::{Quaternion, Translation3, UnitQuaternion};
use mrroc_core::pose::{Pose, Rpy, Zyz};
use toml::de::{DeTable, DeValue};

use super::super::error::At;
use super::{Reader, Value};

pub(in super::super) const POSE_KEYS: [&str; 4] = ["xyz", "rpy", "quat_xyzw", "zyz"];

/// What is farther away than this in a cell, or from a robot's flange, is asked about \[m\] ..
pub(super) const IN_CELL: f64 = 30.0;
pub(super) const ON_FLANGE: f64 = 3.0;
/// .. and what is turned by more \[rad\].
const MOST_TURNED: f64 = 6.3;

/// By how much the length of a quaternion may differ from 1.
const OFF_LENGTH: f64 = 1e-6;

/// How a pose is written.
const POSE: &str = "{ xyz = [x, y, z], rpy = [roll, pitch, yaw] } [m, rad]";

/// The forms of an orientation, with what each is.
const ORIENTATIONS: [(&str, Form, &str); 3] = [
    ("rpy", Form::Rpy, "three angles, rpy = [roll, pitch, yaw] [rad]"),
    ("quat_xyzw", Form::Quaternion, "a quaternion of length 1, quat_xyzw = [x, y, z, w]"),
    ("zyz", Form::Zyz, "three angles, zyz = [a, b, c] [rad]"),
];

#[derive(Clone, Copy)]
enum Form {
    /// Turns about the fixed axes x, y and z.
    Rpy,
    /// Its real part is the last number.
    Quaternion,
    /// Turns about the moved axes z, y and z.
    Zyz,
}

impl Reader {
    /// Reads `{ xyz = [x, y, z], rpy = [roll, pitch, yaw] }` [m, rad], or with another orientation. Asks about what is farther away.
    pub(super) fn pose(&mut self, value: &Value<'_>, farthest: f64) -> Option<Pose> {
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong_type(value, POSE);
            return None;
        };
        self.known(table, &POSE_KEYS, "a pose has");
        self.pose_of(table, farthest)
    }

    /// Reads the keys of a pose in a table that may have others. Asks about what is farther away.
    pub(super) fn pose_of(&mut self, table: &DeTable<'_>, farthest: f64) -> Option<Pose> {
        let place = match table.get("xyz") {
            None => Some([0.0; 3]),
            Some(value) => self.list(value, "xyz", "three lengths, xyz = [x, y, z] [m]").map(|place| {
                self.ask_about_place(place.value, farthest, &place.span);
                place.value
            }),
        };
        let rotation = self.orientation(table);
        let ([x, y, z], rotation) = (place?, rotation?);
        Some(Pose::from_parts(Translation3::new(x, y, z), rotation))
    }

    /// Reads the one orientation of a table.
    fn orientation(&mut self, table: &DeTable<'_>) -> Option<UnitQuaternion<f64>> {
        let written = ORIENTATIONS.iter().filter_map(|(key, form, expected)| {
            table.get_key_value(*key).map(|(key, value)| (key, value, *form, *expected))
        });
        let mut written: Vec<_> = written.collect();
        // In the order of the file, because the map is sorted by keys.
        written.sort_by_key(|(key, ..)| key.span().start);
        let Some((first, value, form, expected)) = written.first() else {
            return Some(UnitQuaternion::identity());
        };
        let others = &written[1..];
        for (second, ..) in others {
            let (first, second_key) = (first.get_ref(), second.get_ref());
            let what = format!("`{second_key}` beside `{first}`: both give the orientation");
            self.complain(&second.span(), what, format!("write `{first}` or `{second_key}`, not both"));
        }
        let rotation = match form {
            Form::Rpy => {
                let [roll, pitch, yaw] = self.angles(value, "rpy", expected)?;
                Rpy { roll, pitch, yaw }.rotation()
            }
            Form::Quaternion => self.quaternion(value, expected)?,
            Form::Zyz => {
                let [alpha, beta, gamma] = self.angles(value, "zyz", expected)?;
                Zyz { alpha, beta, gamma }.rotation()
            }
        };
        others.is_empty().then_some(rotation)
    }

    /// Reads three angles. Asks about those that are more than a turn.
    fn angles(&mut self, value: &Value<'_>, key: &str, expected: &str) -> Option<[f64; 3]> {
        let three = self.list(value, key, expected)?;
        let largest = three.value.map(f64::abs).into_iter().fold(0.0, f64::max);
        if largest > MOST_TURNED {
            let what = format!("an angle of {largest} rad: are these degrees?");
            self.ask(&three.span, what, "write radians: 90 degrees are 1.570796");
        }
        Some(three.value)
    }

    fn quaternion(&mut self, value: &Value<'_>, expected: &str) -> Option<UnitQuaternion<f64>> {
        let four: At<[f64; 4]> = self.list(value, "quat_xyzw", expected)?;
        let [x, y, z, w] = four.value;
        let quaternion = Quaternion::new(w, x, y, z);
        let length = quaternion.norm();
        if (length - 1.0).abs() > OFF_LENGTH {
            let what =
                format!("a quaternion of length {length}, which differs from 1 by more than {OFF_LENGTH}");
            self.complain(&four.span, what, format!("write {expected}, or write rpy"));
            return None;
        }
        Some(UnitQuaternion::new_normalize(quaternion))
    }

    /// Reads a list of `N` numbers.
    fn list<const N: usize>(&mut self, value: &Value<'_>, key: &str, expected: &str) -> Option<At<[f64; N]>> {
        let numbers = self.numbers(value, expected)?;
        let values: Vec<_> = numbers.value.iter().map(|number| number.value).collect();
        let list = <[f64; N]>::try_from(values).ok();
        if list.is_none() {
            let what = format!("`{key}` has {} numbers", numbers.value.len());
            self.complain(&numbers.span, what, format!("write {expected}"));
        }
        list.map(|list| At { value: list, span: numbers.span })
    }

    /// Asks about a place that is farther away than is probable.
    pub(super) fn ask_about_place(&mut self, three: [f64; 3], farthest: f64, at: &Range<usize>) {
        let largest = three.map(f64::abs).into_iter().fold(0.0, f64::max);
        if largest > farthest {
            let what = format!("a place {largest} m away: are these millimetres?");
            self.ask(at, what, "write metres: 300 mm are 0.3");
        }
    }
}
