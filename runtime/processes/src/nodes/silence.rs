//! Nodes that say nothing any more, by what has come of them and not by what the network tells.
//!
//! In: that something has come of a node. Out: a node of which nothing has come for [`SILENT`]. A network tells of a lost node
//! sooner, 300 ms after its last word; but where a writer waits for a peer behind a pulled cable, zenoh may hold the connection for
//! it, and tell nothing. Robots do not wait for either: they stop when demands are missing.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use mrroc_core::link::Nanos;

/// After so long without a word a node is lost, whatever the network says. A node pings 20 times a second while a cell runs on it.
pub(super) const SILENT: Duration = Duration::from_secs(2);

/// When something has come of each node: 0 if nothing is awaited of it.
pub(super) struct Silences(Vec<AtomicU64>);

impl Silences {
    /// Of so many nodes.
    pub fn of(nodes: usize) -> Silences {
        Silences((0..nodes).map(|_| AtomicU64::new(0)).collect())
    }

    /// Something has come of a node, now.
    pub fn heard(&self, node: usize, now: Nanos) {
        if let Some(heard) = self.0.get(node) {
            heard.store(now, Ordering::Release);
        }
    }

    /// Nothing is awaited of any node, until something comes.
    pub fn forget(&self) {
        self.0.iter().for_each(|heard| heard.store(0, Ordering::Release));
    }

    /// A node that has fallen silent, which is told once.
    pub fn fallen_silent(&self, now: Nanos) -> Option<usize> {
        self.0.iter().position(|heard| {
            let last = heard.load(Ordering::Acquire);
            let is_silent = last != 0 && now.saturating_sub(last) > SILENT.as_nanos() as Nanos;
            is_silent && heard.compare_exchange(last, 0, Ordering::AcqRel, Ordering::Acquire).is_ok()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Nanos = 1_000_000;

    #[test]
    fn fault_159_a_node_that_says_nothing_for_two_seconds_is_lost_once_and_one_that_never_spoke_is_not() {
        let silences = Silences::of(3);
        assert_eq!(silences.fallen_silent(1_000_000 * MS), None);
        silences.heard(1, 1000 * MS);
        silences.heard(2, 1500 * MS);
        silences.heard(7, 1500 * MS);
        assert_eq!(silences.fallen_silent(3000 * MS), None);
        assert_eq!(silences.fallen_silent(3001 * MS), Some(1));
        assert_eq!(silences.fallen_silent(3001 * MS), None, "it is told once");
        silences.heard(1, 3400 * MS);
        assert_eq!(silences.fallen_silent(3501 * MS), Some(2));
        silences.forget();
        assert_eq!(silences.fallen_silent(9000 * MS), None);
    }
}
