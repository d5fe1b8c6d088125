//! Hold-to-run: at reduced speed robots move only while a person holds something that says so again and again.
//!
//! In: renewals of holds, and that one is let go, from any thread. Out: whether a hold lasts, at the beginning of each step. A hold
//! that has ended, because it was let go or not renewed in time, never comes back: who wants to go on begins another one.

use core::time::Duration;

use crate::model::time::Nanos;

/// How long a hold lasts after its last renewal.
pub const LAPSE: Duration = Duration::from_millis(300);

/// Bits of a renewal's count.
const COUNT: u32 = 16;

/// One saying that a person still holds. The first renewal begins the hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Renewal {
    hold: u64,
    count: u16,
}

impl Renewal {
    /// The first renewal of a hold. `hold` is a number that grows from hold to hold, such as the milliseconds since the machine
    /// started, of which 48 bits count: a smaller one than that of a hold that has ended begins nothing.
    #[must_use]
    pub const fn first(hold: u64) -> Renewal {
        Renewal { hold: hold & (u64::MAX >> COUNT), count: 0 }
    }

    /// The next renewal of the same hold; `None` after 65,535 of them: then the hold has to be begun anew.
    #[must_use]
    pub const fn next(self) -> Option<Renewal> {
        match self.count.checked_add(1) {
            Some(count) => Some(Renewal { count, ..self }),
            None => None,
        }
    }

    /// The renewal of this count, from 0, of a hold; `None` if either number is too large.
    #[must_use]
    pub fn of(hold: u64, count: u64) -> Option<Renewal> {
        let fits = hold <= u64::MAX >> COUNT;
        u16::try_from(count).ok().filter(|_| fits).map(|count| Renewal { hold, count })
    }

    /// How many renewals of its hold were before it.
    #[must_use]
    pub const fn count(self) -> u16 {
        self.count
    }

    /// The number of its hold.
    #[must_use]
    pub const fn hold(self) -> u64 {
        self.hold
    }

    /// In one word: that of a later renewal is greater.
    pub const fn to_word(self) -> u64 {
        self.hold << COUNT | self.count as u64
    }

    /// Back from it.
    pub const fn from_word(word: u64) -> Renewal {
        Renewal { hold: word >> COUNT, count: word as u16 }
    }
}

/// The hold that lasts, if one does, as an MP keeps it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hold {
    /// The last renewal that was heard.
    last: Option<Renewal>,
    /// Until when it lasts, if it has not ended \[ns\].
    until: Option<Nanos>,
    /// All holds up to this one have ended.
    ended: Option<u64>,
}

impl Hold {
    /// Whether a hold lasts at `now` \[ns\], after the newest renewal so far, and the newest hold that was let go.
    pub fn lasts(&mut self, newest: Option<Renewal>, let_go: Option<u64>, now: Nanos) -> bool {
        if self.until.is_some_and(|until| now >= until) {
            self.end(self.last.map(Renewal::hold));
        }
        self.end(let_go);
        if newest > self.last {
            self.last = newest;
            let goes_on = newest.filter(|newest| Some(newest.hold) > self.ended);
            if let Some(renewal) = goes_on {
                // Those before it are over, should they be renewed once more.
                self.ended = self.ended.max(renewal.hold.checked_sub(1));
                self.until = Some(now + LAPSE.as_nanos() as Nanos);
            }
        }
        self.until.is_some()
    }

    /// The number of the hold that lasts.
    pub fn lasting(&self) -> Option<u64> {
        self.until.and(self.last).map(Renewal::hold)
    }

    /// All holds up to this one have ended.
    fn end(&mut self, hold: Option<u64>) {
        self.ended = self.ended.max(hold);
        if self.last.map(Renewal::hold) <= self.ended {
            self.until = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: Nanos = 1_000_000;

    #[test]
    fn fault_05_a_hold_ends_when_it_is_let_go_or_not_renewed_and_never_comes_back() {
        let mut hold = Hold::default();
        let first = Renewal::first(7);
        let second = first.next().expect("not the last");
        let third = second.next().expect("not the last");
        assert!(!hold.lasts(None, None, 0));
        assert!(hold.lasts(Some(first), None, 10 * MS));
        // The same renewal once more is none.
        assert!(hold.lasts(Some(first), None, 309 * MS));
        assert!(!hold.lasts(Some(first), None, 310 * MS));
        // Late: it ended before.
        assert!(!hold.lasts(Some(second), None, 311 * MS));
        let again = Renewal::first(8);
        assert!(hold.lasts(Some(again), None, 400 * MS));
        assert!(!hold.lasts(Some(again), Some(8), 401 * MS));
        assert!(!hold.lasts(again.next(), Some(8), 402 * MS));
        // An older hold does not begin any more.
        assert!(!hold.lasts(Some(third), Some(8), 403 * MS));
        assert!(hold.lasts(Some(Renewal::first(9)), Some(8), 404 * MS));
        // What is let go is that hold, and not the next one.
        assert!(hold.lasts(Some(Renewal::first(9)), Some(8), 405 * MS));
    }

    #[test]
    fn a_renewal_survives_its_word_and_later_ones_are_greater() {
        let first = Renewal::first(u64::MAX);
        assert_eq!(Renewal::from_word(first.to_word()), first);
        let next = first.next().expect("not the last");
        assert!(next > first && next.to_word() > first.to_word());
        assert!(Renewal::first(4) > (0..9).try_fold(Renewal::first(3), |at, _| at.next()).expect("nine"));
        assert_eq!(
            (0..u16::MAX).try_fold(Renewal::first(3), |at, _| at.next()).and_then(Renewal::next),
            None
        );
    }

    proptest! {
        #[test]
        fn no_hold_lasts_longer_than_its_lapse_after_the_last_new_renewal(
            events in prop::collection::vec((0_u64..4, 0_u16..4, 0_u64..400, prop::option::of(0_u64..4)), 0..40)
        ) {
            let mut hold = Hold::default();
            let (mut now, mut newest, mut let_go) = (0, None::<Renewal>, None::<u64>);
            let mut renewed = None;
            let mut over = [false; 4];
            let mut lasted: Option<u64> = None;
            for (id, count, wait, released) in events {
                now += wait * MS;
                // What the operator's handle keeps: the greatest of all.
                let renewal = Renewal { hold: id, count };
                if newest < Some(renewal) {
                    (newest, renewed) = (Some(renewal), Some(now));
                }
                let_go = let_go.max(released);
                let lasts = hold.lasts(newest, let_go, now);
                let of = newest.map(Renewal::hold);
                if lasts {
                    prop_assert!(renewed.is_some_and(|renewed| now < renewed + 300 * MS), "renewed at {renewed:?}, now {now}");
                    prop_assert!(of > let_go, "{of:?} was let go");
                    prop_assert!(!over[of.unwrap_or(0) as usize], "{of:?} had ended");
                }
                // One that lasted and does not, or another one than the one that lasts, is over.
                if let Some(before) = lasted.filter(|&before| !lasts || of != Some(before)) {
                    over[before as usize] = true;
                }
                lasted = if lasts { of } else { None };
            }
        }
    }
}
