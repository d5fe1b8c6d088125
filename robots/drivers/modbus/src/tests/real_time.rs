//! The drives over sockets, in real time: they connect, exchange and end, and a loss of the connection is seen.

use mrroc_driver_kit::Network;
use mrroc_driver_kit::testing::{Server, unused_address};

use super::*;

fn until<T>(mut look: impl FnMut() -> Option<T>) -> T {
    loop {
        if let Some(found) = look() {
            return found;
        }
        Network::SOCKETS.wait(ms(1));
    }
}

fn served() -> (Arc<Mutex<Device>>, Drives) {
    let device = Arc::new(Mutex::new(Device::default()));
    let server = Server::start(([127, 0, 0, 1], 0).into(), Arc::clone(&device)).expect("a port");
    let mut drives: Drives = Box::new(ModbusIo::new(ModbusIoSettings::new(server.address(), layout())));
    drives.open().expect("it is there");
    (device, drives)
}

#[test]
fn outputs_are_switched_and_inputs_are_read() {
    let (device, mut drives) = served();
    device.lock().expect("whole").inputs[12] = true;
    until(|| drives.signals().inputs.is_on(2).then_some(()));
    drives.switch_outputs(&on(3));
    until(|| drives.signals().outputs.is_on(3).then_some(()));
    drives.close();
    let device = device.lock().expect("whole");
    assert_eq!((&device.written[..], device.connections), (&[(5, 19, 0xff00)][..], 1));
}

#[test]
fn a_connection_that_is_lost_is_seen_and_only_a_reset_calls_again() {
    let (device, mut drives) = served();
    device.lock().expect("whole").closes = true;
    let told = until(|| drives.tick(&NoJoints::zeros()).err());
    assert!(lost(&told), "{told}");
    assert_eq!(device.lock().expect("whole").connections, 1);
    until(|| match drives.recover().expect("it is there again") {
        Recovery::Over => Some(()),
        Recovery::GoesOn => None,
    });
    drives.switch_on().expect("it answers");
    assert_eq!(device.lock().expect("whole").connections, 2);
    let nobody = ModbusIoSettings::new(unused_address().expect("a port"), layout());
    assert!((Box::new(ModbusIo::new(nobody)) as Drives).open().is_err_and(|fault| lost(&fault)));
}
