//! Sensors with hardware: when it is opened, what takes its place, and how old what it took is.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::cell::CellError;
use mrroc::fault::FaultKind;
use mrroc::observe::layout::HardwareLayout;
use mrroc::prelude::*;
use mrroc::sensor::{Taken, VspMode};
use mrroc_tests::{MS, fault, gantry};

use crate::runtime::kit::{Count, Counter, Counting, Offset, Watch};

/// A camera behind a cable: it counts frames.
struct Camera {
    refusals: u32,
    name: Option<&'static str>,
    calls: Rc<RefCell<Vec<&'static str>>>,
    /// How many steps ago its newest frame was taken.
    age: u64,
}

impl VirtualSensor for Camera {
    type Kind = Counter;

    fn hardware(&self) -> Option<String> {
        self.name.map(str::to_owned)
    }

    fn open(&mut self) -> Result<(), Fault> {
        self.calls.borrow_mut().push("open");
        if self.refusals > 0 {
            self.refusals -= 1;
            return Err(Fault::new(FaultKind::SensorFailed).text("the cable is not plugged in"));
        }
        Ok(())
    }

    fn taken(&mut self, order: &ReadingOrder<Offset>) -> Taken {
        order.step.checked_sub(self.age).map_or(Taken::NotYet, Taken::In)
    }

    fn aggregate(&mut self, order: &ReadingOrder<Offset>) -> Result<Count, Fault> {
        self.calls.borrow_mut().push("aggregate");
        Ok(Count { count: order.step, x: 0.0, step: order.step })
    }
}

fn camera(refusals: u32, name: Option<&'static str>, age: u64) -> (Camera, Rc<RefCell<Vec<&'static str>>>) {
    let calls = Rc::default();
    (Camera { refusals, name, calls: Rc::clone(&calls), age }, calls)
}

/// Runs a cell whose ECP rests for some time and then reads the sensor in each of `steps` steps.
fn watched(sensor: SensorSetup<Camera>, rest: Duration, steps: usize) -> Result<Watch, CellError> {
    let (robot, _) = gantry("g");
    let seen = Rc::new(RefCell::new(Watch::default()));
    let keep = Rc::clone(&seen);
    let robot = robot.program(move |ecp| {
        ecp.wait_until((), Rested(rest))?;
        let mut counter = ecp.sensor::<Counter>("camera")?;
        *keep.borrow_mut() = ecp.move_robot((&mut counter,), Watch { steps, ..Watch::default() })?;
        Ok(())
    });
    Cell::new(MS).robot(robot).sensor(sensor.of("g")).run()?;
    Ok(seen.take())
}

/// So much time has passed.
struct Rested(Duration);

#[condition(ecp)]
fn rested(c: &mut Rested) -> bool {
    c.0 = c.0.saturating_sub(MS);
    c.0.is_zero()
}

#[test]
fn fault_120_a_sensor_that_cannot_be_opened_is_a_fault_with_its_reason_for_who_reads_it() {
    let (camera, calls) = camera(u32::MAX, None, 0);
    let Err(CellError::Fault(told)) = watched(SensorSetup::new("camera", camera), MS, 3) else {
        panic!("it cannot be read")
    };
    assert_eq!((told.kind(), told.message()), (FaultKind::SensorFailed, "the cable is not plugged in"));
    assert_eq!(told.process().map(|by| by.to_string()).as_deref(), Some("vsp camera"));
    assert_eq!(*calls.borrow(), ["open"], "once, and nothing is aggregated");
}

#[test]
fn fault_120_a_sensor_that_could_not_be_opened_is_tried_again_a_second_later() {
    for (rest, well) in [(Duration::from_millis(900), false), (Duration::from_millis(1100), true)] {
        let (camera, calls) = camera(1, None, 0);
        let read = watched(SensorSetup::new("camera", camera), rest, 3);
        assert_eq!(read.is_ok(), well, "after {rest:?}");
        let opened = calls.borrow().iter().filter(|call| **call == "open").count();
        assert_eq!(opened, if well { 2 } else { 1 });
    }
}

