//! Values that a picture has as words, to the bit, and as the processes write them on the state board.
//!
//! In: a value. Out: its words, and from these the same value again, checked.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use mrroc_core::operator::CellState;
use mrroc_core::operator::jog::JogStop;
use mrroc_core::operator::state::InstructionKind;
use mrroc_core::payload::Wire;
use mrroc_core::pose::Pose;
use mrroc_core::robot::{Load, Signals};

/// A value that is written as words.
pub(super) trait AsWords: Sized {
    fn words(&self) -> Vec<u64>;
    fn read(words: &[u64]) -> Option<Self>;
}

pub(super) fn serialize<T: AsWords, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
    value.words().serialize(to)
}

pub(super) fn deserialize<'de, T: AsWords, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    let words = Vec::<u64>::deserialize(from)?;
    T::read(&words).ok_or_else(|| D::Error::custom("words that are no value of their type"))
}

fn words_of<T: Wire>(value: &T) -> Vec<u64> {
    let mut words = vec![0; T::LEN];
    value.put(&mut words);
    words
}

macro_rules! as_words {
    ($($type:ty: $words:expr, $read:expr;)*) => {$(
        impl AsWords for $type {
            fn words(&self) -> Vec<u64> {
                const WORDS: fn(&$type) -> Vec<u64> = $words;
                WORDS(self)
            }
            fn read(words: &[u64]) -> Option<Self> {
                const READ: fn(&[u64]) -> Option<$type> = $read;
                READ(words)
            }
        }
    )*};
}

as_words! {
    Pose: words_of, |words| Pose::get(words).ok();
    Signals: words_of, |words| Signals::get(words).ok();
    Option<Load>: |load| load.iter().flat_map(words_of).collect(), |words| match words {
        [] => Some(None),
        words => Load::get(words).ok().map(Some),
    };
    Vec<f64>: |numbers| numbers.iter().map(|x| x.to_bits()).collect(),
        |words| Some(words.iter().map(|word| f64::from_bits(*word)).collect());
    CellState: |state| vec![*state as u64], |words| CellState::from_word(*words.first()?);
    InstructionKind: |doing| vec![*doing as u64], |words| InstructionKind::from_word(*words.first()?);
    JogStop: |stop| vec![stop.to_word()], |words| words.first().copied().map(JogStop::from_word);
}
