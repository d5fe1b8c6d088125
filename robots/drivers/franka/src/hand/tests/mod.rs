//! The drives against a hand that is a model of its interface, and against what is no hand, under a virtual clock.

mod faults;
mod real_time;

use core::time::Duration;
use std::sync::{Arc, Mutex, PoisonError};

use mrroc::robot::{DriveFault, Driver, Homing, Recovery, Regulators, Search, StopCause};
use mrroc_counting_allocator::{Counting, count};
use mrroc_driver_kit::testing::VirtualNetwork;
use mrroc_robots::{One, TwoFingers};

use super::fake::{Fake, Fingers, GRASP, HOMING, MOVE, STOP, STROKE};
use super::faults::{NOT_HOMED, OTHER_VERSION};
use super::{Hand, HandHoming, HandSettings};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

type Drives = Box<dyn Driver<TwoFingers>>;

/// How fast the opening changes by default [m/s], and how hard it presses \[N\].
const SPEED: f64 = 0.1;
const FORCE: f64 = 40.0;

const fn ms(time: u64) -> Duration {
    Duration::from_millis(time)
}

/// A hand on a virtual network, on which its answers arrive in pieces of five bytes.
struct Fixture {
    hand: Arc<Mutex<Fake>>,
    network: VirtualNetwork,
}

impl Fixture {
    fn new(fingers: Fingers) -> Fixture {
        let hand = Arc::new(Mutex::new(Fake::new(fingers)));
        let network = VirtualNetwork::with(Arc::clone(&hand));
        network.change(|faults| faults.piece = 5);
        Fixture { hand, network }
    }

    fn look<T>(&self, look: impl FnOnce(&mut Fingers) -> T) -> T {
        look(&mut self.hand.lock().unwrap_or_else(PoisonError::into_inner).fingers)
    }

    fn asked(&self) -> Vec<(u16, Vec<f64>)> {
        self.look(|fingers| fingers.asked.clone())
    }

    fn drives(&self) -> Drives {
        Box::new(Hand::over(self.network.network(), settings()))
    }

    fn opened(&self) -> Drives {
        let mut drives = self.drives();
        drives.open().expect("it is homed");
        drives
    }

    fn homing(&self) -> HandHoming {
        HandHoming::over(self.network.network(), settings())
    }

    /// What becomes of a homing that is asked for all the time.
    fn homed(&self) -> Result<Drives, DriveFault> {
        let mut homing = Some(self.homing());
        self.network.until(|| match search(homing.take()?) {
            Ok(Search::Found(drives)) => Some(Ok(Box::new(drives) as Drives)),
            Ok(Search::Searching(on)) => {
                homing = Some(on);
                None
            }
            Err(why) => Some(Err(why)),
        })
    }

    /// Demands this opening until the fingers stand at another, or the same \[m\].
    fn go(&self, drives: &mut Drives, demanded: f64, there: f64) {
        self.network.until(|| {
            let measured = drives.tick(&One::new(demanded)).expect("it goes on");
            ((measured.position[0] - there).abs() < 1e-9).then_some(())
        });
    }

    /// Demands this opening for so long \[m\].
    fn stay(&self, drives: &mut Drives, demanded: f64, time: Duration) {
        let until = self.network.now() + time;
        while self.network.now() < until {
            drives.tick(&One::new(demanded)).expect("it goes on");
            self.network.advance(ms(1).min(until - self.network.now()));
        }
    }

    /// The fault that the next ticks end with.
    fn fault(&self, drives: &mut Drives, demanded: f64) -> DriveFault {
        self.network.until(|| drives.tick(&One::new(demanded)).err())
    }

    /// The fault of ticks that go on until this time, and not sooner.
    fn fault_at(&self, drives: &mut Drives, demanded: f64, at: Duration) -> DriveFault {
        let before = at - Duration::from_nanos(1);
        self.stay(drives, demanded, before - self.network.now());
        drives.tick(&One::new(demanded)).expect("it goes on until then");
        self.network.advance(Duration::from_nanos(1));
        drives.tick(&One::new(demanded)).expect_err("it is over now")
    }

