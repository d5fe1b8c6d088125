//! A program in Rust that sends the readings of a virtual sensor: what the module of `external` is in Python.

use core::marker::PhantomData;

use mrroc::observe::layout::SensorLayout;
use mrroc::payload::Wire;
use mrroc::sensor::Sensor;

use crate::message::{Message, VERSION, WORDS};
use crate::port::{Ends, ProgramEnds, folder, monotonic};

/// Sends readings of a virtual sensor, and hears its orders. It may begin before the cell, and be there for several runs of it.
pub struct Sender<K: Sensor> {
    words: WordSender,
    kind: PhantomData<K>,
}

impl<K: Sensor> Sender<K> {
    /// At the port of a sensor of the cell file, its name unless it says another one.
    ///
    /// # Errors
    /// Why the port cannot be opened: another program sends what the sensor reads.
    pub fn at(port: &str) -> Result<Self, String> {
        let (layout, len) = (<K::Reading as Wire>::LAYOUT, <K::Reading as Wire>::LEN);
        Ok(Sender { words: WordSender::of(port, layout, len)?, kind: PhantomData })
    }

    /// Sends a reading that was measured at a time of [`monotonic`] \[ns\].
    pub fn send(&self, reading: &K::Reading, measured: u64) {
        let mut words = [0; WORDS];
        reading.put(&mut words);
        self.words.send(&words, measured);
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
        let Some(order) = self.words.order() else { return Ok(None) };
        let is_it = order.version == VERSION && order.layout == <K::Configuration as Wire>::LAYOUT;
        let configuration = is_it.then(|| K::Configuration::get(&order.words).ok()).flatten();
        configuration
            .map(Some)
            .ok_or_else(|| "the cell was made with another version of this sensor".to_owned())
    }
}

/// The same for a sensor of any kind: a reading is words, whose meaning the [layout](SensorLayout::reading) of the sensor says.
pub struct WordSender {
    ends: ProgramEnds,
    layout: u64,
    len: usize,
    step: u64,
}

impl WordSender {
    /// At the port of a sensor of a cell.
    ///
    /// # Errors
    /// Why the port cannot be opened: another program sends what the sensor reads.
    pub fn at(port: &str, sensor: &SensorLayout) -> Result<Self, String> {
        Self::of(port, sensor.reading_layout, sensor.reading.len())
    }

    fn of(port: &str, layout: u64, len: usize) -> Result<Self, String> {
        let Ends { node } = Ends::open(&folder())?;
        Ok(WordSender { ends: ProgramEnds::open(node, port)?, layout, len, step: 0 })
    }

    /// Sends the words of a reading that was measured at a time of [`monotonic`] \[ns\]. Of more words than a reading has, the first ones count; fewer are
    /// refused by the cell.
    pub fn send(&self, words: &[u64], measured: u64) {
        let len = self.len.min(words.len()).min(WORDS);
        let (layout, step) = (self.layout, self.step);
        let mut message =
            Message { version: VERSION, len: len as u32, layout, step, time: measured, ..Message::EMPTY };
        message.words[..len].copy_from_slice(&words[..len]);
        self.ends.send(message);
    }

    /// The newest order since the last call.
    fn order(&mut self) -> Option<Message> {
        let order = self.ends.newest()?;
        self.step = order.step;
        Some(order)
    }
}
