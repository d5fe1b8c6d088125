//! The ring that carries records from the step to the thread that writes them.
//!
//! In: what processes show. Out: records of a fixed size for [`channels`](super::channels), in their order, on a thread
//! that may lag or block. The ring has a fixed length. When it is full, a record is dropped and counted in real time;
//! under the virtual clock the step waits as long as the thread makes progress.

#![expect(
    clippy::disallowed_methods,
    reason = "a thread that lags is waited for, and never by a step in real time"
)]

use core::cell::{Cell, RefCell};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rtrb::{Consumer, Producer, RingBuffer};

use super::channels::{Channels, Outlet};
use mrroc_core::console::complain;
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Clock;
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::recording::{Recording, RunRecord};
use mrroc_core::observe::witness::{IMAGE_WORDS, What, Witness};
use mrroc_core::payload::WORDS;

/// Number of records that the ring holds: those of a second with two robots and a sensor at 1 kHz.
const LENGTH: usize = 8192;

/// How long the thread sleeps when there is nothing to write.
const REST: Duration = Duration::from_millis(2);

/// How often what was written is handed on, so that a killed process loses no more than the last part.
const FLUSH: Duration = Duration::from_secs(1);

/// How long to wait for a thread that makes no progress, under the virtual clock and at the end.
const PATIENCE: Duration = Duration::from_secs(3);

const _: () = assert!(IMAGE_WORDS <= WORDS);

/// One thing that a process has shown.
#[derive(Clone, Copy)]
pub(super) struct Record {
    pub time: Nanos,
    pub by: ProcessId,
    pub what: What,
    len: usize,
    words: [u64; WORDS],
}

impl Record {
    fn new(time: Nanos, by: ProcessId, what: &What, words: &[u64]) -> Record {
        let mut record = Record { time, by, what: *what, len: words.len().min(WORDS), words: [0; WORDS] };
        record.words[..record.len].copy_from_slice(&words[..record.len]);
        record
    }

    pub fn words(&self) -> &[u64] {
        &self.words[..self.len]
    }
}

/// What both ends of the ring share.
#[derive(Default)]
struct Shared {
    /// Number of records that the thread has taken, and of messages that it has written.
    taken: AtomicU64,
    written: AtomicU64,
    /// Number of records dropped because the ring was full or the file could not be written.
    dropped: AtomicU64,
    closing: AtomicBool,
}

/// The witness of a run that passes what it sees to the thread that writes it.
pub(crate) struct RunRecorder {
    ring: RefCell<Producer<Record>>,
    shared: Arc<Shared>,
    thread: RefCell<Option<JoinHandle<()>>>,
    clock: Clock,
    recording: Recording,
    /// Number of records that the thread had taken when the step gave up waiting for it.
    stuck: Cell<Option<u64>>,
}

/// Opens the outlet for messages. Only the thread calls it, because it may block for ever.
pub(super) type Open = Box<dyn FnOnce() -> io::Result<Box<dyn Outlet>> + Send>;

impl RunRecorder {
    /// Begins to record to the outlet that `open` opens.
    pub(super) fn begin(
        recording: &Recording,
        layout: Layout,
        clock: Clock,
        open: Open,
    ) -> io::Result<RunRecorder> {
        let (mut ring, mut taken) = RingBuffer::new(LENGTH);
        // Filling the ring once makes all its pages resident before the first step.
        let blank = Record::new(0, ProcessId::MP, &What::Late { step: 0 }, &[]);
        while ring.push(blank).is_ok() {}
        while taken.pop().is_ok() {}
        let shared = Arc::new(Shared::default());
        let thread = Thread {
            ring: taken,
            shared: Arc::clone(&shared),
            channels: Channels::of(layout),
            name: recording.file().display().to_string(),
        };
        let thread =
            std::thread::Builder::new().name("recorder".to_owned()).spawn(move || thread.run(open))?;
        let (ring, thread, stuck) = (RefCell::new(ring), RefCell::new(Some(thread)), Cell::new(None));
        Ok(RunRecorder { ring, shared, thread, clock, recording: recording.clone(), stuck })
    }

    /// Whether this is to be recorded.
    fn is_asked_for(&self, by: ProcessId, what: &What) -> bool {
        match what {
            What::Image { .. } | What::Currents { .. } => {
                by.name.is_none_or(|name| self.recording.has_robot(name.as_str()))
            }
            What::Order { robot, .. } => self.recording.has_robot(robot.as_str()),
            What::Reading { sensor, .. } => self.recording.has_sensor(sensor.as_str()),
            What::Step { .. }
            | What::Instruction { .. }
            | What::Abort { .. }
            | What::Late { .. }
            | What::LateRequest { .. }
            | What::Found { .. }
            | What::Fault { .. }
            | What::Body { .. }
            | What::End { .. } => true,
        }
    }

