//! Goals that come from a bag, one after the other.
//!
//! In: what became of the one at work. Out: the next one, and lines on the console. The first that does not succeed ends it: the next one begins where
//! that one should have led.

use std::collections::VecDeque;

use mrroc_core::console::complain;
use ros2_client::action_msgs::{GoalId, GoalStatusEnum};

use super::messages::{INVALID_JOINTS, Outcome, Request};

/// How long a cell must have said that its program is there before a goal is sent \[ns\]: what it hears before its robots are offered is old.
const SETTLED: u64 = 1_000_000_000;

/// Goals of a bag.
pub struct Playback {
    waiting: VecDeque<Request>,
    /// The robot that they are all for.
    pub only: Option<usize>,
    count: usize,
    at_work: Option<GoalId>,
    /// Since when the cell takes goals \[ns\].
    ready: Option<u64>,
}

impl Playback {
    /// Of these goals.
    pub fn of(goals: Vec<Request>, only: Option<usize>) -> Playback {
        let count = goals.len();
        Playback { waiting: goals.into(), only, count, at_work: None, ready: None }
    }

    /// The goal that the robots follow.
    pub const fn at_work(&self) -> Option<GoalId> {
        self.at_work
    }

    /// The goal at work has ended.
    pub fn ended(&mut self, status: GoalStatusEnum, outcome: &Outcome) {
        self.at_work = None;
        let number = self.count - self.waiting.len();
        let of = format!("bag: trajectory {number} of {}", self.count);
        if status == GoalStatusEnum::Succeeded {
            complain(&format!("{of}: done"));
        } else {
            let skipped = match self.waiting.len() {
                0 => String::new(),
                left => format!("; {left} more are not sent"),
            };
            self.waiting.clear();
            let help = match outcome.error_code {
                INVALID_JOINTS => "\n help: name the robot whose joints they are by --robot",
                _ if outcome.is_elsewhere => {
                    "\n help: --approach gives the robots time to get to the first point"
                }
                _ => "",
            };
            complain(&format!("{of}: {}{skipped}{help}", outcome.error_string));
        }
    }

    /// The next goal at a time of the machine's monotonic clock \[ns\], where none is at work and a cell has taken goals for long enough.
    pub fn next(&mut self, now: u64, is_ready: bool) -> Option<(GoalId, Request)> {
        if !is_ready {
            self.ready = None;
            return None;
        }
        let since = *self.ready.get_or_insert(now);
        if self.at_work.is_some() || now.saturating_sub(since) < SETTLED {
            return None;
        }
        let goal = self.waiting.pop_front()?;
        let id = GoalId::new_random();
        self.at_work = Some(id);
        Some((id, goal))
    }
}
