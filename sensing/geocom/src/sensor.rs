//! The instrument as a virtual sensor: what it is told to sight as an order, what it reads as a reading.
//!
//! A thread of its own asks the instrument, which takes seconds; a step only looks at what has come. What both hand over are atomics: the step tells what to sight, then its
//! number; the thread tells what came of it, then the same number.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use core::time::Duration;
use std::path::PathBuf;
use std::sync::Arc;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_driver_kit::{Handed, Number, Talk, Watch};

use crate::angles::Face;
use crate::client::{Client, Patience, Trouble, Wire};
use crate::line::Line;
use crate::protocol::Code;

/// The kind of sensor.
#[derive(Clone, Copy, Debug)]
pub struct Sighting;

impl Sensor for Sighting {
    const KIND: &'static str = "geocom";
    type Reading = Angles;
    type Configuration = Sight;
}

/// What to sight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Sight {
    /// Which one, from 1; a new number is a new sight. 0: nothing. A program begins with 0, which forgets the last sight.
    pub index: u32,
    /// Where the target is about: horizontal angle from x to y \[rad\].
    pub hz: f64,
    /// Its elevation \[rad\].
    pub v: f64,
    /// In the second face.
    pub turned: bool,
}

/// What was read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Angles {
    /// Of which sight.
    pub index: u32,
    /// Horizontal angle from x to y, -pi to pi \[rad\], as of the first face.
    pub hz: f64,
    /// Elevation \[rad\], as of the first face.
    pub v: f64,
    /// In the second face.
    pub turned: bool,
    /// It is the reading of the sight that was ordered.
    pub settled: bool,
}

/// What the thread and the sensor hand to each other.
#[derive(Debug, Default)]
struct Shared {
    asked: AtomicU32,
    about: [Number; 2],
    turned: AtomicU32,
    done: AtomicU32,
    read: [Number; 2],
    /// 0, or what was wrong: see [`number_of`].
    trouble: AtomicU32,
    ends: Arc<AtomicBool>,
}

impl Handed for Shared {
    fn hang_up(&self) {
        self.ends.store(true, Ordering::Release);
    }
}

/// How long the end of the cell is not noticed while an answer is waited for.
const SLICE: Duration = Duration::from_millis(100);

/// A wire on which nothing is waited for any more when the cell ends.
struct UntilTheEnd<W> {
    wire: W,
    ends: Arc<AtomicBool>,
}

impl<W: Wire> Wire for UntilTheEnd<W> {
    fn send(&mut self, line: &str) -> Result<(), Trouble> {
        self.wire.send(line)
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<String>, Trouble> {
        let mut left = patience;
        loop {
            if self.ends.load(Ordering::Acquire) {
                return Err(Trouble::Closed);
            }
            let slice = left.min(SLICE);
            if let Some(line) = self.wire.receive(slice)? {
                return Ok(Some(line));
            }
            left -= slice;
            if left.is_zero() {
                return Ok(None);
            }
        }
    }
}

/// How often the thread looks for a new order.
const PAUSE: Duration = Duration::from_millis(2);

/// A theodolite that speaks GeoCOM on a serial port.
#[derive(Debug)]
pub struct Theodolite {
    port: PathBuf,
    baud: u32,
    patience: Patience,
    talk: Option<Talk<Shared, Trouble>>,
    /// What was ordered last, and how many sights were by then.
    ordered: Sight,
    count: u32,
}

impl Theodolite {
    /// On such a port (`/dev/ttyUSB0`), at its speed \[baud\], 9600 of most. It is opened when the cell begins.
    #[must_use]
    pub fn on(port: impl Into<PathBuf>, baud: u32, patience: Patience) -> Self {
        Self { port: port.into(), baud, patience, talk: None, ordered: Sight::default(), count: 0 }
    }

