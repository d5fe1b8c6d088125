//! Drivers that connect to hardware: when they are opened and closed, and what becomes of those that cannot be.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::cell::{AfterFault, CellError};
use mrroc::fault::FaultKind;
use mrroc::operator::Latch;
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, Measured};
use mrroc_tests::{Gantry, MS, Q, fault};

use crate::runtime::kit::Smooth;

/// Drives behind a controller, which answers after so many tries.
struct Remote {
    refusals: u32,
    name: Option<&'static str>,
    position: Option<Q<3>>,
    calls: Calls,
}

/// What a driver was asked, in order.
type Calls = Rc<RefCell<Vec<&'static str>>>;

impl Driver<Gantry> for Remote {
    fn period(&self) -> Duration {
        MS
    }

    fn hardware(&self) -> Option<String> {
        self.name.map(str::to_owned)
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        self.calls.borrow_mut().push("open");
        if self.refusals > 0 {
            self.refusals -= 1;
            return Err(DriveFault::Other("the controller does not answer"));
        }
        self.position = Some(Q::zeros());
        Ok(())
    }

    fn close(&mut self) {
        self.calls.borrow_mut().push("close");
        self.position = None;
    }

    fn measured(&self) -> Measured<Q<3>> {
        Measured { position: self.position.expect("it is open"), velocity: Q::zeros() }
    }

    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        assert!(self.position.is_some(), "it is open");
        self.position = Some(*demanded);
        Ok(self.measured())
    }
}

fn cell(refusals: u32, name: Option<&'static str>) -> (Cell, Calls) {
    let calls = Calls::default();
    let drives = Remote { refusals, name, position: None, calls: Rc::clone(&calls) };
    let robot = RobotSetup::new("g", Gantry::default(), drives)
        .program(|ecp| ecp.move_robot((), Smooth::to(0.1, 0.4)).map(drop));
    (Cell::new(MS).robot(robot), calls)
}

#[test]
fn fault_83_a_driver_is_opened_once_by_its_edp_and_closed_when_the_robot_stands() {
    let (mut checked, calls) = cell(0, None);
    checked.check().expect("nothing is wrong with it");
    let _ = checked.layout();
    assert!(calls.borrow().is_empty());
    checked.run().expect("within the limits");
    assert_eq!(*calls.borrow(), ["open", "close"]);
}

#[test]
fn fault_83_a_driver_that_cannot_be_opened_is_a_fault_with_its_reason() {
    let (cell, calls) = cell(u32::MAX, None);
    let told = fault(cell.run());
    assert_eq!((told.kind(), told.message()), (FaultKind::DriveFault, "the controller does not answer"));
    assert_eq!(told.robot().map(|name| name.to_string()).as_deref(), Some("g"));
    assert_eq!(*calls.borrow(), ["open"]);
}

#[test]
fn fault_83_a_reset_opens_a_driver_that_could_not_be_opened_before() {
    let (cell, calls) = cell(2, None);
    let resets = cell.after_fault(AfterFault::AwaitReset).on_step(|_, operator| {
        if operator.latch() != Latch::Clear {
            // Refused while the robot is not brought to a standstill yet.
            let _ = operator.acknowledge();
            let _ = operator.reset();
        }
    });
    resets.run().expect("the third time it answers");
    assert_eq!(*calls.borrow(), ["open", "open", "open", "close"]);
}

#[test]
fn fault_83_hardware_is_refused_under_the_virtual_clock_before_it_is_opened() {
    let (cell, calls) = cell(0, Some("udp 10.0.0.7:30004"));
    let refused = cell.run().expect_err("real drives");
    assert!(matches!(refused, CellError::RealDrives { .. }), "{refused}");
    assert!(refused.to_string().contains("`g` has real drives, udp 10.0.0.7:30004"), "{refused}");
    assert!(calls.borrow().is_empty());
}