    fn recovered(&self, drives: &mut Drives) -> Result<(), DriveFault> {
        self.network.until(|| match drives.recover() {
            Ok(Recovery::Over) => Some(Ok(())),
            Ok(Recovery::GoesOn) => None,
            Err(why) => Some(Err(why)),
        })
    }
}

/// At an address that no virtual network looks at.
fn settings() -> HandSettings {
    HandSettings::new(([127, 0, 0, 1], 1).into())
}

fn search(homing: HandHoming) -> Result<Search<HandHoming, Hand>, DriveFault> {
    Homing::<TwoFingers>::search(homing)
}

fn cause(fault: DriveFault) -> StopCause {
    let DriveFault::Stopped(stop) = fault else { panic!("{fault}") };
    stop.cause()
}

fn holds(drives: &Drives) -> bool {
    drives.signals().inputs.is_on(0)
}

#[test]
fn drives_are_open_when_the_fingers_have_stood_for_more_than_200_ms() {
    let all = Fixture::new(Fingers::open());
    let drives = all.opened();
    // The first state comes after 10 ms, and states are looked at every 2 ms.
    assert_eq!(all.network.now(), ms(212));
    assert_eq!(drives.held(), Some(One::new(STROKE)));
}

#[test]
fn fingers_that_close_grasp_what_they_find_and_open_when_they_are_told() {
    let all = Fixture::new(Fingers { object: Some(0.03), ..Fingers::open() });
    let mut drives = all.opened();
    assert_eq!(drives.held(), Some(One::new(STROKE)));
    assert!(!holds(&drives));
    all.go(&mut drives, 0.01, 0.03);
    all.network.advance(ms(20));
    assert!(holds(&drives));
    // Narrower still: it presses already, and is told nothing.
    all.stay(&mut drives, 0.005, ms(1000));
    assert!(all.look(|fingers| fingers.is_grasped));
    all.go(&mut drives, 0.06, 0.06);
    all.network.advance(ms(20));
    assert!(!holds(&drives));
    all.stay(&mut drives, 0.06, ms(220));
    let standing = drives.tick(&One::new(0.06)).expect("it goes on");
    assert_eq!((standing.position, standing.velocity), (One::new(0.06), One::new(0.0)));
    // Wider than 0.01 m is grasped, up to all that the hand opens.
    assert_eq!(all.asked(), [(GRASP, vec![0.01, 0.0, STROKE, SPEED, FORCE]), (MOVE, vec![0.06, SPEED])]);
}

#[test]
fn fingers_that_find_nothing_hold_nothing_which_is_no_fault() {
    let all = Fixture::new(Fingers::open());
    let mut drives = all.opened();
    all.go(&mut drives, 0.02, 0.0);
    all.stay(&mut drives, 0.02, ms(1000));
    assert!(!holds(&drives));
}

#[test]
fn a_position_is_told_when_demands_have_stood_there() {
    let all = Fixture::new(Fingers::open());
    let mut drives = all.opened();
    drives.choose_regulators(&Regulators::uniform(1));
    assert!(drives.has_regulator(0, 1) && !drives.has_regulator(0, 2));
    for step in 1_u32..=100 {
        all.stay(&mut drives, STROKE - 3e-4 * f64::from(step), ms(1));
    }
    assert!(all.asked().is_empty(), "they have not stood");
    // The last of them is 0.05 m: it was demanded 1 ms ago, and demands are looked at every 2 ms.
    let seen = all.network.now();
    all.stay(&mut drives, 0.05, ms(100));
    assert_eq!(all.asked(), [(MOVE, vec![0.05, SPEED])]);
    assert_eq!(all.look(|fingers| fingers.asked_at), seen + ms(20));
    all.go(&mut drives, 0.05, 0.05);
    assert_eq!(all.asked().len(), 1);
}

#[test]
fn another_demand_ends_a_motion_that_goes_on() {
    let all = Fixture::new(Fingers::open());
    let mut drives = all.opened();
    drives.choose_regulators(&Regulators::uniform(1));
    all.network.until(|| {
        drives.tick(&One::new(0.0)).expect("it goes on");
        (all.look(|fingers| fingers.width) < 0.075).then_some(())
    });
    all.go(&mut drives, STROKE, STROKE);
    let requests: Vec<u16> = all.asked().into_iter().map(|(request, _)| request).collect();
    assert_eq!(requests, [MOVE, STOP, MOVE]);
}

