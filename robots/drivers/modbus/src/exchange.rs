//! The exchange with a device, as fast as it answers, whatever the EDP's periods.
//!
//! In: what outputs were told. Out: what inputs read and outputs are, and why it has ended. The exchange and the drives hand this over in
//! atomics, so that neither waits for the other.

use core::ops::Range;
use core::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use core::time::Duration;
use std::sync::Arc;

use mrroc::robot::{ANALOG, Channel, DriveFault, Outputs, Signals, Value, Values};
use mrroc_driver_kit::{Exchange, Network, NotConnected, Number, Peer, Protocol, Received, Session, Times};

use crate::client::{Broken, CONNECT, Client, lost};
use crate::layout::Layout;
use crate::message::{Answer, Table, UnitRequest};
use crate::settings::ModbusIoSettings;

/// The shortest time from one exchange to the next.
const PAUSE: Duration = Duration::from_millis(5);

/// Exchanges after which an output must be as it was told.
const ECHOES: u32 = 20;

/// Questions of the readings of an exchange, and one more; each output that is written counts as heard by itself.
const QUESTIONS: u32 = 5;

/// What the exchange and the drives hand to each other.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    times: Times,
    /// Which digital outputs were told something, in the upper half, and what.
    told: AtomicU64,
    /// The same of analog ones: registers, and which of them.
    told_analog: [AtomicU32; ANALOG],
    inputs: AtomicU32,
    outputs: AtomicU32,
    analog_inputs: [Number; ANALOG],
    analog_outputs: [Number; ANALOG],
}

/// The bit that says that an analog output was told something.
const TOLD: u32 = 1 << 16;

/// An exchange that goes on.
pub(crate) type Link = Exchange<Shared, DriveFault>;

pub(crate) const CLOSED: DriveFault = DriveFault::Other("the device is not connected");

const NOT_SWITCHED: DriveFault = DriveFault::Other(
    "the device does not switch its outputs as it is told: does another master switch them, or are they other coils?",
);

/// Begins to connect, and returns.
///
/// # Errors
/// A thread cannot be started.
pub(crate) fn connect(network: &Network, settings: &ModbusIoSettings) -> Result<Link, DriveFault> {
    let silence = settings.timeout * QUESTIONS;
    let shared = Arc::new(Shared::default());
    let peer = Peer { address: settings.address, timeout: CONNECT, sends_datagrams: false };
    let protocol = IoProtocol {
        shared: Arc::clone(&shared),
        layout: settings.layout.clone(),
        client: Client::new(settings.unit, settings.timeout),
        silence,
        next: None,
        step: Step::FIRST,
        differs: false,
        written: (0, 0),
        written_analog: [None; ANALOG],
        unswitched: 0,
    };
    let session = Session::begin(network, "modbus", peer, protocol, CLOSED);
    let session = session.map_err(|_| DriveFault::Other("this machine starts no more threads"))?;
    Ok(Exchange::new(session, shared, silence, lost("no reading came in time")))
}

impl AsRef<Times> for Shared {
    fn as_ref(&self) -> &Times {
        &self.times
    }
}

impl Shared {
    /// The newest that was read.
    pub fn signals(&self) -> Signals {
        let values = |digital: &AtomicU32, analog: &[Number; ANALOG]| {
            Values::new(digital.load(Ordering::Relaxed), analog.each_ref().map(Number::get))
        };
        Signals {
            inputs: values(&self.inputs, &self.analog_inputs),
            outputs: values(&self.outputs, &self.analog_outputs),
        }
    }

    /// What programs have told outputs so far: digital values, and registers of analog ones.
    pub fn tell(&self, told: &Outputs, layout: &Layout) {
        let word = u64::from(told.digital()) << 32 | u64::from(told.values().digital());
        self.told.store(word, Ordering::Relaxed);
        for (channel, value) in told.iter() {
            if let (Channel::Analog(number), Value::Analog(value)) = (channel, value)
                && let Some(register) = layout.analog_output.register(value)
            {
                self.told_analog[usize::from(number)].store(TOLD | u32::from(register), Ordering::Relaxed);
            }
        }
    }
}

/// What is asked next.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// Reads a table.
    Read(Table),
    /// Switches these digital outputs, one after another, of those that were told these values; then goes on with registers.
    Switch { wrong: u32, which: u32, values: u32 },
    /// Compares analog outputs from this number on with what was read, and sets those that differ.
    Compare(Answer, u16),
    /// Sets the analog output of this number to a register, and goes on comparing.
    Set(Answer, u16, u16),
    /// Everything was read.
    Over,
}

impl Step {
    const FIRST: Step = Step::Read(Table::DiscreteInputs);
}

/// What goes on in the exchange: reads everything, and switches what is not as it was told.
struct IoProtocol {
    shared: Arc<Shared>,
    layout: Layout,
    client: Client,
    silence: Duration,
    /// When the next exchange begins; before the first one nothing is known.
    next: Option<Duration>,
    step: Step,
    /// Whether an output was not as it had been written, in this exchange.
    differs: bool,
    /// Which digital outputs were written by now, and what; and the registers of analog ones.
    written: (u32, u32),
    written_analog: [Option<u16>; ANALOG],
    /// Exchanges in a row in which an output was not as it had been written.
    unswitched: u32,
}

impl Protocol for IoProtocol {
    type Fault = DriveFault;

