//! The messages of a step, on this crate's link or on bare shared memory and futexes: MP to ECPs, ECPs to EDPs, and
//! back.
//!
//! In: which process this is, and the number of robots. Out: its lines to the others, and a place to wait. Both kinds
//! carry messages of one size along the same lines, and each process waits in one place for all that write to it.

use std::os::fd::{AsFd, OwnedFd};
use std::sync::atomic::{AtomicU32, Ordering};

use rustix::mm::{MapFlags, ProtFlags, mmap};
use rustix::thread::futex;

use super::{SEAL, SIZE, folder, waiter};
use crate::link::{Clock, Fabric};
use mrroc_core::fault::Name;
use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::link::message::{Kind, Message, OrderKind};
use mrroc_core::link::{Client, Link, Server, Waiter};

/// The largest number of robots.
pub const ROBOTS: usize = 4;

/// The process at a place: the MP, then the ECPs, then the EDPs.
pub fn id(place: usize, robots: usize) -> ProcessId {
    let named = |role, robot: usize| ProcessId::new(role, Name::new(&format!("r{robot}")).expect("a name"));
    match place {
        0 => ProcessId::MP,
        _ if place <= robots => named(Role::Ecp, place - 1),
        _ => named(Role::Edp, place - robots - 1),
    }
}

/// The asking and the answering process of each line: the MP asks each ECP, each ECP asks its EDP.
fn lines(robots: usize) -> impl Iterator<Item = (usize, usize)> {
    (1..=robots).flat_map(move |ecp| [(0, ecp), (ecp, robots + ecp)])
}

/// A process's lines, in the order of [`lines`], and where it waits.
pub trait Topology {
    /// Asks, or answers, on a line.
    fn send(&mut self, line: usize);
    /// Takes what has come on a line; returns whether anything has.
    fn take(&mut self, line: usize) -> bool;
    /// Sleeps until something may have come.
    fn wait(&mut self);
}

enum Line {
    Asks(Box<dyn Client>),
    Answers(Box<dyn Server>),
}

/// This crate's link.
pub struct Ours<W> {
    lines: Vec<Line>,
    waiter: W,
    message: Message,
}

impl<W: Waiter> Topology for Ours<W> {
    fn send(&mut self, line: usize) {
        match &self.lines[line] {
            Line::Asks(client) => client.send(&self.message),
            Line::Answers(server) => server.reply(&self.message),
        }
    }

    fn take(&mut self, line: usize) -> bool {
        match &self.lines[line] {
            Line::Asks(client) => client.receive(&mut self.message),
            Line::Answers(server) => server.receive(&mut self.message),
        }
    }

    fn wait(&mut self) {
        self.waiter.wait(None).expect("open");
    }
}

/// The process at `place` on this crate's link; `barrier` returns when all processes have come to the same point.
pub fn ours(place: usize, robots: usize, of: u32, barrier: &dyn Fn()) -> Box<dyn Topology> {
    let mut fabric = Fabric::new(id(place, robots), Clock::Real);
    for place in 0..=2 * robots {
        fabric.place(id(place, robots));
    }
    let mut mine = Vec::new();
    for (asks, answers) in lines(robots) {
        let (client, server) = fabric.port(asks, answers);
        if asks == place {
            mine.push(Line::Asks(client));
        } else if answers == place {
            mine.push(Line::Answers(server));
        }
    }
    fabric.create(&folder(of), &format!("mrl{of}s_"), SEAL).expect("made");
    barrier();
    fabric.connect(SEAL).expect("connected");
    barrier();
    let waiter = waiter(&fabric);
    // The node lives as long as the process.
    std::mem::forget(fabric);
    let mut message = Message::new(Kind::Order(OrderKind::Step));
    message.header.len = mrroc_core::payload::WORDS as u32;
    Box::new(Ours { lines: mine, waiter, message })
}

/// Words of a message and of its slot, which begins with the message's ordinal and has cache lines of its own.
const BODY: usize = SIZE / 4;
const SLOT: usize = (1 + BODY).next_multiple_of(16);
/// Messages for a process are counted in a word on a cache line of its own.
const FUTEX: usize = 16;
const SLOTS: usize = FUTEX * (1 + 2 * ROBOTS);
const WORDS: usize = SLOTS + 4 * ROBOTS * SLOT;
/// Size of the memory that all processes share \[bytes\].
pub const MEMORY: u64 = 4 * WORDS as u64;

/// One direction of a line: where the message lies, and which futex counts it.
#[derive(Clone, Copy)]
struct Direction {
    slot: usize,
    wake_futex: usize,
    ordinal: u32,
}

/// Shared memory and futexes.
pub struct Bare {
    words: &'static [AtomicU32; WORDS],
    /// The outgoing and the incoming direction of each line.
    lines: Vec<(Direction, Direction)>,
    wake_futex: usize,
    heard: u32,
}

impl Topology for Bare {
    fn send(&mut self, line: usize) {
        let direction = &mut self.lines[line].0;
        direction.ordinal = direction.ordinal.wrapping_add(1);
        let body = direction.slot + 1..=direction.slot + BODY;
        self.words[body].iter().for_each(|word| word.store(direction.ordinal, Ordering::Relaxed));
        self.words[direction.slot].store(direction.ordinal, Ordering::Release);
        self.words[direction.wake_futex].fetch_add(1, Ordering::Release);
        futex::wake(&self.words[direction.wake_futex], futex::Flags::empty(), 1).expect("woken");
    }

    fn take(&mut self, line: usize) -> bool {
        let direction = &mut self.lines[line].1;
        let came = self.words[direction.slot].load(Ordering::Acquire);
        if came == direction.ordinal {
            return false;
        }
        direction.ordinal = came;
        let body = direction.slot + 1..=direction.slot + BODY;
        self.words[body].iter().all(|word| word.load(Ordering::Relaxed) == came)
    }

    fn wait(&mut self) {
        let wake_futex = &self.words[self.wake_futex];
        while wake_futex.load(Ordering::Acquire) == self.heard {
            let _ = futex::wait(wake_futex, futex::Flags::empty(), self.heard, None);
        }
        self.heard = wake_futex.load(Ordering::Acquire);
    }
}

/// The process at `place` on bare shared memory, new and all zeros.
pub fn bare(place: usize, robots: usize, shared: &OwnedFd) -> Box<dyn Topology> {
    // SAFETY: a new mapping of a file of that size, which is never unmapped.
    #[allow(unsafe_code)]
    let memory = unsafe {
        let both = ProtFlags::READ | ProtFlags::WRITE;
        mmap(core::ptr::null_mut(), MEMORY as usize, both, MapFlags::SHARED, shared.as_fd(), 0)
            .expect("mapped")
    };
    // SAFETY: it is aligned to a page, consists of atomics, for which every value is valid, and is never unmapped.
    #[allow(unsafe_code)]
    let words = unsafe { &*memory.cast::<[AtomicU32; WORDS]>() };
    let direction =
        |i: usize, to: usize| Direction { slot: SLOTS + i * SLOT, wake_futex: FUTEX * to, ordinal: 0 };
    let mut mine = Vec::new();
    for (i, (asks, answers)) in lines(robots).enumerate() {
        let (order, reply) = (direction(2 * i, answers), direction(2 * i + 1, asks));
        if asks == place {
            mine.push((order, reply));
        } else if answers == place {
            mine.push((reply, order));
        }
    }
    Box::new(Bare { words, lines: mine, wake_futex: FUTEX * place, heard: 0 })
}
