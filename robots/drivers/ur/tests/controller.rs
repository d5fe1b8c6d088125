//! The driver against the controller of `mrroc-ur-controller`, in one process and under the virtual clock: faults 90
//! to 93 and 107 in docs/safety, its inputs and outputs, and that no period is without a set-point.

use core::cell::{Cell as Shared, RefCell};
use core::time::Duration;
use std::rc::Rc;

use mrroc::cell::{AfterFault, Cell, CellError, InputSetup, OutputSetup, RobotSetup, RunReport};
use mrroc::fault::{Fault, FaultKind};
use mrroc::generator::Each;
use mrroc::operator::Latch;
use mrroc::prelude::*;
use mrroc::robot::{Channel, ClearedBy, Input, Outputs, StopCause, Value as Level};
use mrroc_generators::generators::{JointMove, StraightLine, Tell};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Serial, Simulated, Six};
use mrroc_ur::outputs::Groups;
use mrroc_ur::rtde::Value;
use mrroc_ur::{Calibration, Ur, UrModel, UrSettings};
use mrroc_ur_controller::{Controller, Inside, Press};

const MODEL: UrModel = UrModel::Ur5e;
const STEP: Duration = Duration::from_millis(2);

fn start() -> Six {
    Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0)
}

fn there() -> Six {
    start() + Six::new(0.5, -0.2, 0.2, 0.0, 0.3, 0.0)
}

fn controller() -> Rc<RefCell<Controller>> {
    Rc::new(RefCell::new(Controller::new(MODEL, &start()).expect("an arm")))
}

/// A cell whose arm goes to and fro so many times; each takes 1.5 s.
fn cell(wire: Inside, times: u32) -> Cell {
    let any = "127.0.0.1:0".parse().expect("an address");
    let settings = UrSettings::new(MODEL, "127.0.0.1".parse().expect("one"), any);
    let arm = MODEL.arm(Pose::identity()).expect("an arm");
    let setup =
        RobotSetup::new("arm", arm, Ur::over(wire, settings)).following_error(MODEL.velocities() * 0.06);
    Cell::new(STEP).robot(setup).program(move |mp| {
        let mut arm = mp.robot::<Serial<6>>("arm")?;
        for _ in 0..times {
            for goal in [there(), start()] {
                mp.move_robot(&mut arm, (), JointMove::to(goal, Six::repeat(1.0), Six::repeat(4.0)))?;
            }
        }
        Ok(())
    })
}

/// The input reads on.
struct On(Input<bool>);

#[condition(mp)]
fn on(c: &mut On, e: &State<(Serial<6>,)>) -> bool {
    e.0.value(c.0)
}

#[test]
fn outputs_of_the_controller_are_switched_by_rtde_and_its_inputs_are_read() {
    let controller = controller();
    let seen = Rc::clone(&controller);
    let any = "127.0.0.1:0".parse().expect("an address");
    let settings = UrSettings::new(MODEL, "127.0.0.1".parse().expect("one"), any);
    let drives = Ur::over(Inside::new(Rc::clone(&controller)), settings);
    let setup = RobotSetup::new("arm", MODEL.arm(Pose::identity()).expect("an arm"), drives)
        .following_error(MODEL.velocities() * 0.06)
        .output(OutputSetup::new("vacuum", Channel::Digital(9)).holds_body())
        .output(OutputSetup::new("spindle", Channel::Digital(0)).turns_tool().on_stop(Level::Digital(false)))
        .input(InputSetup::new("part", Channel::Digital(17)));
    let asked = Rc::clone(&controller);
    let cell = Cell::new(STEP).robot(setup).on_step(move |step, _| {
        if step == 300 {
            asked.borrow_mut().set_digital_inputs(1 << 17);
        }
    });
    cell.program(move |mp| {
        let mut arm = mp.robot::<Serial<6>>("arm")?;
        let (vacuum, spindle) = (arm.output::<bool>("vacuum")?, arm.output::<bool>("spindle")?);
        let part = arm.input::<bool>("part")?;
        mp.move_robot(&mut arm, (), Tell::output(vacuum, true).and(spindle, true))?;
        mp.wait_at_most((&mut arm,), (), On(part), 500)?;
        assert!((300..305).contains(&mp.step()), "{}", mp.step());
        // Switched long ago, and said so by the controller.
        assert!(arm.value(vacuum) && arm.value(spindle));
        assert_eq!(seen.borrow().digital_outputs(), 1 << 9 | 1);
        Ok(())
    })
    .run()
    .expect("no fault");
    assert_eq!(controller.borrow().digital_outputs(), 1 << 9, "the end of the cell is a stop");
}

