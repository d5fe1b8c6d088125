//! The wrench that the controller tells, against its equations: where the flange is, by Denavit-Hartenberg parameters, and what a force
//! at the tip of a tool does to it.

use core::cell::RefCell;
use core::time::Duration;
use std::rc::Rc;

use mrroc::cell::{Cell, RobotSetup, SensorSetup};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::robot::Driver;
use mrroc_robots::sensors::{RobotWrench, WristForce};
use mrroc_robots::{Serial, Six};
use mrroc_ur::rtde::Value;
use mrroc_ur::{Calibration, Ur, UrModel, UrSettings};
use mrroc_ur_controller::{Controller, Inside};
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

const MODEL: UrModel = UrModel::Ur5e;

fn start() -> Six {
    Six::new(0.4, -1.3, 1.1, -0.7, -1.5, 0.9)
}

fn controller() -> Rc<RefCell<Controller>> {
    Rc::new(RefCell::new(Controller::new(MODEL, &start()).expect("an arm")))
}

fn settings() -> UrSettings {
    let any = "127.0.0.1:0".parse().expect("an address");
    UrSettings::new(MODEL, "127.0.0.1".parse().expect("one"), any)
}

/// How the flange is turned in the base: `R_z(q + theta) R_x(alpha)` of each joint.
fn turned(calibration: &Calibration, q: &[f64; 6]) -> Rotation3<f64> {
    (0..6).fold(Rotation3::identity(), |turned, i| {
        let about = |axis: Vector3<f64>, angle: f64| Rotation3::from_scaled_axis(axis * angle);
        turned * about(Vector3::z(), q[i] + calibration.theta[i]) * about(Vector3::x(), calibration.alpha[i])
    })
}

fn is_near(is: &Wrench, expected: &Wrench) {
    let off = *is - *expected;
    assert!(off.force.norm() < 1e-9 && off.torque.norm() < 1e-9, "{is:?}, {expected:?}");
}

/// A tool of 0.2 m, turned against the flange.
fn tool() -> Pose {
    let turned = UnitQuaternion::from_euler_angles(0.3, -0.8, 1.9);
    Pose::from_parts(Translation3::new(0.03, -0.02, 0.2), turned)
}

#[test]
fn the_wrench_is_turned_into_the_flange_wherever_the_tool_centre_point_of_the_controller_is() {
    let mut calibrated = Calibration::nominal(MODEL);
    calibrated.theta[3] += 2e-3;
    calibrated.alpha[1] += 3e-3;
    for calibration in [None, Some(calibrated)] {
        let controller = controller();
        let used = calibration.unwrap_or(Calibration::nominal(MODEL));
        controller.borrow_mut().calibrate(&used).expect("a UR5e");
        let mut ur = Ur::over(Inside::new(Rc::clone(&controller)), UrSettings { calibration, ..settings() });
        let drives: &mut dyn Driver<Serial<6>> = &mut ur;
        assert_eq!(drives.wrench(), None, "nothing is open yet");
        let told = Wrench::new(Vector3::new(7.0, -11.0, 30.0), Vector3::new(0.5, -1.5, 2.5));
        controller.borrow_mut().push(told);
        controller.borrow_mut().set_tool(tool());
        drives.open().expect("the controller answers");
        let q = drives.measured().expect("it is open").position;
        let into = turned(&used, &q.into()).inverse();
        let expected = Wrench::new(into * told.force, into * told.torque);
        is_near(&drives.wrench().expect("it tells one"), &expected);
        // The poses that it tells are those of its tool centre point.
        let Some(Value::Vector6d(pose)) = controller.borrow().output("actual_TCP_pose") else {
            panic!("no pose")
        };
        let turn = Rotation3::from_scaled_axis(Vector3::new(pose[3], pose[4], pose[5]));
        let of_tool = into.inverse() * tool().rotation.to_rotation_matrix();
        assert!((turn.matrix() - of_tool.matrix()).norm() < 1e-9, "{turn} {of_tool}");
    }
}

/// What was read last.
struct Felt(Wrench);

#[condition(mp)]
fn felt(c: &mut Felt, v: &Reading<(WristForce,)>) -> bool {
    v.0.reading().is_some_and(|reading| {
        c.0 = reading;
        true
    })
}

#[test]
fn a_force_at_the_tip_of_the_cells_tool_is_read_there_without_a_torque_wherever_the_arm_stands() {
    let controller = controller();
    let force = Vector3::new(4.0, 9.0, -20.0);
    // By equilibrium: about the flange the force has the torque p x f, with the tip at p.
    let flange = turned(&Calibration::nominal(MODEL), &start().into());
    let arm = flange * tool().translation.vector;
    controller.borrow_mut().push(Wrench::new(force, arm.cross(&force)));
    // The controller knows of no world, and of another tool.
    controller.borrow_mut().set_tool(Pose::translation(0.0, 0.1, 0.1));
    let base = Isometry3::new(Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.2, 0.4, 2.0));
    let base = Pose::from_parts(base.translation, base.rotation);
    let drives = Ur::over(Inside::new(Rc::clone(&controller)), settings());
    let robot = RobotSetup::new("arm", MODEL.arm(base).expect("an arm"), drives)
        .following_error(MODEL.velocities() * 0.06)
        .tool(tool());
    let sensor = SensorSetup::new("wrist", RobotWrench::new()).of("arm").readers([]);
    let cell = Cell::new(Duration::from_millis(2)).robot(robot).sensor(sensor).program(move |mp| {
        let mut arm = mp.robot::<Serial<6>>("arm")?;
        let mut wrist = mp.sensor::<WristForce>("wrist")?;
        let at_tip = (flange * tool().rotation.to_rotation_matrix()).inverse() * force;
        let felt = mp.wait_until((&mut arm,), (&mut wrist,), Felt(Wrench::default()))?;
        let off = felt.0 - Wrench::new(at_tip, Vector3::zeros());
        // The encoders of the simulated arm tell where it is to some µrad.
        assert!(off.force.norm() < 1e-2 && off.torque.norm() < 1e-2, "{:?}, {at_tip:?}", felt.0);
        Ok(())
    });
    cell.run().expect("no fault");
}