    /// Waits until the ring has room, as long as the thread makes progress.
    fn make_room(&self, ring: &Producer<Record>) {
        let (mut since, mut seen) = (Instant::now(), self.shared.taken.load(Ordering::Acquire));
        while ring.is_full() && self.stuck.get() != Some(seen) {
            let taken = self.shared.taken.load(Ordering::Acquire);
            if taken != seen {
                (since, seen) = (Instant::now(), taken);
            } else if since.elapsed() > PATIENCE {
                self.stuck.set(Some(seen));
            }
            std::thread::sleep(Duration::from_micros(50));
        }
    }

    /// Waits until the thread has written the rest, as long as it makes progress.
    fn wait_for_the_rest(&self) {
        let Some(thread) = self.thread.take() else { return };
        self.shared.closing.store(true, Ordering::Release);
        let progress = || {
            let Shared { taken, written, .. } = &*self.shared;
            (taken.load(Ordering::Acquire), written.load(Ordering::Acquire))
        };
        let (mut since, mut seen) = (Instant::now(), progress());
        while !thread.is_finished() {
            let now = progress();
            if now != seen {
                (since, seen) = (Instant::now(), now);
            } else if since.elapsed() > PATIENCE {
                let lost = self.ring.borrow().buffer().capacity() - self.ring.borrow().slots();
                let lost = lost as u64 + self.shared.dropped.load(Ordering::Acquire);
                let file = self.recording.file().display();
                complain(&format!("warning: {file}: nothing more can be written: {lost} records are lost"));
                return;
            }
            std::thread::sleep(Duration::from_micros(200));
        }
    }
}

impl RunRecord for RunRecorder {
    fn finish(&self) {
        self.wait_for_the_rest();
    }
}

impl Witness for RunRecorder {
    fn see(&self, time: Nanos, by: ProcessId, what: &What, words: &[u64]) {
        if !self.is_asked_for(by, what) {
            return;
        }
        let mut ring = self.ring.borrow_mut();
        if self.clock == Clock::Virtual && ring.is_full() {
            self.make_room(&ring);
        }
        if ring.push(Record::new(time, by, what, words)).is_err() {
            self.shared.dropped.fetch_add(1, Ordering::AcqRel);
        }
    }
}

impl Drop for RunRecorder {
    fn drop(&mut self) {
        self.finish();
    }
}

/// The thread that writes.
struct Thread {
    ring: Consumer<Record>,
    shared: Arc<Shared>,
    channels: Channels,
    /// The name of the file in messages.
    name: String,
}

impl Thread {
    fn run(mut self, open: Open) {
        let mut outlet = open().map_err(|error| self.warn(&error)).ok();
        let mut flushed = Instant::now();
        let mut warned = false;
        loop {
            // `closing` is read before the ring is emptied, so that what was pushed before the end is written.
            let closing = self.shared.closing.load(Ordering::Acquire);
            while let Ok(record) = self.ring.pop() {
                self.shared.taken.fetch_add(1, Ordering::AcqRel);
                self.write(&record, &mut outlet);
            }
            let dropped = self.shared.dropped.load(Ordering::Acquire);
            if dropped > 0 && outlet.is_some() && !core::mem::replace(&mut warned, true) {
                complain(&format!("warning: {}: writing is too slow: records are dropped", self.name));
            }
            if closing {
                break;
            }
            if flushed.elapsed() > FLUSH {
                flushed = Instant::now();
                self.attempt(&mut outlet, |outlet| outlet.flush());
            }
            std::thread::sleep(REST);
        }
        let count = |counter: &AtomicU64| counter.load(Ordering::Acquire);
        let (written, dropped) = (count(&self.shared.written), count(&self.shared.dropped));
        self.attempt(&mut outlet, |outlet| outlet.finish(dropped));
        let dropped = count(&self.shared.dropped);
        if dropped > 0 {
            complain(&format!("warning: {}: {dropped} of {} records are lost", self.name, written + dropped));
        }
    }

    /// Writes a record, or counts it as dropped if nothing can be written any more.
    fn write(&mut self, record: &Record, outlet: &mut Option<Box<dyn Outlet>>) {
        let put = outlet.as_mut().map(|outlet| self.channels.put(record, &mut **outlet));
        let counter = match put {
            Some(Ok(())) => &self.shared.written,
            Some(Err(_)) | None => &self.shared.dropped,
        };
        counter.fetch_add(1, Ordering::AcqRel);
        if let Some(Err(error)) = put {
            self.warn(&error);
            *outlet = None;
        }
    }

    fn attempt(
        &self,
        outlet: &mut Option<Box<dyn Outlet>>,
        work: impl FnOnce(&mut dyn Outlet) -> io::Result<()>,
    ) {
        if let Some(Err(error)) = outlet.as_mut().map(|outlet| work(&mut **outlet)) {
            self.warn(&error);
            *outlet = None;
        }
    }

    /// Once: after it nothing more is written.
    fn warn(&self, error: &io::Error) {
        complain(&format!("warning: {}: cannot be written: {error}; the run goes on unrecorded", self.name));
    }
}
