//! The drives against a model of a controller, under a virtual clock.

mod model;
mod real_time;

use mrroc::pose::Pose;
use mrroc::robot::{Channel, Limits, NoInverse, Value};

use self::model::{Counting, FIRST, Fixture, PERIOD, Says};
use std::net::IpAddr;

use super::*;
use crate::corrections::Corrections;
use crate::opening::{NO_COUNT, NO_DELAY, TIMEOUT};
use crate::session::radians;

/// Where the controller sends from.
const CONTROLLER: SocketAddr = SocketAddr::new(IpAddr::V4(core::net::Ipv4Addr::LOCALHOST), 6008);

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
    let mut fixture = Fixture::new(Corrections::Absolute, Says::Same(said(4000, 10.0)));
    assert_eq!(fixture.drives.measured(), Err(CLOSED), "nothing is open yet");
    fixture.open().expect("the controller speaks");
    assert_eq!(fixture.now(), PERIOD, "by its first message");
    assert_eq!(fixture.drives.measured().map(|measured| measured.position), Ok(at(10.0)));
    assert_eq!(fixture.told(), [(4000, 0.0)]);

    // Nothing was demanded before, so the first message is answered as it is read, and not again when something is demanded.
    assert_eq!(fixture.pulse(said(4004, 10.0)), Ok(1001));
    assert_eq!(fixture.told(), [(4004, 0.0)]);
    fixture.drives.tick(&at(10.5)).expect("sent");
    assert_eq!(fixture.told(), []);
    assert_eq!(fixture.pulse(said(4008, 10.25)), Ok(1002));
    assert_eq!(fixture.told(), []);
    let measured = fixture.drives.tick(&at(11.0)).expect("sent");
    assert_eq!(measured.position, at(10.25));
    let velocity = 0.25_f64.to_radians() / 4e-3;
    assert!((measured.velocity[0] - velocity).abs() < 1e-9, "{}", measured.velocity[0]);
    let sent = fixture.simulation.borrow_mut().sent();
    let [answer] = &sent[..] else { panic!("not one answer: {sent:?}") };
    assert!(
        answer.contains(r#"A1="1.000000" A2="0.000000""#) && answer.contains("<IPOC>4008</IPOC>"),
        "{answer}"
    );

    // Nobody demands anything: the next message is left unanswered, and from then on the drives hold by themselves.
    assert_eq!(fixture.pulse(said(4012, 11.0)), Ok(1003));
    assert_eq!(fixture.told(), []);
    assert_eq!(fixture.pulse(said(4016, 11.0)), Ok(1004));
    assert_eq!(fixture.told(), [(4016, 1.0)]);
}

#[test]
fn a_message_is_as_old_as_it_has_waited_and_the_newest_counts() {
    let mut fixture = Fixture::opened();
    for (ipoc, later) in [(4004, PERIOD), (4008, Duration::from_micros(300))] {
        fixture.says(said(ipoc, 10.0));
        fixture.simulation.borrow_mut().pass(later);
    }
    let pulse = fixture.drives.pulse(Duration::ZERO).expect("it goes on").expect("a message");
    assert_eq!((pulse.count, pulse.age), (1002, Duration::from_micros(300)));
    assert_eq!(fixture.drives.pulse(Duration::ZERO), Ok(None));
    assert_eq!(fixture.told(), [(4008, 0.0)]);
}

#[test]
fn a_controller_that_says_nothing_is_waited_for_for_2_s() {
    let mut fixture = Fixture::new(Corrections::Absolute, Says::Nothing);
    assert_eq!(fixture.open(), Err(SILENT));
    assert_eq!(fixture.now(), TIMEOUT);
    assert!(!fixture.simulation.borrow().is_open, "the port is let go");
    // What it says is no message.
    let mut fixture = Fixture::new(Corrections::Absolute, Says::Same(b"<Rob></Rob>".to_vec()));
    assert_eq!(fixture.open(), Err(SILENT));
    assert_eq!((fixture.now(), fixture.told()), (TIMEOUT, vec![]));
}

