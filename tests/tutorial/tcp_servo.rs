//! The page of a driver of one's own over TCP: what it says of the servo, with a servo on loopback.

#[path = "tcp_servo/arm.rs"]
mod arm;

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::time::Duration;

use arm::{Arm, Servo};
use mrroc::cell_file::CellFile;
use mrroc::robot::{ClearedBy, DriveFault, Driver, Pace, Pulse, Recovery, StopCause};
use mrroc_robots::One;

use super::page::root;

/// As the servo of the page says it.
fn said(count: u64, position: f64, velocity: f64, state: u8) -> Vec<u8> {
    [&count.to_le_bytes()[..], &position.to_le_bytes(), &velocity.to_le_bytes(), &[state]].concat()
}

fn listening(at: SocketAddr) -> TcpListener {
    TcpListener::bind(at).expect("a port")
}

/// Drives that have called a servo, which stands at 0.5 rad, and the servo's end of the line.
fn opened(servo: &TcpListener) -> (Box<dyn Driver<Arm>>, TcpStream) {
    let mut drives: Box<dyn Driver<Arm>> = Box::new(Servo::at(servo.local_addr().expect("bound")));
    assert!(drives.measured().is_err(), "nothing is open yet");
    let (opened, line) = std::thread::scope(|scope| {
        let called = scope.spawn(|| {
            let (mut line, _) = servo.accept().expect("it calls");
            line.write_all(&said(7, 0.5, 0.0, 0)).expect("sent");
            line
        });
        (drives.open(), called.join().expect("no panic"))
    });
    opened.expect("it speaks");
    (drives, line)
}

/// What comes of what was sent before, however long it takes.
fn heard(drives: &mut dyn Driver<Arm>) -> Result<Pulse, DriveFault> {
    loop {
        if let Some(pulse) = drives.pulse(Duration::ZERO)? {
            return Ok(pulse);
        }
        std::thread::yield_now();
    }
}

fn loopback() -> SocketAddr {
    "127.0.0.1:0".parse().expect("an address")
}

#[test]
fn a_servo_over_tcp_paces_its_drives_and_is_told_each_demand() {
    let (mut drives, mut line) = opened(&listening(loopback()));
    assert_eq!(drives.pace(), Pace::Robot { timeout: Duration::from_millis(100) });
    assert_eq!(drives.measured().map(|measured| measured.position), Ok(One::new(0.5)));
    assert_eq!(drives.pulse(Duration::ZERO), Ok(None), "a period begins when the servo says so");
    line.write_all(&said(8, 0.51, 2.5, 0)).expect("sent");
    assert_eq!(heard(&mut *drives).map(|pulse| pulse.count), Ok(8));
    let measured = drives.tick(&One::new(0.52)).expect("told");
    assert_eq!((measured.position, measured.velocity), (One::new(0.51), One::new(2.5)));
    let mut told = [0; 8];
    line.read_exact(&mut told).expect("told");
    assert_eq!(f64::from_le_bytes(told), 0.52);
    drives.close();
    assert_eq!(line.read(&mut told).expect("the line ends"), 0);
}

#[test]
fn a_servo_over_tcp_names_its_stops_and_who_may_clear_them() {
    let (mut drives, mut line) = opened(&listening(loopback()));
    for (state, cause, by) in [
        (1, StopCause::EmergencyStop, ClearedBy::PersonAtRobot),
        (2, StopCause::PendantInControl, ClearedBy::Pendant),
        (3, StopCause::Failure, ClearedBy::PersonAtRobot),
    ] {
        line.write_all(&said(8, 0.5, 0.0, state)).expect("sent");
        // It says the same until something else comes.
        let stop = loop {
            match drives.pulse(Duration::ZERO) {
                Err(DriveFault::Stopped(stop)) if stop.cause() == cause => break stop,
                Ok(None) | Err(DriveFault::Stopped(_)) => std::thread::yield_now(),
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(stop.cleared_by(), by);
        // No reset clears it, and none calls a servo that is there.
        assert_eq!(drives.recover(), Ok(Recovery::Over));
        assert_eq!(drives.switch_on(), Err(DriveFault::Stopped(stop)));
    }
    line.write_all(&said(9, 0.5, 0.0, 0)).expect("sent");
    while drives.pulse(Duration::ZERO).is_err() {
        std::thread::yield_now();
    }
    assert_eq!(drives.switch_on(), Ok(()));
}

#[test]
fn a_servo_over_tcp_that_is_gone_is_lost_until_a_reset_calls_it_again() {
    let servo = listening(loopback());
    let (mut drives, line) = opened(&servo);
    let at = servo.local_addr().expect("bound");
    drop((line, servo));
    let lost = heard(&mut *drives).expect_err("it is gone");
    let DriveFault::Stopped(stop) = lost else { panic!("{lost:?}") };
    assert_eq!((stop.cause(), stop.cleared_by()), (StopCause::CommunicationLost, ClearedBy::Operator));
    assert_eq!(drives.tick(&One::new(0.5)), Err(lost));
    assert_eq!(drives.recover(), Err(lost), "nobody is there");
    let servo = listening(at);
    assert_eq!(drives.recover(), Ok(Recovery::GoesOn), "called, and it has said nothing yet");
    let (mut line, _) = servo.accept().expect("it calls");
    line.write_all(&said(0, 0.7, 0.0, 0)).expect("sent");
    // An EDP asks for periods between: what they take away counts, too.
    assert_eq!(heard(&mut *drives).map(|pulse| pulse.count), Ok(0));
    assert_eq!(drives.recover(), Ok(Recovery::Over));
    assert_eq!(drives.switch_on(), Ok(()));
    assert_eq!(drives.measured().map(|measured| measured.position), Ok(One::new(0.7)));
}

#[test]
fn the_cell_of_the_servos_page_is_in_order() {
    let file = CellFile::read(root().join("tests/tutorial/tcp_servo/cell.toml")).expect("in order");
    let cell = file.cell(&arm::kinds()).expect("known").program(|mp| mp.robot::<Arm>("table").map(drop));
    let refused = cell.run().expect_err("the virtual clock waits for no hardware").to_string();
    assert!(refused.contains("servo 127.0.0.1:2000"), "{refused}");
}