/// An analog input is at least this.
struct AtLeast(Input<f64>, f64);

#[condition(mp)]
fn at_least(c: &mut AtLeast, e: &State<(Serial<6>,)>) -> bool {
    e.0.value(c.0) >= c.1
}

/// A cell with two analog outputs, whose program tells the first one this.
fn with_analog(controller: &Rc<RefCell<Controller>>, told: f64) -> Cell {
    let any = "127.0.0.1:0".parse().expect("an address");
    let settings = UrSettings::new(MODEL, "127.0.0.1".parse().expect("one"), any);
    let drives = Ur::over(Inside::new(Rc::clone(controller)), settings);
    let setup = RobotSetup::new("arm", MODEL.arm(Pose::identity()).expect("an arm"), drives)
        .following_error(MODEL.velocities() * 0.06)
        .output(OutputSetup::new("glue", Channel::Analog(0)).on_stop(Level::Analog(0.125)))
        .output(OutputSetup::new("air", Channel::Analog(1)))
        .input(InputSetup::new("distance", Channel::Analog(3)));
    let (asked, seen) = (Rc::clone(controller), Rc::clone(controller));
    let cell = Cell::new(STEP).robot(setup).on_step(move |step, _| {
        if step == 300 {
            asked.borrow_mut().set_analog_inputs([0.0, 0.0, 0.0, 7.5]);
        }
    });
    cell.program(move |mp| {
        let mut arm = mp.robot::<Serial<6>>("arm")?;
        let (glue, air) = (arm.output::<f64>("glue")?, arm.output::<f64>("air")?);
        let distance = arm.input::<f64>("distance")?;
        mp.move_robot(&mut arm, (), Tell::output(glue, told).and(air, 0.75))?;
        mp.wait_at_most((&mut arm,), (), AtLeast(distance, 7.5), 500)?;
        assert!((300..305).contains(&mp.step()), "{}", mp.step());
        // Said by the controller in volts and in amperes, from which a rounding error of the last digit remains.
        assert!((arm.value(glue) - told).abs() < 1e-12 && (arm.value(air) - 0.75).abs() < 1e-12);
        assert_eq!(seen.borrow().analog_outputs(), [told, 0.75]);
        Ok(())
    })
}

#[test]
fn analog_outputs_are_told_as_fractions_of_the_range_that_was_chosen_at_the_pendant() {
    let controller = controller();
    // Output 0 is a voltage, output 1 a current.
    controller.borrow_mut().choose_voltages(0b0100);
    with_analog(&controller, 0.25).run().expect("no fault");
    let controller = controller.borrow();
    assert_eq!(controller.output("analog_io_types"), Some(Value::Uint32(0b0100)), "not changed");
    assert_eq!(controller.analog_outputs(), [0.125, 0.75], "the end of the cell is a stop");
    assert_eq!(controller.output("standard_analog_output0"), Some(Value::Double(1.25)), "volts of ten");
    assert_eq!(controller.output("standard_analog_output1"), Some(Value::Double(0.016)), "4 to 20 mA");
}

#[test]
fn fault_116_an_analog_output_that_is_told_more_than_its_range_is_not_switched_and_a_fault() {
    let controller = controller();
    let fault = fault(with_analog(&controller, 1.5).run());
    assert_eq!(fault.kind(), FaultKind::DriveFault);
    assert!(fault.to_string().contains("is not between 0 and 1, the fraction of its range"), "{fault}");
    // The other one, of the same demand, is switched with what the stop declares.
    assert_eq!(controller.borrow().analog_outputs(), [0.125, 0.75]);
}

