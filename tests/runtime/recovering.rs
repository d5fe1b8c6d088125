//! Robots that stop by themselves: what is told of it, and how an operator's reset lets them recover.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::cell::AfterFault;
use mrroc::fault::FaultKind;
use mrroc::operator::Latch;
use mrroc::prelude::*;
use mrroc::robot::{ClearedBy, DriveFault, Driver, Measured, Recovery, RobotStop, StopCause};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault};

use crate::runtime::kit::Smooth;

/// What the robots were asked, in order.
type Asked = Rc<RefCell<Vec<(&'static str, &'static str)>>>;

/// Drives of a controller with a mind of its own.
struct Controller {
    name: &'static str,
    drives: ExactDrive<3>,
    /// The tick in which the robot stops, what for, and how many steps its recovery takes.
    stops_in: u64,
    stop: RobotStop,
    recovery: u32,
    /// Resets that come too early: the person at the robot is not there yet.
    absences: u32,
    ticks: u64,
    is_stopped: bool,
    asked: Asked,
    /// By how much the arm sags: the controller holds it so far from what its encoders read.
    sag: Option<Q<3>>,
    demanded: Rc<RefCell<Vec<Q<3>>>>,
}

impl Controller {
    fn new(name: &'static str, stops_in: u64, stop: RobotStop, asked: &Asked) -> Controller {
        Controller {
            name,
            drives: ExactDrive::new(Q::zeros(), MS),
            stops_in,
            stop,
            recovery: 4,
            absences: 0,
            ticks: 0,
            is_stopped: false,
            asked: Rc::clone(asked),
            sag: None,
            demanded: Rc::default(),
        }
    }
}

impl Driver<Gantry> for Controller {
    fn period(&self) -> Duration {
        MS
    }

    fn held(&self) -> Option<Q<3>> {
        let measured = Driver::<Gantry>::measured(&self.drives).ok()?;
        Some(measured.position + self.sag?)
    }

    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::measured(&self.drives)
    }

    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        assert!(!self.is_stopped, "{} is told something while it is stopped", self.name);
        self.ticks += 1;
        if self.ticks == self.stops_in {
            self.is_stopped = true;
            return Err(self.stop.into());
        }
        self.demanded.borrow_mut().push(*demanded);
        Driver::<Gantry>::tick(&mut self.drives, demanded)
    }

    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        self.asked.borrow_mut().push((self.name, "recover"));
        if self.stop.cause().needs_a_person() {
            return Ok(Recovery::Over);
        }
        self.recovery -= 1;
        Ok(if self.recovery > 0 { Recovery::GoesOn } else { Recovery::Over })
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.asked.borrow_mut().push((self.name, "switch on"));
        if self.absences > 0 {
            self.absences -= 1;
            return Err(self.stop.into());
        }
        self.is_stopped = false;
        Ok(())
    }
}

fn setup(drives: Controller) -> RobotSetup<Gantry> {
    let name = drives.name;
    RobotSetup::new(name, Gantry::default(), drives)
        .program(|ecp| ecp.move_robot((), Smooth::to(0.1, 0.4)).map(drop))
}

const REFLEX: RobotStop = RobotStop::new(StopCause::Reflex).named("joint_velocity_violation");

#[test]
fn fault_100_a_robot_that_stops_by_itself_is_told_with_its_own_words_and_who_may_clear_it() {
    for (stop, kind, help) in [
        (REFLEX, ClearedBy::Operator, "then reset: that clears it, moves nothing"),
        (RobotStop::new(StopCause::PendantInControl), ClearedBy::Pendant, "at its pendant, then reset"),
        (RobotStop::new(StopCause::EmergencyStop), ClearedBy::PersonAtRobot, "go to the robot"),
    ] {
        let asked = Asked::default();
        let drives = Controller::new("g", 100, stop, &asked);
        let told = fault(Cell::new(MS).robot(setup(drives)).run());
        assert_eq!((told.kind(), told.message()), (FaultKind::RobotStopped, &*stop.to_string()));
        assert_eq!(told.robot_stop(), Some((stop.cause(), kind)));
        assert!(told.help().is_some_and(|words| words.contains(help)), "{:?}", told.help());
        // Nobody has asked for a reset.
        assert!(asked.borrow().is_empty());
    }
    let told = Fault::from(mrroc::fault::FaultWords::from(&Fault::of_robot_stop(&REFLEX)));
    assert_eq!(
        told.to_string(),
        "stopped at the robot: reflex: joint_velocity_violation",
        "it crosses links with its words"
    );
}

#[test]
fn fault_101_robots_recover_one_after_the_other_when_an_operator_resets_the_cell_and_not_before() {
    let asked = Asked::default();
    let robot = |name| setup(Controller::new(name, 100, REFLEX, &asked));
    let log = Rc::clone(&asked);
    let mut stood = 0;
    let resets =
        Cell::new(MS).robot(robot("a")).robot(robot("b")).after_fault(AfterFault::AwaitReset).on_step(
            move |_, operator| {
                stood += u64::from(operator.latch() == Latch::Latched);
                if stood > 50 {
                    let _ = operator.acknowledge();
                    let _ = operator.reset();
                } else {
                    assert!(log.borrow().is_empty(), "before the reset");
                }
            },
        );
    resets.run().expect("the programs run again, and end");
    let recovers = |name| std::iter::repeat_n((name, "recover"), 4);
    let mut expected: Vec<_> = recovers("a").chain(recovers("b")).collect();
    expected.extend([("a", "switch on"), ("b", "switch on")]);
    assert_eq!(*asked.borrow(), expected);
}

#[test]
fn fault_101_what_needs_a_person_at_the_robot_stays_until_the_person_has_cleared_it() {
    let asked = Asked::default();
    let stop = RobotStop::new(StopCause::EmergencyStop);
    let mut drives = Controller::new("g", 100, stop, &asked);
    drives.absences = 3;
    let persisting = Rc::new(RefCell::new(Vec::new()));
    let seen = Rc::clone(&persisting);
    let resets =
        Cell::new(MS).robot(setup(drives)).after_fault(AfterFault::AwaitReset).on_step(move |_, operator| {
            if operator.latch() != Latch::Clear {
                seen.borrow_mut().extend(operator.persisting().and_then(|fault| fault.robot_stop()));
                let _ = operator.acknowledge();
                let _ = operator.reset();
            }
        });
    resets.run().expect("the fourth time somebody has released it");
    assert!(persisting.borrow().contains(&(StopCause::EmergencyStop, ClearedBy::PersonAtRobot)));
    assert_eq!(asked.borrow().iter().filter(|(_, what)| *what == "switch on").count(), 4);
}

#[test]
fn demands_begin_where_the_drives_hold_and_not_where_an_arm_that_sags_is_measured() {
    let asked = Asked::default();
    let sag = Q::<3>::new(2e-4, 0.0, 0.0);
    let mut drives = Controller::new("g", 100, REFLEX, &asked);
    drives.sag = Some(sag);
    let demanded = Rc::clone(&drives.demanded);
    let resets = Cell::new(MS).robot(setup(drives)).after_fault(AfterFault::AwaitReset);
    let resets = resets.on_step(|step, operator| {
        assert!(step < 10_000, "{:?}", operator.fault());
        if operator.latch() != Latch::Clear {
            let _ = operator.acknowledge();
            let _ = operator.reset();
        }
    });
    resets.run().expect("within the limits");
    let demanded = demanded.borrow();
    assert_eq!(demanded[0], sag);
    // After the reset it begins so again: these drives were last where they were told to be before the 100th tick.
    assert_eq!(demanded[99], demanded[98] + sag);
}
