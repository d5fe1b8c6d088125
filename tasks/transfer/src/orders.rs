//! What the coordinator tells the robots. Loose: a phase, which each carries out on its own. Tight: a
//! [`Displacement`](mrroc_generators::cooperation::Displacement) in every step.

use mrroc::prelude::*;
use mrroc_robots::{Gripper, Polycrank, Rnt};

/// The arms, as instructions name them together.
pub type Arms = (Rnt, Polycrank);
/// Their hands.
pub type Hands = [Gripper; 2];

/// A phase of the task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Payload)]
pub enum Phase {
    /// Arms: go to the grasp.
    Approach,
    /// Hands: close.
    Close,
    /// Hands: open.
    Open,
    /// Arms: leave the grasp.
    Withdraw,
}

impl Phase {
    /// What this phase means to a robot which knows these.
    ///
    /// # Errors
    /// The robot does not know it: an order for another robot, or at another time.
    pub fn choose<T: Copy, const N: usize>(self, known: [(Phase, T); N]) -> Result<T, Fault> {
        let found = known.iter().find(|(phase, _)| *phase == self).map(|(_, meaning)| *meaning);
        found.ok_or_else(|| {
            let known = known.map(|(phase, _)| format!("{phase:?}")).join(" or ");
            Fault::thrown(&format!("phase {self:?} is none of this robot's now: order {known}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_phase_means_what_is_said_and_others_are_refused_by_name() {
        let known = [(Phase::Close, 1), (Phase::Open, 2)];
        assert_eq!(Phase::Close.choose(known).expect("known"), 1);
        assert_eq!(Phase::Open.choose(known).expect("known"), 2);
        for phase in [Phase::Approach, Phase::Withdraw] {
            let text = phase.choose(known).expect_err("unknown").to_string();
            assert!(text.contains(&format!("{phase:?}")) && text.contains("Close or Open"), "{text}");
        }
    }
}
