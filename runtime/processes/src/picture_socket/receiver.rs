//! The plant's end of the socket.
//!
//! In: datagrams of the cell's processes. Out: what they say, to the observers of the picture, on a thread that may lag.

use std::io::{self, ErrorKind};
use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mrroc_core::console::complain;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::step_observer::{SharedStepObserver, StepObserver};

use super::datagram::{PictureRecord, TIMEOUT, read, socket};

/// The longest datagram \[bytes\].
const LONGEST: usize = 64 * 1024;

/// How often the thread checks whether the picture is to be drawn, if it is not told so.
const REST: Duration = Duration::from_millis(50);

/// Stack of the thread \[bytes\], kept small because locked memory holds all of it.
const STACK: usize = 256 << 10;

/// What the thread and the plant share.
#[derive(Default)]
struct Shared {
    /// No process shows anything more.
    closing: AtomicBool,
    /// Number of datagrams received, and of things that were lost before they could be sent.
    received: AtomicU64,
    lost: AtomicU64,
}

/// Shows the observers of a picture what the processes of a session send.
pub(crate) struct Receiver {
    shared: Arc<Shared>,
    /// Tells the thread that it is closing.
    bell: UnixDatagram,
    thread: JoinHandle<()>,
}

impl Receiver {
    /// Makes the socket in the folder of a session of a cell of this layout, and begins to receive.
    ///
    /// # Errors
    /// The socket cannot be made, or the thread cannot be started.
    pub fn open(folder: &Path, layout: Layout, observers: Vec<SharedStepObserver>) -> io::Result<Receiver> {
        let path = socket(folder);
        let socket = UnixDatagram::bind(&path)?;
        socket.set_read_timeout(Some(REST))?;
        let bell = UnixDatagram::unbound()?;
        bell.connect(&path)?;
        bell.set_nonblocking(true)?;
        let shared = Arc::<Shared>::default();
        let of_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("picture".to_owned())
            .stack_size(STACK)
            .spawn(move || receive(&socket, &of_thread, &layout, &observers))?;
        Ok(Receiver { shared, bell, thread })
    }

    /// Waits until the observers have seen all that was sent before, as long as they make progress, and tells what is missing.
    pub fn finish(self) {
        let Receiver { shared, bell, thread } = self;
        shared.closing.store(true, Ordering::Release);
        // If the socket is full, the thread notices by itself.
        let _ = bell.send(&[]);
        let (mut since, mut seen) = (Instant::now(), shared.received.load(Ordering::Acquire));
        while !thread.is_finished() {
            let received = shared.received.load(Ordering::Acquire);
            if received != seen {
                (since, seen) = (Instant::now(), received);
            } else if since.elapsed() > TIMEOUT {
                complain(
                    "warning: the picture does not get all that the processes have shown: it takes nothing more",
                );
                return;
            }
            std::thread::sleep(Duration::from_micros(200));
        }
        let lost = shared.lost.load(Ordering::Acquire);
        if lost > 0 {
            complain(&format!(
                "warning: the picture lacks {lost} steps, readings, or values of inputs and outputs: the plant was too slow to take them"
            ));
        }
    }
}

/// Receives until there is nothing more.
fn receive(socket: &UnixDatagram, shared: &Shared, layout: &Layout, observers: &[SharedStepObserver]) {
    let mut bytes = vec![0; LONGEST];
    let mut words = Vec::new();
    loop {
        // Read before the socket is, so that what was sent before the end is received.
        let closing = shared.closing.load(Ordering::Acquire);
        match socket.recv(&mut bytes) {
            // The bell, after all that the processes have sent.
            Ok(0) => {
                if shared.closing.load(Ordering::Acquire) {
                    return;
                }
            }
            Ok(len) => {
                words.clear();
                words.extend(bytes[..len].as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word)));
                show(&words, shared, layout, observers);
                shared.received.fetch_add(1, Ordering::AcqRel);
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                if closing {
                    return;
                }
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => {
                complain(&format!("warning: the picture lacks what processes show: {error}"));
                return;
            }
        }
    }
}

fn show(words: &[u64], shared: &Shared, layout: &Layout, observers: &[SharedStepObserver]) {
    for shown in read(words, layout) {
        match shown {
            PictureRecord::Something(time, by, what, words) => {
                observers.iter().for_each(|observer| observer.see(time, by, &what, words));
            }
            PictureRecord::End(lost) => {
                shared.lost.fetch_add(lost, Ordering::AcqRel);
            }
        }
    }
}
