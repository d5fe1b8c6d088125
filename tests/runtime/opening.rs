//! Drivers that connect to hardware: when they are opened and closed, and what becomes of those that cannot be.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::cell::{AfterFault, CellError};
use mrroc::fault::FaultKind;
use mrroc::observe::layout::HardwareLayout;
use mrroc::operator::Latch;
use mrroc::prelude::*;
use mrroc::robot::{Connecting, DriveFault, Driver, IdealDrives, Measured};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault, traced};

use crate::runtime::kit::Smooth;

/// Drives behind a controller, which answers after so many tries.
struct Remote {
    refusals: u32,
    name: Option<&'static str>,
    position: Option<Q<3>>,
    /// Whether the encoders can be read once they are open.
    is_read: bool,
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

    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        let position = self.position.filter(|_| self.is_read);
        let position = position.ok_or(DriveFault::Other("encoder 3 is unplugged"))?;
        Ok(Measured { position, velocity: Q::zeros() })
    }

    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        assert!(self.position.is_some(), "it is open");
        self.position = Some(*demanded);
        self.measured()
    }
}

fn cell(refusals: u32, name: Option<&'static str>) -> (Cell, Calls) {
    let calls = Calls::default();
    let drives = Remote { refusals, name, position: None, is_read: true, calls: Rc::clone(&calls) };
    (Cell::new(MS).robot(moving(drives)), calls)
}

fn moving(drives: Remote) -> RobotSetup<Gantry> {
    RobotSetup::new("g", Gantry::default(), drives)
        .program(|ecp| ecp.move_robot((), Smooth::to(0.1, 0.4)).map(drop))
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

#[test]
fn fault_83_encoders_that_cannot_be_read_are_a_fault_of_the_robot_and_nothing_moves() {
    let calls = Calls::default();
    let drives = Remote { refusals: 0, name: None, position: None, is_read: false, calls: Rc::clone(&calls) };
    let told = fault(Cell::new(MS).robot(moving(drives)).run());
    assert_eq!((told.kind(), told.message()), (FaultKind::DriveFault, "encoder 3 is unplugged"));
    assert_eq!(told.robot().map(|name| name.to_string()).as_deref(), Some("g"));
    assert_eq!(*calls.borrow(), ["open", "close"]);
}

/// Drives of a controller at an address.
fn remote() -> (Remote, Calls) {
    let calls = Calls::default();
    let name = Some("udp 10.0.0.7:30004");
    (Remote { refusals: 0, name, position: None, is_read: true, calls: Rc::clone(&calls) }, calls)
}

#[test]
fn fault_83_simulated_drives_stand_in_for_hardware_which_is_not_opened() {
    let start = Q::<3>::new(0.3, 0.0, 0.0);
    let ideal = || IdealDrives::new(&Gantry::default(), start, MS);
    type StandIn = fn(RobotSetup<Gantry>, IdealDrives<Gantry>) -> RobotSetup<Gantry>;
    let stand_ins: [StandIn; 2] = [
        |setup, ideal| setup.stand_in(ideal),
        |setup, ideal| {
            setup.stand_in_of(move |gantry, period| {
                assert_eq!(period, MS);
                Ok(RobotSetup::new("other", gantry.clone(), ideal))
            })
        },
    ];
    for stand_in in stand_ins {
        let (drives, calls) = remote();
        let (setup, trace) = traced(stand_in(moving(drives), ideal()));
        let cell = Cell::new(MS).robot(setup);
        assert_eq!(cell.layout().robots[0].drives, HardwareLayout::Real("udp 10.0.0.7:30004".to_owned()));
        let cell = cell.simulated().expect("they stand in");
        assert_eq!(cell.layout().robots[0].drives, HardwareLayout::StandIn("udp 10.0.0.7:30004".to_owned()));
        assert!(cell.hardware().is_empty());
        cell.run().expect("within the limits");
        let (first, last) = (trace.borrow()[0], *trace.borrow().last().expect("it moved"));
        assert!((first - start).amax() < 1e-3 && (last[0] - 0.1).abs() < 1e-9, "{first} {last}");
        assert!(calls.borrow().is_empty(), "{calls:?}");
    }
}

#[test]
fn fault_83_hardware_that_nothing_can_stand_in_for_is_refused_with_what_to_write() {
    let nothing = Cell::new(MS).robot(moving(remote().0));
    // Drives that are hardware themselves do not stand in for any.
    let hardware = Cell::new(MS).robot(moving(remote().0).stand_in(remote().0));
    for cell in [nothing, hardware] {
        let refused = cell.simulated().err().expect("refused").to_string();
        assert!(
            refused.contains("nothing to stand in for them") && refused.contains(".stand_in("),
            "{refused}"
        );
    }
    // Simulated drives need none.
    let (exact, _) = mrroc_tests::gantry("g");
    let cell = Cell::new(MS).robot(exact).simulated().expect("nothing is real");
    assert_eq!(cell.layout().robots[0].drives, HardwareLayout::Nothing);
}

#[test]
fn fault_83_drives_that_are_made_when_they_are_opened_are_made_by_their_edp_alone() {
    let made = Calls::default();
    let cell = || {
        let note = Rc::clone(&made);
        let drives =
            Connecting::to("udp 10.0.0.7:30004", MS, move || -> Result<ExactDrive<3>, DriveFault> {
                note.borrow_mut().push("made");
                Err(DriveFault::NoAnswer)
            });
        let ideal = IdealDrives::new(&Gantry::default(), Q::zeros(), MS);
        let setup = RobotSetup::new("g", Gantry::default(), drives).stand_in(ideal);
        Cell::new(MS).robot(setup.program(|ecp| ecp.move_robot((), Smooth::to(0.1, 0.4)).map(drop)))
    };
    assert_eq!(cell().hardware(), ["udp 10.0.0.7:30004"]);
    assert!(matches!(cell().run(), Err(CellError::RealDrives { .. })));
    cell().simulated().expect("they stand in").run().expect("within the limits");
    assert!(made.borrow().is_empty());
}
