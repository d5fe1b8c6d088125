//! The drives against a device on loopback that is a table of bits and registers, and against what is no such device.

#![expect(clippy::disallowed_methods, reason = "the exchange has a thread of its own, which tests wait for")]

use core::time::Duration;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener};
use std::sync::{Arc, Mutex, PoisonError};

use mrroc::robot::{Channel, DriveFault, Driver, Outputs, Recovery, Signals, StopCause, Value, WhenLost};
use mrroc_counting_allocator::{Counting, count};
use mrroc_robots::{IoBlock, NoJoints};

use crate::{Layout, ModbusIo, ModbusIoSettings, Scale};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

type Drives = Box<dyn Driver<IoBlock>>;

/// 0 to 10 V on 10 bits.
const VOLTAGE: Scale = Scale { at_zero: 0.0, per_count: 10.0 / 1023.0 };

fn layout() -> Layout {
    Layout {
        digital_inputs: 10..16,
        digital_outputs: 16..20,
        analog_inputs: 0..2,
        analog_outputs: 8..9,
        analog_input: VOLTAGE,
        analog_output: VOLTAGE,
        when_lost: WhenLost::Drop,
    }
}

#[derive(Debug, Default)]
struct Device {
    inputs: [bool; 32],
    coils: [bool; 32],
    input_registers: [u16; 16],
    holding_registers: [u16; 16],
    /// What was written, in order: function, place, value.
    written: Vec<(u8, u16, u16)>,
    connections: usize,
    /// Whether what is written counts for nothing.
    is_stubborn: bool,
    is_silent: bool,
    /// An exception in place of every answer.
    exception: Option<u8>,
}

impl Device {
    /// The answer to a message.
    fn answer(&mut self, message: &[u8]) -> Vec<u8> {
        let word = |at: usize| u16::from_be_bytes([message[at], message[at + 1]]);
        let (function, at, what) = (message[0], word(1), word(3));
        if let Some(code) = self.exception {
            return vec![function | 0x80, code];
        }
        let places = usize::from(at)..usize::from(at) + usize::from(what);
        let bits = |all: &[bool; 32]| {
            let bytes = all[places.clone()]
                .chunks(8)
                .map(|eight| eight.iter().rev().fold(0, |byte, &on| byte << 1 | u8::from(on)));
            bytes.collect::<Vec<_>>()
        };
        let words =
            |all: &[u16; 16]| all[places.clone()].iter().flat_map(|word| word.to_be_bytes()).collect();
        let read: Vec<u8> = match function {
            1 => bits(&self.coils),
            2 => bits(&self.inputs),
            3 => words(&self.holding_registers),
            4 => words(&self.input_registers),
            _ => {
                self.written.push((function, at, what));
                if !self.is_stubborn {
                    match function {
                        5 => self.coils[usize::from(at)] = what == 0xff00,
                        _ => self.holding_registers[usize::from(at)] = what,
                    }
                }
                return message.to_vec();
            }
        };
        [&[function, read.len() as u8], &read[..]].concat()
    }
}

#[derive(Clone)]
struct Bench {
    device: Arc<Mutex<Device>>,
    address: SocketAddr,
}

impl Bench {
    fn new() -> Bench {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("bound");
        let bench = Bench { device: Arc::default(), address };
        let of_thread = bench.clone();
        std::thread::spawn(move || {
            for mut socket in listener.incoming().map_while(Result::ok) {
                of_thread.look(|device| device.connections += 1);
                let mut question = [0; 12];
                while socket.read_exact(&mut question).is_ok() && !of_thread.look(|device| device.is_silent) {
                    let answer = of_thread.look(|device| device.answer(&question[7..]));
                    let length = (answer.len() as u16 + 1).to_be_bytes();
                    let frame = [&question[..4], &length, &question[6..7], &answer].concat();
                    if socket.write_all(&frame).is_err() {
                        break;
                    }
                }
                if of_thread.look(|device| device.is_silent) {
                    // It says nothing, and goes on listening.
                    std::mem::forget(socket);
                }
            }
        });
        bench
    }