#[test]
fn fault_107_the_script_switches_what_is_declared_when_the_cell_is_lost() {
    let mut controller = Controller::new(MODEL, &start()).expect("an arm");
    let off = |number| Outputs::NONE.with(Channel::Digital(number), Level::Digital(false));
    let script = mrroc_ur::Script::new("127.0.0.1:50001".parse().expect("an address"), 9.0);
    let when_lost = off(0).with(Channel::Analog(1), Level::Analog(0.5));
    let script = mrroc_ur::Script { when_lost, ..script };
    // Both are on.
    controller.switch_digital_outputs(1 << 9 | 1);
    assert!(controller.take_script(&script.text()));
    controller.connected(true);
    controller.take_set_point(&mrroc_ur::SetPoint::to(&start().into(), Duration::from_millis(20)).bytes());
    // 20 ms are ten periods.
    (0..11).for_each(|_| controller.step());
    assert_eq!((controller.digital_outputs(), controller.analog_outputs()), (1 << 9 | 1, [0.0; 2]));
    controller.step();
    assert_eq!((controller.digital_outputs(), controller.analog_outputs()), (1 << 9, [0.0, 0.5]));
}

#[test]
fn outputs_that_another_program_switches_are_told() {
    let controller = controller();
    let mut other = Inside::new(Rc::clone(&controller));
    let digital = Groups::of(&Outputs::NONE.with(Channel::Digital(0), Level::Digital(false)));
    mrroc_ur::Wire::connect(&mut other, digital).expect("nobody else");
    let mut second = Inside::new(controller);
    let lost = mrroc_ur::Wire::connect(&mut second, digital).expect_err("in use");
    assert!(lost.0.starts_with("another program switches its outputs"), "{lost:?}");
    mrroc_ur::Wire::connect(&mut second, Groups::NONE).expect("to look is allowed");
}

fn fault(result: Result<RunReport, CellError>) -> Fault {
    match result {
        Err(CellError::Fault(fault)) => fault,
        other => panic!("expected a fault, got {other:?}"),
    }
}

/// Acknowledges and resets as soon as a fault is latched.
fn resets(operator: &mrroc::operator::Operator) {
    if operator.latch() != Latch::Clear {
        let _ = operator.acknowledge();
        let _ = operator.reset();
    }
}

#[test]
fn no_set_point_of_100_000_periods_is_missed() {
    let controller = controller();
    let wire = Inside::new(Rc::clone(&controller)).slow_by(5e-5);
    let report = cell(wire, 134).run().expect("no fault");
    let controller = controller.borrow();
    let periods = ((controller.timestamp() - 100.0) / 0.002).round();
    assert!(periods >= 100_000.0, "{periods} periods, {report:?}");
    assert_eq!(controller.longest_gap(), 0);
    // Told in µrad.
    assert!((controller.target() - start()).amax() <= 0.5e-6, "{}", controller.target());
}

#[test]
fn set_points_that_are_lost_for_less_than_the_read_timeout_stop_nothing() {
    let controller = controller();
    // 20 ms are ten periods.
    let wire = Inside::new(Rc::clone(&controller)).losing(|count| count % 250 >= 240 && count % 250 < 249);
    cell(wire, 4).run().expect("no fault");
    let controller = controller.borrow();
    assert_eq!(controller.longest_gap(), 9);
    assert!((controller.target() - start()).amax() <= 0.5e-6, "{}", controller.target());
}

#[test]
fn fault_90_set_points_that_are_lost_for_longer_end_the_script_and_are_told_as_communication_lost() {
    let controller = controller();
    let lost = |count| (600..620).contains(&count);
    let fault = fault(cell(Inside::new(Rc::clone(&controller)).losing(lost), 1).run());
    assert_eq!(fault.kind(), FaultKind::RobotStopped);
    assert_eq!(fault.robot_stop(), Some((StopCause::CommunicationLost, ClearedBy::Operator)));
    assert!(fault.to_string().contains("set-points did not come in time"), "{fault}");
}

