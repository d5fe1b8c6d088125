//! What a link between two machines can do: measured before any cell runs, for `doctor`.
//!
//! In: the nodes of a cell whose agents wait. Out: for each, how long a word takes to and fro, how many were lost, and which step
//! that carries.

use std::fmt::Write;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use mrroc_core::cell::Nodes;
use mrroc_core::link::Nanos;
use mrroc_core::link::timeout::together_budget;
use mrroc_launch::network::{JoinOptions, NodeListener, Side, Wires, network};

use super::absence::absent;
use super::identity::keys;
use super::message::NodeMessage;
use super::phase::{Figures, Phase, WORK};
use crate::launch::launcher::NO_NETWORK;
use crate::link::monotonic;

/// How many pings, and the time between two.
const PINGS: u32 = 1000;
const APART: Duration = Duration::from_millis(2);

/// How long a node may take to be there, and the last answers to come.
const TIMEOUT: Duration = Duration::from_secs(5);
const LAST: Duration = Duration::from_millis(500);

struct Listener {
    there: Mutex<Vec<bool>>,
    phases: Mutex<Vec<Phase>>,
}

impl NodeListener for Listener {
    fn came(&self, from: usize, bytes: &[u8]) {
        let now = monotonic();
        if let Some((_, NodeMessage::Pong(sent, answered))) = NodeMessage::read(bytes)
            && let Some(phase) = self.phases.lock().unwrap_or_else(PoisonError::into_inner).get_mut(from)
        {
            phase.hear(sent, answered, now);
        }
    }

    fn is_there(&self, node: usize) {
        self.set(node, true);
    }

    fn is_lost(&self, node: usize) {
        self.set(node, false);
    }
}

impl Listener {
    fn set(&self, node: usize, is_there: bool) {
        if let Some(there) = self.there.lock().unwrap_or_else(PoisonError::into_inner).get_mut(node) {
            *there = is_there;
        }
    }

    fn is(&self, node: usize) -> bool {
        self.there.lock().unwrap_or_else(PoisonError::into_inner).get(node).copied().unwrap_or(false)
    }
}

/// Measures the links from the node of the MP to all others of the cell in the file at `file`; a line for each.
pub(crate) fn examine(nodes: &Nodes, file: &Path) -> String {
    let Some(network) = network() else { return format!("nodes           {NO_NETWORK}\n") };
    let all = nodes.all().len();
    let listener = Arc::new(Listener {
        there: Mutex::new(vec![false; all]),
        phases: Mutex::new((0..all).map(|_| Phase::new(0)).collect()),
    });
    let folder = keys(file);
    let joining = JoinOptions { nodes, me: nodes.mp(), side: Side::Calls, keys: &folder };
    let wires: Arc<dyn Wires> = match network.join(&joining, Arc::clone(&listener) as Arc<dyn NodeListener>) {
        Ok(wires) => Arc::from(wires),
        Err(error) => return format!("nodes           {error}\n"),
    };
    let others: Vec<_> = (0..all).filter(|node| *node != nodes.mp()).collect();
    let until = Instant::now() + TIMEOUT;
    while Instant::now() < until && !others.iter().all(|&node| listener.is(node)) {
        std::thread::sleep(Duration::from_millis(20));
    }
    for _ in 0..PINGS {
        for &node in others.iter().filter(|&&node| listener.is(node)) {
            if let Some(phase) = listener.phases.lock().unwrap_or_else(PoisonError::into_inner).get_mut(node)
            {
                phase.ask();
            }
            wires.send(node, &NodeMessage::Ping(monotonic()).to_bytes(0));
        }
        std::thread::sleep(APART);
    }
    std::thread::sleep(LAST);
    let phases = listener.phases.lock().unwrap_or_else(PoisonError::into_inner);
    let mut told = String::new();
    for place in others {
        let (node, figures) = (&nodes.all()[place], phases[place].figures());
        let is_silent = figures.asked == figures.lost;
        let described = if is_silent { absent(node, listener.is(place)) } else { describe(&figures) };
        // Writing to a text does not fail.
        let _ = writeln!(told, "{:<16}{}", format!("to node {}", node.name.as_str()), described);
    }
    told
}

/// `0.61 ms (half), ..; no step is missed from 2 ms on, and a tight Move goes on from 1 ms on`.
fn describe(figures: &Figures) -> String {
    let ms = |nanos: Nanos| nanos as f64 * 1e-6;
    let [half, most, nearly_all] = figures.round_trip;
    let (all, tight) = steps(nearly_all);
    format!(
        "round trip {:.2} ms (half), {:.2} ms (99 %), {:.2} ms (99.9 %), {} of {} lost; no step is missed from step_ms = {all} on, and a \
         tight Move goes on from {tight} on",
        ms(half),
        ms(most),
        ms(nearly_all),
        figures.lost,
        figures.asked
    )
}

/// The shortest steps \[whole ms\] that a round trip carries: in which the answer comes within its step, and, in a tight Move, before
/// the last step that the MP waits for it is over.
fn steps(round_trip: Nanos) -> (u64, u64) {
    let least = (round_trip + WORK).div_ceil(1_000_000).max(1);
    let waits = |ms: u64| ms * u64::from(together_budget(Duration::from_millis(ms)));
    let tight = (1..least).find(|&ms| waits(ms) * 1_000_000 >= round_trip + WORK);
    (least, tight.unwrap_or(least))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_that_a_link_carries_is_as_long_as_its_round_trip_and_shorter_for_a_tight_move_that_waits_for_several()
     {
        // 0.3 ms of a switch, 0.5 ms of work.
        assert_eq!(steps(300_000), (1, 1));
        // Six steps of 1 ms are waited for.
        assert_eq!(steps(3_000_000), (4, 1));
        assert_eq!(steps(5_600_000), (7, 4));
        assert_eq!(steps(15_000_000), (16, 8));
    }

    #[test]
    fn a_link_is_told_with_its_step() {
        let figures = Figures {
            asked: 1000,
            lost: 2,
            round_trip: [610_000, 1_200_000, 2_600_000],
            ..Figures::default()
        };
        let told = describe(&figures);
        assert!(
            told.contains("2.60 ms (99.9 %), 2 of 1000 lost")
                && told.contains("from step_ms = 4 on, and a tight Move goes on from 1 on"),
            "{told}"
        );
    }
}