#[test]
fn fault_89_a_reset_finds_a_controller_silent_after_100_periods_and_counts_anew_from_where_the_arm_stands_then()
 {
    let timeout = 100 * PERIOD;
    let driver: &dyn Driver<Arm> = &Rsi::new(RsiSettings::new(CONTROLLER, CONTROLLER.ip()));
    assert_eq!(driver.pace(), Pace::Robot { timeout });
    let mut fixture = Fixture::opened();
    fixture.pulse(said(4004, 10.0)).expect("it goes on");
    fixture.drives.tick(&at(10.5)).expect("sent");
    fixture.pulse(said(4008, 10.5)).expect("it goes on");
    fixture.drives.tick(&at(11.0)).expect("sent");
    assert_eq!(fixture.told(), [(4004, 0.0), (4008, 1.0)]);
    fixture.simulation.borrow_mut().pass(timeout);
    assert_eq!(fixture.drives.switch_on(), Ok(()), "not longer than that");
    // Within it corrections go on from what was told.
    fixture.says(said(4408, 11.0));
    assert_eq!(fixture.drives.switch_on(), Ok(()));
    assert_eq!(fixture.told(), [(4408, 1.0)]);
    fixture.simulation.borrow_mut().pass(timeout + Duration::from_nanos(1));
    assert_eq!(fixture.drives.switch_on(), Err(SILENT));
    fixture.says(said(4812, 12.0));
    assert_eq!(fixture.drives.switch_on(), Ok(()));
    assert_eq!(fixture.told(), [(4812, 0.0)]);
    fixture.pulse(said(4816, 12.0)).expect("it goes on");
    fixture.drives.tick(&at(12.25)).expect("sent");
    fixture.pulse(said(4820, 12.0)).expect("it goes on");
    fixture.drives.tick(&at(12.25)).expect("sent");
    assert_eq!(fixture.told(), [(4816, 0.0), (4820, 0.25)], "against where it stood then");
}

#[test]
fn fault_89_a_controller_that_was_started_anew_moves_by_nothing_until_a_reset() {
    let mut fixture = Fixture::opened();
    assert_eq!(fixture.pulse(said(4004, 10.0)), Ok(1001));
    fixture.drives.tick(&at(20.0)).expect("sent");
    assert_eq!(fixture.told(), [(4004, 0.0)]);
    // Its clock counts from the beginning, and corrections from where it stands.
    assert_eq!(fixture.pulse(said(8, 20.0)), Err(ANEW));
    assert_eq!(fixture.told(), [(8, 0.0)]);
    fixture.drives.switch_on().expect("it speaks");
    assert_eq!(fixture.told(), []);
    // Held by the drives, before something is demanded.
    assert_eq!(fixture.pulse(said(12, 20.0)), Ok(3));
    fixture.drives.tick(&at(20.5)).expect("sent");
    assert_eq!(fixture.told(), [(12, 0.0)]);
    assert_eq!(fixture.pulse(said(16, 20.0)), Ok(4));
    fixture.drives.tick(&at(20.5)).expect("sent");
    assert_eq!(fixture.told(), [(16, 0.5)]);
}

#[test]
fn what_cannot_be_read_is_not_answered_and_changes_nothing() {
    let mut fixture = Fixture::opened();
    assert_eq!(fixture.pulse(said(4004, 10.0)), Ok(1001));
    assert_eq!(fixture.told(), [(4004, 0.0)]);
    fixture.says(b"<Rob Type=\"KUKA\"><IPOC>4008</IPOC></Rob>".to_vec());
    assert_eq!(fixture.drives.pulse(Duration::ZERO), Ok(None));
    assert_eq!(fixture.told(), []);
    assert_eq!(fixture.drives.measured().map(|measured| measured.position), Ok(at(10.0)));
}