#[test]
fn fault_90_only_a_reset_sends_the_script_again_and_the_program_begins_where_the_arm_stands() {
    let controller = controller();
    let lost = |count| (600..620).contains(&count);
    let seen = Rc::clone(&controller);
    let (stood, resumed) = (Rc::new(Shared::new(0)), Rc::new(Shared::new(false)));
    let (stands, resumes) = (Rc::clone(&stood), Rc::clone(&resumed));
    cell(Inside::new(Rc::clone(&controller)).losing(lost), 1)
        .after_fault(AfterFault::AwaitReset)
        .on_step(move |_, operator| {
            let controller = seen.borrow();
            // For a second after the fault nobody asks for a reset.
            if operator.latch() != Latch::Clear && stands.get() < 500 {
                stands.set(stands.get() + 1);
                if stands.get() > 250 {
                    assert!(!controller.runs(), "the script is gone");
                    assert_eq!(controller.target_speed(), Six::zeros());
                }
                if stands.get() == 500 {
                    resumes.set(true);
                }
            } else {
                drop(controller);
                resets(operator);
            }
        })
        .run()
        .expect("the program begins again, and ends");
    assert!(resumed.get());
    assert!((controller.borrow().target() - start()).amax() <= 0.5e-6);
}

/// Runs until something is pressed, in step 600; the fault.
fn pressed(press: Press) -> Fault {
    let controller = controller();
    let seen = Rc::clone(&controller);
    let hook = move |step, _: &mrroc::operator::Operator| {
        if step == 600 {
            seen.borrow_mut().press(press);
        }
    };
    fault(cell(Inside::new(controller), 1).on_step(hook).run())
}

#[test]
fn fault_91_a_protective_stop_is_released_by_a_reset_which_moves_nothing() {
    let stop = pressed(Press::Collide);
    assert_eq!(stop.robot_stop(), Some((StopCause::ProtectiveStop, ClearedBy::Operator)));

    let controller = controller();
    let seen = Rc::clone(&controller);
    let stood = Rc::new(RefCell::new(None::<Six>));
    let stands = Rc::clone(&stood);
    cell(Inside::new(Rc::clone(&controller)), 1)
        .after_fault(AfterFault::AwaitReset)
        .on_step(move |step, operator| {
            if step == 600 {
                seen.borrow_mut().press(Press::Collide);
            }
            // It stands half a second later, and stays there until the cell is clear again.
            if operator.latch() != Latch::Clear && step > 850 {
                let target = seen.borrow().target();
                let first = *stands.borrow_mut().get_or_insert(target);
                // The drives come on where the encoders say that the arm is.
                assert!((target - first).amax() < 1e-3, "{step}");
            }
            resets(operator);
        })
        .run()
        .expect("the program begins again, and ends");
    // A controller is not asked to release it before five seconds.
    assert!(controller.borrow().timestamp() > 100.0 + 1.2 + 5.0);
    assert!(stood.borrow().is_some());
    assert!((controller.borrow().target() - start()).amax() <= 0.5e-6);
}

#[test]
fn fault_91_a_jump_of_set_points_is_a_protective_stop_of_the_controller() {
    let mut controller = Controller::new(MODEL, &start()).expect("an arm");
    let script = mrroc_ur::Script::new("127.0.0.1:50001".parse().expect("an address"), 9.0);
    assert!(controller.take_script(&script.text()));
    controller.connected(true);
    let timeout = Duration::from_millis(20);
    let tell = |q: Six, controller: &mut Controller| {
        controller.take_set_point(&mrroc_ur::SetPoint::to(&q.into(), timeout).bytes());
        controller.step();
    };
    tell(start(), &mut controller);
    // 180 degrees a second are 94.2 mrad within a lookahead of 30 ms.
    tell(start() + Six::repeat(90e-3), &mut controller);
    assert_eq!(controller.dashboard("safetymode"), "Safetymode: NORMAL");
    tell(start() + Six::repeat(95e-3), &mut controller);
    assert_eq!(controller.dashboard("safetymode"), "Safetymode: PROTECTIVE_STOP");
}