    fn look<T>(&self, look: impl FnOnce(&mut Device) -> T) -> T {
        look(&mut self.device.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn settings(&self) -> ModbusIoSettings {
        ModbusIoSettings::new(self.address, layout())
    }

    fn opened(&self) -> Drives {
        let mut drives: Drives = Box::new(ModbusIo::new(self.settings()));
        drives.open().expect("it is there");
        drives
    }
}

/// What comes to be.
fn until<T>(mut look: impl FnMut() -> Option<T>) -> T {
    loop {
        if let Some(found) = look() {
            return found;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn shows(drives: &Drives, holds: impl Fn(&Signals) -> bool) {
    until(|| holds(&drives.signals()).then_some(()));
}

/// The fault that comes to be.
fn fault(drives: &mut Drives) -> DriveFault {
    until(|| drives.tick(&NoJoints::zeros()).err())
}

fn lost(fault: &DriveFault) -> bool {
    matches!(fault, DriveFault::Stopped(stop) if stop.cause() == StopCause::CommunicationLost)
}

#[test]
fn inputs_are_read_and_only_outputs_that_were_told_something_are_switched() {
    let bench = Bench::new();
    bench.look(|device| {
        (device.inputs[10], device.inputs[15], device.inputs[16]) = (true, true, true);
        (device.coils[17], device.coils[18]) = (true, true);
        (device.input_registers[0], device.input_registers[1]) = (1023, 512);
        device.holding_registers[8] = 100;
    });
    let mut drives = bench.opened();
    let channels = drives.channels();
    assert_eq!((channels.digital_inputs, channels.digital_outputs), (6, 4));
    assert_eq!((channels.analog_inputs, channels.analog_outputs), (2, 1));
    let signals = drives.signals();
    assert_eq!((signals.inputs.digital(), signals.outputs.digital()), (0b10_0001, 0b0110));
    assert!((signals.inputs.analog(0) - 10.0).abs() < 1e-9, "{signals:?}");
    assert!((signals.inputs.analog(1) - 5.005).abs() < 1e-3, "{signals:?}");
    assert!(bench.look(|device| device.written.is_empty()), "nothing was told");
    let told = Outputs::NONE
        .with(Channel::Digital(0), Value::Digital(true))
        .with(Channel::Digital(1), Value::Digital(false))
        .with(Channel::Digital(2), Value::Digital(true))
        .with(Channel::Analog(0), Value::Analog(2.5));
    drives.switch_outputs(&told);
    shows(&drives, |signals| signals.outputs.digital() == 0b0101 && signals.outputs.analog(0) > 2.0);
    assert!((drives.signals().outputs.analog(0) - 2.5).abs() < 0.005);
    // Coil 18 was on, and coil 19 was told nothing.
    let written = bench.look(|device| device.written.clone());
    assert_eq!(written, [(5, 16, 0xff00), (5, 17, 0), (6, 8, 256)]);
}

#[test]
fn fault_175_a_device_that_is_not_there_or_says_nothing_is_lost_and_only_a_reset_calls_it_again() {
    let nobody = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()).expect("a port");
    let mut drives: Drives = Box::new(ModbusIo::new(ModbusIoSettings::new(nobody, layout())));
    assert!(drives.open().is_err_and(|fault| lost(&fault)));
    let bench = Bench::new();
    let mut drives = bench.opened();
    drives.switch_outputs(&Outputs::NONE.with(Channel::Digital(3), Value::Digital(true)));
    shows(&drives, |signals| signals.outputs.is_on(3));
    bench.look(|device| device.is_silent = true);
    let told = fault(&mut drives);
    assert!(lost(&told), "{told}");
    // As the watchdog of such a device does.
    bench.look(|device| (device.coils[19], device.is_silent) = (false, false));
    assert_eq!(bench.look(|device| device.connections), 1);
    until(|| match drives.recover().expect("it is there again") {
        Recovery::Over => Some(()),
        _ => None,
    });
    drives.switch_on().expect("it answers");
    assert_eq!(bench.look(|device| device.connections), 2);
    shows(&drives, |signals| signals.outputs.is_on(3));
}

#[test]
fn fault_175_a_refusal_is_told_by_its_name_and_one_that_passes_is_asked_again() {
    let bench = Bench::new();
    bench.look(|device| device.exception = Some(2));
    let mut drives: Drives = Box::new(ModbusIo::new(bench.settings()));
    assert_eq!(
        drives.open(),
        Err(DriveFault::Other("exception 2: the device has no such bits or registers"))
    );
    bench.look(|device| device.exception = Some(6));
    let busy = bench.clone();
    let waits = std::thread::spawn(move || drop(busy.opened()));
    until(|| (bench.look(|device| device.connections) == 2).then_some(()));
    bench.look(|device| device.exception = None);
    waits.join().expect("it was only busy");
}

#[test]
fn fault_176_an_output_that_does_not_switch_is_told() {
    let bench = Bench::new();
    let mut drives = bench.opened();
    bench.look(|device| device.is_stubborn = true);
    drives.switch_outputs(&Outputs::NONE.with(Channel::Digital(0), Value::Digital(true)));
    let told = fault(&mut drives).to_string();
    assert!(told.contains("does not switch its outputs"), "{told}");
}

#[test]
fn fault_176_an_output_that_others_switch_is_switched_back_and_told_if_they_go_on() {
    let bench = Bench::new();
    let mut drives = bench.opened();
    drives.switch_outputs(&Outputs::NONE.with(Channel::Digital(0), Value::Digital(true)));
    shows(&drives, |signals| signals.outputs.is_on(0));
    bench.look(|device| device.coils[16] = false);
    shows(&drives, |signals| !signals.outputs.is_on(0));
    shows(&drives, |signals| signals.outputs.is_on(0));
    let told = until(|| {
        bench.look(|device| device.coils[16] = false);
        drives.tick(&NoJoints::zeros()).err()
    });
    assert!(told.to_string().contains("does not switch its outputs"), "{told}");
}

#[test]
fn fault_176_a_value_that_no_register_can_say_is_refused() {
    let bench = Bench::new();
    let mut drives = bench.opened();
    drives.switch_outputs(&Outputs::NONE.with(Channel::Analog(0), Value::Analog(-0.1)));
    let told = drives.tick(&NoJoints::zeros()).expect_err("it is below 0 V").to_string();
    assert!(told.contains("cannot say"), "{told}");
    assert!(bench.look(|device| device.written.is_empty()));
    // What else is told then is switched: a stop tells it.
    let told = Outputs::NONE
        .with(Channel::Analog(0), Value::Analog(-0.1))
        .with(Channel::Digital(2), Value::Digital(true));
    drives.switch_outputs(&told);
    shows(&drives, |signals| signals.outputs.is_on(2));
}

#[test]
fn fault_176_an_output_that_changes_in_every_exchange_is_no_fault() {
    let bench = Bench::new();
    let mut drives = bench.opened();
    let mut on = false;
    // Five times as many exchanges as an output may take to switch, and in each of them it is told something else.
    until(|| {
        on = !on;
        let level = if on { 2.5 } else { 5.0 };
        let told = Outputs::NONE
            .with(Channel::Analog(0), Value::Analog(level))
            .with(Channel::Digital(0), Value::Digital(on));
        let before = bench.look(|device| device.written.len());
        drives.switch_outputs(&told);
        until(|| {
            drives.tick(&NoJoints::zeros()).expect("it switches as fast as it is asked");
            (bench.look(|device| device.written.len()) > before).then_some(())
        });
        (bench.look(|device| device.written.len()) > 200).then_some(())
    });
}

#[test]
fn a_servo_period_allocates_nothing() {
    let bench = Bench::new();
    let mut drives = bench.opened();
    let on = Outputs::NONE.with(Channel::Digital(1), Value::Digital(true));
    let ((), allocations) = count(|| {
        for _ in 0..100 {
            drives.switch_outputs(&on);
            drives.tick(&NoJoints::zeros()).expect("it answers");
            assert!(!drives.signals().outputs.is_on(3));
        }
    });
    assert_eq!(allocations, 0);
}
