//! The drives against a gripper that is a model of its registers, and against what is no gripper, under a virtual clock.

mod faults;
mod gripper;
mod real_time;

use core::time::Duration;
use std::sync::{Arc, Mutex, PoisonError};

use mrroc::robot::{DriveFault, Driver, Homing, Recovery, Regulators, Search, StopCause};
use mrroc_counting_allocator::{Counting, count};
use mrroc_driver_kit::testing::{Faults, VirtualNetwork};
use mrroc_robots::{One, TwoFingers};

use crate::registers::INACTIVE;
use crate::{Activation, Openings, Robotiq, RobotiqSettings};

use gripper::Gripper;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

type Drives = Box<dyn Driver<TwoFingers>>;

const fn ms(time: u64) -> Duration {
    Duration::from_millis(time)
}

/// A gripper on a virtual network, on which its answers arrive in pieces of five bytes.
struct Fixture {
    gripper: Arc<Mutex<Gripper>>,
    network: VirtualNetwork,
}

impl Fixture {
    fn new(gripper: Gripper) -> Fixture {
        let gripper = Arc::new(Mutex::new(gripper));
        let network = VirtualNetwork::with(Arc::clone(&gripper));
        network.change(|faults| *faults = Faults { piece: 5, ..Faults::NONE });
        Fixture { gripper, network }
    }

