//! The drives over sockets on loopback, in real time.

#![expect(clippy::disallowed_methods, reason = "a message over a real socket takes its time")]

use std::net::UdpSocket;

use super::*;

/// A controller's socket, and the drives that it has opened.
fn opened() -> (UdpSocket, SocketAddr, Rsi) {
    let controller = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    // A port that was free a moment ago.
    let listen = UdpSocket::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port");
    let mut drives = Rsi::new(RsiSettings::new(listen, CONTROLLER.ip()));
    // It says the same until somebody listens.
    std::thread::scope(|scope| {
        let opens = scope.spawn(|| {
            let edp: &mut dyn Driver<Arm> = &mut drives;
            edp.open()
        });
        while !opens.is_finished() {
            controller.send_to(&said(4000, 10.0), listen).expect("sent");
            std::thread::sleep(Duration::from_millis(4));
        }
        opens.join().expect("it returns").expect("the controller speaks");
    });
    (controller, listen, drives)
}

/// Until this period's message has come.
fn pulse(drives: &mut Rsi, count: u64) -> Pulse {
    let edp: &mut dyn Driver<Arm> = drives;
    loop {
        match edp.pulse(Duration::ZERO).expect("it goes on") {
            Some(pulse) if pulse.count == count => return pulse,
            _ => std::thread::sleep(Duration::from_micros(100)),
        }
    }
}

/// The answer to the message of this clock.
fn answer(controller: &UdpSocket, ipoc: u64) -> String {
    let mut bytes = [0; 512];
    loop {
        let len = controller.recv(&mut bytes).expect("an answer");
        let answer = String::from_utf8(bytes[..len].to_vec()).expect("text");
        if answer.contains(&format!("<IPOC>{ipoc}</IPOC>")) {
            return answer;
        }
    }
}

#[test]
fn fault_89_what_is_no_message_of_the_controller_is_not_answered() {
    let (controller, listen, mut drives) = opened();
    controller.send_to(&said(4004, 10.0), listen).expect("sent");
    pulse(&mut drives, 1001);
    let stranger = UdpSocket::bind("127.0.0.2:0").expect("a socket");
    stranger.send_to(&said(4008, 90.0), listen).expect("sent");
    controller.send_to(b"<Rob Type=\"KUKA\"><IPOC>4008</IPOC></Rob>", listen).expect("sent");
    controller.send_to(&said(4012, 10.0), listen).expect("sent");
    pulse(&mut drives, 1003);
    assert_eq!(drives.counted().map(|counted| counted.of_others), Some(1));
    let edp: &mut dyn Driver<Arm> = &mut drives;
    assert_eq!(edp.measured().map(|measured| measured.position), Ok(at(10.0)));
}

#[test]
fn messages_are_answered_over_sockets_until_the_drives_are_closed() {
    let (controller, listen, mut drives) = opened();
    assert!(answer(&controller, 4000).contains(r#"A1="0.000000""#));
    for period in 1..=10 {
        let a1 = 10.0 + 0.01 * period as f64;
        controller.send_to(&said(4000 + 4 * period, 10.0), listen).expect("sent");
        pulse(&mut drives, 1000 + period);
        let edp: &mut dyn Driver<Arm> = &mut drives;
        edp.tick(&at(a1)).expect("sent");
        // It may have been answered before the tick, where nothing was demanded in the period before.
        let answer = answer(&controller, 4000 + 4 * period);
        let correction = format!("A1=\"{:.6}\"", a1 - 10.0);
        assert!(period == 1 || answer.contains(&correction), "{answer}");
    }
    let edp: &mut dyn Driver<Arm> = &mut drives;
    edp.close();
    assert_eq!((edp.measured(), drives.counted()), (Err(CLOSED), None));
    UdpSocket::bind(listen).expect("the port is free again");
}