/// Also while the hand says nothing, and after its connection is lost.
#[test]
fn a_servo_period_allocates_nothing() {
    let all = Fixture::new(Fingers::open());
    let mut drives = all.opened();
    all.go(&mut drives, 0.05, 0.0);
    all.look(|fingers| fingers.is_silent = true);
    let mut is_lost = false;
    while !is_lost {
        let demanded = One::new(0.06);
        let (ticked, allocations) = count(|| (drives.tick(&demanded), drives.signals()).0);
        assert_eq!(allocations, 0);
        is_lost = ticked.is_err();
        all.network.advance(ms(1));
    }
}

#[test]
fn what_is_held_keeps_its_grip_until_something_else_is_demanded() {
    let holds_it = Fingers { width: 0.03, object: Some(0.03), is_grasped: true, ..Fingers::open() };
    let all = Fixture::new(holds_it);
    let mut drives = all.opened();
    let held = drives.held().expect("it is open");
    assert_eq!(held, One::new(0.03));
    all.stay(&mut drives, held[0], ms(1000));
    // The last digit of a number lets nothing go.
    all.stay(&mut drives, held[0] + 1e-9, ms(1000));
    // The cell ends.
    drives.close();
    all.network.advance(ms(1000));
    assert!(all.look(|fingers| fingers.asked.is_empty() && fingers.is_grasped));
}

#[test]
fn fault_113_a_hand_that_is_not_homed_keeps_its_cell_from_beginning_and_is_not_touched() {
    let all = Fixture::new(Fingers { max_width: 0.0, width: 0.03, ..Fingers::open() });
    let mut drives = all.drives();
    // A reset opens drives again that could not be opened, and does not home either.
    for _ in 0..2 {
        assert_eq!(drives.open(), Err(NOT_HOMED));
    }
    assert!(drives.measured().is_err());
    assert!(all.asked().is_empty());
}

#[test]
fn fault_113_homing_homes_a_hand_that_is_not_homed_and_no_other() {
    for max_width in [0.0, STROKE] {
        let all = Fixture::new(Fingers { max_width, width: 0.03, ..Fingers::open() });
        let mut drives = all.homed().expect("nothing is in its way");
        let is_homed = max_width > 0.0;
        assert_eq!(all.asked(), if is_homed { vec![] } else { vec![(STOP, vec![]), (HOMING, vec![])] });
        assert_eq!(drives.held(), Some(One::new(if is_homed { 0.03 } else { STROKE })));
        all.go(&mut drives, 0.05, if is_homed { 0.05 } else { 0.0 });
    }
}

#[test]
fn fault_113_a_homing_that_is_asked_for_no_more_is_stopped() {
    let all = Fixture::new(Fingers { max_width: 0.0, width: 0.0, ..Fingers::open() });
    let Ok(Search::Searching(homing)) = search(all.homing()) else { panic!("it takes longer than a period") };
    // More than 100 ms after it was asked for, where that is looked at every 2 ms.
    all.network.advance(ms(101));
    assert_eq!(all.asked(), [(STOP, vec![]), (HOMING, vec![])]);
    all.network.advance(ms(1));
    assert_eq!(all.asked(), [(STOP, vec![]), (HOMING, vec![]), (STOP, vec![])]);
    // It begins anew when it is asked for, and not before.
    all.network.advance(ms(5000));
    assert_eq!(all.asked().len(), 3);
    let Ok(Search::Searching(homing)) = search(homing) else { panic!("it begins anew") };
    all.network.advance(ms(2));
    assert_eq!(all.asked()[3..], [(STOP, vec![]), (HOMING, vec![])]);
    drop(homing);
}

#[test]
fn fault_113_a_homing_that_a_lost_connection_has_begun_is_ended_before_the_next_one() {
    let all = Fixture::new(Fingers { max_width: 0.0, width: 0.0, ..Fingers::open() });
    // As of a process that was killed: the hand goes on.
    assert!(all.look(|fingers| fingers.ask(HOMING, 2, Vec::new())).is_empty());
    all.network.advance(ms(100));
    all.homed().expect("the one before was ended");
    assert_eq!(all.asked(), [(HOMING, vec![]), (STOP, vec![]), (HOMING, vec![])]);
}
