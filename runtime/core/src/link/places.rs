//! Sets of processes of a cell, by their places.
//!
//! In: places. Out: a set that is copied and joined in a few instructions, and travels as words.

use core::cell::Cell;

/// The most processes that a cell can have, its plant among them.
pub const MAX_PROCESSES: usize = 192;

const WORDS: usize = MAX_PROCESSES / 64;

/// A set of places below [`MAX_PROCESSES`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Places([u64; WORDS]);

impl Places {
    /// How many words a set has.
    pub const WORDS: usize = WORDS;

    /// A set without places.
    pub const NONE: Places = Places([0; WORDS]);

    /// The set of one place.
    #[must_use]
    pub const fn of(place: usize) -> Places {
        Places::NONE.with(place)
    }

    /// The set as words of a message.
    #[must_use]
    pub const fn to_words(self) -> [u64; WORDS] {
        self.0
    }

    /// The set in words of a message.
    #[must_use]
    pub const fn from_words(words: [u64; WORDS]) -> Places {
        Places(words)
    }

    /// The set and a place; a place that no process can have is left out.
    #[must_use]
    pub const fn with(mut self, place: usize) -> Places {
        if place < MAX_PROCESSES {
            self.0[place / 64] |= 1 << (place % 64);
        }
        self
    }

    /// The set without a place.
    #[must_use]
    pub const fn without(mut self, place: usize) -> Places {
        if place < MAX_PROCESSES {
            self.0[place / 64] &= !(1 << (place % 64));
        }
        self
    }

    /// The places of both sets.
    #[must_use]
    pub fn and(self, other: Places) -> Places {
        Places(core::array::from_fn(|i| self.0[i] | other.0[i]))
    }
}

/// A set of places that changes in every step of a cell: one word of it at a time.
#[derive(Debug, Default)]
pub(super) struct PlaceCells([Cell<u64>; WORDS]);

impl PlaceCells {
    /// Puts a place into the set; one that no process can have is left out.
    #[inline]
    pub fn insert(&self, place: usize) {
        if let Some(word) = self.0.get(place / 64) {
            word.set(word.get() | 1 << (place % 64));
        }
    }

    /// Puts all places of another set into this one.
    pub fn insert_all(&self, places: Places) {
        for (word, more) in self.0.iter().zip(places.0) {
            word.set(word.get() | more);
        }
    }

    /// Takes a place out of the set.
    #[inline]
    pub fn remove(&self, place: usize) {
        if let Some(word) = self.0.get(place / 64) {
            word.set(word.get() & !(1 << (place % 64)));
        }
    }

    /// Whether a place is in both sets.
    #[inline]
    pub fn meets(&self, other: &PlaceCells) -> bool {
        self.0.iter().zip(&other.0).any(|(a, b)| a.get() & b.get() != 0)
    }

    /// The lowest place of the set.
    #[inline]
    pub fn first(&self) -> Option<usize> {
        let (i, word) = self.0.iter().enumerate().find(|(_, word)| word.get() != 0)?;
        Some(64 * i + word.get().trailing_zeros() as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn take_first(set: &PlaceCells) -> Option<usize> {
        set.first().inspect(|&place| set.remove(place))
    }

    #[test]
    fn places_are_taken_out_of_a_set_from_the_lowest_to_the_highest() {
        let set = PlaceCells::default();
        set.insert_all(Places::of(127).with(64));
        for place in [3, 191, 0, 3, MAX_PROCESSES] {
            set.insert(place);
        }
        let taken: Vec<_> = std::iter::from_fn(|| take_first(&set)).collect();
        assert_eq!(taken, [0, 3, 64, 127, 191]);
    }

    #[test]
    fn every_place_is_in_the_set_that_it_was_put_into_and_the_lowest_comes_first() {
        let all = [0, 1, 63, 64, 127, 128, MAX_PROCESSES - 1];
        let mut set = all.iter().rev().fold(Places::NONE, |set, &place| set.and(Places::of(place)));
        assert_eq!(Places::from_words(set.to_words()), set);
        let cells = PlaceCells::default();
        cells.insert_all(set);
        for place in all {
            assert_eq!(take_first(&cells), Some(place));
            assert_ne!(set, set.without(place));
            set = set.without(place);
        }
        assert_eq!((set, take_first(&cells)), (Places::NONE, None));
        assert_eq!(Places::of(MAX_PROCESSES).without(MAX_PROCESSES), Places::NONE);
    }
}