#[test]
fn fault_92_stops_that_need_a_person_are_named_and_a_reset_does_not_touch_them() {
    let cases = [
        (Press::EmergencyStop, Press::ReleaseEmergencyStop, StopCause::EmergencyStop),
        (Press::OpenDoor, Press::CloseDoor, StopCause::Safeguard),
        (Press::Violate, Press::Violate, StopCause::Violation),
        (Press::Freedrive, Press::ReleaseFreedrive, StopCause::HandGuiding),
    ];
    for (press, release, cause) in cases {
        assert_eq!(pressed(press).robot_stop(), Some((cause, ClearedBy::PersonAtRobot)), "{press:?}");
        if press == release {
            continue;
        }
        let controller = controller();
        let seen = Rc::clone(&controller);
        cell(Inside::new(Rc::clone(&controller)), 1)
            .after_fault(AfterFault::AwaitReset)
            .on_step(move |step, operator| {
                let mut controller = seen.borrow_mut();
                match step {
                    600 => controller.press(press),
                    // A person clears it, and gives power where that is gone.
                    2000 => {
                        controller.press(release);
                        controller.dashboard("brake release");
                    }
                    900..2000 => {
                        assert!(operator.latch() != Latch::Clear, "a reset has cleared {press:?}");
                        assert_eq!(controller.target_speed(), Six::zeros());
                    }
                    _ => {}
                }
                drop(controller);
                resets(operator);
            })
            .run()
            .expect("the program begins again, and ends");
        assert!((controller.borrow().target() - start()).amax() <= 0.5e-6, "{press:?}");
    }
}

#[test]
fn fault_93_a_script_that_is_ended_or_paused_at_the_robot_is_told_and_sent_again_only_in_remote_control() {
    for press in [Press::StopProgram, Press::PauseProgram] {
        let stop = pressed(press);
        assert_eq!(stop.robot_stop(), Some((StopCause::ProgramNotRunning, ClearedBy::Operator)), "{press:?}");
        let controller = controller();
        let seen = Rc::clone(&controller);
        cell(Inside::new(Rc::clone(&controller)), 1)
            .after_fault(AfterFault::AwaitReset)
            .on_step(move |step, operator| {
                let mut controller = seen.borrow_mut();
                match step {
                    600 => {
                        controller.press(press);
                        controller.press(Press::TakeOver);
                    }
                    900..2000 => assert!(operator.latch() != Latch::Clear, "{press:?}"),
                    2000 => controller.press(Press::GiveBack),
                    _ => {}
                }
                drop(controller);
                resets(operator);
            })
            .run()
            .expect("the program begins again, and ends");
        assert!((controller.borrow().target() - start()).amax() <= 0.5e-6, "{press:?}");
    }
}

#[test]
fn drives_that_are_in_a_protective_stop_when_the_cell_starts_are_released_by_a_reset() {
    let controller = controller();
    controller.borrow_mut().press(Press::Collide);
    (0..2500).for_each(|_| controller.borrow_mut().step());
    let at_start = fault(cell(Inside::new(Rc::clone(&controller)), 1).run());
    assert_eq!(at_start.robot_stop(), Some((StopCause::ProtectiveStop, ClearedBy::Operator)));
    assert_eq!(controller.borrow_mut().dashboard("safetymode"), "Safetymode: PROTECTIVE_STOP");
    cell(Inside::new(Rc::clone(&controller)), 1)
        .after_fault(AfterFault::AwaitReset)
        .on_step(|_, operator| resets(operator))
        .run()
        .expect("the program begins again, and ends");
}

