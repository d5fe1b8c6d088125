//! The exchange with a device, in a thread of its own: as fast as it answers, whatever the EDP's periods.
//!
//! In: what outputs were told. Out: what inputs read and outputs are, and why it has ended. Both sides hand this over in atomics, so that
//! neither waits for the other.

#![expect(
    clippy::disallowed_methods,
    reason = "the exchange keeps the device's time, outside of the cell's periods"
)]

use core::ops::Range;
use core::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use core::time::Duration;
use std::net::{Shutdown, TcpStream};
use std::sync::OnceLock;
use std::time::Instant;

use mrroc::robot::{ANALOG, Channel, DriveFault, Outputs, Signals, Value, Values};
use mrroc_driver_kit::{Handed, Number, Recalled, Talk, Watch};

use crate::client::{Broken, Client, lost};
use crate::drives::ModbusIoSettings;
use crate::layout::Layout;
use crate::message::{Answer, Asked, Table};

/// The shortest time from one exchange to the next.
const PAUSE: Duration = Duration::from_millis(5);

/// Exchanges after which an output must be as it was told.
const ECHOES: u32 = 20;

/// Questions of the readings of an exchange, and one more; each output that is written counts as heard by itself.
const QUESTIONS: u32 = 5;

/// What the thread and the drives hand to each other.
#[derive(Debug, Default)]
struct Shared {
    /// Which digital outputs were told something, in the upper half, and what.
    told: AtomicU64,
    /// The same of analog ones: registers, and which of them.
    told_analog: [AtomicU32; ANALOG],
    inputs: AtomicU32,
    outputs: AtomicU32,
    analog_inputs: [Number; ANALOG],
    analog_outputs: [Number; ANALOG],
    socket: OnceLock<TcpStream>,
}

/// The bit that says that an analog output was told something.
const TOLD: u32 = 1 << 16;

impl Handed for Shared {
    fn hang_up(&self) {
        // The other end may have closed it already.
        let _ = self.socket.get().map(|socket| socket.shutdown(Shutdown::Both));
    }
}

/// An exchange that goes on.
#[derive(Debug)]
pub struct Link {
    talk: Talk<Shared, DriveFault>,
    silence: Duration,
}

pub(crate) const CLOSED: DriveFault = DriveFault::Other("the device is not connected");

const NOT_SWITCHED: DriveFault = DriveFault::Other(
    "the device does not switch its outputs as it is told: does another master switch them, or are they other coils?",
);

impl Link {
    /// Begins to connect, and returns.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn begin(settings: &ModbusIoSettings) -> Result<Link, DriveFault> {
        let silence = settings.patience * QUESTIONS;
        let settings = settings.clone();
        let work = move |shared: &Shared, watch: &Watch| exchange(shared, watch, &settings);
        let talk = Talk::begin("modbus", Shared::default(), CLOSED, work);
        let talk = talk.map_err(|_| DriveFault::Other("this machine starts no more threads"))?;
        Ok(Link { talk, silence })
    }

    /// The newest that was read; `None` before the first time.
    ///
    /// # Errors
    /// Why nothing more is heard.
    pub fn heard(&self) -> Result<Option<Signals>, DriveFault> {
        self.talk.goes_on()?;
        if !self.talk.watch().has_heard() {
            return Ok(None);
        }
        if self.talk.watch().is_silent_for(self.silence) {
            return Err(lost("no reading came in time"));
        }
        let Shared { inputs, outputs, analog_inputs, analog_outputs, .. } = self.talk.handed();
        let values = |digital: &AtomicU32, analog: &[Number; ANALOG]| {
            Values::new(digital.load(Ordering::Relaxed), analog.each_ref().map(Number::get))
        };
        Ok(Some(Signals { inputs: values(inputs, analog_inputs), outputs: values(outputs, analog_outputs) }))
    }

    /// What programs have told outputs so far: digital values, and registers of analog ones.
    pub fn tell(&self, told: &Outputs, layout: &Layout) {
        let Shared { told: digital, told_analog, .. } = self.talk.handed();
        let word = u64::from(told.digital()) << 32 | u64::from(told.values().digital());
        digital.store(word, Ordering::Relaxed);
        for (channel, value) in told.iter() {
            if let (Channel::Analog(number), Value::Analog(value)) = (channel, value)
                && let Some(register) = layout.analog_output.register(value)
            {
                told_analog[usize::from(number)].store(TOLD | u32::from(register), Ordering::Relaxed);
            }
        }
    }
}

impl Recalled for Link {
    type Fault = DriveFault;

    fn has_heard(&self) -> Result<bool, DriveFault> {
        self.heard().map(|heard| heard.is_some())
    }