    fn poll(
        &mut self,
        now: Duration,
        received: Received<'_>,
        send: &mut Vec<u8>,
    ) -> Result<Duration, DriveFault> {
        self.client.receive(&received);
        loop {
            match self.client.answer(now) {
                Ok(Some(answer)) => self.take(now, answer),
                Ok(None) => {}
                // The drives see how old the newest reading is.
                Err(Broken::NoAnswer(why)) if why.passes() => {
                    if self.shared.times.is_silent_for(now, self.silence) {
                        return Err(lost(why.name()));
                    }
                    self.pause(now);
                }
                Err(broken) => return Err(broken.into()),
            }
            if let Some(until) = self.client.until() {
                return Ok(until);
            }
            let next = (*self.next.get_or_insert(now)).max(self.client.may_ask_from());
            if now < next {
                return Ok(next);
            }
            self.go_on(now, send)?;
        }
    }

    fn not_connected(&self, _: NotConnected) -> DriveFault {
        Broken::Unreachable.into()
    }
}

impl IoProtocol {
    /// The next exchange begins anew, after a while.
    fn pause(&mut self, now: Duration) {
        self.next = self.next.map(|next| (next + PAUSE).max(now));
        (self.step, self.differs) = (Step::FIRST, false);
    }

    /// Asks the next question, or ends the exchange.
    fn go_on(&mut self, now: Duration, send: &mut Vec<u8>) -> Result<(), DriveFault> {
        match self.step {
            Step::Read(table) => {
                let (range, most) = self.places(table);
                match range.len().min(most) as u16 {
                    0 => self.step = after(table),
                    count => self.client.ask(now, UnitRequest::Read(table, range.start, count), send),
                }
            }
            Step::Switch { wrong: 0, which, values } => {
                self.written = (which, values);
                self.step = after(Table::Coils);
            }
            Step::Switch { wrong, values, .. } => {
                let bit = wrong.trailing_zeros();
                let coil = self.layout.digital_outputs.start + bit as u16;
                self.client.ask(now, UnitRequest::Switch(coil, values >> bit & 1 != 0), send);
            }
            Step::Compare(read, number) => self.step = self.compare(read, number),
            Step::Set(_, number, told) => {
                self.client.ask(now, UnitRequest::Set(self.layout.analog_outputs.start + number, told), send);
            }
            Step::Over => {
                self.unswitched = if self.differs { self.unswitched + 1 } else { 0 };
                if self.unswitched > ECHOES {
                    return Err(NOT_SWITCHED);
                }
                self.shared.times.hear(now);
                self.pause(now);
            }
        }
        Ok(())
    }

    /// Where something is, and how much of it counts.
    fn places(&self, table: Table) -> (Range<u16>, usize) {
        let Layout { digital_inputs, digital_outputs, analog_inputs, analog_outputs, .. } = &self.layout;
        match table {
            Table::DiscreteInputs => (digital_inputs.clone(), 32),
            Table::InputRegisters => (analog_inputs.clone(), ANALOG),
            Table::Coils => (digital_outputs.clone(), 32),
            Table::HoldingRegisters => (analog_outputs.clone(), ANALOG),
        }
    }

    /// The answer to what was asked.
    fn take(&mut self, now: Duration, answer: Answer) {
        let shared = &self.shared;
        match self.step {
            Step::Read(table) => {
                self.step = after(table);
                match table {
                    Table::DiscreteInputs => shared.inputs.store(answer.bits(), Ordering::Relaxed),
                    Table::InputRegisters => {
                        for (number, register) in shared.analog_inputs.iter().zip(answer.registers()) {
                            number.set(self.layout.analog_input.value(*register));
                        }
                    }
                    Table::Coils => {
                        shared.outputs.store(answer.bits(), Ordering::Relaxed);
                        let told = shared.told.load(Ordering::Relaxed);
                        let (which, values) = ((told >> 32) as u32, told as u32);
                        self.differs |= (answer.bits() ^ self.written.1) & self.written.0 != 0;
                        self.step = Step::Switch { wrong: (answer.bits() ^ values) & which, which, values };
                    }
                    Table::HoldingRegisters => self.step = Step::Compare(answer, 0),
                }
            }
            Step::Switch { wrong, which, values } => {
                self.wrote(now);
                self.step = Step::Switch { wrong: wrong & (wrong - 1), which, values };
            }
            Step::Set(read, number, told) => {
                self.wrote(now);
                self.written_analog[usize::from(number)] = Some(told);
                self.step = Step::Compare(read, number + 1);
            }
            // They ask nothing.
            Step::Compare(..) | Step::Over => {}
        }
    }

    /// An output was written. The device answers, so nothing is lost while many are written.
    fn wrote(&self, now: Duration) {
        if self.shared.times.has_heard() {
            self.shared.times.hear(now);
        }
    }

    /// Takes over an analog output, and compares it with what it was told.
    fn compare(&mut self, read: Answer, number: u16) -> Step {
        let i = usize::from(number);
        let Some(&register) = read.registers().get(i) else { return Step::Over };
        self.shared.analog_outputs[i].set(self.layout.analog_output.value(register));
        self.differs |= self.written_analog[i].is_some_and(|written| written != register);
        let told = self.shared.told_analog[i].load(Ordering::Relaxed);
        if told & TOLD == 0 {
            return Step::Compare(read, number + 1);
        }
        if told as u16 != register {
            return Step::Set(read, number, told as u16);
        }
        self.written_analog[i] = Some(told as u16);
        Step::Compare(read, number + 1)
    }
}

/// What is asked when a table was read.
const fn after(table: Table) -> Step {
    match table {
        Table::DiscreteInputs => Step::Read(Table::InputRegisters),
        Table::InputRegisters => Step::Read(Table::Coils),
        Table::Coils => Step::Read(Table::HoldingRegisters),
        Table::HoldingRegisters => Step::Over,
    }
}
