//! Values of one type, range and form, of which any key may have one.

use core::ops::{Range, RangeInclusive};
use core::time::Duration;

use mrroc_core::nalgebra::Translation3;
use mrroc_core::pose::{Pose, Zyz};
use mrroc_core::suggestion::suggestion;
use toml::de::{DeTable, DeValue};

use super::super::error::At;
use super::{Reader, Value};

pub(in super::super) const POSE_KEYS: [&str; 2] = ["position", "zyz"];

/// What is farther away than this in a cell, or from a robot's flange, is asked about \[m\] ..
pub(super) const IN_CELL: f64 = 30.0;
pub(super) const ON_FLANGE: f64 = 3.0;
/// .. and what is turned by more \[rad\].
const MOST_TURNED: f64 = 6.3;

/// How a pose is written.
const POSE: &str = "{ position = [x, y, z], zyz = [a, b, c] } [m, rad]";

impl Reader {
    /// Reports the keys that are not known.
    pub(super) fn known(&mut self, table: &DeTable<'_>, keys: &[&str], owner_has: &str) {
        for key in table.keys() {
            if !keys.contains(&key.get_ref().as_ref()) {
                let what = format!("unknown key `{}`", key.get_ref());
                self.complain(&key.span(), what, suggestion(key.get_ref(), keys, owner_has));
            }
        }
    }

    pub(super) fn wrong_type(&mut self, value: &Value<'_>, expected: &str) {
        let what = format!("a {} where {expected} is due", value.get_ref().type_str());
        self.complain(&value.span(), what, format!("write {expected}"));
    }

    pub(super) fn number(&mut self, value: &Value<'_>, expected: &str) -> Option<At<f64>> {
        let parsed = match value.get_ref() {
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|integer| integer as f64)
            }
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            DeValue::String(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_)
            | DeValue::Array(_)
            | DeValue::Table(_) => {
                self.wrong_type(value, expected);
                return None;
            }
        };
        let finite = parsed.filter(|number| number.is_finite());
        if finite.is_none() {
            let help = format!("write {expected}");
            self.complain(&value.span(), "not a finite number".to_owned(), help);
        }
        finite.map(|number| At { value: number, span: value.span() })
    }

    pub(super) fn numbers(&mut self, value: &Value<'_>, expected: &str) -> Option<At<Vec<At<f64>>>> {
        let DeValue::Array(array) = value.get_ref() else {
            self.wrong_type(value, expected);
            return None;
        };
        let numbers: Vec<_> = array.iter().map(|number| self.number(number, "a number")).collect();
        let numbers: Option<Vec<_>> = numbers.into_iter().collect();
        numbers.map(|numbers| At { value: numbers, span: value.span() })
    }

    /// Reads a whole number in a range.
    pub(super) fn whole(
        &mut self,
        number: &At<f64>,
        range: RangeInclusive<usize>,
        expected: &str,
    ) -> Option<usize> {
        let found = range.into_iter().find(|&whole| whole as f64 == number.value);
        if found.is_none() {
            let what = if number.value.fract() == 0.0 { "out of range" } else { "not a whole number" };
            self.complain(&number.span, format!("{} is {what}", number.value), format!("write {expected}"));
        }
        found
    }

    pub(super) fn text<'t>(&mut self, value: &'t Value<'_>, expected: &str) -> Option<&'t str> {
        let text = value.get_ref().as_str();
        if text.is_none() {
            self.wrong_type(value, expected);
        }
        text
    }

    pub(super) fn truth(&mut self, value: &Value<'_>, expected: &str) -> Option<At<bool>> {
        let truth = value.get_ref().as_bool();
        if truth.is_none() {
            self.wrong_type(value, expected);
        }
        truth.map(|truth| At { value: truth, span: value.span() })
    }

    /// Reads a time in milliseconds, from 0.1 ms to a minute.
    pub(super) fn duration(&mut self, value: &Value<'_>) -> Option<Duration> {
        const RANGE: &str = "a number of milliseconds from 0.1 to 60000";
        let ms = self.number(value, RANGE)?;
        if (0.1..=60e3).contains(&ms.value) {
            // Rounded to whole nanoseconds, in which the cell's clock counts.
            return Some(Duration::from_nanos((ms.value * 1e6).round() as u64));
        }
        self.complain(&ms.span, format!("{} ms", ms.value), format!("write {RANGE}"));
        None
    }

    /// Reads a list of names, each of which must be among `there`.
    pub(super) fn names(&mut self, value: &Value<'_>, of: &str, there: &[String]) -> Option<Vec<String>> {
        let expected = format!("a list of names of {of}, in quotes");
        let DeValue::Array(array) = value.get_ref() else {
            self.wrong_type(value, &expected);
            return None;
        };
        let known: Vec<_> = there.iter().map(String::as_str).collect();
        let names: Vec<_> = array
            .iter()
            .map(|value| {
                let name = self.text(value, &expected)?;
                if !known.contains(&name) {
                    let what = format!("`{name}` is none of the {of}");
                    self.complain(&value.span(), what, suggestion(name, &known, "there are"));
                    return None;
                }
                Some(name.to_owned())
            })
            .collect();
        names.into_iter().collect()
    }

    /// Reads `{ position = [x, y, z], zyz = [a, b, c] }` [m, rad]; each is zero by default. Asks about what is farther away.
    pub(super) fn pose(&mut self, value: &Value<'_>, farthest: f64) -> Option<Pose> {
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong_type(value, POSE);
            return None;
        };
        self.known(table, &POSE_KEYS, "a pose has");
        self.pose_of(table, farthest)
    }

    /// Reads `position` and `zyz` of a table; each is zero by default. Asks about what is farther away.
    pub(super) fn pose_of(&mut self, table: &DeTable<'_>, farthest: f64) -> Option<Pose> {
        let mut three = |key: &str| {
            let Some(value) = table.get(key) else { return Some([0.0; 3]) };
            let numbers = self.numbers(value, "three numbers")?;
            if let [x, y, z] = numbers.value.as_slice() {
                let three = [x.value, y.value, z.value];
                if key == "zyz" {
                    self.ask_about_angles(three, &numbers.span);
                } else {
                    self.ask_about_place(three, farthest, &numbers.span);
                }
                return Some(three);
            }
            let what = format!("`{key}` has {} numbers", numbers.value.len());
            self.complain(&numbers.span, what, format!("write three: {POSE}"));
            None
        };
        let ([x, y, z], [alpha, beta, gamma]) = (three("position")?, three("zyz")?);
        Some(Pose::from_parts(Translation3::new(x, y, z), Zyz { alpha, beta, gamma }.rotation()))
    }

    /// Asks about angles that are more than a turn.
    fn ask_about_angles(&mut self, three: [f64; 3], at: &Range<usize>) {
        let largest = three.map(f64::abs).into_iter().fold(0.0, f64::max);
        if largest > MOST_TURNED {
            let what = format!("an angle of {largest} rad: are these degrees?");
            self.ask(at, what, "write radians: 90 degrees are 1.570796");
        }
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
