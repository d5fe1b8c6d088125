//! The drives against a hand on loopback that is a model of its interface, and against what is no hand.

#![expect(clippy::disallowed_methods, reason = "the exchange has a thread of its own, which tests wait for")]

use core::time::Duration;
use std::io::Write;
use std::net::{TcpListener, TcpStream};

use mrroc::robot::{DriveFault, Driver, Homing, Recovery, Regulators, Search, StopCause};
use mrroc_counting_allocator::{Counting, count};
use mrroc_robots::{One, TwoFingers};

use super::fake::{Fake, Fingers, GRASP, HOMING, MOVE, STOP, STROKE};
use super::protocol::{NOT_HOMED, OTHER_VERSION};
use super::{Hand, HandHoming, HandSettings};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

type Drives = Box<dyn Driver<TwoFingers>>;

fn fake(fingers: Fingers) -> Fake {
    Fake::at(([127, 0, 0, 1], 0).into(), fingers).expect("a port")
}

/// In a hurry: the fingers take a tenth of their time.
fn settings(fake: &Fake) -> HandSettings {
    HandSettings { speed: 1.0, ..HandSettings::new(fake.address) }
}

fn opened(fake: &Fake) -> Drives {
    let mut drives: Drives = Box::new(Hand::new(settings(fake)));
    drives.open().expect("it is homed");
    drives
}

