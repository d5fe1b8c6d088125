//! The wrench that a robot tells by itself: from its driver to the readings of a sensor.

use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::nalgebra::{UnitQuaternion, Vector3};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, Measured};
use mrroc_robots::sensors::{RobotWrench, WristForce};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault, gantry};

use crate::runtime::kit::Smooth;

/// Where a wall begins along x \[m\], and its stiffness [N/m].
const WALL: f64 = 0.01;
const STIFFNESS: f64 = 2000.0;

/// An exact drive whose flange meets a wall, and which tells what the wall does to it.
struct Feeling(ExactDrive<3>);

impl Driver<Gantry> for Feeling {
    fn period(&self) -> Duration {
        MS
    }
    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::measured(&self.0)
    }
    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::tick(&mut self.0, demanded)
    }
    fn wrench(&self) -> Option<Wrench> {
        let x = Driver::<Gantry>::measured(&self.0).ok()?.position[0];
        Some(Wrench::new(Vector3::new(-STIFFNESS * (x - WALL).max(0.0), 0.0, 0.0), Vector3::zeros()))
    }
}

/// A tool of 0.1 m along the flange's z, turned by a right angle about it.
fn tool() -> Pose {
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), core::f64::consts::FRAC_PI_2);
    Pose::from_parts(Vector3::new(0.0, 0.0, 0.1).into(), turned)
}

fn feeling() -> RobotSetup<Gantry> {
    RobotSetup::new("g", Gantry::default(), Feeling(ExactDrive::at_origin())).tool(tool())
}

/// Along x until the tool feels a force \[N\].
#[derive(Default)]
struct Press {
    until: f64,
    felt: Wrench,
    /// Where the flange was measured \[m\], and in the step before, whose state the reading was ordered with.
    x: f64,
    before: f64,
}

#[generator(ecp)]
fn press(c: &mut Press, e: &State<Gantry>, v: &Reading<(WristForce,)>) -> Step<Gantry> {
    let Some(reading) = v.0.reading() else { return Step::Next(Demand::hold()) };
    (c.felt, c.before, c.x) = (reading, c.x, e.measured().joints[0]);
    if reading.force.norm() > c.until {
        return Step::Done;
    }
    Step::Next(Demand::joints(e.demanded().joints + Vector3::new(5e-6, 0.0, 0.0)))
}

/// What a tool that is turned against its flange feels of a wall's force `f` on the flange, against its x: the force is along
/// the tool's y, and turns the tool about its x with the arm of 0.1 m, by virtual work.
fn is_of_the_wall(felt: &Wrench, f: f64) {
    let expected = Wrench::new(Vector3::new(0.0, f, 0.0), Vector3::new(0.1 * f, 0.0, 0.0));
    let apart = *felt - expected;
    assert!(apart.force.norm() < 1e-9 && apart.torque.norm() < 1e-9, "{felt:?}, {expected:?}");
}

#[test]
fn what_a_robot_feels_ends_a_motion_of_its_ecp_in_the_frame_of_its_tool() {
    let robot = feeling().program(|ecp| {
        let mut force = ecp.sensor::<WristForce>("wrist")?;
        let press = Press { until: 5.0, ..Press::default() };
        let press = ecp.move_robot((&mut force,), press)?;
        assert!(press.felt.force.norm() > 5.0);
        is_of_the_wall(&press.felt, STIFFNESS * (press.before - WALL));
        Ok(())
    });
    let sensor = SensorSetup::new("wrist", RobotWrench::new()).of("g");
    Cell::new(MS).robot(robot).sensor(sensor).run().expect("the wall is there");
}

#[test]
fn the_mp_reads_it_as_well() {
    #[derive(Clone, Copy)]
    struct Felt(f64);
    #[condition(mp)]
    fn felt(c: &mut Felt, v: &Reading<(WristForce,)>) -> bool {
        v.0.reading().is_some_and(|reading| {
            is_of_the_wall(&reading, c.0);
            true
        })
    }
    let sensor = SensorSetup::new("wrist", RobotWrench::new()).of("g").readers([]);
    let cell = Cell::new(MS).robot(feeling()).sensor(sensor).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        let mut force = mp.sensor::<WristForce>("wrist")?;
        mp.wait_until((&mut g,), (&mut force,), Felt(0.0))?;
        mp.move_robot(&mut g, (), Smooth::to(WALL + 0.003, 0.2))?;
        mp.wait_until((&mut g,), (&mut force,), Felt(STIFFNESS * 0.003)).map(drop)
    });
    cell.run().expect("the wall is there");
}

#[test]
fn a_robot_that_tells_no_wrench_ends_the_motion_that_reads_it() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut force = ecp.sensor::<WristForce>("wrist")?;
        let press = Press { until: 5.0, ..Press::default() };
        ecp.move_robot((&mut force,), press).map(drop)
    });
    let sensor = SensorSetup::new("wrist", RobotWrench::new()).of("g");
    let ended = fault(Cell::new(MS).robot(robot).sensor(sensor).run());
    assert_eq!(ended.kind(), FaultKind::SensorFailed);
    assert!(ended.to_string().contains("tells no wrench"), "{ended}");
}

#[test]
fn a_driver_that_tells_no_numbers_tells_no_wrench() {
    struct Broken(ExactDrive<3>);
    impl Driver<Gantry> for Broken {
        fn period(&self) -> Duration {
            MS
        }
        fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
            Driver::<Gantry>::measured(&self.0)
        }
        fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
            Driver::<Gantry>::tick(&mut self.0, demanded)
        }
        fn wrench(&self) -> Option<Wrench> {
            Some(Wrench::new(Vector3::repeat(f64::NAN), Vector3::zeros()))
        }
    }
    let robot = RobotSetup::new("g", Gantry::default(), Broken(ExactDrive::at_origin())).program(|ecp| {
        let mut force = ecp.sensor::<WristForce>("wrist")?;
        let press = Press { until: 5.0, ..Press::default() };
        ecp.move_robot((&mut force,), press).map(drop)
    });
    let sensor = SensorSetup::new("wrist", RobotWrench::new()).of("g");
    assert_eq!(fault(Cell::new(MS).robot(robot).sensor(sensor).run()).kind(), FaultKind::SensorFailed);
}