    /// Ends the exchange.
    fn hang_up(&self) {
        self.talk.hang_up();
    }

    fn is_over(&self) -> bool {
        self.talk.is_over()
    }
}

/// What goes on in the thread.
struct Exchange<'a> {
    shared: &'a Shared,
    watch: &'a Watch,
    layout: &'a Layout,
    client: Client,
    patience: Duration,
    /// Which digital outputs were written by now, and what; and the registers of analog ones.
    written: (u32, u32),
    written_analog: [Option<u16>; ANALOG],
    /// Exchanges in a row in which an output was not as it had been written.
    unswitched: u32,
}

fn exchange(shared: &Shared, watch: &Watch, settings: &ModbusIoSettings) -> Result<(), DriveFault> {
    let client = Client::connect(settings.address, settings.unit, settings.patience)?;
    if let Some(socket) = client.socket() {
        // It was empty: nobody else sets it.
        let _ = shared.socket.set(socket);
    }
    let patience = settings.patience * QUESTIONS;
    let mut exchange = Exchange {
        shared,
        watch,
        layout: &settings.layout,
        client,
        patience,
        written: (0, 0),
        written_analog: [None; ANALOG],
        unswitched: 0,
    };
    exchange.go_on()
}

impl Exchange<'_> {
    fn go_on(&mut self) -> Result<(), DriveFault> {
        let mut next = Instant::now();
        loop {
            if self.watch.ends() {
                return Err(CLOSED);
            }
            match self.once() {
                Ok(()) if self.unswitched > ECHOES => return Err(NOT_SWITCHED),
                Ok(()) => self.watch.hear(),
                // The drives see how old the newest reading is.
                Err(Broken::NoAnswer(why)) if why.passes() => {
                    if self.watch.is_silent_for(self.patience) {
                        return Err(lost(why.name()));
                    }
                }
                Err(broken) => return Err(broken.into()),
            }
            next = (next + PAUSE).max(Instant::now());
            std::thread::sleep(next.saturating_duration_since(Instant::now()));
        }
    }

    fn read(&mut self, table: Table, range: &Range<u16>, most: usize) -> Result<Option<Answer>, Broken> {
        let count = range.len().min(most) as u16;
        if count == 0 {
            return Ok(None);
        }
        self.client.ask(Asked::Read(table, range.start, count)).map(Some)
    }

    /// Writes an output. The device answers, so nothing is lost while many are written.
    fn write(&mut self, what: Asked) -> Result<(), Broken> {
        self.client.ask(what)?;
        if self.watch.has_heard() {
            self.watch.hear();
        }
        Ok(())
    }

    /// Reads everything, and switches what is not as it was told.
    fn once(&mut self) -> Result<(), Broken> {
        let (layout, shared) = (self.layout, self.shared);
        if let Some(read) = self.read(Table::DiscreteInputs, &layout.digital_inputs, 32)? {
            shared.inputs.store(read.bits(), Ordering::Relaxed);
        }
        if let Some(read) = self.read(Table::InputRegisters, &layout.analog_inputs, ANALOG)? {
            for (number, register) in shared.analog_inputs.iter().zip(read.registers()) {
                number.set(layout.analog_input.value(*register));
            }
        }
        let mut differs = false;
        if let Some(read) = self.read(Table::Coils, &layout.digital_outputs, 32)? {
            shared.outputs.store(read.bits(), Ordering::Relaxed);
            let told = shared.told.load(Ordering::Relaxed);
            let (which, values) = ((told >> 32) as u32, told as u32);
            differs |= (read.bits() ^ self.written.1) & self.written.0 != 0;
            let wrong = (read.bits() ^ values) & which;
            for bit in (0..32).filter(|bit| wrong >> bit & 1 != 0) {
                let coil = layout.digital_outputs.start + bit;
                self.write(Asked::Switch(coil, values >> bit & 1 != 0))?;
            }
            self.written = (which, values);
        }
        if let Some(read) = self.read(Table::HoldingRegisters, &layout.analog_outputs, ANALOG)? {
            for (i, register) in (0..).zip(read.registers()) {
                shared.analog_outputs[usize::from(i)].set(layout.analog_output.value(*register));
                differs |= self.written_analog[usize::from(i)].is_some_and(|written| written != *register);
                let told = shared.told_analog[usize::from(i)].load(Ordering::Relaxed);
                if told & TOLD == 0 {
                    continue;
                }
                if told as u16 != *register {
                    self.write(Asked::Set(layout.analog_outputs.start + i, told as u16))?;
                }
                self.written_analog[usize::from(i)] = Some(told as u16);
            }
        }
        self.unswitched = if differs { self.unswitched + 1 } else { 0 };
        Ok(())
    }
}