/// Drives that were opened, or not, with relative corrections, by a controller that counts.
fn counting(counting: Counting) -> (Fixture, Result<(), DriveFault>) {
    let says = Says::Counts { counting, ipoc: FIRST, late: 7, missed: 0 };
    let mut fixture = Fixture::new(Corrections::Relative, says);
    let opened = fixture.open();
    (fixture, opened)
}

/// The clock and the count of a controller whose third message alone was not answered.
const OPENED: (u64, u64) = (FIRST + 20, 8);

/// It answers all messages but the third, at once, by a controller that counts them so.
fn opened_by(how: Counting) -> Fixture {
    let (fixture, opened) = counting(how);
    assert_eq!((opened, fixture.now()), (Ok(()), 5 * PERIOD));
    let answered: Vec<_> = [1, 2, 4, 5].map(|period| (FIRST + 4 * period, 0.0)).into();
    assert_eq!(fixture.told(), answered);
    fixture
}

#[test]
fn relative_corrections_say_what_is_new_and_what_was_lost() {
    let (ipoc, late) = OPENED;
    let mut fixture = opened_by(Counting::AtOnce);
    let mut said = |period: u64, more: u64, a1: f64| fixture.answers(ipoc + 4 * period, late + more, a1);
    // The drives hold by themselves until something is demanded.
    assert_eq!(said(1, 0, 10.0), 0.0);
    assert_eq!(said(2, 0, 10.75), 0.75);
    // The answer before came too late: it is in this one.
    assert_eq!(said(3, 1, 10.75), 0.75);
    assert_eq!(said(4, 1, 10.75), 0.0);
    // A message was lost before it came, so its answer is missing, and the one before it was taken.
    assert_eq!(said(6, 2, 11.0), 0.25);
    // The same, and the one before it was late, too.
    assert_eq!(said(8, 4, 11.0), 0.25);
}

#[test]
fn a_controller_that_counts_a_message_later_is_found_out() {
    let (ipoc, late) = OPENED;
    let mut fixture = opened_by(Counting::WhenHeard);
    let mut said = |period: u64, more: u64, a1: f64| fixture.answers(ipoc + 4 * period, late + more, a1);
    assert_eq!(said(1, 0, 10.0), 0.0);
    assert_eq!(said(2, 0, 10.75), 0.75);
    assert_eq!(said(3, 0, 11.0), 0.25);
    // Not that one was lost, but the one before.
    assert_eq!(said(4, 1, 11.0), 0.75);
    // A message was lost before it came: what is counted is that nobody answered it.
    assert_eq!(said(6, 1, 11.5), 0.5);
    assert_eq!(said(7, 2, 11.5), 0.0);
}

#[test]
fn relative_corrections_are_refused_where_the_controller_does_not_count_what_is_late() {
    let mut fixture = Fixture::new(Corrections::Relative, Says::Same(said(4000, 10.0)));
    assert_eq!(fixture.open(), Err(NO_DELAY));
    assert_eq!(fixture.now(), 2 * PERIOD);
    assert_eq!(fixture.told(), [(4000, 0.0), (4000, 0.0)]);
    // Of four messages one is left unanswered, ten times.
    let (fixture, opened) = counting(Counting::Never);
    assert_eq!((opened, fixture.now()), (Err(NO_COUNT), (1 + 10 * 4) * PERIOD));
    assert_eq!(fixture.told().len(), 1 + 10 * 3);
}

#[test]
fn a_controller_that_is_cut_off_while_it_is_found_out_when_it_counts_is_waited_for_for_2_s() {
    let says = Says::Counts { counting: Counting::AtOnce, ipoc: FIRST, late: 7, missed: 0 };
    let mut fixture = Fixture::new(Corrections::Relative, says);
    // Its first message comes at the end of its first period, and then no other one.
    fixture.simulation.borrow_mut().ends = Some(2 * PERIOD);
    assert_eq!(fixture.open(), Err(SILENT));
    assert_eq!((fixture.now(), fixture.told()), (PERIOD + TIMEOUT, vec![(FIRST + 4, 0.0)]));
}

