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

fn served(fingers: Fingers) -> (Arc<Mutex<Fake>>, Drives) {
    let hand = Arc::new(Mutex::new(Fake::new(fingers)));
    let server = Server::start(([127, 0, 0, 1], 0).into(), Arc::clone(&hand)).expect("a port");
    // In a hurry: the fingers take a tenth of their time.
    let settings = HandSettings { speed: 1.0, ..HandSettings::new(server.address()) };
    let mut drives: Drives = Box::new(Hand::new(settings));
    drives.open().expect("it is homed");
    (hand, drives)
}

#[test]
fn fingers_grasp_and_keep_their_grip_when_the_drives_close() {
    let (hand, mut drives) = served(Fingers { object: Some(0.03), ..Fingers::open() });
    until(|| {
        let measured = drives.tick(&One::new(0.01)).expect("it goes on");
        ((measured.position[0] - 0.03).abs() < 1e-9 && holds(&drives)).then_some(())
    });
    drives.close();
    let fingers = &hand.lock().expect("whole").fingers;
    assert_eq!(fingers.asked, [(GRASP, vec![0.01, 0.0, STROKE, 1.0, FORCE])]);
    assert_eq!((fingers.connections, fingers.is_grasped), (1, true));
}

#[test]
fn a_connection_that_is_lost_is_seen_and_only_a_reset_calls_again() {
    let (hand, mut drives) = served(Fingers::open());
    hand.lock().expect("whole").fingers.hangs_up = true;
    let told = until(|| drives.tick(&One::new(STROKE)).err());
    assert_eq!(told.to_string(), "communication lost: connection closed by the robot");
    assert_eq!(hand.lock().expect("whole").fingers.connections, 1);
    until(|| match drives.recover().expect("it is there again") {
        Recovery::Over => Some(()),
        Recovery::GoesOn => None,
    });
    drives.switch_on().expect("it says where it is");
    assert_eq!(hand.lock().expect("whole").fingers.connections, 2);
    let nobody = HandSettings::new(unused_address().expect("a port"));
    assert!((Box::new(Hand::new(nobody)) as Drives).open().is_err());
}
