//! Pings of an agent, by which its node's steps follow those of the MP.
//!
//! In: time. Out: pings to the launcher's node; on the state board, by how much the time of this node's processes has moved.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::agent::Agent;
use super::message::NodeMessage;
use super::phase::{FOLLOWS, Phase};
use crate::board::StateBoard;
use crate::link::monotonic;

/// The time between two pings, of which 64 count, and how many there must be before a cell begins.
const PING: Duration = Duration::from_millis(50);
const ENOUGH: usize = 20;

/// A thread that pings the launcher's node, and lets the time of this node's processes follow the answers.
pub(super) struct Pings(Arc<AtomicBool>);

impl Pings {
    /// Begins, for the run in this session.
    pub(super) fn begin(agent: &Agent, session: u64, board: StateBoard) -> std::io::Result<Pings> {
        let ends = Arc::<AtomicBool>::default();
        let (over, hub, wires, mp) =
            (Arc::clone(&ends), Arc::clone(&agent.hub), Arc::clone(&agent.wires), agent.mp());
        std::thread::Builder::new().name("pings".to_owned()).spawn(move || {
            let mut asked: Option<Instant> = None;
            while !over.load(Ordering::Acquire) {
                let (slew, is_new) = hub.phase(|phase| (phase.follow(), phase.heard() < ENOUGH));
                board.slew().store(slew, Ordering::Relaxed);
                // The first ones come sooner, because the cell begins with them.
                if is_new || asked.is_none_or(|asked| asked.elapsed() >= PING) {
                    asked = Some(Instant::now());
                    hub.phase(Phase::ask);
                    wires.send(mp, &NodeMessage::Ping(monotonic()).to_bytes(session));
                }
                std::thread::sleep(FOLLOWS);
            }
        })?;
        Ok(Pings(ends))
    }
}

impl Drop for Pings {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}
