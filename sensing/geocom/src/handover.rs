//! Sights that are ordered in steps, and carried out between them.
//!
//! In: orders of a step on one side; on the other, the time and what the instrument sends. Out: readings; and questions. Both sides share atomics: the
//! step tells what to sight, then its number; the other side tells what came of it, then the same number. Neither waits for the other.

use core::sync::atomic::{AtomicU32, Ordering};
use core::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_driver_kit::{Handed, Number};

use crate::action::{ClientAction, GeocomError, Measured};
use crate::angles::Face;
use crate::client::Client;
use crate::protocol::Code;

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

/// What both sides hand to each other.
#[derive(Debug, Default)]
pub struct Shared {
    asked: AtomicU32,
    about: [Number; 2],
    turned: AtomicU32,
    done: AtomicU32,
    read: [Number; 2],
    /// 0, or what was wrong: see [`number_of`].
    trouble: AtomicU32,
}

impl Handed for Shared {}

/// The side of the steps: what was ordered last, and how many sights were by then.
#[derive(Debug, Default)]
pub struct Orders {
    ordered: Sight,
    count: u32,
}

impl Orders {
    /// What there is to say of a sight, which is begun if it is a new one. `goes_on` says whether anybody carries sights out.
    ///
    /// # Errors
    /// What was wrong with the sight, or why nobody carries it out.
    pub fn aggregate(
        &mut self,
        shared: &Shared,
        sight: Sight,
        goes_on: Result<(), GeocomError>,
    ) -> Result<Angles, Fault> {
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
        goes_on.map_err(fault)?;
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
}

/// The side of the instrument.
#[derive(Debug)]
pub struct Worker {
    client: Client,
    /// The number of the sight that is carried out.
    begun: Option<u32>,
}

impl Worker {
    /// Asks by this client.
    pub const fn new(client: Client) -> Self {
        Self { client, begun: None }
    }

    /// What asks, for whoever sends and receives.
    pub const fn client(&mut self) -> &mut Client {
        &mut self.client
    }

    /// Goes on at a time with the bytes that have come. [`ClientAction::Idle`]: nothing is ordered; look again soon.
    pub fn poll(&mut self, now: Duration, bytes: &[u8], shared: &Shared) -> ClientAction {
        if self.begun.is_none() {
            let asked = shared.asked.load(Ordering::Acquire);
            if asked == shared.done.load(Ordering::Relaxed) {
                return ClientAction::Idle;
            }
            let about = [shared.about[0].get(), shared.about[1].get()];
            let face = if shared.turned.load(Ordering::Relaxed) == 0 { Face::One } else { Face::Two };
            self.client.sight(about, face);
            self.begun = Some(asked);
        }
        let next = self.client.poll(now, bytes);
        if let ClientAction::Done(outcome) = next {
            self.tell(shared, outcome);
        }
        next
    }

    /// The line is closed: so much for the sight that is carried out.
    pub fn close(&mut self, shared: &Shared) {
        self.tell(shared, Err(GeocomError::Closed));
    }

    fn tell(&mut self, shared: &Shared, outcome: Result<Option<Measured>, GeocomError>) {
        let Some(asked) = self.begun.take() else { return };
        if let Ok(Some(measured)) = outcome {
            for (shared, angle) in shared.read.iter().zip(measured.angles) {
                shared.set(angle);
            }
        }
        shared.trouble.store(outcome.err().map_or(0, number_of), Ordering::Relaxed);
        shared.done.store(asked, Ordering::Release);
    }
}

/// Troubles as numbers: codes of the instrument as they are, which are below 65536.
const fn number_of(trouble: GeocomError) -> u32 {
    match trouble {
        GeocomError::Refused(code) => code.0,
        GeocomError::Silent => 1 << 16,
        GeocomError::Garbled => 2 << 16,
        GeocomError::OtherFace => 3 << 16,
        GeocomError::Closed => 4 << 16,
    }
}

const fn trouble_of(number: u32) -> Option<GeocomError> {
    Some(match (number >> 16, number) {
        (_, 0) => return None,
        (0, code) => GeocomError::Refused(Code(code)),
        (1, _) => GeocomError::Silent,
        (2, _) => GeocomError::Garbled,
        (3, _) => GeocomError::OtherFace,
        _ => GeocomError::Closed,
    })
}

/// A trouble as a fault of the sensor.
pub fn fault(trouble: GeocomError) -> Fault {
    Fault::new(FaultKind::SensorFailed).text(&trouble.to_string())
}