#[test]
fn a_reading_is_as_old_as_what_was_taken_for_it() {
    let free = VspMode::NonInteractive(MS);
    let setup = |age| SensorSetup::new("camera", camera(0, None, age).0).mode(free);
    let seen = watched(setup(7), 30 * MS, 20).expect("not too old").seen;
    // The sensor runs once in a step, so that what it shows is of this step or of the one before.
    assert!(seen.iter().flatten().all(|(_, age)| (7..=8).contains(age)), "{seen:?}");
    // Too old to move by, however often it is aggregated.
    let Err(CellError::Fault(told)) = watched(setup(7).stale_after(5 * MS), 30 * MS, 20) else {
        panic!("older than 5 ms")
    };
    assert_eq!(told.kind(), FaultKind::SensorStale);
}

#[test]
fn a_sensor_that_has_taken_nothing_yet_has_no_reading() {
    let free = VspMode::NonInteractive(MS);
    let (camera, calls) = camera(0, None, 15);
    let seen = watched(SensorSetup::new("camera", camera).mode(free), MS, 30).expect("in time").seen;
    let first = seen.iter().position(Option::is_some).expect("it has taken something");
    assert!((10..=17).contains(&first) && seen[first..].iter().all(Option::is_some), "{seen:?}");
    assert!(calls.borrow().contains(&"aggregate"));
}

#[test]
fn fault_120_hardware_of_a_sensor_is_refused_under_the_virtual_clock_and_a_simulated_sensor_stands_in() {
    const NAME: &str = "camera /dev/video0";
    let cell = |setup: SensorSetup<Camera>| {
        let (robot, _) = gantry("g");
        let robot = robot.program(|ecp| {
            let mut counter = ecp.sensor::<Counter>("camera")?;
            let watch = ecp.move_robot((&mut counter,), Watch { steps: 3, ..Watch::default() })?;
            assert_eq!(watch.seen[0], Some((1, 0)), "what stands in counts its aggregations");
            Ok(())
        });
        Cell::new(MS).robot(robot).sensor(setup.of("g"))
    };
    let (real, calls) = camera(0, Some(NAME), 0);
    let cell_with = |real| cell(SensorSetup::new("camera", real).stand_in(Counting::default()));
    let there = cell_with(real);
    assert_eq!(there.hardware(), [NAME]);
    assert_eq!(there.layout().sensors[0].hardware, HardwareLayout::Real(NAME.to_owned()));
    let refused = there.run().expect_err("time is not that of the world").to_string();
    assert!(refused.contains(NAME) && refused.contains("cannot follow the virtual clock"), "{refused}");

    let simulated = cell_with(camera(0, Some(NAME), 0).0).simulated().expect("a sensor stands in");
    assert_eq!(simulated.layout().sensors[0].hardware, HardwareLayout::StandIn(NAME.to_owned()));
    assert!(simulated.hardware().is_empty());
    simulated.run().expect("it is read");
    assert!(calls.borrow().is_empty(), "{calls:?}");

    // What is hardware itself does not stand in.
    let (one, other) = (camera(0, Some(NAME), 0).0, camera(0, Some("camera /dev/video1"), 0).0);
    for setup in [
        SensorSetup::new("camera", camera(0, Some(NAME), 0).0),
        SensorSetup::new("camera", one).stand_in(other),
    ] {
        let refused = cell(setup).simulated().err().expect("refused").to_string();
        assert!(
            refused.contains("nothing to stand in for it") && refused.contains(".stand_in("),
            "{refused}"
        );
    }
}

#[test]
fn a_panic_while_hardware_is_opened_is_that_sensor_s_fault() {
    struct Panics;
    impl VirtualSensor for Panics {
        type Kind = Counter;
        fn open(&mut self) -> Result<(), Fault> {
            panic!("no such port")
        }
        fn aggregate(&mut self, _: &ReadingOrder<Offset>) -> Result<Count, Fault> {
            unreachable!("it is not open")
        }
    }
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut counter = ecp.sensor::<Counter>("camera")?;
        ecp.move_robot((&mut counter,), Watch { steps: 3, ..Watch::default() }).map(drop)
    });
    let cell: Cell = Cell::new(MS).robot(robot).sensor(SensorSetup::new("camera", Panics).of("g"));
    let told = fault(cell.run());
    assert_eq!(told.process().map(|by| by.to_string()).as_deref(), Some("vsp camera"));
    assert!(told.to_string().contains("no such port"), "{told}");
}
