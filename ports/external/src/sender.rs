//! A program in Rust that sends the readings of a virtual sensor: what the module of `external` is in Python.

use core::marker::PhantomData;

use mrroc::payload::Wire;
use mrroc::sensor::Sensor;

use crate::message::{Message, VERSION};
use crate::port::{Ends, ProgramEnds, folder, monotonic};

/// Sends readings of a virtual sensor, and hears its orders. It may begin before the cell, and be there for several runs of it.
pub struct Sender<K: Sensor> {
    ends: ProgramEnds,
    step: u64,
    kind: PhantomData<K>,
}

impl<K: Sensor> Sender<K> {
    /// At the port of a sensor of the cell file, its name unless it says another one.
    ///
    /// # Errors
    /// Why the port cannot be opened: another program sends what the sensor reads.
    pub fn at(port: &str) -> Result<Self, String> {
        let Ends { node } = Ends::open(&folder())?;
        Ok(Sender { ends: ProgramEnds::open(node, port)?, step: 0, kind: PhantomData })
    }

    /// Sends a reading that was measured at a time of [`monotonic`] \[ns\].
    pub fn send(&self, reading: &K::Reading, measured: u64) {
        let (layout, len) = (<K::Reading as Wire>::LAYOUT, <K::Reading as Wire>::LEN as u32);
        let mut message =
            Message { version: VERSION, len, layout, step: self.step, time: measured, ..Message::EMPTY };
        reading.put(&mut message.words);
        self.ends.send(message);
    }

    /// The same of a reading of now.
    pub fn send_now(&self, reading: &K::Reading) {
        self.send(reading, monotonic());
    }

    /// The configuration of the newest order that has come since the last call.
    ///
    /// # Errors
    /// The cell is of another version: its configuration has another type.
    pub fn order(&mut self) -> Result<Option<K::Configuration>, String> {
        let Some(order) = self.ends.newest() else { return Ok(None) };
        self.step = order.step;
        let is_it = order.version == VERSION && order.layout == <K::Configuration as Wire>::LAYOUT;
        let configuration = is_it.then(|| K::Configuration::get(&order.words).ok()).flatten();
        configuration
            .map(Some)
            .ok_or_else(|| "the cell was made with another version of this sensor".to_owned())
    }
}
