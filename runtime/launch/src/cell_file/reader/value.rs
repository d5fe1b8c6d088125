//! Values of one type, range and form, of which any key may have one.

use core::ops::RangeInclusive;
use core::time::Duration;

use mrroc_core::suggestion::suggestion;
use toml::de::{DeTable, DeValue};

use super::super::error::At;
use super::{Reader, Value};

/// Keys of former versions, with those that have replaced them.
const FORMER: [(&str, &str); 2] = [("position", "xyz"), ("rotation_vector", "quat_xyzw")];

impl Reader {
    /// Reports the keys that are not known.
    pub(super) fn known(&mut self, table: &DeTable<'_>, keys: &[&str], owner_has: &str) {
        for key in table.keys() {
            if !keys.contains(&key.get_ref().as_ref()) {
                let what = format!("unknown key `{}`", key.get_ref());
                let is_former = |(former, now): &&(&str, &str)| key.get_ref() == former && keys.contains(now);
                let help = match FORMER.iter().find(is_former) {
                    Some((_, now)) => format!("write {now}"),
                    None => suggestion(key.get_ref(), keys, owner_has),
                };
                self.complain(&key.span(), what, help);
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
}
