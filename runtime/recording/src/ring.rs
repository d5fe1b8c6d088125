//! What a process shows, on its way from the step to the thread that writes it.
//!
//! In: what processes show. Out: records for [`channels`](super::channels), in their order, by a [`Ring`].

use std::io;
use std::sync::Arc;
use std::time::Duration;

use super::channels::{Channels, Outlet};
use super::file::write_timeout;
use mrroc_core::console::complain;
use mrroc_core::fault::{Name, ProcessId};
use mrroc_core::link::Clock;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::recording::Recording;
use mrroc_core::observe::ring::{Record, Ring, RingError, RingUse, Sink};
use mrroc_core::observe::sample::Subject;
use mrroc_core::observe::step_observer::StepEvent;

/// Number of records that the ring holds: those of a second with two robots and a sensor at 1 kHz.
const LENGTH: usize = 8192;

/// How long the thread sleeps when there is nothing to write.
const REST: Duration = Duration::from_millis(2);

/// How often what was written is handed on, so that a killed process loses no more than the last part.
const FLUSH: Duration = Duration::from_secs(1);

/// Stack of the thread, which compresses \[bytes\].
const STACK: usize = 2 << 20;

/// Opens the outlet for messages. Only the thread calls it, because it may block for ever.
pub(super) type Open = Box<dyn FnOnce() -> io::Result<Box<dyn Outlet>> + Send>;

/// Begins to record to the outlet that `open` opens.
pub(super) fn begin(recording: &Recording, layout: Layout, clock: Clock, open: Open) -> io::Result<Ring> {
    let (asked, name) = (recording.clone(), recording.file().display().to_string());
    let about = RingUse {
        length: LENGTH,
        clock,
        rest: REST,
        flush: FLUSH,
        timeout: write_timeout(recording.file()),
        stack: STACK,
        is_asked_for: Box::new(move |by, what: &StepEvent| is_asked_for(&asked, by, what)),
        tell: Arc::new(move |trouble: &RingError| tell(&name, trouble)),
    };
    let open = move || {
        let outlet = open()?;
        Ok(Box::new(Messages { channels: Channels::of(layout), outlet }) as Box<dyn Sink>)
    };
    Ring::begin("recorder", about, Box::new(open))
}

/// Whether this is to be recorded.
fn is_asked_for(recording: &Recording, by: ProcessId, what: &StepEvent) -> bool {
    match what.topic(by).subject {
        Subject::Robot(name) => recording.has_robot(name.as_str()),
        Subject::Sensor(cell, name) => {
            recording.has_sensor_in(cell.as_ref().map(Name::as_str), name.as_str())
        }
        Subject::Cell(_) | Subject::Body(_) => true,
    }
}

/// Tells what is missing in the recording of this name.
fn tell(name: &str, trouble: &RingError) {
    complain(&match trouble {
        RingError::Slow => format!("warning: {name}: writing is too slow: records are dropped"),
        RingError::Failed(error) => {
            format!("warning: {name}: cannot be written: {error}; the run goes on unrecorded")
        }
        RingError::Stuck { lost } => {
            format!("warning: {name}: nothing more can be written: {lost} records are lost")
        }
        RingError::Lost { lost, of } => format!("warning: {name}: {lost} of {of} records are lost"),
    });
}

/// Writes records as messages.
struct Messages {
    channels: Channels,
    outlet: Box<dyn Outlet>,
}

impl Sink for Messages {
    fn put(&mut self, record: &Record) -> io::Result<()> {
        self.channels.put(record, &mut *self.outlet)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.outlet.flush()
    }

    fn finish(&mut self, dropped: u64) -> io::Result<()> {
        self.outlet.finish(dropped)
    }
}
