//! Drives and sensors' hardware from before the cell begins until their EDP, or VSP, takes them.
//!
//! In: drives that are connected to nothing. Out: open ones, however long the controllers of the cell's robots take to answer.
//! Until the cell begins, a robot that paces itself is told in each of its periods to stay where it is: it would stop by itself
//! if it were told nothing.

use core::cell::{Cell, RefCell};

use crate::control::drive::Drive;
use crate::control::guarded::guarded;
use crate::control::vsp::RawSensors;
use crate::link::Preparation;
use crate::model::pace::Pace;
use crate::model::robot::Robot;

/// The drives of a robot whose EDP has not begun.
pub(crate) struct Opening<R: Robot> {
    drive: RefCell<Option<Drive<R>>>,
    is_open: Cell<bool>,
    /// Where the robot is to stay: known once it is open, if its encoders can be read.
    rest: Cell<Option<R::Joints>>,
}

impl<R: Robot> Opening<R> {
    pub fn new(drive: Drive<R>) -> Self {
        Opening { drive: RefCell::new(Some(drive)), is_open: Cell::new(false), rest: Cell::new(None) }
    }

    /// The drives, opened here unless they have been; `None` if they have been taken.
    pub fn take(&self) -> Option<Drive<R>> {
        self.open();
        self.drive.take()
    }
}

impl<R: Robot> Preparation for Opening<R> {
    fn open(&self) {
        if self.is_open.replace(true) {
            return;
        }
        let drive = self.drive.take().map(Drive::opened);
        let paces = |drive: &&Drive<R>| matches!(drive.pace(), Pace::Robot { .. });
        // One that cannot be read is told nothing; its EDP says why.
        let rest = drive.as_ref().filter(paces).and_then(|drive| {
            let measured = guarded(|| drive.measured()).and_then(|measured| measured).ok()?;
            Some(drive.held().unwrap_or(measured.position))
        });
        self.rest.set(rest);
        self.drive.replace(drive);
    }

    fn keep(&self) {
        let Some(rest) = self.rest.get() else { return };
        let Some(mut drive) = self.drive.take() else { return };
        match guarded(|| drive.keep(&rest)).and_then(|kept| kept) {
            Ok(()) => {}
            Err(fault) => {
                self.rest.set(None);
                drive = drive.let_go(fault);
            }
        }
        self.drive.replace(Some(drive));
    }
}

impl<R: Robot> Drop for Opening<R> {
    /// The cell never began.
    fn drop(&mut self) {
        if let Some(mut drive) = self.drive.take()
            && self.is_open.get()
        {
            // Whether that goes well changes nothing.
            drop(guarded(|| drive.close()));
        }
    }
}

/// A virtual sensor whose VSP has not begun.
pub(crate) struct SensorOpening {
    sensors: RefCell<Option<RawSensors>>,
    is_open: Cell<bool>,
}

impl SensorOpening {
    pub fn new(sensors: RawSensors) -> Self {
        SensorOpening { sensors: RefCell::new(Some(sensors)), is_open: Cell::new(false) }
    }

    /// The sensor, opened here unless it has been; `None` if it has been taken.
    pub fn take(&self) -> Option<RawSensors> {
        self.open();
        self.sensors.take()
    }
}

impl Preparation for SensorOpening {
    fn open(&self) {
        if self.is_open.replace(true) {
            return;
        }
        if let Some(RawSensors::Here(aggregator)) = &mut *self.sensors.borrow_mut() {
            aggregator.open(0);
        }
    }

    /// Nobody breaks off who is not asked for readings.
    fn keep(&self) {}
}

#[cfg(test)]
mod tests {
    use core::time::Duration;
    use std::rc::Rc;

    use super::*;
    use crate::model::drive_fault::DriveFault;
    use crate::model::driver::{Driver, Measured};
    use crate::model::fault::FaultKind;
    use crate::model::pace::Pulse;
    use crate::tests::slide::{One, Slide};

    const MS: Duration = Duration::from_millis(1);

    /// What a robot was asked, in order: one that paces itself, holds at 0.25 what its encoders read as 0.2, and breaks off
    /// after so many periods.
    struct Paced {
        asked: Rc<RefCell<Vec<String>>>,
        periods: u64,
    }

    impl Paced {
        fn note(&self, what: impl Into<String>) {
            self.asked.borrow_mut().push(what.into());
        }
    }

    impl Driver<Slide> for Paced {
        fn period(&self) -> Duration {
            MS
        }
        fn pace(&self) -> Pace {
            Pace::Robot { timeout: MS }
        }
        fn pulse(&mut self, _: Duration) -> Result<Option<Pulse>, DriveFault> {
            if self.periods == 0 {
                return Err(DriveFault::NoAnswer);
            }
            self.periods -= 1;
            Ok(self.periods.is_multiple_of(2).then_some(Pulse { count: self.periods, age: Duration::ZERO }))
        }
        fn open(&mut self) -> Result<(), DriveFault> {
            self.note("open");
            Ok(())
        }
        fn close(&mut self) {
            self.note("close");
        }
        fn held(&self) -> Option<One> {
            Some(One::new(0.25))
        }
        fn measured(&self) -> Result<Measured<One>, DriveFault> {
            Ok(Measured { position: One::new(0.2), velocity: One::new(0.0) })
        }
        fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
            self.note(format!("tick {}", demanded[0]));
            Driver::<Slide>::measured(self)
        }
    }

    fn opening(periods: u64) -> (Opening<Slide>, Rc<RefCell<Vec<String>>>) {
        let asked = Rc::default();
        (Opening::new(Drive::Here(Box::new(Paced { asked: Rc::clone(&asked), periods }))), asked)
    }

    #[test]
    fn a_robot_that_paces_itself_is_told_to_stay_in_each_of_its_periods_until_the_cell_begins() {
        let (opening, asked) = opening(4);
        opening.keep();
        assert!(asked.borrow().is_empty(), "it is not open");
        opening.open();
        (0..4).for_each(|_| opening.keep());
        assert_eq!(*asked.borrow(), ["open", "tick 0.25", "tick 0.25"]);
        assert!(opening.take().is_some_and(|drive| drive.unopened().is_none()), "opened once");
        drop(opening);
        assert_eq!(asked.borrow().len(), 3, "whoever took it closes it");
    }

    #[test]
    fn a_robot_that_breaks_off_before_the_cell_begins_is_let_go_and_its_edp_says_why() {
        let (opening, asked) = opening(1);
        opening.open();
        (0..3).for_each(|_| opening.keep());
        assert_eq!(*asked.borrow(), ["open", "tick 0.25", "close"]);
        let drive = opening.take().expect("not taken before");
        assert_eq!(drive.unopened().map(|fault| fault.kind()), Some(FaultKind::DriveFault));
    }

    #[test]
    fn drives_of_a_cell_that_never_begins_are_closed() {
        let (opening, asked) = opening(4);
        opening.open();
        drop(opening);
        assert_eq!(*asked.borrow(), ["open", "close"]);
    }
}
