//! Panics anywhere in user code: they are caught where they happen, the process is named, and the robots stop.

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, Measured};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault, gantry, peaks, traced};

use crate::runtime::kit::{Count, Counter, Offset, Smooth, Twin, Watch};

fn stopped(result: Result<mrroc::cell::RunReport, CellError>, process: &str, trace: &[Q<3>]) {
    let fault = fault(result);
    assert_eq!(fault.kind(), FaultKind::Panicked, "{fault}");
    assert_eq!(fault.process().expect("named").to_string(), process, "{fault}");
    assert!(fault.message().contains("on purpose"), "{fault}");
    assert!(peaks(trace, 1e-3).1 <= 10.0 + 1e-6);
    assert_eq!(trace[trace.len() - 1], trace[trace.len() - 2], "not at standstill");
}

#[test]
fn fault_08_a_hook_that_panics_in_every_step_stops_the_robots() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(0.3, 0.5)).map(drop));
    let cell = Cell::new(MS).robot(robot).on_step(|step, _| assert!(step < 200, "on purpose"));
    stopped(cell.run(), "mp", &trace.borrow());
}

#[test]
fn fault_08_an_observer_that_panics_in_every_servo_period_stops_the_robots() {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    let mut periods = 0;
    let left = left.observe(move |_| {
        periods += 1;
        assert!(periods < 200, "on purpose");
    });
    let cell = Cell::new(MS).robot(left).robot(right).program(|mp| {
        let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
        mp.move_robots((&mut left, &mut right), (), Twin(Smooth::to(0.3, 0.5))).map(drop)
    });
    stopped(cell.run(), "edp left", &right_trace.borrow());
    assert!(peaks(&left_trace.borrow(), 1e-3).1 <= 10.0 + 1e-6);
}

/// Panics in tick `at`, and in every later one.
struct Panicking {
    drive: ExactDrive<3>,
    ticks: u32,
    at: u32,
}

impl Driver<Gantry> for Panicking {
    fn period(&self) -> std::time::Duration {
        MS
    }
    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::measured(&self.drive)
    }
    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        self.ticks += 1;
        assert!(self.ticks < self.at, "on purpose");
        Driver::<Gantry>::tick(&mut self.drive, demanded)
    }
}

#[test]
fn a_driver_that_panics_stops_the_other_robot() {
    let drive = Panicking { drive: ExactDrive::at_origin(), ticks: 0, at: 200 };
    let (left, _) = traced(RobotSetup::new("left", Gantry::default(), drive));
    let (right, right_trace) = gantry("right");
    let cell = Cell::new(MS).robot(left).robot(right).program(|mp| {
        let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
        mp.move_robots((&mut left, &mut right), (), Twin(Smooth::to(0.3, 0.5))).map(drop)
    });
    stopped(cell.run(), "edp left", &right_trace.borrow());
}

struct Touchy(u32);

#[condition(ecp)]
fn touchy(c: &mut Touchy) -> bool {
    c.0 -= 1;
    assert!(c.0 > 0, "on purpose");
    false
}

#[test]
fn fault_08_a_condition_that_panics_ends_the_wait() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| ecp.wait_until((), Touchy(10)).map(drop));
    stopped(Cell::new(MS).robot(robot).run(), "ecp g", &trace.borrow());
}

struct Explosive(u32);

impl VirtualSensor for Explosive {
    type Kind = Counter;
    fn aggregate(&mut self, _: &ReadingOrder<Offset>) -> Result<Count, Fault> {
        self.0 -= 1;
        assert!(self.0 > 0, "on purpose");
        Ok(Count { count: 0, x: 0.0, step: 0 })
    }
}

#[test]
fn fault_08_a_sensor_that_panics_ends_the_motion_that_reads_it() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut counter = ecp.sensor::<Counter>("counter")?;
        ecp.move_robot((&mut counter,), Watch { steps: 100, ..Watch::default() }).map(drop)
    });
    let cell = Cell::new(MS).robot(robot).sensor(SensorSetup::new("counter", Explosive(10)).of("g"));
    stopped(cell.run(), "vsp counter", &trace.borrow());
}

#[test]
fn a_program_that_swallows_a_latched_fault_still_ends_with_it() {
    let (robot, _) = gantry("g");
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let _ = mp.wait_until((), (), Broken);
        Ok(())
    });
    assert_eq!(fault(cell.run()).message(), "on purpose");
}

