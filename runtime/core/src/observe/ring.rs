//! The ring that carries what a process shows from its step to a thread that writes it to a file or sends it to another
//! process.
//!
//! In: what processes show. Out: records of a fixed size for a [`Sink`], in their order, on a thread that may lag or block. The
//! ring has a fixed length. When it is full, a record is dropped and counted in real time; under the virtual clock the step
//! waits as long as the thread makes progress.

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

use crate::model::fault::ProcessId;
use crate::model::time::{Clock, Nanos};
use crate::model::wire::WORDS;
use crate::observe::recording::RunRecord;
use crate::observe::step_observer::{IMAGE_WORDS, StepEvent, StepObserver};

const _: () = assert!(IMAGE_WORDS <= WORDS);

/// One thing that a process has shown.
#[derive(Clone, Copy)]
pub struct Record {
    /// The time of the cell \[ns\].
    pub time: Nanos,
    /// Who has shown it.
    pub by: ProcessId,
    /// What it was.
    pub what: StepEvent,
    len: usize,
    words: [u64; WORDS],
}

impl Record {
    fn new(time: Nanos, by: ProcessId, what: &StepEvent, words: &[u64]) -> Record {
        let mut record = Record { time, by, what: *what, len: words.len().min(WORDS), words: [0; WORDS] };
        record.words[..record.len].copy_from_slice(&words[..record.len]);
        record
    }

    /// Its words.
    #[must_use]
    pub fn words(&self) -> &[u64] {
        &self.words[..self.len]
    }
}

/// Where the thread puts the records.
pub trait Sink {
    /// Takes a record. It may block.
    ///
    /// # Errors
    /// What keeps it from being put; the records after it are not tried.
    fn put(&mut self, record: &Record) -> io::Result<()>;

    /// Hands on what was put, so that a reader can have it now.
    ///
    /// # Errors
    /// What keeps it from that.
    fn flush(&mut self) -> io::Result<()>;

    /// Ends the output, in which so many records are missing.
    ///
    /// # Errors
    /// What keeps it from that.
    fn finish(&mut self, dropped: u64) -> io::Result<()>;
}

/// What went wrong between the step and the sink.
#[derive(Debug)]
pub enum RingError {
    /// The thread is slower than the steps: records are being dropped.
    Slow,
    /// The sink has failed; nothing more is put into it.
    Failed(io::Error),
    /// The run is over, and the sink takes nothing more.
    Stuck {
        /// How many records are lost.
        lost: u64,
    },
    /// The run is over, and the sink has not got all records.
    Lost {
        /// How many are lost.
        lost: u64,
        /// Of how many.
        of: u64,
    },
}

/// Whether something that a process shows is to be put.
pub type RecordFilter = Box<dyn Fn(ProcessId, &StepEvent) -> bool>;

/// Tells of a trouble, on any thread.
pub type Tell = Arc<dyn Fn(&RingError) + Send + Sync>;

/// What a ring is for.
pub struct RingUse {
    /// How many records it holds.
    pub length: usize,
    /// By which clock the steps come.
    pub clock: Clock,
    /// How long the thread sleeps when there is nothing to put.
    pub rest: Duration,
    /// How often what was put is handed on, at most once in a rest.
    pub flush: Duration,
    /// How long to wait for a thread that makes no progress, under the virtual clock and at the end.
    pub timeout: Duration,
    /// The stack of the thread \[bytes\], which locked memory holds whole.
    pub stack: usize,
    /// What is to be put.
    pub is_asked_for: RecordFilter,
    /// Tells what goes wrong.
    pub tell: Tell,
}

/// What both ends of the ring share.
#[derive(Default)]
struct Shared {
    /// Number of records that the thread has taken, and of those that it has put.
    taken: AtomicU64,
    put: AtomicU64,
    /// Number of records dropped because the ring was full or the sink has failed.
    dropped: AtomicU64,
    closing: AtomicBool,
}

/// The observer of a run that passes what it sees to a thread.
pub struct Ring {
    records: RefCell<Producer<Record>>,
    shared: Arc<Shared>,
    thread: RefCell<Option<JoinHandle<()>>>,
    about: RingUse,
    /// Number of records that the thread had taken when the step gave up waiting for it.
    stuck: Cell<Option<u64>>,
}

/// Opens a sink. Only the thread calls it, because it may block for ever.
pub type Open = Box<dyn FnOnce() -> io::Result<Box<dyn Sink>> + Send>;

