//! The drives against a device that is a table of bits and registers, and against what is no such device, under a virtual clock.

mod device;
mod real_time;

use core::time::Duration;
use std::sync::{Arc, Mutex, PoisonError};

use mrroc::robot::{Channel, DriveFault, Driver, Outputs, Recovery, StopCause, Value, WhenLost};
use mrroc_counting_allocator::{Counting, count};
use mrroc_driver_kit::testing::{Faults, VirtualNetwork};
use mrroc_robots::{IoBlock, NoJoints};

use crate::{Layout, ModbusIo, ModbusIoSettings, Scale};

use device::{Device, LATE};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

type Drives = Box<dyn Driver<IoBlock>>;

const fn ms(time: u64) -> Duration {
    Duration::from_millis(time)
}

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

/// A device on a virtual network, on which its answers arrive in pieces of five bytes.
struct Fixture {
    device: Arc<Mutex<Device>>,
    network: VirtualNetwork,
}

impl Fixture {
    fn new() -> Fixture {
        let device = Arc::<Mutex<Device>>::default();
        let network = VirtualNetwork::with(Arc::clone(&device));
        network.change(|faults| *faults = Faults { piece: 5, ..Faults::NONE });
        Fixture { device, network }
    }

    fn look<T>(&self, look: impl FnOnce(&mut Device) -> T) -> T {
        look(&mut self.device.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn drives(&self) -> Drives {
        // At an address that no virtual network looks at.
        let settings = ModbusIoSettings::new(([127, 0, 0, 1], 1).into(), layout());
        Box::new(ModbusIo::over(self.network.network(), settings))
    }

    fn opened(&self) -> Drives {
        let mut drives = self.drives();
        drives.open().expect("it is there");
        drives
    }

    /// The fault of ticks that go on until this time, and not sooner.
    fn fault_at(&self, drives: &mut Drives, at: Duration) -> DriveFault {
        let before = at - Duration::from_nanos(1);
        while self.network.now() < before {
            self.network.advance(ms(1).min(before - self.network.now()));
            drives.tick(&NoJoints::zeros()).expect("it goes on until then");
        }
        self.network.advance(Duration::from_nanos(1));
        drives.tick(&NoJoints::zeros()).expect_err("it is over now")
    }
}

fn on(output: u8) -> Outputs {
    Outputs::NONE.with(Channel::Digital(output), Value::Digital(true))
}

fn lost(fault: &DriveFault) -> bool {
    matches!(fault, DriveFault::Stopped(stop) if stop.cause() == StopCause::CommunicationLost)
}

#[test]
fn inputs_are_read_and_only_outputs_that_were_told_something_are_switched() {
    let all = Fixture::new();
    all.look(|device| {
        (device.inputs[10], device.inputs[15], device.inputs[16]) = (true, true, true);
        (device.coils[17], device.coils[18]) = (true, true);
        (device.input_registers[0], device.input_registers[1]) = (1023, 512);
        device.holding_registers[8] = 100;
    });
    let mut drives = all.opened();
    let channels = drives.channels();
    assert_eq!((channels.digital_inputs, channels.digital_outputs), (6, 4));
    assert_eq!((channels.analog_inputs, channels.analog_outputs), (2, 1));
    let signals = drives.signals();
    assert_eq!((signals.inputs.digital(), signals.outputs.digital()), (0b10_0001, 0b0110));
    assert!((signals.inputs.analog(0) - 10.0).abs() < 1e-9, "{signals:?}");
    assert!((signals.inputs.analog(1) - 5.005).abs() < 1e-3, "{signals:?}");
    assert!(all.look(|device| device.written.is_empty()), "nothing was told");
    let told = on(0)
        .with(Channel::Digital(1), Value::Digital(false))
        .with(Channel::Digital(2), Value::Digital(true))
        .with(Channel::Analog(0), Value::Analog(2.5));
    drives.switch_outputs(&told);
    // It is written in the next exchange, and read in the one after that.
    all.network.advance(ms(10));
    let signals = drives.signals();
    assert_eq!(signals.outputs.digital(), 0b0101);
    assert!((signals.outputs.analog(0) - 2.5).abs() < 0.005);
    // Coil 18 was on, and coil 19 was told nothing.
    let written = all.look(|device| device.written.clone());
    assert_eq!(written, [(5, 16, 0xff00), (5, 17, 0), (6, 8, 256)]);
}

#[test]
fn everything_is_read_every_5_ms_and_not_more_often() {
    let all = Fixture::new();
    let _drives = all.opened();
    let before = all.look(|device| device.exchanges);
    all.network.advance(ms(1000));
    assert_eq!(all.look(|device| device.exchanges) - before, 200);
    // A device that takes 10 ms for each of four questions is asked as fast as it answers.
    all.network.change(|faults| faults.latency = ms(5));
    all.network.advance(ms(100));
    let before = all.look(|device| device.exchanges);
    all.network.advance(ms(4000));
    assert_eq!(all.look(|device| device.exchanges) - before, 100);
}

#[test]
fn fault_175_a_device_that_is_not_there_or_says_nothing_is_lost_and_only_a_reset_calls_it_again() {
    let settings = ModbusIoSettings::new(([127, 0, 0, 1], 1).into(), layout());
    let mut drives: Drives = Box::new(ModbusIo::over(VirtualNetwork::empty().network(), settings));
    assert!(drives.open().is_err_and(|fault| lost(&fault)));
    let all = Fixture::new();
    let mut drives = all.opened();
    drives.switch_outputs(&on(3));
    all.network.advance(ms(10));
    assert!(drives.signals().outputs.is_on(3));
    all.look(|device| device.is_silent = true);
    all.network.advance(ms(5));
    // 200 ms after the question that it has not answered.
    let end = all.look(|device| device.asked_at) + ms(200);
    let told = all.fault_at(&mut drives, end);
    assert_eq!(told.to_string(), "communication lost: no answer came in time");
    // As the watchdog of such a device does.
    all.look(|device| (device.coils[19], device.is_silent) = (false, false));
    all.network.advance(ms(5000));
    assert_eq!(all.look(|device| device.connections), 1);
    all.network.until(|| match drives.recover().expect("it is there again") {
        Recovery::Over => Some(()),
        Recovery::GoesOn => None,
    });
    drives.switch_on().expect("it answers");
    assert_eq!(all.look(|device| device.connections), 2);
    all.network.advance(ms(10));
    assert!(drives.signals().outputs.is_on(3));
}

#[test]
fn fault_175_a_connection_that_is_closed_or_loses_a_byte_is_lost() {
    let all = Fixture::new();
    let mut drives = all.opened();
    all.network.advance(ms(2));
    all.network.close();
    // The next question shows it.
    let told = all.fault_at(&mut drives, ms(5));
    assert_eq!(told.to_string(), "communication lost: the connection was closed");
    let all = Fixture::new();
    let mut drives = all.opened();
    all.network.change(|faults| faults.lost = Some(9));
    // An answer that a byte is missing of never ends.
    let told = all.fault_at(&mut drives, ms(205));
    assert_eq!(told.to_string(), "communication lost: no answer came in time");
}

#[test]
fn fault_175_whichever_byte_is_lost_outputs_are_told_nothing_but_what_they_were_told() {
    // 44 bytes come in an exchange, and 24 more in the one that switches.
    for byte in 0..100 {
        let all = Fixture::new();
        all.network.change(|faults| faults.lost = Some(byte));
        let mut drives = all.drives();
        drives.switch_outputs(&on(3).with(Channel::Analog(0), Value::Analog(2.5)));
        let told = drives
            .open()
            .err()
            .unwrap_or_else(|| all.network.until(|| drives.tick(&NoJoints::zeros()).err()));
        assert!(lost(&told), "{byte}: {told}");
        assert!(all.network.now() < ms(250), "{byte}: as soon as an answer does not end");
        let written = all.look(|device| device.written.clone());
        let expected = [(5, 19, 0xff00), (6, 8, 256)];
        assert!(expected.starts_with(&written), "{byte}: {written:?}");
    }
}

#[test]
fn fault_175_a_refusal_is_told_by_its_name_and_one_that_passes_is_asked_again() {
    let all = Fixture::new();
    all.look(|device| device.exception = Some(2));
    assert_eq!(
        all.drives().open(),
        Err(DriveFault::Other("exception 2: the device has no such bits or registers"))
    );
    assert_eq!(all.network.now(), ms(1), "at once, as the drives look");
    // One that is only busy for 300 ms.
    let all = Fixture::new();
    let mut drives = all.opened();
    all.look(|device| device.exception = Some(6));
    for _ in 0..300 {
        all.network.advance(ms(1));
        drives.tick(&NoJoints::zeros()).expect("it may pass");
    }
    all.look(|device| (device.exception, device.inputs[11]) = (None, true));
    all.network.advance(ms(5));
    assert!(drives.signals().inputs.is_on(1));
    assert_eq!(all.look(|device| device.connections), 1);
}

/// A gateway gives up the reading of inputs, one of which goes off at that moment; the answer that says it is on comes late.
#[test]
fn fault_175_what_a_gateway_has_given_up_and_passes_on_late_is_no_reading() {
    for renumbers in [false, true] {
        let all = Fixture::new();
        all.look(|device| {
            device.inputs[10] = true;
            // The next question would be open when the late answer comes.
            (device.renumbers, device.takes) = (renumbers, 2 * LATE);
        });
        let mut drives = all.opened();
        assert!(drives.signals().inputs.is_on(0));
        all.look(|device| device.gives_up = Some(2));
        let exchanges = all.look(|device| device.exchanges);
        all.network.until(|| (all.look(|device| device.exchanges) > exchanges).then_some(()));
        all.look(|device| device.inputs[10] = false);
        let given_up = all.look(|device| device.asked_at);
        // 200 ms in which nothing is asked, and four answers.
        let end = given_up + ms(200) + 8 * LATE;
        while all.network.now() < end {
            all.network.advance(ms(1));
            drives.tick(&NoJoints::zeros()).expect("it goes on");
            let is_old = all.look(|device| device.exchanges) == exchanges + 1;
            assert_eq!(is_old, all.network.now() < given_up + ms(200), "{:?}", all.network.now());
        }
        all.network.advance(ms(10));
        assert!(!drives.signals().inputs.is_on(0), "numbered anew: {renumbers}");
        assert_eq!(all.look(|device| device.connections), 1);
    }
}

#[test]
fn fault_175_a_device_that_stays_busy_is_lost_after_a_second() {
    let all = Fixture::new();
    all.look(|device| device.exception = Some(6));
    let told = all.drives().open().expect_err("it stays busy");
    assert_eq!(told.to_string(), "communication lost: exception 6: the device is busy");
    assert_eq!(all.network.now(), ms(1005), "more than a second, and an exchange");
    // The drives see sooner that nothing was read for more than a second.
    let all = Fixture::new();
    let mut drives = all.opened();
    all.look(|device| device.exception = Some(6));
    let told = all.fault_at(&mut drives, ms(1000) + Duration::from_nanos(1));
    assert_eq!(told.to_string(), "communication lost: no reading came in time");
}

#[test]
fn fault_176_an_output_that_does_not_switch_is_told() {
    let all = Fixture::new();
    let mut drives = all.opened();
    all.look(|device| device.is_stubborn = true);
    drives.switch_outputs(&on(0));
    // Written at 5 ms, and not so in the 21 exchanges that follow.
    let told = all.fault_at(&mut drives, ms(5 + 21 * 5)).to_string();
    assert!(told.contains("does not switch its outputs"), "{told}");
}

#[test]
fn fault_176_an_output_that_others_switch_is_switched_back_and_told_if_they_go_on() {
    let all = Fixture::new();
    let mut drives = all.opened();
    drives.switch_outputs(&on(0));
    all.network.advance(ms(10));
    assert!(drives.signals().outputs.is_on(0));
    all.look(|device| device.coils[16] = false);
    all.network.advance(ms(5));
    assert!(!drives.signals().outputs.is_on(0));
    all.network.advance(ms(5));
    assert!(drives.signals().outputs.is_on(0));
    let told = all.network.until(|| {
        all.look(|device| device.coils[16] = false);
        drives.tick(&NoJoints::zeros()).err()
    });
    assert!(told.to_string().contains("does not switch its outputs"), "{told}");
    assert_eq!(all.network.now(), ms(25 + 20 * 5), "with the 21st exchange after the one of 20 ms");
}

#[test]
fn fault_176_a_value_that_no_register_can_say_is_refused() {
    let all = Fixture::new();
    let mut drives = all.opened();
    drives.switch_outputs(&Outputs::NONE.with(Channel::Analog(0), Value::Analog(-0.1)));
    let told = drives.tick(&NoJoints::zeros()).expect_err("it is below 0 V").to_string();
    assert!(told.contains("cannot say"), "{told}");
    all.network.advance(ms(1000));
    assert!(all.look(|device| device.written.is_empty()));
    // What else is told then is switched: a stop tells it.
    let told = Outputs::NONE
        .with(Channel::Analog(0), Value::Analog(-0.1))
        .with(Channel::Digital(2), Value::Digital(true));
    drives.switch_outputs(&told);
    all.network.advance(ms(10));
    assert!(drives.signals().outputs.is_on(2));
}

#[test]
fn fault_176_an_output_that_changes_in_every_exchange_is_no_fault() {
    let all = Fixture::new();
    let mut drives = all.opened();
    // Five times as many exchanges as an output may take to switch, and in each of them it is told something else.
    for exchange in 1..=100 {
        let is_on = exchange % 2 == 1;
        let level = if is_on { 2.5 } else { 5.0 };
        let told = Outputs::NONE
            .with(Channel::Analog(0), Value::Analog(level))
            .with(Channel::Digital(0), Value::Digital(is_on));
        drives.switch_outputs(&told);
        all.network.advance(ms(5));
        drives.tick(&NoJoints::zeros()).expect("it switches as fast as it is asked");
        assert_eq!(all.look(|device| device.written.len()), 2 * exchange);
    }
}

#[test]
fn a_servo_period_allocates_nothing() {
    let all = Fixture::new();
    let mut drives = all.opened();
    let told = on(1);
    for _ in 0..100 {
        let ((), allocations) = count(|| {
            drives.switch_outputs(&told);
            drives.tick(&NoJoints::zeros()).expect("it answers");
            assert!(!drives.signals().outputs.is_on(3));
        });
        assert_eq!(allocations, 0);
        all.network.advance(ms(1));
    }
}
