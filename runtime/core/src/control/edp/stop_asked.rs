//! A stop that a console asks for where every process sees it.
//!
//! In: how many stops were asked for, and how many the MP has begun to carry out, looked at in every step. Out: whether the robot
//! is to stop by itself. The MP stops all robots on their paths. If it has not begun to after `L + 1` steps, it stands still or
//! computes, and its robots do not wait for it.

use core::time::Duration;

use crate::link::StopBoard;
use crate::safety::stopping::missed_step_budget;

/// What an EDP has seen of the stops that were asked for.
pub(super) struct StopAsked {
    seen: u64,
    /// The step in which it saw the first stop that the MP has not begun.
    since: Option<u64>,
    /// Steps that the MP has to begin.
    budget: u64,
}

impl StopAsked {
    /// None yet, in steps of this length.
    pub fn new(step: Duration) -> StopAsked {
        StopAsked { seen: 0, since: None, budget: u64::from(missed_step_budget(step)) + 1 }
    }

    /// Whether the robot is to stop by itself in this step; said once for each stop.
    #[inline]
    pub fn is_overdue(&mut self, step: u64, board: &dyn StopBoard) -> bool {
        let asked = board.asked();
        if asked != self.seen {
            self.seen = asked;
            self.since = self.since.or(Some(step));
        }
        let Some(since) = self.since else { return false };
        let begun = board.begun() >= self.seen;
        let overdue = !begun && step >= since + self.budget;
        if overdue || begun {
            self.since = None;
        }
        overdue
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many stops were asked for, and how many were begun.
    struct Board(u64, u64);

    impl StopBoard for Board {
        fn asked(&self) -> u64 {
            self.0
        }

        fn begun(&self) -> u64 {
            self.1
        }
    }

    /// The steps in which the robot is told to stop, of 100, by what was asked for and begun in each.
    fn stops(of: impl Fn(u64) -> (u64, u64)) -> Vec<u64> {
        let mut stop = StopAsked::new(Duration::from_millis(2));
        (0..100)
            .filter(|&step| {
                let (asked, begun) = of(step);
                stop.is_overdue(step, &Board(asked, begun))
            })
            .collect()
    }

    /// `L` is 10 in steps of 2 ms.
    #[test]
    fn a_stop_that_the_mp_does_not_begin_is_the_robots_own_after_l_and_one_steps() {
        assert_eq!(stops(|step| (u64::from(step >= 20), 0)), [31]);
        // A second one, however soon it comes, does not put off the first.
        assert_eq!(stops(|step| (u64::from(step >= 20) + u64::from(step >= 30), 0)), [31]);
        assert_eq!(stops(|step| (u64::from(step >= 20) + u64::from(step >= 40), 0)), [31, 51]);
    }

    #[test]
    fn a_stop_that_the_mp_begins_in_time_is_left_to_it() {
        assert_eq!(stops(|step| (u64::from(step >= 20), u64::from(step >= 30))), [0; 0]);
        assert_eq!(stops(|step| (u64::from(step >= 20), u64::from(step >= 31))), [0; 0]);
        assert_eq!(stops(|step| (u64::from(step >= 20), u64::from(step >= 32))), [31]);
        assert_eq!(stops(|_| (0, 0)), [0; 0]);
    }
}