#[test]
fn a_calibrated_arm_is_where_its_controller_says() {
    let mut calibration = Calibration::nominal(MODEL);
    for i in 0..6 {
        calibration.theta[i] += 1e-3 * (0.3 + i as f64).sin();
        calibration.alpha[i] += 1e-3 * (1.3 + i as f64).sin();
        calibration.a[i] += 1e-3 * (2.3 + i as f64).sin();
        calibration.d[i] += 1e-3 * (3.3 + i as f64).sin();
    }
    let controller = controller();
    controller.borrow_mut().calibrate(&calibration).expect("a UR5e");
    let arm = MODEL.calibrated(Pose::identity(), &calibration).expect("the same");
    let nominal = MODEL.arm(Pose::identity()).expect("an arm");
    let any = "127.0.0.1:0".parse().expect("an address");
    let settings = UrSettings {
        calibration: Some(calibration),
        ..UrSettings::new(MODEL, "127.0.0.1".parse().expect("one"), any)
    };
    let drives = Ur::over(Inside::new(Rc::clone(&controller)), settings);
    let setup = RobotSetup::new("arm", arm.clone(), drives).following_error(MODEL.velocities() * 0.06);
    // A line of 0.2 m in the world, by the arm's own dimensions.
    let from = arm.forward(&start());
    let to = Pose::from_parts(
        (from.translation.vector + nalgebra::Vector3::new(0.0, -0.2, 0.0)).into(),
        from.rotation,
    );
    Cell::new(STEP)
        .robot(setup)
        .program(move |mp: &mut Mp| {
            let mut arm = mp.robot::<Serial<6>>("arm")?;
            let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
            let line = StraightLine::to(to, ToolLimits { translation: limits, rotation: limits });
            mp.move_robot(&mut arm, (), line)?;
            Ok(())
        })
        .run()
        .expect("no fault");
    let controller = controller.borrow();
    let Some(Value::Vector6d(told)) = controller.output("target_TCP_pose") else { panic!("no pose") };
    let told = nalgebra::Vector3::new(told[0], told[1], told[2]);
    // Joints are told in microradians.
    assert!((told - to.translation.vector).norm() < 3e-6, "{told} {}", to.translation.vector);
    let off = (nominal.forward(&controller.target()).translation.vector - told).norm();
    assert!(off > 2e-4, "the nominal arm would be {off} m off");
}

#[test]
fn the_slider_slows_the_path_of_the_whole_cell_and_the_path_is_kept() {
    let controller = controller();
    let other = MODEL.arm(Pose::translation(0.0, 2.0, 0.0)).expect("an arm");
    let simulated = Simulated::new(other.clone(), &start());
    // Each joint of both arms goes the same share of its displacement at the same time: to there and back, at 1 rad/s of joint 1.
    let displacement = there() - start();
    let seen = Rc::new(RefCell::new(Vec::new()));
    let (sees, watched) = (Rc::clone(&seen), Rc::clone(&controller));
    cell(Inside::new(Rc::clone(&controller)), 0)
        .robot(RobotSetup::new("other", other, simulated))
        .program(|mp| {
            let mut arms = (mp.robot::<Serial<6>>("arm")?, mp.robot::<Serial<6>>("other")?);
            let to = |goal| JointMove::to(goal, Six::repeat(1.0), Six::repeat(4.0));
            for goal in [there(), start()].repeat(4) {
                mp.move_robots((&mut arms.0, &mut arms.1), (), Each::of((to(goal), to(goal))))?;
            }
            Ok(())
        })
        .on_step(move |step, _| {
            let mut controller = watched.borrow_mut();
            match step {
                // On a path, as all are.
                1000 => controller.set_speed_fraction(0.5),
                2000 => controller.set_speed_fraction(1.0),
                _ => {}
            }
            sees.borrow_mut().push((step, controller.target(), controller.target_speed()));
        })
        .run()
        .expect("no fault");
    let seen = seen.borrow();
    let mut fastest = [0.0_f64; 3];
    for (step, target, speed) in seen.iter() {
        let share = (target[0] - start()[0]) / displacement[0];
        let off = (target - (start() + displacement * share)).amax();
        assert!(off < 3e-6, "{off} rad off the path in step {step}");
        // A second for the rate to change.
        match step {
            0..1000 => fastest[0] = fastest[0].max(speed[0].abs()),
            1500..2000 => fastest[1] = fastest[1].max(speed[0].abs()),
            2500.. => fastest[2] = fastest[2].max(speed[0].abs()),
            _ => {}
        }
    }
    assert!((fastest[0] - 1.0).abs() < 1e-3 && (fastest[2] - 1.0).abs() < 1e-3, "{fastest:?}");
    assert!((fastest[1] - 0.5).abs() < 1e-3, "{fastest:?}");
}
