//! Names the process that computes for ever: on the memory link it keeps the one thread, and with it the cell.
//!
//! In: the scheduler's pulse. Out: nothing while it beats; when it does not for as long as a step may take, the name of
//! the process that runs, and the end of the executable: what it computes cannot be ended otherwise.

use core::time::Duration;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;

use super::memory::Pulse;
use crate::console::complain;

/// Looks at the pulse within its timeout.
const LOOKS: u32 = 10;

/// A thread that watches a cell until it is dropped.
pub struct Watchdog {
    leash: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Watchdog {
    /// Watches the processes of these names; one of them may compute for `timeout` at a stretch.
    pub fn new(names: Vec<String>, pulse: Arc<Pulse>, timeout: Duration) -> Watchdog {
        let (leash, held) = channel();
        let watch = move || {
            let mut last = 0;
            let mut same = 0;
            while held.recv_timeout(timeout / LOOKS) == Err(RecvTimeoutError::Timeout) {
                let resumed = pulse.resumed.load(Ordering::Relaxed);
                same = if resumed == last { same + 1 } else { 0 };
                last = resumed;
                if same > LOOKS {
                    bark(names.get(pulse.place.load(Ordering::Relaxed)), timeout);
                }
            }
        };
        // Without it the cell runs as well as with it.
        let unwatched = |error| {
            complain(&format!(
                "warning: no thread for a watchdog: who computes for ever is not named: {error}"
            ));
        };
        let thread = std::thread::Builder::new().spawn(watch).map_err(unwatched).ok();
        Watchdog { leash: Some(leash), thread }
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        self.leash = None;
        if let Some(thread) = self.thread.take() {
            // It does nothing that could panic.
            let _ = thread.join();
        }
    }
}

fn bark(name: Option<&String>, timeout: Duration) -> ! {
    let name = name.map_or("a process", String::as_str);
    let seconds = timeout.as_secs_f64();
    complain(&format!(
        "error: {name} has computed for {seconds} s without an end, and with it the cell stands still\n help: a step function, \
         a condition or the program has an endless loop: let every step return; run as processes, such a cell stops its \
         robots"
    ));
    std::process::exit(1)
}
