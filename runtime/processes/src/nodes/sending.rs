//! A thread that takes what processes of this machine show those of another one to that machine.
//!
//! In: wake-ups of the stand-ins of that machine's processes. Out: the newest envelope of each board that has changed, under the
//! seal of the run. It has the priority that the cell asks for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use mrroc_core::cell::Realtime;
use mrroc_core::link::Nanos;
use mrroc_launch::network::{Hears, Joining, Network, Wires};

use super::message::Said;
use crate::iceoryx::{Outgoing, monotonic};
use crate::scheduling::{give_back_priority, set_priority};

/// How often a thread without boards looks whether it is to end \[ns\].
const LOOK: Nanos = 50_000_000;

/// Joins the network with the priority that the cell asks for, so that the network's own threads have it, too: what they do late is
/// late in a step. The calling thread then has its own again.
pub(super) fn join(
    network: &dyn Network,
    joining: &Joining<'_>,
    hears: Arc<dyn Hears>,
    realtime: Option<&Realtime>,
) -> Result<Arc<dyn Wires>, String> {
    let is_urgent = realtime.is_some_and(|realtime| set_priority(realtime.priority));
    let joined = network.join(joining, hears);
    if is_urgent {
        give_back_priority();
    }
    joined.map(Arc::from)
}

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
        for mut way in outgoing {
            let (wires, ends) = (Arc::clone(wires), Arc::clone(&ends));
            let run = move || {
                if let Some(priority) = priority {
                    // Whether it is permitted, the cell's processes have told.
                    set_priority(priority);
                }
                let mut bytes = Vec::with_capacity(1024);
                let often = if way.has_boards() { often.min(LOOK) } else { LOOK };
                while !ends.load(Ordering::Acquire) {
                    let wakes = way.wake_futex().wakes();
                    while let Some((number, envelope)) = way.next() {
                        Said::Way(number, envelope).put(session, &mut bytes);
                        wires.send(way.to(), &bytes);
                    }
                    way.wake_futex().sleep(wakes, Some(monotonic() + often));
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
        for thread in self.threads.drain(..) {
            // A thread that has panicked has sent what it could.
            let _ = thread.join();
        }
    }
}