struct Broken;

#[condition(mp)]
fn broken(_c: &mut Broken) -> Result<bool, Fault> {
    Err(Fault::thrown("on purpose"))
}

/// Encoders that read NaN from tick `at` on (0: from the beginning); keeps its demands.
struct Blind {
    drive: ExactDrive<3>,
    ticks: u32,
    at: u32,
    velocity_only: bool,
    told: std::rc::Rc<std::cell::RefCell<Vec<Q<3>>>>,
}

impl Blind {
    fn read(&self, mut measured: Measured<Q<3>>) -> Measured<Q<3>> {
        if self.ticks >= self.at {
            measured.velocity[1] = f64::NAN;
            if !self.velocity_only {
                measured.position[1] = f64::NAN;
            }
        }
        measured
    }
}

impl Driver<Gantry> for Blind {
    fn period(&self) -> std::time::Duration {
        MS
    }
    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::measured(&self.drive).map(|measured| self.read(measured))
    }
    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        self.ticks += 1;
        self.told.borrow_mut().push(*demanded);
        let measured = Driver::<Gantry>::tick(&mut self.drive, demanded)?;
        Ok(self.read(measured))
    }
}

#[test]
fn fault_18_encoders_that_read_no_number_stop_the_robot_and_never_reach_its_drives() {
    for at in [0, 1, 200] {
        for velocity_only in [false, true] {
            let told = std::rc::Rc::default();
            let drive = Blind {
                drive: ExactDrive::at_origin(),
                ticks: 0,
                at,
                velocity_only,
                told: std::rc::Rc::clone(&told),
            };
            let robot = RobotSetup::new("g", Gantry::default(), drive)
                .program(|ecp| ecp.move_robot((), Smooth::to(0.3, 0.5)).map(drop));
            let fault = fault(Cell::new(MS).robot(robot).run());
            assert_eq!(fault.process().expect("named").to_string(), "edp g", "at {at}: {fault}");
            assert_eq!(fault.joint(), Some(1), "at {at}: {fault}");
            assert!(told.borrow().iter().all(|q| q.iter().all(|x| x.is_finite())), "at {at}");
        }
    }
}

/// A gantry whose kinematics panic where `x` is at least this \[m\].
#[derive(Clone)]
struct Unfinished(Gantry, f64);

impl Robot for Unfinished {
    const KIND: &'static str = "unfinished";
    type Joints = Q<3>;
    fn limits(&self) -> &mrroc::robot::Limits<Q<3>> {
        self.0.limits()
    }
    fn forward(&self, q: &Q<3>) -> Pose {
        assert!(q[0] < self.1, "on purpose");
        self.0.forward(q)
    }
    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Q<3>) -> Result<Q<3>, mrroc::robot::NoInverse> {
        self.0.inverse(X_WF, near)
    }
}

fn unfinished(name: &str, x: f64) -> RobotSetup<Unfinished> {
    RobotSetup::new(name, Unfinished(Gantry::default(), x), ExactDrive::at_origin())
        .program(|ecp| ecp.wait_until((), Touchy(10)).map(drop))
}

#[test]
fn fault_78_kinematics_that_panic_while_the_cell_is_checked_are_refused_with_the_robots_name() {
    let cell = || Cell::new(MS).robot(unfinished("left", -1.0)).robot(unfinished("right", -1.0));
    let refused = cell().run().expect_err("nothing runs").to_string();
    for robot in ["left", "right"] {
        let told =
            format!("robot `{robot}`: its code panicked while the cell was checked: on purpose\n help: ");
        assert!(refused.contains(&told), "{refused}");
    }
    assert!(cell().check().is_err(), "a check refuses it as well");
}

#[test]
fn fault_78_kinematics_that_panic_where_the_robot_stands_are_a_fault_of_its_process() {
    // The check asks for the middle of the limits, 0, and the robot stands at 0.5 m.
    let at = Q::<3>::new(0.5, 0.0, 0.0);
    let robot = RobotSetup::new("left", Unfinished(Gantry::default(), 0.4), ExactDrive::new(at, MS))
        .program(|ecp| ecp.wait_until((), Touchy(10)).map(drop));
    let fault = fault(Cell::new(MS).robot(robot).run());
    assert_eq!(fault.kind(), FaultKind::Panicked, "{fault}");
    assert!(fault.process().is_some() && fault.message().contains("on purpose"), "{fault}");
}
