//! A state over time, such as on and off, in bounded memory.
//!
//! In: the state, step by step; or a step in which nobody knew it. Out: spans of time in each of which it was the same; when
//! there are too many, neighbours become one.

use crate::svg::Range;

/// The most spans kept.
const CAPACITY: usize = 2000;

/// A time in which a state was the same, or neighbours that are shown as one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spell {
    /// From when to when \[s\]: until another state was seen.
    pub time: Range,
    /// The state; none where there are several.
    pub state: Option<u64>,
    /// How many states there are in it.
    pub count: u64,
}

/// A state over time.
#[derive(Clone, Debug, Default)]
pub(crate) struct States {
    spells: Vec<Spell>,
    /// The last state, while it is known.
    last: Option<u64>,
}

impl States {
    /// The state at a time \[s\].
    pub fn see(&mut self, time: f64, state: u64) {
        if !time.is_finite() || self.spells.last().is_some_and(|last| time < last.time.high) {
            return;
        }
        // What was seen before lasted until now.
        if self.last.is_some()
            && let Some(spell) = self.spells.last_mut()
        {
            spell.time.high = time;
        }
        if self.last != Some(state) {
            if self.spells.len() >= CAPACITY {
                self.spells = self.spells.chunks(2).map(merged).collect();
            }
            self.spells.push(Spell { time: Range { low: time, high: time }, state: Some(state), count: 1 });
            self.last = Some(state);
        }
    }

    /// Nobody knows the state until it is seen again.
    pub fn gap(&mut self) {
        self.last = None;
    }

    /// In order of time.
    pub fn spells(&self) -> &[Spell] {
        &self.spells
    }
}

fn merged(spells: &[Spell]) -> Spell {
    spells[1..].iter().fold(spells[0], |all, next| Spell {
        time: Range { low: all.time.low, high: next.time.high },
        state: all.state.filter(|_| all.state == next.state),
        count: all.count + next.count,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_lasts_until_another_one_is_seen_or_nobody_knows_it() {
        let mut states = States::default();
        for (time, state) in [(0.0, 0), (1.0, 0), (2.0, 1), (3.0, 1), (4.0, 0)] {
            states.see(time, state);
        }
        states.gap();
        states.see(7.0, 0);
        states.see(8.0, 0);
        let spell = |low, high, state| Spell { time: Range { low, high }, state: Some(state), count: 1 };
        assert_eq!(
            states.spells(),
            [spell(0.0, 2.0, 0), spell(2.0, 4.0, 1), spell(4.0, 4.0, 0), spell(7.0, 8.0, 0)]
        );
    }

    #[test]
    fn of_very_many_changes_neighbours_become_one_and_none_is_lost() {
        let mut states = States::default();
        for i in 0..10_001_u32 {
            states.see(f64::from(i), u64::from(i % 2));
        }
        assert!(states.spells().len() <= CAPACITY);
        assert_eq!(states.spells().iter().map(|spell| spell.count).sum::<u64>(), 10_001);
    }
}