    fn look<T>(&self, look: impl FnOnce(&mut Gripper) -> T) -> T {
        look(&mut self.gripper.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn drives(&self) -> Drives {
        Box::new(Robotiq::over(self.network.network(), settings()))
    }

    fn opened(&self) -> Drives {
        let mut drives = self.drives();
        drives.open().expect("it is active");
        drives
    }

    fn activation(&self) -> Activation {
        Activation::over(self.network.network(), settings())
    }

    /// Demands this until the fingers are there.
    fn go(&self, drives: &mut Drives, demanded: One, there: One) {
        self.network.until(|| {
            let measured = drives.tick(&demanded).expect("it goes on");
            ((measured.position - there).amax() < 1e-9).then_some(())
        });
    }

    /// The fault of ticks that go on until this time, and not sooner.
    fn fault_at(&self, drives: &mut Drives, demanded: One, at: Duration) -> DriveFault {
        let before = at - Duration::from_nanos(1);
        while self.network.now() < before {
            self.network.advance(ms(1).min(before - self.network.now()));
            drives.tick(&demanded).expect("it goes on until then");
        }
        self.network.advance(Duration::from_nanos(1));
        drives.tick(&demanded).expect_err("it is over now")
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
fn settings() -> RobotiqSettings {
    RobotiqSettings::new(([127, 0, 0, 1], 1).into())
}

fn opening(number: u8) -> One {
    One::new(Openings::OF_85.opening(number))
}

fn cause(fault: DriveFault) -> StopCause {
    let DriveFault::Stopped(stop) = fault else { panic!("{fault}") };
    stop.cause()
}

fn search(activation: Activation) -> Result<Search<Activation, Robotiq>, DriveFault> {
    Homing::<TwoFingers>::search(activation)
}

/// 85 mm at 3, closed at 230.
#[test]
fn openings_are_those_of_the_grippers_numbers() {
    let openings = Openings::OF_85;
    assert!((openings.opening(3) - 0.085).abs() < 1e-15 && openings.opening(230).abs() < 1e-15);
    for number in 0..=255 {
        assert_eq!(openings.number(openings.opening(number)), Ok(number));
    }
    assert_eq!(openings.number(0.0425), Ok(117), "half-way: 116.5");
    assert!(openings.number(0.1).is_err() && openings.number(-0.02).is_err());
    assert!(openings.number(f64::NAN).is_err());
}

#[test]
fn fingers_go_where_they_are_told_and_stop_at_what_they_hold_without_a_fault() {
    let all = Fixture::new(Gripper { object: 120, ..Gripper::ACTIVE });
    let mut drives = all.opened();
    assert_eq!(drives.held(), Some(opening(40)));
    assert_eq!(drives.measured().map(|measured| measured.position), Ok(opening(40)));
    all.go(&mut drives, opening(100), opening(100));
    // 60 numbers are eight readings, and the demand came before that of 5 ms.
    assert_eq!(all.network.now(), ms(40));
    // Closed on an object: the demand goes on, the fingers stay.
    all.go(&mut drives, opening(200), opening(120));
    all.network.until(|| all.look(|gripper| gripper.held).then_some(()));
    let standing =
        all.network.until(|| drives.tick(&opening(200)).ok().filter(|now| now.velocity[0].abs() < 1e-12));
    assert_eq!(standing.position, opening(120));
    assert_eq!(drives.motor_currents(), Some(One::new(0.12)));
    all.go(&mut drives, opening(10), opening(10));
    let written = all.look(|gripper| gripper.written.clone());
    assert!(written.contains(&[0x0900, 200, 0xff40]), "{written:x?}");
}

#[test]
fn registers_are_exchanged_every_5_ms_and_not_more_often() {
    let all = Fixture::new(Gripper::ACTIVE);
    let mut drives = all.opened();
    let before = all.look(|gripper| gripper.reads);
    for _ in 0..1000 {
        drives.tick(&opening(100)).expect("it goes on");
        all.network.advance(ms(1));
    }
    assert_eq!(all.look(|gripper| gripper.reads) - before, 200);
    // A device that takes 30 ms for each of two questions is asked as fast as it answers.
    all.network.change(|faults| faults.latency = ms(15));
    all.network.advance(ms(100));
    let before = all.look(|gripper| gripper.reads);
    all.network.advance(ms(6000));
    assert_eq!(all.look(|gripper| gripper.reads) - before, 100);
}

/// Also while the gripper says nothing, and after its connection is lost.
#[test]
fn a_servo_period_allocates_nothing() {
    let all = Fixture::new(Gripper::ACTIVE);
    let mut drives = all.opened();
    all.go(&mut drives, opening(100), opening(100));
    all.look(|gripper| gripper.is_silent = true);
    let mut is_lost = false;
    while !is_lost {
        let (ticked, allocations) = count(|| (drives.tick(&opening(120)), drives.motor_currents()).0);
        assert_eq!(allocations, 0);
        is_lost = ticked.is_err();
        all.network.advance(ms(1));
    }
}

#[test]
fn parameter_sets_are_forces() {
    let all = Fixture::new(Gripper::ACTIVE);
    let mut drives = all.opened();
    assert!(drives.has_regulator(0, 2) && !drives.has_regulator(0, 3));
    for (set, force) in [(1, 0), (2, 255), (0, 64)] {
        drives.choose_regulators(&Regulators::uniform(set));
        drives.tick(&opening(100)).expect("it goes on");
        all.network.advance(ms(5));
        assert_eq!(all.look(|gripper| gripper.request[2]), 0xff00 | force);
    }
}

#[test]
fn what_is_held_keeps_its_grip_until_something_else_is_demanded() {
    // Somebody has closed it on an object, with a force of their own.
    let holds = Gripper { object: 90, position: 90, told: 255, held: true, ..Gripper::ACTIVE };
    let all = Fixture::new(holds);
    let mut drives = all.opened();
    let held = drives.held().expect("it is open");
    assert_eq!(held, opening(255), "where it presses to, not where the object is");
    for _ in 0..1000 {
        drives.tick(&held).expect("it goes on");
        all.network.advance(ms(1));
    }
    assert!(all.look(|gripper| gripper.written.is_empty()));
    // The cell ends.
    drives.close();
    all.network.advance(ms(1000));
    assert!(all.look(|gripper| gripper.written.is_empty() && gripper.held));
}

#[test]
fn fault_103_a_gripper_that_is_not_activated_keeps_its_cell_from_beginning_and_is_not_touched() {
    let all = Fixture::new(Gripper::inactive());
    let mut drives = all.drives();
    // A reset opens drives again that could not be opened, and does not activate either.
    for _ in 0..2 {
        assert_eq!(drives.open(), Err(INACTIVE.into()));
    }
    assert!(drives.measured().is_err());
    assert!(all.look(|gripper| gripper.written.is_empty()));
}

#[test]
fn fault_103_homing_activates_a_gripper_that_is_not_active_and_no_other() {
    for gripper in [Gripper::inactive(), Gripper::ACTIVE] {
        let is_active = gripper.is_active;
        let all = Fixture::new(gripper);
        let mut activation = Some(all.activation());
        let mut drives =
            all.network.until(|| match search(activation.take()?).expect("nothing is in its way") {
                Search::Found(drives) => Some(Box::new(drives) as Drives),
                Search::Searching(on) => {
                    activation = Some(on);
                    None
                }
            });
        let written = all.look(|gripper| gripper.written.clone());
        assert_eq!(written, if is_active { vec![] } else { vec![[0; 3], [0x0100, 0, 0]] });
        all.go(&mut drives, opening(100), opening(100));
    }
}

#[test]
fn fault_103_an_activation_that_is_asked_for_no_more_is_stopped() {
    let all = Fixture::new(Gripper { takes: u32::MAX, ..Gripper::inactive() });
    let Ok(Search::Searching(activation)) = search(all.activation()) else {
        panic!("it takes longer than a period")
    };
    // It is asked for during 100 ms, and its status is read every 5 ms.
    all.network.advance(ms(104));
    assert_eq!(all.look(|gripper| gripper.written.clone()), [[0; 3], [0x0100, 0, 0]]);
    all.network.advance(ms(1));
    assert_eq!(all.look(|gripper| gripper.written.clone()), [[0; 3], [0x0100, 0, 0], [0; 3]]);
    // It begins anew when it is asked for, and not before.
    all.network.advance(ms(1000));
    assert_eq!(all.look(|gripper| gripper.written.len()), 3);
    let Ok(Search::Searching(activation)) = search(activation) else { panic!("it begins anew") };
    all.network.advance(ms(5));
    assert_eq!(all.look(|gripper| gripper.written[3..].to_vec()), [[0; 3], [0x0100, 0, 0]]);
    drop(activation);
}