fn until<T>(mut look: impl FnMut() -> Option<T>) -> T {
    loop {
        if let Some(found) = look() {
            return found;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Demands this opening until the fingers stand at another, or the same \[m\].
fn go(drives: &mut Drives, demanded: f64, there: f64) {
    until(|| {
        let measured = drives.tick(&One::new(demanded)).expect("it goes on");
        ((measured.position[0] - there).abs() < 1e-9).then_some(())
    });
}

/// The fault that the next ticks end with.
fn fault(drives: &mut Drives, demanded: f64) -> DriveFault {
    until(|| drives.tick(&One::new(demanded)).err())
}

fn cause(fault: DriveFault) -> StopCause {
    let DriveFault::Stopped(stop) = fault else { panic!("{fault}") };
    stop.cause()
}

fn recovered(drives: &mut Drives) -> Result<(), DriveFault> {
    until(|| match drives.recover() {
        Ok(Recovery::Over) => Some(Ok(())),
        Ok(Recovery::GoesOn) => None,
        Err(why) => Some(Err(why)),
    })
}

fn asked(fake: &Fake) -> Vec<(u16, Vec<f64>)> {
    fake.look(|fingers| fingers.asked.clone())
}

fn holds(drives: &Drives) -> bool {
    drives.signals().inputs.is_on(0)
}

#[test]
fn fingers_that_close_grasp_what_they_find_and_open_when_they_are_told() {
    let hand = fake(Fingers { object: Some(0.03), ..Fingers::open() });
    let mut drives = opened(&hand);
    assert_eq!(drives.held(), Some(One::new(STROKE)));
    assert!(!holds(&drives));
    go(&mut drives, 0.01, 0.03);
    until(|| holds(&drives).then_some(()));
    // Narrower still: it presses already, and is told nothing.
    for _ in 0..60 {
        drives.tick(&One::new(0.005)).expect("it goes on");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(hand.look(|fingers| fingers.is_grasped));
    go(&mut drives, 0.06, 0.06);
    until(|| (!holds(&drives)).then_some(()));
    let standing = until(|| drives.tick(&One::new(0.06)).ok().filter(|now| now.velocity[0].abs() < 1e-12));
    assert_eq!(standing.position, One::new(0.06));
    // Wider than 0.01 m is grasped, up to all that the hand opens.
    assert_eq!(asked(&hand), [(GRASP, vec![0.01, 0.0, STROKE, 1.0, 40.0]), (MOVE, vec![0.06, 1.0])]);
}

#[test]
fn fingers_that_find_nothing_hold_nothing_which_is_no_fault() {
    let hand = fake(Fingers::open());
    let mut drives = opened(&hand);
    go(&mut drives, 0.02, 0.0);
    for _ in 0..50 {
        drives.tick(&One::new(0.02)).expect("it goes on");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(!holds(&drives));
}

#[test]
fn a_position_is_told_when_demands_have_stood_there() {
    let hand = fake(Fingers::open());
    let mut drives = opened(&hand);
    drives.choose_regulators(&Regulators::uniform(1));
    assert!(drives.has_regulator(0, 1) && !drives.has_regulator(0, 2));
    for step in 1_u32..=100 {
        drives.tick(&One::new(STROKE - 3e-4 * f64::from(step))).expect("it goes on");
        std::thread::sleep(Duration::from_millis(1));
    }
    go(&mut drives, 0.05, 0.05);
    let told = asked(&hand);
    // A machine that gives this thread no time lets demands stand in between.
    assert!(told.iter().all(|(request, _)| [MOVE, STOP].contains(request)), "{told:?}");
    assert_eq!(told.last(), Some(&(MOVE, vec![0.05, 1.0])));
}

#[test]
fn another_demand_ends_a_motion_that_goes_on() {
    let hand = fake(Fingers::open());
    let settings = HandSettings { speed: 0.05, ..settings(&hand) };
    let mut drives: Drives = Box::new(Hand::new(settings));
    drives.open().expect("it is homed");
    drives.choose_regulators(&Regulators::uniform(1));
    until(|| {
        drives.tick(&One::new(0.0)).expect("it goes on");
        (hand.look(|fingers| fingers.width) < 0.075).then_some(())
    });
    go(&mut drives, STROKE, STROKE);
    let requests: Vec<u16> = asked(&hand).into_iter().map(|(request, _)| request).collect();
    assert_eq!(requests, [MOVE, STOP, MOVE]);
}

/// Also while the hand says nothing, and after its connection is lost.
#[test]
fn a_servo_period_allocates_nothing() {
    let hand = fake(Fingers::open());
    let mut drives = opened(&hand);
    go(&mut drives, 0.05, 0.0);
    hand.look(|fingers| fingers.is_silent = true);
    let mut is_lost = false;
    while !is_lost {
        let demanded = One::new(0.06);
        let (ticked, allocations) = count(|| (drives.tick(&demanded), drives.signals()).0);
        assert_eq!(allocations, 0);
        is_lost = ticked.is_err();
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn what_is_held_keeps_its_grip_until_something_else_is_demanded() {
    let holds_it = Fingers { width: 0.03, object: Some(0.03), is_grasped: true, ..Fingers::open() };
    let hand = fake(holds_it);
    let mut drives = opened(&hand);
    let held = drives.held().expect("it is open");
    assert_eq!(held, One::new(0.03));
    for _ in 0..60 {
        drives.tick(&held).expect("it goes on");
        std::thread::sleep(Duration::from_millis(1));
    }
    // The last digit of a number lets nothing go.
    for _ in 0..60 {
        drives.tick(&(held + One::new(1e-9))).expect("it goes on");
        std::thread::sleep(Duration::from_millis(1));
    }
    // The cell ends.
    drives.close();
    assert!(hand.look(|fingers| fingers.asked.is_empty() && fingers.is_grasped));
}

#[test]
fn fault_113_a_hand_that_is_not_homed_keeps_its_cell_from_beginning_and_is_not_touched() {
    let hand = fake(Fingers { max_width: 0.0, width: 0.03, ..Fingers::open() });
    let mut drives: Drives = Box::new(Hand::new(settings(&hand)));
    // A reset opens drives again that could not be opened, and does not home either.
    for _ in 0..2 {
        assert_eq!(drives.open(), Err(NOT_HOMED));
    }
    assert!(drives.measured().is_err());
    assert!(asked(&hand).is_empty());
}

fn search(homing: HandHoming) -> Result<Search<HandHoming, Hand>, DriveFault> {
    Homing::<TwoFingers>::search(homing)
}

#[test]
fn fault_113_homing_homes_a_hand_that_is_not_homed_and_no_other() {
    for max_width in [0.0, STROKE] {
        let hand = fake(Fingers { max_width, width: 0.03, haste: 10.0, ..Fingers::open() });
        let mut homing = Some(HandHoming::new(settings(&hand)));
        let mut drives: Drives = until(|| match search(homing.take()?).expect("nothing is in its way") {
            Search::Found(drives) => Some(Box::new(drives) as Drives),
            Search::Searching(on) => {
                homing = Some(on);
                None
            }
        });
        let is_homed = max_width > 0.0;
        assert_eq!(asked(&hand), if is_homed { vec![] } else { vec![(STOP, vec![]), (HOMING, vec![])] });
        assert_eq!(drives.held(), Some(One::new(if is_homed { 0.03 } else { STROKE })));
        go(&mut drives, 0.05, if is_homed { 0.05 } else { 0.0 });
    }
}

#[test]
fn fault_113_a_homing_that_is_asked_for_no_more_is_stopped() {
    let hand = fake(Fingers { max_width: 0.0, width: 0.0, haste: 0.1, ..Fingers::open() });
    let Ok(Search::Searching(homing)) = search(HandHoming::new(settings(&hand))) else {
        panic!("it takes longer than a period")
    };
    until(|| (asked(&hand).len() == 3).then_some(()));
    assert_eq!(asked(&hand), [(STOP, vec![]), (HOMING, vec![]), (STOP, vec![])]);
    drop(homing);
}

#[test]
fn fault_113_a_homing_that_a_lost_connection_has_begun_is_ended_before_the_next_one() {
    let hand = fake(Fingers { max_width: 0.0, width: 0.0, haste: 0.1, ..Fingers::open() });
    // As of a process that was killed: the hand goes on.
    let mut socket = TcpStream::connect(hand.address).expect("it listens");
    socket.write_all(&[1, 0, 2, 0, 0, 0, 10, 0, 0, 0]).expect("it reads");
    until(|| (asked(&hand) == [(HOMING, vec![])]).then_some(()));
    drop(socket);
    hand.look(|fingers| fingers.haste = 10.0);
    let mut homing = Some(HandHoming::new(settings(&hand)));
    until(|| match search(homing.take()?).expect("the one before was ended") {
        Search::Found(_) => Some(()),
        Search::Searching(on) => {
            homing = Some(on);
            None
        }
    });
    assert_eq!(asked(&hand), [(HOMING, vec![]), (STOP, vec![]), (HOMING, vec![])]);
}

#[test]
fn fault_114_an_opening_that_the_hand_does_not_have_is_refused() {
    let hand = fake(Fingers { max_width: 0.079, width: 0.06, ..Fingers::open() });
    let mut drives = opened(&hand);
    for bad in [0.0795, -0.001, f64::NAN] {
        let told = drives.tick(&One::new(bad)).expect_err("it does not open so far").to_string();
        assert!(told.starts_with("demanded opening"), "{told}");
    }
    go(&mut drives, 0.079, 0.079);
    assert_eq!(asked(&hand), [(MOVE, vec![0.079, 1.0])]);
    // Fingers that stand a little beyond may stay there.
    let hand = fake(Fingers { width: -1e-4, ..Fingers::open() });
    let mut drives = opened(&hand);
    let held = drives.held().expect("it is open");
    drives.tick(&held).expect("it stays");
}

#[test]
fn fault_114_a_motion_that_the_hand_does_not_do_is_told_and_a_reset_moves_nothing() {
    // Its status, and what it means.
    for (status, text, of) in [
        (1, "move failed", StopCause::ProtectiveStop),
        (2, "did not come to the opening", StopCause::ProtectiveStop),
        (3, "somebody else", StopCause::PendantInControl),
        (9, "no Franka Hand", StopCause::CommunicationLost),
    ] {
        let hand = fake(Fingers { width: 0.05, refuses: Some(status), ..Fingers::open() });
        let mut drives = opened(&hand);
        let told = fault(&mut drives, 0.07);
        assert!(told.to_string().contains(text), "{told}");
        assert_eq!(cause(told), of);
        assert_eq!(drives.switch_on(), Err(told));
        assert_eq!(recovered(&mut drives), Ok(()));
        drives.switch_on().expect("it is there");
        assert_eq!(drives.held(), Some(One::new(0.05)));
        drives.tick(&One::new(0.05)).expect("it goes on");
        assert_eq!(asked(&hand).len(), 1);
        go(&mut drives, 0.07, 0.07);
    }
    let hand = fake(Fingers { refuses: Some(1), ..Fingers::open() });
    let mut drives = opened(&hand);
    assert_eq!(fault(&mut drives, 0.02).to_string(), "protective stop: grasp failed");
}

#[test]
fn fault_114_a_move_that_something_holds_back_is_stopped_and_told() {
    let hand = fake(Fingers { object: Some(0.05), ..Fingers::open() });
    let settings = HandSettings { patience: Duration::from_millis(300), ..settings(&hand) };
    let mut drives: Drives = Box::new(Hand::new(settings));
    drives.open().expect("it is homed");
    drives.choose_regulators(&Regulators::uniform(1));
    let told = fault(&mut drives, 0.02);
    assert_eq!(cause(told), StopCause::ProtectiveStop);
    assert!(told.to_string().contains("is something in its way?"), "{told}");
    until(|| (asked(&hand).last() == Some(&(STOP, vec![]))).then_some(()));
}

#[test]
fn fault_112_a_hand_that_says_nothing_is_lost_and_only_a_reset_calls_it_again() {
    let hand = fake(Fingers { object: Some(0.03), ..Fingers::open() });
    let mut drives = opened(&hand);
    go(&mut drives, 0.01, 0.03);
    until(|| holds(&drives).then_some(()));
    hand.look(|fingers| fingers.is_silent = true);
    let told = fault(&mut drives, 0.01);
    assert_eq!(told.to_string(), "communication lost: no state came in time");
    assert!(drives.measured().is_err() && !holds(&drives));
    hand.look(|fingers| fingers.is_silent = false);
    std::thread::sleep(Duration::from_millis(50));
    assert!(drives.switch_on().is_err(), "it does not connect by itself");
    assert_eq!(hand.look(|fingers| fingers.connections), 1);
    assert_eq!(recovered(&mut drives), Ok(()));
    drives.switch_on().expect("it says where it is");
    assert_eq!(hand.look(|fingers| fingers.connections), 2);
    // It keeps its grip.
    assert_eq!(drives.held(), Some(One::new(0.03)));
    drives.tick(&One::new(0.03)).expect("it goes on");
    assert!(hand.look(|fingers| fingers.is_grasped && fingers.asked.len() == 1));
}

#[test]
fn fault_112_a_connection_that_is_closed_is_told() {
    let hand = fake(Fingers::open());
    let mut drives = opened(&hand);
    hand.look(|fingers| fingers.hangs_up = true);
    let told = fault(&mut drives, 0.05);
    assert_eq!(told.to_string(), "communication lost: connection closed by the robot");
}

#[test]
fn fault_112_a_hand_that_is_not_there_or_of_another_version_is_told_as_such() {
    let free = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port");
    let mut drives: Drives = Box::new(Hand::new(HandSettings::new(free)));
    let told = drives.open().expect_err("nobody listens");
    assert!(told.to_string().contains("is the hand mounted?"), "{told}");
    assert_eq!(recovered(&mut drives), Err(told));
    let hand = fake(Fingers { version: 2, ..Fingers::open() });
    assert_eq!((Box::new(Hand::new(settings(&hand))) as Drives).open(), Err(OTHER_VERSION));
}

#[test]
fn fault_112_what_answers_and_is_no_hand_is_told() {
    // One with a length that cannot be, one of another request, one of another protocol.
    let cases: [&[u8]; 3] = [
        &[0, 0, 1, 0, 0, 0, 255, 255, 255, 255],
        &[0, 0, 7, 0, 0, 0, 14, 0, 0, 0, 0, 0, 3, 0],
        b"HTTP/1.1 400 Bad Request\r\n\r\n",
    ];
    for instead in cases {
        let hand = fake(Fingers { instead: Some(instead.to_vec()), ..Fingers::open() });
        let told = (Box::new(Hand::new(settings(&hand))) as Drives).open().expect_err("it is no hand");
        assert!(told.to_string().contains("no Franka Hand"), "{told}");
    }
}

#[test]
fn fault_112_fingers_that_somebody_else_moves_are_not_taken_over() {
    let hand = fake(Fingers { is_restless: true, ..Fingers::open() });
    let told = (Box::new(Hand::new(settings(&hand))) as Drives).open().expect_err("they do not stand");
    assert_eq!(cause(told), StopCause::PendantInControl);
}
