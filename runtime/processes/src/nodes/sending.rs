//! A thread that takes what processes of this machine show those of another one to that machine.
//!
//! In: wake-ups of the stand-ins of that machine's processes. Out: the newest envelope of each board that has changed, under the
//! seal of the run. It has the priority that the cell asks for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mrroc_core::cell::Realtime;
use mrroc_core::link::Nanos;
use mrroc_launch::network::{JoinOptions, Network, NodeListener, Wires};

use super::message::NodeMessage;
use crate::link::{Outgoing, monotonic};
use crate::machine::scheduling::{give_back_priority, set_priority};

/// How often a thread without boards looks whether it is to end \[ns\].
const LOOK: Nanos = 50_000_000;

/// Joins the network with the priority that the cell asks for, so that the network's own threads have it, too: what they do late is
/// late in a step. The calling thread then has its own again.
pub(super) fn join(
    network: &dyn Network,
    joining: &JoinOptions<'_>,
    hears: Arc<dyn NodeListener>,
    realtime: Option<&Realtime>,
) -> Result<Arc<dyn Wires>, String> {
    let is_urgent = realtime.is_some_and(|realtime| set_priority(realtime.priority));
    let joined = network.join(joining, hears);
    if is_urgent {
        give_back_priority();
    }
    joined.map(Arc::from)
}

/// How many words wait at most for a machine that takes none.
const QUEUE: usize = 4096;

/// What is said to other machines, apart from what stands on boards: in order, and by threads of its own, because a network whose
/// cable is pulled may take nothing more for a long time. Who says something never waits.
pub(super) struct Post(Vec<SyncSender<Vec<u8>>>);

impl Post {
    /// Begins, with a thread for each of so many machines.
    ///
    /// # Errors
    /// There is no room for a thread.
    pub fn begin(wires: &Arc<dyn Wires>, machines: usize) -> std::io::Result<Post> {
        let mut queues = Vec::new();
        for to in 0..machines {
            let (queue, said) = sync_channel::<Vec<u8>>(QUEUE);
            let wires = Arc::clone(wires);
            std::thread::Builder::new().name("says".to_owned()).spawn(move || {
                said.iter().for_each(|bytes| wires.send(to, &bytes));
            })?;
            queues.push(queue);
        }
        Ok(Post(queues))
    }

    /// Says something to a machine. What waits behind too much is lost, as it would be in the cable.
    pub fn say(&self, to: usize, bytes: Vec<u8>) {
        if let Some(queue) = self.0.get(to) {
            let _ = queue.try_send(bytes);
        }
    }
}

/// How long threads may take to end. One that the network holds ends later, by itself.
const ENDING: Duration = Duration::from_millis(200);

/// The threads of a machine, which end with it.
pub(super) struct Sending {
    ends: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Sending {
    /// Begins to send: one thread for each other machine, so that one that takes nothing holds up no other. Boards that wake
    /// nobody are looked at `often` \[ns\].
    ///
    /// # Errors
    /// There is no room for a thread.
    pub fn begin(
        outgoing: Vec<Outgoing>,
        wires: &Arc<dyn Wires>,
        session: u64,
        (priority, often): (Option<u8>, Nanos),
    ) -> std::io::Result<Sending> {
        let ends = Arc::<AtomicBool>::default();
        let mut threads = Vec::new();
        for mut node in outgoing {
            let (wires, ends) = (Arc::clone(wires), Arc::clone(&ends));
            let run = move || {
                if let Some(priority) = priority {
                    // Whether it is permitted, the cell's processes have told.
                    set_priority(priority);
                }
                let mut bytes = Vec::with_capacity(1024);
                let often = if node.has_boards() { often.min(LOOK) } else { LOOK };
                while !ends.load(Ordering::Acquire) {
                    let wakes = node.wake_futex().wakes();
                    while let Some((number, envelope)) = node.next() {
                        NodeMessage::Slot(number, envelope).put(session, &mut bytes);
                        wires.send(node.to(), &bytes);
                    }
                    node.wake_futex().sleep(wakes, Some(monotonic() + often));
                }
            };
            threads.push(std::thread::Builder::new().name("sends".to_owned()).spawn(run)?);
        }
        Ok(Sending { ends, threads })
    }
}

impl Drop for Sending {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        let until = Instant::now() + ENDING;
        while self.threads.iter().any(|thread| !thread.is_finished()) && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}
