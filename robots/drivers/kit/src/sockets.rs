//! A protocol over the sockets of this machine: a thread, a connection, the monotonic clock, and nothing that a protocol decides.

#![expect(
    clippy::disallowed_methods,
    reason = "a device keeps its own time, beside that of the cell's periods"
)]

use core::time::Duration;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::os::fd::AsFd;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::Instant;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::protocol::{NotConnected, Peer, Received};
use crate::serial::Serial;
use crate::task::{Running, Task};
use crate::udp::Guest;

/// The most bytes that are taken at once; more are taken by the next poll.
const TAKEN: usize = 4096;

/// The longest wait, of a protocol that waits for bytes alone.
const LONGEST: Duration = Duration::from_secs(3600);

/// The same where only the thread itself sees that it is to end.
const SHORT: Duration = Duration::from_millis(20);

/// What the thread and who started it see.
#[derive(Debug)]
struct Shared {
    began: Instant,
    ends: AtomicBool,
    /// To be shut down while the thread waits.
    socket: OnceLock<TcpStream>,
}

/// A protocol that runs in a thread.
#[derive(Debug)]
pub(crate) struct Thread {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Thread {
    pub(crate) fn start(name: &str, peer: Peer, mut task: Box<dyn Task>) -> io::Result<Thread> {
        Thread::spawn(name, move |shared| match connect(&peer, &shared.socket) {
            Ok((socket, guest)) => run(socket, guest, &mut *task, shared, LONGEST),
            Err(why) => task.fail(why),
        })
    }

    pub(crate) fn start_serial(name: &str, port: Serial, mut task: Box<dyn Task>) -> io::Result<Thread> {
        Thread::spawn(name, move |shared| match port.open() {
            // Nothing shuts a serial line down while the thread waits.
            Ok(line) => run(line, None, &mut *task, shared, SHORT),
            Err(_) => task.fail(NotConnected::Unreachable),
        })
    }

    fn spawn(name: &str, work: impl FnOnce(&Shared) + Send + 'static) -> io::Result<Thread> {
        let (ends, socket) = (AtomicBool::new(false), OnceLock::new());
        let shared = Arc::new(Shared { began: Instant::now(), ends, socket });
        let of_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name(name.to_owned()).spawn(move || work(&of_thread))?;
        Ok(Thread { shared, thread: Some(thread) })
    }
}

impl Running for Thread {
    fn now(&self) -> Duration {
        self.shared.began.elapsed()
    }

    fn hang_up(&self) {
        self.shared.ends.store(true, Ordering::Release);
        // The other end may have closed it already.
        let _ = self.shared.socket.get().map(|socket| socket.shutdown(Shutdown::Both));
        let _ = self.thread.as_ref().map(|thread| thread.thread().unpark());
    }

    fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for Thread {
    fn drop(&mut self) {
        self.hang_up();
        // A thread that panicked has nothing left to end.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn connect(peer: &Peer, shared: &OnceLock<TcpStream>) -> Result<(TcpStream, Option<Guest>), NotConnected> {
    let socket = TcpStream::connect_timeout(&peer.address, peer.timeout);
    let ready = socket.and_then(|socket| {
        socket.set_nodelay(true)?;
        socket.set_nonblocking(true)?;
        // Nobody else sets it.
        let _ = shared.set(socket.try_clone()?);
        Ok((socket.local_addr()?.ip(), socket))
    });
    let (own, socket) = ready.map_err(|_| NotConnected::Unreachable)?;
    if !peer.sends_datagrams {
        return Ok((socket, None));
    }
    let guest = Guest::expect(SocketAddr::new(own, 0), peer.address.ip());
    Ok((socket, Some(guest.map_err(|_| NotConnected::NoPort)?)))
}

fn run(
    mut socket: impl Read + Write + AsFd,
    mut guest: Option<Guest>,
    task: &mut dyn Task,
    shared: &Shared,
    longest: Duration,
) {
    let port = guest.as_ref().map_or(0, |guest| guest.address().port());
    let (mut bytes, mut send) = ([0; TAKEN], Vec::new());
    let (mut next, mut is_closed) = (Duration::ZERO, false);
    loop {
        let left = next.saturating_sub(shared.began.elapsed()).min(longest);
        let len = if is_closed {
            std::thread::park_timeout(left);
            0
        } else {
            receive(&mut socket, left, &mut bytes).unwrap_or_else(|()| {
                is_closed = true;
                0
            })
        };
        if shared.ends.load(Ordering::Acquire) {
            return task.close();
        }
        let datagram = guest.as_mut().and_then(Guest::newest);
        let datagram = datagram.as_ref().map(|datagram| datagram.bytes());
        let received = Received { bytes: &bytes[..len], datagram, is_closed, port };
        let at = task.poll(shared.began.elapsed(), received, &mut send);
        // What the other end does not take at once is too late.
        let is_sent =
            is_closed || send.is_empty() || socket.write(&send).is_ok_and(|sent| sent == send.len());
        send.clear();
        let Some(at) = at else { return };
        // A protocol hears at once that nothing more can be sent.
        (next, is_closed) = if is_sent { (at, is_closed) } else { (Duration::ZERO, true) };
    }
}

/// Waits for bytes: how many have come. An error is the end of the connection.
fn receive(socket: &mut (impl Read + AsFd), time: Duration, bytes: &mut [u8]) -> Result<usize, ()> {
    let timeout = Timespec::try_from(time).map_err(drop)?;
    // A signal ends the wait early, which does no harm.
    let ready = poll(&mut [PollFd::new(&*socket, PollFlags::IN)], Some(&timeout)).unwrap_or(0);
    if ready == 0 {
        return Ok(0);
    }
    match socket.read(bytes) {
        Ok(0) => Err(()),
        Ok(len) => Ok(len),
        Err(why) if matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(0),
        Err(_) => Err(()),
    }
}
