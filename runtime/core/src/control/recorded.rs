//! Values that programs compute themselves and that a replay must not compute again: a plan, a random choice, what a file or a
//! network said.
//!
//! In: a name and what computes the value. Out: the value; its words go to the recording of the run, in parts of [`PART`] words. In a
//! replay the value is that of the recording, and nothing is computed.

use crate::control::replay::RecordedValues;
use crate::model::fault::{Fault, FaultKind, FaultWords};
use crate::model::name::Name;
use crate::model::wire::{WORDS, Wire};
use crate::observe::step_observer::StepEvent;

/// Words of a part, of which each is an event.
const PART: usize = WORDS;

/// The most words of a value: 8 MB.
const MOST: usize = 1 << 20;

/// What the first recorded word says: a value follows, or the fault with which the computation ended.
const VALUE: u64 = 0;
const FAULT: u64 = 1;

/// A value that can be recorded: it becomes words, of which it can be made again without loss.
pub trait Recorded: Sized {
    /// Its words, at most a million.
    fn to_words(&self) -> Vec<u64>;

    /// The value of these words; `None` if they are of no value.
    fn from_words(words: &[u64]) -> Option<Self>;
}

impl Recorded for Vec<u64> {
    fn to_words(&self) -> Vec<u64> {
        self.clone()
    }

    fn from_words(words: &[u64]) -> Option<Self> {
        Some(words.to_vec())
    }
}

impl Recorded for Vec<f64> {
    fn to_words(&self) -> Vec<u64> {
        self.iter().map(|number| number.to_bits()).collect()
    }

    fn from_words(words: &[u64]) -> Option<Self> {
        Some(words.iter().map(|word| f64::from_bits(*word)).collect())
    }
}

/// Computes a value and shows it part by part, or takes it from a recording.
pub(super) fn recorded<T: Recorded>(
    name: &str,
    step: u64,
    replayed: Option<&RecordedValues>,
    show: impl Fn(&StepEvent, &[u64]),
    compute: impl FnOnce() -> Result<T, Fault>,
) -> Result<T, Fault> {
    let config = |text: &str| Fault::new(FaultKind::Config).text(text);
    let named = Name::new(name).map_err(|bad| config(&bad.to_string()))?;
    if let Some(replayed) = replayed {
        let missing =
            || config(&format!("the recording has no value `{name}` here: another program made it"));
        return match replayed.next(named).ok_or_else(missing)? {
            [VALUE, words @ ..] => T::from_words(words).ok_or_else(missing),
            [FAULT, words @ ..] if words.len() >= FaultWords::LEN => {
                Err(FaultWords::get(words).map_or_else(|_| missing(), Fault::from))
            }
            _ => Err(missing()),
        };
    }
    let outcome = compute();
    let words = match &outcome {
        Ok(value) => [vec![VALUE], value.to_words()].concat(),
        Err(fault) => {
            let mut words = vec![FAULT; 1 + FaultWords::LEN];
            FaultWords::from(fault).put(&mut words[1..]);
            words
        }
    };
    if words.len() > MOST {
        return Err(config(&format!("`{name}` has {} words, {MOST} can be recorded", words.len() - 1)));
    }
    let left = words.len().div_ceil(PART);
    for (k, part) in words.chunks(PART).enumerate() {
        show(&StepEvent::Value { step, name: named, left: (left - 1 - k) as u32 }, part);
    }
    outcome
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::replay::values::RecordedValue;
    use std::cell::RefCell;

    /// What a recording has of a value that is computed so.
    fn shown(compute: impl FnOnce() -> Result<Vec<f64>, Fault>) -> RecordedValues {
        let values = RefCell::new(Vec::<RecordedValue>::new());
        let left = core::cell::Cell::new(0);
        let show = |what: &StepEvent, words: &[u64]| {
            let StepEvent::Value { step: 7, name, left: now } = *what else { panic!("{what:?}") };
            let mut values = values.borrow_mut();
            if left.get() == 0 {
                values.push(RecordedValue { name, words: Vec::new() });
            } else {
                assert_eq!(now, left.get() - 1);
            }
            left.set(now);
            values.last_mut().expect("a value").words.extend(words);
        };
        let computed = compute();
        let outcome = recorded("numbers", 7, None, show, || computed.clone());
        assert_eq!(outcome, computed);
        assert_eq!(left.get(), 0);
        RecordedValues::of(values.into_inner())
    }

    fn again(from: &RecordedValues, name: &str) -> Result<Vec<f64>, Fault> {
        let show = |_: &StepEvent, _: &[u64]| panic!("a replay shows nothing");
        recorded(name, 7, Some(from), show, || panic!("a replay computes nothing"))
    }

    #[test]
    fn a_value_of_any_length_is_the_same_to_the_bit_in_a_replay_and_is_not_computed_again() {
        for count in [0, 1, 63, 64, 1000] {
            let numbers: Vec<f64> = (0..count).map(|k| 1.0 / (f64::from(k) - 0.3)).collect();
            let values = shown(|| Ok(numbers.clone()));
            assert_eq!(again(&values, "numbers"), Ok(numbers));
            let none = again(&values, "numbers").expect_err("it was there once");
            assert_eq!(none.kind(), FaultKind::Config);
        }
    }

    #[test]
    fn a_fault_of_a_computation_is_the_same_in_a_replay_and_another_name_is_refused() {
        let fault = Fault::thrown("no path found");
        let values = shown(|| Err(fault.clone()));
        let other = again(&values, "plan").expect_err("there is no plan");
        assert!(other.to_string().contains("no value `plan` here"), "{other}");
        assert_eq!(again(&values, "numbers"), Err(fault));
    }
}
