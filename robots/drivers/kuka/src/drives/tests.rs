//! The drives against a controller that a test plays, over loopback.

use core::sync::atomic::{AtomicBool, Ordering};
use std::net::UdpSocket;

use mrroc::pose::Pose;
use mrroc::robot::{Channel, Limits, NoInverse, Value};

use super::*;

#[derive(Clone)]
struct Arm(Limits<Joints>);

impl Robot for Arm {
    const KIND: &'static str = "arm";
    type Joints = Joints;
    fn limits(&self) -> &Limits<Joints> {
        &self.0
    }
    fn forward(&self, _: &Joints) -> Pose {
        Pose::identity()
    }
    fn inverse(&self, _: &Pose, near: &Joints) -> Result<Joints, NoInverse> {
        Ok(*near)
    }
}

/// A controller on loopback, and the drives that it talks to.
struct Bench {
    controller: UdpSocket,
    drives: Box<dyn Driver<Arm>>,
    listen: SocketAddr,
}

impl Bench {
    fn opened() -> Bench {
        let (bench, opened) = Bench::with(Corrections::Absolute, &said(4000, 10.0));
        opened.expect("the controller speaks");
        bench
    }

    /// Drives that were opened, or not, while the controller said this.
    fn with(corrections: Corrections, message: &[u8]) -> (Bench, Result<(), DriveFault>) {
        Bench::having(corrections, message, |_| {})
    }

    /// The same with drives to which something was said before.
    fn having(
        corrections: Corrections,
        message: &[u8],
        before: impl FnOnce(&mut dyn Driver<Arm>),
    ) -> (Bench, Result<(), DriveFault>) {
        let controller = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        // A port that was free a moment ago.
        let listen = UdpSocket::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port");
        let robot = controller.local_addr().expect("bound").ip();
        let settings = RsiSettings { corrections, ..RsiSettings::new(listen, robot) };
        let mut drives: Box<dyn Driver<Arm>> = Box::new(Rsi::new(settings));
        assert!(drives.measured().is_err(), "nothing is open yet");
        before(drives.as_mut());
        let says = controller.try_clone().expect("the same socket");
        // It says the same until somebody listens.
        let done = AtomicBool::new(false);
        let opened = std::thread::scope(|scope| {
            scope.spawn(|| {
                while !done.load(Ordering::Acquire) {
                    says.send_to(message, listen).expect("sent");
                    std::thread::sleep(Duration::from_millis(4));
                }
            });
            let opened = drives.open();
            done.store(true, Ordering::Release);
            opened
        });
        (Bench { controller, drives, listen }, opened)
    }

    fn says(&self, ipoc: u64, a1: f64) {
        self.controller.send_to(&said(ipoc, a1), self.listen).expect("sent");
    }

    /// The answer to a message that says how many answers were late so far, with axis 1 demanded there.
    fn answers(&mut self, ipoc: u64, late: u64, a1: f64) -> String {
        self.controller.send_to(&said_late(ipoc, a1, late), self.listen).expect("sent");
        while self.pulse().expect("it goes on").count != ipoc / 4 {}
        self.drives.tick(&at(a1)).expect("sent");
        loop {
            let answer = self.answer();
            if answer.contains(&format!("<IPOC>{ipoc}</IPOC>")) {
                return answer;
            }
        }
    }

    /// The next answer, as text.
    fn answer(&self) -> String {
        let mut bytes = [0; 512];
        let len = self.controller.recv(&mut bytes).expect("an answer");
        String::from_utf8(bytes[..len].to_vec()).expect("text")
    }

    fn pulse(&mut self) -> Result<Pulse, DriveFault> {
        loop {
            if let Some(pulse) = self.drives.pulse(Duration::ZERO)? {
                return Ok(pulse);
            }
            std::thread::sleep(Duration::from_micros(100));
        }
    }
}