#[test]
fn fault_89_answers_that_the_controller_does_not_take_are_told() {
    let mut fixture = Fixture::new(Corrections::Absolute, Says::Same(said_late(4000, 10.0, 0)));
    fixture.open().expect("the controller speaks");
    let told = (1..).map(|period| fixture.pulse(said_late(4000 + 4 * period, 10.0, period)));
    let told: Vec<_> = told.take(REFUSED as usize).collect();
    let goes_on: Vec<_> = (1..REFUSED).map(|period| Ok(1000 + period)).collect();
    assert_eq!((&told[..goes_on.len()], told.last()), (&goes_on[..], Some(&Err(NOT_TAKEN))));
    // It takes them again.
    fixture.says(said(4204, 10.0));
    fixture.drives.switch_on().expect("it speaks");
    fixture.simulation.borrow_mut().sent();
    assert_eq!(fixture.answers(4208, 50, 10.0), 0.0);
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
    let mut fixture = Fixture::new(Corrections::Absolute, Says::Same(said(4000, 10.0)));
    fixture.drives.declare_outputs(&named, &Outputs::NONE);
    let refused = fixture.open().expect_err("it sends no words").to_string();
    assert!(refused.contains("does not send both `DiL` and `DoutW`"), "{refused}");
    assert_eq!(fixture.told(), [], "it is not answered");

    let mut fixture = Fixture::new(Corrections::Absolute, Says::Same(with_words(4000, 0b1, 0b10)));
    fixture.drives.declare_outputs(&named, &Outputs::NONE);
    fixture.open().expect("it sends both");
    let answer = |fixture: &Fixture| {
        let sent = fixture.simulation.borrow_mut().sent();
        let [answer] = &sent[..] else { panic!("not one answer: {sent:?}") };
        answer.clone()
    };
    assert!(answer(&fixture).contains("/><DiO>2</DiO><IPOC>4000</IPOC>"), "as they are");
    fixture.drives.switch_outputs(&Outputs::NONE.with(Channel::Digital(3), Value::Digital(true)));
    assert_eq!(fixture.pulse(with_words(4004, 0b101, 0b10)), Ok(1001));
    let signals = fixture.drives.signals();
    assert_eq!((signals.inputs.digital(), signals.outputs.digital()), (0b101, 0b10));
    fixture.drives.tick(&at(10.0)).expect("sent");
    let told = answer(&fixture);
    assert!(told.contains("<DiO>10</DiO><IPOC>4004</IPOC>"), "{told}");
    // It does not switch.
    let mut periods = 0;
    let fault = loop {
        periods += 1;
        if let Err(fault) = fixture.pulse(with_words(4004 + 4 * periods, 0b101, 0b10)) {
            break fault.to_string();
        }
        fixture.drives.tick(&at(10.0)).expect("sent");
    };
    assert!(fault.contains("does not switch its outputs"), "{fault}");
    // 25 periods, and that of the first answer.
    assert_eq!(periods, 25);
}

#[test]
fn fault_119_a_load_is_refused_in_words_when_the_arm_stands() {
    let mut fixture = Fixture::opened();
    fixture.pulse(said(4004, 10.0)).expect("it goes on");
    fixture.drives.tick(&at(10.0)).expect("sent");
    fixture.drives.carry(&Load::point(2.0, [0.0, 0.0, 0.1].into()));
    // While it moves it is led to where it stands.
    fixture.pulse(said(4008, 10.0)).expect("it goes on");
    fixture.drives.tick(&at(10.001)).expect("it moves");
    fixture.pulse(said(4012, 10.0)).expect("it goes on");
    let refused = fixture.drives.tick(&at(10.001)).expect_err("it stands").to_string();
    assert!(refused.contains("is told no load") && refused.contains("at the pendant"), "{refused}");
    // A reset goes on, until it is told one again.
    fixture.pulse(said(4016, 10.0)).expect("it goes on");
    fixture.drives.switch_on().expect("it speaks");
    fixture.pulse(said(4020, 10.0)).expect("it goes on");
    fixture.drives.tick(&at(10.001)).expect("sent");
}
