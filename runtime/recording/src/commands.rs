//! What consoles ask of a cell of processes, in its recording.
//!
//! In: commands with their answers, from the launcher's console server. Out: a message of each on the channel `/commands`, by the
//! socket of [`relay`](super::relay). A thread of its own sends them, so that the console server waits for no file.

use std::io;
use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, atomic::AtomicU64, atomic::Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use serde_json::json;

use super::channels::Outlet;
use super::json::object;
use super::relay::{Sender, socket};
use mrroc_core::fault::Name;
use mrroc_core::link::Clock;
use mrroc_core::observe::recording::{Command, CommandRecord};
use mrroc_core::observe::sample::{Schema, Subject, Topic};

/// Commands that wait for the file.
const WAITING: usize = 256;

/// How long the file may take nothing, until commands are recorded no more.
const TIMEOUT: Duration = Duration::from_secs(2);

/// Begins to record what is asked of the cell of a session; `None` if that is not recorded.
pub(super) fn begin(folder: &Path, clock: Clock) -> Option<Box<dyn CommandRecord>> {
    let path = socket(folder, clock);
    let connect = || {
        let socket = UnixDatagram::unbound()?;
        socket.connect(&path)?;
        socket.set_write_timeout(Some(TIMEOUT))?;
        io::Result::Ok(socket)
    };
    let sender = Sender::to(connect().ok()?);
    let (puts, waiting) = sync_channel(WAITING);
    let lost = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&lost);
    let run = move || run(sender, &waiting, &counted);
    let thread = std::thread::Builder::new().name("commands".to_owned()).spawn(run).ok()?;
    Some(Box::new(Commands { puts: Some(puts), lost, thread: Some(thread) }))
}

struct Commands {
    puts: Option<SyncSender<Command>>,
    lost: Arc<AtomicU64>,
    thread: Option<JoinHandle<()>>,
}

impl CommandRecord for Commands {
    fn put(&self, command: Command) {
        let Some(puts) = &self.puts else { return };
        if let Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) = puts.try_send(command) {
            self.lost.fetch_add(1, Ordering::AcqRel);
        }
    }
}

impl Drop for Commands {
    /// Waits until what was put is sent, or the file takes nothing.
    fn drop(&mut self) {
        drop(self.puts.take());
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has printed its message already.
            drop(thread.join());
        }
    }
}

fn run(mut sender: Sender, waiting: &Receiver<Command>, lost: &AtomicU64) {
    let mut channels: Vec<(Option<Name>, u16)> = Vec::new();
    let mut is_stuck = false;
    for command in waiting {
        is_stuck = is_stuck || send(&mut sender, &mut channels, &command).is_err();
        if is_stuck {
            lost.fetch_add(1, Ordering::AcqRel);
        }
    }
    if !is_stuck {
        // A recording that takes no more is warned of by whoever writes it.
        let _ = sender.finish(lost.load(Ordering::Acquire));
    }
}

fn send(sender: &mut Sender, channels: &mut Vec<(Option<Name>, u16)>, command: &Command) -> io::Result<()> {
    let channel = match channels.iter().find(|(cell, _)| *cell == command.cell) {
        Some((_, channel)) => *channel,
        None => {
            let (integer, text) = (json!({"type": "integer"}), json!({"type": "string"}));
            let fields = [
                ("asked", integer.clone()),
                ("answered", integer),
                ("by", text.clone()),
                ("command", text.clone()),
                ("outcome", text.clone()),
                ("answer", text),
            ];
            let topic = Topic::new(Subject::Cell(command.cell), "commands", Schema::Common("Command"));
            let schema = object(fields).to_string();
            let channel = sender.open(&topic.to_string(), &topic.schema(), &schema)?;
            channels.push((command.cell, channel));
            channel
        }
    };
    let Command { asked, answered, by, command, outcome, answer, .. } = command;
    let json = json!({
        "asked": asked, "answered": answered, "by": by, "command": command, "outcome": outcome, "answer": answer,
    });
    sender.write(channel, *answered, &json.to_string())
}