    /// Over a connection that is open already.
    ///
    /// # Errors
    /// [`Trouble`]: the instrument does not answer; or this machine starts no more threads.
    pub fn over(wire: impl Wire + Send + 'static, patience: Patience) -> Result<Self, Trouble> {
        let talk = Some(begin(wire, patience)?);
        Ok(Self { port: PathBuf::new(), baud: 0, patience, talk, ordered: Sight::default(), count: 0 })
    }
}

fn begin(wire: impl Wire + Send + 'static, patience: Patience) -> Result<Talk<Shared, Trouble>, Trouble> {
    let ends = Arc::new(AtomicBool::new(false));
    let mut client = Client::new(UntilTheEnd { wire, ends: Arc::clone(&ends) }, patience);
    client.greet()?;
    let work = move |shared: &Shared, watch: &Watch| {
        while !watch.ends() {
            let asked = shared.asked.load(Ordering::Acquire);
            if asked == shared.done.load(Ordering::Relaxed) {
                std::thread::sleep(PAUSE);
                continue;
            }
            let about = [shared.about[0].get(), shared.about[1].get()];
            let face = if shared.turned.load(Ordering::Relaxed) == 0 { Face::One } else { Face::Two };
            let read = client.sight(about, face);
            if let Ok(measured) = read {
                for (shared, angle) in shared.read.iter().zip(measured.angles) {
                    shared.set(angle);
                }
            }
            shared.trouble.store(read.err().map_or(0, number_of), Ordering::Relaxed);
            shared.done.store(asked, Ordering::Release);
            if read == Err(Trouble::Closed) {
                return Err(Trouble::Closed);
            }
        }
        Ok(())
    };
    Talk::begin("theodolite", Shared { ends, ..Shared::default() }, Trouble::Closed, work)
        .map_err(|_| Trouble::Closed)
}

/// Troubles as numbers: codes of the instrument as they are, which are below 65536.
const fn number_of(trouble: Trouble) -> u32 {
    match trouble {
        Trouble::Refused(code) => code.0,
        Trouble::Silent => 1 << 16,
        Trouble::Garbled => 2 << 16,
        Trouble::OtherFace => 3 << 16,
        Trouble::Closed => 4 << 16,
    }
}

const fn trouble_of(number: u32) -> Option<Trouble> {
    Some(match (number >> 16, number) {
        (_, 0) => return None,
        (0, code) => Trouble::Refused(Code(code)),
        (1, _) => Trouble::Silent,
        (2, _) => Trouble::Garbled,
        (3, _) => Trouble::OtherFace,
        _ => Trouble::Closed,
    })
}

fn fault(trouble: Trouble) -> Fault {
    Fault::new(FaultKind::SensorFailed).text(&trouble.to_string())
}

impl VirtualSensor for Theodolite {
    type Kind = Sighting;

    fn aggregate(&mut self, order: &ReadingOrder<Sight>) -> Result<Angles, Fault> {
        let Some(talk) = &self.talk else { return Err(fault(Trouble::Closed)) };
        let (shared, sight) = (talk.handed(), order.configuration);
        let nothing = Angles { index: sight.index, ..Angles::default() };
        let is_read = shared.done.load(Ordering::Acquire) == self.count;
        if is_read && sight.index != 0 && sight == self.ordered {
            if let Some(trouble) = trouble_of(shared.trouble.load(Ordering::Relaxed)) {
                // Whoever orders it again has it tried again.
                self.ordered = Sight::default();
                return Err(fault(trouble));
            }
            let [hz, v] = [shared.read[0].get(), shared.read[1].get()];
            return Ok(Angles { index: sight.index, hz, v, turned: sight.turned, settled: true });
        }
        talk.goes_on().map_err(fault)?;
        if !is_read {
            return Ok(nothing);
        }
        if sight.index == 0 {
            self.ordered = Sight::default();
            return Ok(nothing);
        }
        shared.about[0].set(sight.hz);
        shared.about[1].set(sight.v);
        shared.turned.store(u32::from(sight.turned), Ordering::Relaxed);
        (self.ordered, self.count) = (sight, self.count.wrapping_add(1));
        shared.asked.store(self.count, Ordering::Release);
        Ok(nothing)
    }

    fn hardware(&self) -> Option<String> {
        self.talk.is_none().then(|| format!("serial port {}", self.port.display()))
    }

    fn open(&mut self) -> Result<(), Fault> {
        if self.talk.is_some() && !self.port.as_os_str().is_empty() {
            (self.talk, self.ordered, self.count) = (None, Sight::default(), 0);
        }
        if self.talk.is_none() {
            let line = Line::open(&self.port, self.baud).map_err(|why| {
                let text = format!("{} cannot be opened: {why}", self.port.display());
                Fault::new(FaultKind::SensorFailed).text(&text)
            })?;
            self.talk = Some(begin(line, self.patience).map_err(fault)?);
        }
        Ok(())
    }
}