impl Ring {
    /// Begins to pass what is seen to the sink that `open` opens, on a thread of this name.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn begin(name: &str, about: RingUse, open: Open) -> io::Result<Ring> {
        let (mut records, mut taken) = RingBuffer::new(about.length);
        // Filling the ring once makes all its pages resident before the first step.
        let blank = Record::new(0, ProcessId::MP, &StepEvent::Late { step: 0 }, &[]);
        while records.push(blank).is_ok() {}
        while taken.pop().is_ok() {}
        let shared = Arc::new(Shared::default());
        let thread = Thread {
            records: taken,
            shared: Arc::clone(&shared),
            rest: about.rest,
            flush: about.flush,
            tell: Arc::clone(&about.tell),
        };
        let builder = std::thread::Builder::new().name(name.to_owned()).stack_size(about.stack);
        let thread = builder.spawn(move || thread.run(open))?;
        let (records, thread) = (RefCell::new(records), RefCell::new(Some(thread)));
        Ok(Ring { records, shared, thread, about, stuck: Cell::new(None) })
    }

    /// Waits until the ring has room, as long as the thread makes progress.
    fn make_room(&self, records: &Producer<Record>) {
        let (mut since, mut seen) = (Instant::now(), self.shared.taken.load(Ordering::Acquire));
        while records.is_full() && self.stuck.get() != Some(seen) {
            let taken = self.shared.taken.load(Ordering::Acquire);
            if taken != seen {
                (since, seen) = (Instant::now(), taken);
            } else if since.elapsed() > self.about.timeout {
                self.stuck.set(Some(seen));
            }
            std::thread::sleep(Duration::from_micros(50));
        }
    }

    /// Waits until the thread has put the rest, as long as it makes progress.
    fn wait_for_the_rest(&self) {
        let Some(thread) = self.thread.take() else { return };
        self.shared.closing.store(true, Ordering::Release);
        thread.thread().unpark();
        let progress = || {
            let Shared { taken, put, .. } = &*self.shared;
            (taken.load(Ordering::Acquire), put.load(Ordering::Acquire))
        };
        let (mut since, mut seen) = (Instant::now(), progress());
        while !thread.is_finished() {
            let now = progress();
            if now != seen {
                (since, seen) = (Instant::now(), now);
            } else if since.elapsed() > self.about.timeout {
                let records = self.records.borrow();
                let lost = records.buffer().capacity() - records.slots();
                let lost = lost as u64 + self.shared.dropped.load(Ordering::Acquire);
                (self.about.tell)(&RingError::Stuck { lost });
                return;
            }
            std::thread::sleep(Duration::from_micros(200));
        }
    }
}

impl RunRecord for Ring {
    fn finish(&self) {
        self.wait_for_the_rest();
    }
}

impl StepObserver for Ring {
    fn see(&self, time: Nanos, by: ProcessId, what: &StepEvent, words: &[u64]) {
        if !(self.about.is_asked_for)(by, what) {
            return;
        }
        let mut records = self.records.borrow_mut();
        if self.about.clock == Clock::Virtual && records.is_full() {
            self.make_room(&records);
        }
        if records.push(Record::new(time, by, what, words)).is_err() {
            self.shared.dropped.fetch_add(1, Ordering::AcqRel);
        }
    }
}

impl Drop for Ring {
    fn drop(&mut self) {
        self.finish();
    }
}

/// The thread that puts the records.
struct Thread {
    records: Consumer<Record>,
    shared: Arc<Shared>,
    rest: Duration,
    flush: Duration,
    tell: Tell,
}

impl Thread {
    fn run(mut self, open: Open) {
        let mut sink = open().map_err(|error| self.fail(error)).ok();
        let mut flushed = Instant::now();
        let mut warned = false;
        loop {
            // `closing` is read before the ring is emptied, so that what was pushed before the end is put.
            let closing = self.shared.closing.load(Ordering::Acquire);
            while let Ok(record) = self.records.pop() {
                self.shared.taken.fetch_add(1, Ordering::AcqRel);
                self.put(&record, &mut sink);
            }
            let dropped = self.shared.dropped.load(Ordering::Acquire);
            if dropped > 0 && sink.is_some() && !core::mem::replace(&mut warned, true) {
                (self.tell)(&RingError::Slow);
            }
            if closing {
                break;
            }
            if flushed.elapsed() > self.flush {
                flushed = Instant::now();
                self.attempt(&mut sink, |sink| sink.flush());
            }
            std::thread::park_timeout(self.rest);
        }
        let count = |counter: &AtomicU64| counter.load(Ordering::Acquire);
        let (put, dropped) = (count(&self.shared.put), count(&self.shared.dropped));
        self.attempt(&mut sink, |sink| sink.finish(dropped));
        let lost = count(&self.shared.dropped);
        if lost > 0 {
            (self.tell)(&RingError::Lost { lost, of: put + lost });
        }
    }

    /// Puts a record, or counts it as dropped if nothing can be put any more.
    fn put(&self, record: &Record, sink: &mut Option<Box<dyn Sink>>) {
        let put = sink.as_mut().map(|sink| sink.put(record));
        let counter = match put {
            Some(Ok(())) => &self.shared.put,
            Some(Err(_)) | None => &self.shared.dropped,
        };
        counter.fetch_add(1, Ordering::AcqRel);
        if let Some(Err(error)) = put {
            self.fail(error);
            *sink = None;
        }
    }

    fn attempt(&self, sink: &mut Option<Box<dyn Sink>>, work: impl FnOnce(&mut dyn Sink) -> io::Result<()>) {
        if let Some(Err(error)) = sink.as_mut().map(|sink| work(&mut **sink)) {
            self.fail(error);
            *sink = None;
        }
    }

    /// Once: after it nothing more is put.
    fn fail(&self, error: io::Error) {
        (self.tell)(&RingError::Failed(error));
    }
}