fn said(ipoc: u64, a1: f64) -> Vec<u8> {
    let axes = r#"A2="-90" A3="90" A4="0" A5="45" A6="0""#;
    format!(r#"<Rob Type="KUKA"><AIPos A1="{a1}" {axes}/><IPOC>{ipoc}</IPOC></Rob>"#).into_bytes()
}

fn said_late(ipoc: u64, a1: f64, late: u64) -> Vec<u8> {
    let text = String::from_utf8(said(ipoc, a1)).expect("text");
    text.replace("<IPOC>", &format!("<Delay D=\"{late}\"/><IPOC>")).into_bytes()
}

fn at(a1: f64) -> Joints {
    radians(&[a1, -90.0, 90.0, 0.0, 45.0, 0.0])
}

#[test]
fn every_message_gets_one_answer_with_its_clock_and_corrections_against_the_start() {
    let mut bench = Bench::opened();
    assert_eq!(bench.drives.measured().map(|measured| measured.position), Ok(at(10.0)));
    let first = bench.answer();
    assert!(first.contains(r#"A1="0.000000""#) && first.contains("<IPOC>4000</IPOC>"), "{first}");

    // What had come while the drives were opened is not what comes now.
    bench.says(4004, 10.0);
    while bench.pulse().expect("it goes on").count != 1001 {}
    bench.drives.tick(&at(10.5)).expect("sent");
    bench.says(4008, 10.25);
    assert_eq!(bench.pulse().map(|pulse| pulse.count), Ok(1002));
    let measured = bench.drives.tick(&at(11.0)).expect("sent");
    assert_eq!(measured.position, at(10.25));
    let velocity = 0.25_f64.to_radians() / 4e-3;
    assert!((measured.velocity[0] - velocity).abs() < 1e-9, "{}", measured.velocity[0]);
    let mut answer = bench.answer();
    while !answer.contains("<IPOC>4008</IPOC>") {
        answer = bench.answer();
    }
    assert!(answer.contains(r#"A1="1.000000" A2="0.000000""#), "{answer}");

    // Nobody demands anything: the next message is left unanswered, and from then on the drives hold by themselves.
    bench.says(4012, 11.0);
    bench.pulse().expect("it goes on");
    bench.says(4016, 11.0);
    bench.pulse().expect("it goes on");
    let held = bench.answer();
    assert!(held.contains(r#"A1="1.000000""#) && held.contains("<IPOC>4016</IPOC>"), "{held}");
}

#[test]
fn fault_89_a_controller_that_was_started_anew_moves_by_nothing_until_a_reset() {
    let mut bench = Bench::opened();
    bench.says(4004, 10.0);
    while bench.pulse().expect("it goes on").count != 1001 {}
    bench.drives.tick(&at(20.0)).expect("sent");
    // Its clock counts from the beginning, and corrections from where it stands.
    bench.says(8, 20.0);
    assert_eq!(bench.pulse(), Err(ANEW));
    let mut answer = bench.answer();
    while !answer.contains("<IPOC>8</IPOC>") {
        answer = bench.answer();
    }
    assert!(answer.contains(r#"A1="0.000000""#), "{answer}");
    bench.drives.switch_on().expect("it speaks");
    bench.says(12, 20.0);
    assert_eq!(bench.pulse().map(|pulse| pulse.count), Ok(3));
    bench.drives.tick(&at(20.5)).expect("sent");
    while !answer.contains("<IPOC>12</IPOC>") {
        answer = bench.answer();
    }
    // Held by the drives, or demanded: the message may have been answered before the tick.
    bench.says(16, 20.0);
    bench.pulse().expect("it goes on");
    bench.drives.tick(&at(20.5)).expect("sent");
    while !answer.contains("<IPOC>16</IPOC>") {
        answer = bench.answer();
    }
    assert!(answer.contains(r#"A1="0.500000""#), "{answer}");
}

#[test]
fn fault_89_what_is_no_message_of_the_controller_is_not_answered() {
    let mut bench = Bench::opened();
    bench.says(4004, 10.0);
    while bench.pulse().expect("it goes on").count != 1001 {}
    let stranger = UdpSocket::bind("127.0.0.2:0").expect("a socket");
    stranger.send_to(&said(4008, 90.0), bench.listen).expect("sent");
    bench.controller.send_to(b"<Rob Type=\"KUKA\"><IPOC>4008</IPOC></Rob>", bench.listen).expect("sent");
    bench.says(4012, 10.0);
    while bench.pulse().expect("it goes on").count != 1003 {}
    assert_eq!(bench.drives.measured().map(|measured| measured.position), Ok(at(10.0)));
}

/// When a controller of these tests counts an answer that did not come.
#[derive(Clone, Copy, PartialEq)]
enum Counting {
    AtOnce,
    WhenHeard,
    Never,
}

impl Bench {
    /// Drives that were opened, or not, with relative corrections, by a controller that counts. Its clock and its count then.
    fn counting(counting: Counting) -> (Bench, Result<(), DriveFault>, u64, u64) {
        let controller = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        controller.set_read_timeout(Some(Duration::from_millis(30))).expect("set");
        let listen = UdpSocket::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port");
        let robot = controller.local_addr().expect("bound").ip();
        let settings = RsiSettings { corrections: Corrections::Relative, ..RsiSettings::new(listen, robot) };
        let mut drives: Box<dyn Driver<Arm>> = Box::new(Rsi::new(settings));
        let done = AtomicBool::new(false);
        let (opened, ipoc, late) = std::thread::scope(|scope| {
            let says = scope.spawn(|| {
                let (mut ipoc, mut late, mut missed) = (4000, 7, 0);
                while !done.load(Ordering::Acquire) {
                    ipoc += 4;
                    controller.send_to(&said_late(ipoc, 10.0, late), listen).expect("sent");
                    let mut bytes = [0; 512];
                    let own = format!("<IPOC>{ipoc}</IPOC>");
                    let in_time = loop {
                        let Ok(len) = controller.recv(&mut bytes) else { break false };
                        if core::str::from_utf8(&bytes[..len]).expect("text").contains(&own) {
                            break true;
                        }
                    };
                    match counting {
                        Counting::AtOnce => late += u64::from(!in_time),
                        Counting::WhenHeard if in_time => late += core::mem::take(&mut missed),
                        Counting::WhenHeard => missed += 1,
                        Counting::Never => {}
                    }
                }
                (ipoc, late + missed)
            });
            let opened = drives.open();
            done.store(true, Ordering::Release);
            let (ipoc, late) = says.join().expect("it has said all");
            (opened, ipoc, late)
        });
        controller.set_read_timeout(None).expect("set");
        (Bench { controller, drives, listen }, opened, ipoc, late)
    }
}

#[test]
fn relative_corrections_say_what_is_new_and_what_was_lost() {
    let (mut bench, opened, ipoc, late) = Bench::counting(Counting::AtOnce);
    opened.expect("the controller speaks, and counts");
    let mut said = |period: u64, more: u64, a1: f64| bench.answers(ipoc + 4 * period, late + more, a1);
    // The drives hold by themselves until something is demanded.
    assert!(said(1, 0, 10.0).contains(r#"A1="0.000000""#));
    assert!(said(2, 0, 10.75).contains(r#"A1="0.750000""#));
    // The answer before came too late: it is in this one.
    assert!(said(3, 1, 10.75).contains(r#"A1="0.750000""#));
    assert!(said(4, 1, 10.75).contains(r#"A1="0.000000""#));
    // A message was lost on the way here, so its answer is missing, and the one before it was taken.
    assert!(said(6, 2, 11.0).contains(r#"A1="0.250000""#));
    // The same, and the one before it was late, too.
    assert!(said(8, 4, 11.0).contains(r#"A1="0.250000""#));
}

#[test]
fn a_controller_that_counts_a_message_later_is_found_out() {
    let (mut bench, opened, ipoc, late) = Bench::counting(Counting::WhenHeard);
    opened.expect("the controller speaks, and counts");
    let mut said = |period: u64, more: u64, a1: f64| bench.answers(ipoc + 4 * period, late + more, a1);
    assert!(said(1, 0, 10.0).contains(r#"A1="0.000000""#));
    assert!(said(2, 0, 10.75).contains(r#"A1="0.750000""#));
    assert!(said(3, 0, 11.0).contains(r#"A1="0.250000""#));
    // Not that one was lost, but the one before.
    assert!(said(4, 1, 11.0).contains(r#"A1="0.750000""#));
    // A message was lost on the way here: what is counted is that nobody answered it.
    assert!(said(6, 1, 11.5).contains(r#"A1="0.500000""#));
    assert!(said(7, 2, 11.5).contains(r#"A1="0.000000""#));
}

#[test]
fn relative_corrections_are_refused_where_the_controller_does_not_count_what_is_late() {
    let (_, opened) = Bench::with(Corrections::Relative, &said(4000, 10.0));
    assert_eq!(opened, Err(NO_DELAY));
    let (_, opened, ..) = Bench::counting(Counting::Never);
    assert_eq!(opened, Err(NO_COUNT));
}

#[test]
fn fault_89_answers_that_the_controller_does_not_take_are_told() {
    let (mut bench, opened) = Bench::with(Corrections::Absolute, &said_late(4000, 10.0, 0));
    opened.expect("the controller speaks");
    let mut told = Ok(());
    let mut periods = 0;
    while told.is_ok() {
        periods += 1;
        bench.controller.send_to(&said_late(4000 + 4 * periods, 10.0, periods), bench.listen).expect("sent");
        // What was said before the drives were open comes first.
        told = loop {
            match bench.pulse() {
                Ok(pulse) if pulse.count < 1000 + periods => {}
                other => break other.map(drop),
            }
        };
    }
    assert_eq!((told, periods), (Err(NOT_TAKEN), REFUSED));
    // It takes them again.
    bench.says(4204, 10.0);
    bench.drives.switch_on().expect("it speaks");
    assert!(bench.answers(4208, 50, 10.0).contains(r#"A1="0.000000""#));
}

/// A message with the words of inputs and outputs.
fn with_words(ipoc: u64, inputs: u16, outputs: u16) -> Vec<u8> {
    let text = String::from_utf8(said(ipoc, 10.0)).expect("text");
    let words = format!("<DiL>{inputs}</DiL><DoutW>{outputs}</DoutW><IPOC>");
    text.replace("<IPOC>", &words).into_bytes()
}

#[test]
fn fault_119_outputs_are_told_in_every_answer_and_where_the_controller_says_nothing_of_them_the_arm_does_not_move()
 {
    let named = Outputs::NONE.with(Channel::Digital(3), Value::Digital(false));
    let declare = |drives: &mut dyn Driver<Arm>| drives.declare_outputs(&named, &Outputs::NONE);
    let (_, opened) = Bench::having(Corrections::Absolute, &said(4000, 10.0), declare);
    let refused = opened.expect_err("it sends no words").to_string();
    assert!(refused.contains("does not send both `DiL` and `DoutW`"), "{refused}");

    let (mut bench, opened) = Bench::having(Corrections::Absolute, &with_words(4000, 0b1, 0b10), declare);
    opened.expect("it sends both");
    assert!(bench.answer().contains("/><DiO>2</DiO><IPOC>4000</IPOC>"), "as they are");
    bench.drives.switch_outputs(&Outputs::NONE.with(Channel::Digital(3), Value::Digital(true)));
    bench.controller.send_to(&with_words(4004, 0b101, 0b10), bench.listen).expect("sent");
    while bench.pulse().expect("it goes on").count < 1001 {}
    let signals = bench.drives.signals();
    assert_eq!((signals.inputs.digital(), signals.outputs.digital()), (0b101, 0b10));
    bench.drives.tick(&at(10.0)).expect("sent");
    let told = loop {
        let answer = bench.answer();
        if answer.contains("<IPOC>4004</IPOC>") {
            break answer;
        }
    };
    assert!(told.contains("<DiO>10</DiO>"), "{told}");
    // It does not switch.
    let mut periods = 0;
    let fault = loop {
        periods += 1;
        bench.controller.send_to(&with_words(4004 + 4 * periods, 0b101, 0b10), bench.listen).expect("sent");
        if let Err(fault) = bench.pulse() {
            break fault.to_string();
        }
        bench.drives.tick(&at(10.0)).expect("sent");
    };
    assert!(fault.contains("does not switch its outputs"), "{fault}");
    // 25 periods, and that of the first answer.
    assert_eq!(periods, 25);
}

#[test]
fn fault_119_a_load_is_refused_in_words_when_the_arm_stands() {
    let mut bench = Bench::opened();
    let next = |bench: &mut Bench, ipoc: u64| {
        bench.says(ipoc, 10.0);
        while bench.pulse().expect("it goes on").count != ipoc / 4 {}
    };
    next(&mut bench, 4004);
    bench.drives.tick(&at(10.0)).expect("sent");
    bench.drives.carry(&Load::point(2.0, [0.0, 0.0, 0.1].into()));
    // On its way it is led to where it stands.
    next(&mut bench, 4008);
    bench.drives.tick(&at(10.001)).expect("it moves");
    next(&mut bench, 4012);
    let refused = bench.drives.tick(&at(10.001)).expect_err("it stands").to_string();
    assert!(refused.contains("is told no load") && refused.contains("at the pendant"), "{refused}");
    // A reset goes on, until it is told one again.
    next(&mut bench, 4016);
    bench.drives.switch_on().expect("it speaks");
    next(&mut bench, 4020);
    bench.drives.tick(&at(10.001)).expect("sent");
}
