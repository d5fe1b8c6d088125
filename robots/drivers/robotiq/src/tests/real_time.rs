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

#[test]
fn fingers_are_told_where_to_go_and_keep_their_grip_when_the_drives_close() {
    let gripper = Arc::new(Mutex::new(Gripper { object: 120, ..Gripper::ACTIVE }));
    let server = Server::start(([127, 0, 0, 1], 0).into(), Arc::clone(&gripper)).expect("a port");
    let mut drives: Drives = Box::new(Robotiq::new(RobotiqSettings::new(server.address())));
    drives.open().expect("it is active");
    until(|| {
        let measured = drives.tick(&opening(200)).expect("it goes on");
        ((measured.position - opening(120)).amax() < 1e-9).then_some(())
    });
    drives.close();
    let gripper = gripper.lock().expect("whole");
    assert_eq!((gripper.told, gripper.connections, gripper.is_active), (200, 1, true));
}

#[test]
fn a_connection_that_is_lost_is_seen_and_only_a_reset_calls_again() {
    let gripper = Arc::new(Mutex::new(Gripper::ACTIVE));
    let server = Server::start(([127, 0, 0, 1], 0).into(), Arc::clone(&gripper)).expect("a port");
    let mut drives: Drives = Box::new(Robotiq::new(RobotiqSettings::new(server.address())));
    drives.open().expect("it is active");
    gripper.lock().expect("whole").closes = true;
    assert_eq!(cause(until(|| drives.tick(&opening(40)).err())), StopCause::CommunicationLost);
    assert_eq!(gripper.lock().expect("whole").connections, 1);
    until(|| match drives.recover().expect("it is there again") {
        Recovery::Over => Some(()),
        Recovery::GoesOn => None,
    });
    drives.switch_on().expect("it answers");
    assert_eq!(gripper.lock().expect("whole").connections, 2);
    let nobody = RobotiqSettings::new(unused_address().expect("a port"));
    assert!((Box::new(Robotiq::new(nobody)) as Drives).open().is_err());
}
