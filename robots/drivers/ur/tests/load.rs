//! What the arm carries, told to the controller of `mrroc-ur-controller` in one process and under the virtual clock: fault
//! 118 in docs/safety, and when it is told.

use core::cell::{Cell as Shared, RefCell};
use core::time::Duration;
use std::rc::Rc;

use mrroc::cell::{AfterFault, Cell, CellError, RobotSetup};
use mrroc::fault::{Fault, FaultKind};
use mrroc::operator::Latch;
use mrroc::prelude::*;
use mrroc::robot::{ClearedBy, Load, StopCause, Tool};
use mrroc_generators::generators::{JointMove, Tell};
use mrroc_robots::{Serial, Six};
use mrroc_ur::rtde::Value;
use mrroc_ur::{Ur, UrModel, UrSettings};
use mrroc_ur_controller::{Controller, Inside, Press};
use nalgebra::Matrix3;

const MODEL: UrModel = UrModel::Ur5e;

fn start() -> Six {
    Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0)
}

fn there() -> Six {
    start() + Six::new(0.5, -0.2, 0.2, 0.0, 0.3, 0.0)
}

/// A drill: kg, m, kg m².
fn drill() -> Tool {
    let inertia = Matrix3::new(2e-3, 1e-4, -2e-4, 1e-4, 3e-3, 5e-5, -2e-4, 5e-5, 4e-3);
    let load = Load { mass: 1.25, centre: [0.01, -0.02, 0.1].into(), inertia };
    Tool { frame: Pose::translation(0.0, 0.0, 0.15), load }
}

/// A controller with 0.4 kg in its installation.
fn controller() -> Rc<RefCell<Controller>> {
    let mut controller = Controller::new(MODEL, &start()).expect("an arm");
    controller.install_payload(&installed());
    Rc::new(RefCell::new(controller))
}

fn installed() -> Load {
    Load::point(0.4, [0.0, 0.0, 0.03].into())
}

/// A cell without a program.
fn cell(wire: Inside) -> Cell {
    let any = "127.0.0.1:0".parse().expect("an address");
    let settings = UrSettings::new(MODEL, "127.0.0.1".parse().expect("one"), any);
    let arm = MODEL.arm(Pose::identity()).expect("an arm");
    let setup = RobotSetup::new("arm", arm, Ur::over(wire, settings));
    Cell::new(Duration::from_millis(2)).robot(setup.following_error(MODEL.velocities() * 0.06))
}

fn fault(cell: Cell) -> Fault {
    match cell.run() {
        Err(CellError::Fault(fault)) => fault,
        other => panic!("expected a fault, got {other:?}"),
    }
}

fn go_to(goal: Six) -> JointMove<Serial<6>> {
    JointMove::to(goal, Six::repeat(1.0), Six::repeat(4.0))
}

#[test]
fn a_load_reaches_the_controller_before_tell_is_over_and_again_after_its_program_has_started_anew() {
    let controller = controller();
    let (seen, presses) = (Rc::clone(&controller), Rc::clone(&controller));
    let (runs, resets_left) = (Rc::new(Shared::new(0)), Shared::new(1));
    let began = Rc::clone(&runs);
    cell(Inside::new(Rc::clone(&controller)))
        .after_fault(AfterFault::AwaitReset)
        .program(move |mp| {
            let mut arm = mp.robot::<Serial<6>>("arm")?;
            began.set(began.get() + 1);
            let payload = || seen.borrow().payload();
            if began.get() == 1 {
                mp.move_robot(&mut arm, (), go_to(start() + Six::repeat(0.01)))?;
                assert_eq!(payload(), installed(), "nothing was said of it");
                mp.move_robot(&mut arm, (), Tell::tool(drill()))?;
                // As RTDE tells it: xx, yy, zz, xy, xz, yz. A demand carries seven digits of it, and the wire mg m².
                let inertia = seen.borrow().output("payload_inertia");
                let Some(Value::Vector6d(inertia)) = inertia else { panic!("{inertia:?}") };
                let expected = [2e-3, 3e-3, 4e-3, 1e-4, -2e-4, 5e-5];
                assert!(inertia.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{inertia:?}");
            }
            for goal in [there(), start()] {
                mp.move_robot(&mut arm, (), go_to(goal))?;
                let Load { mass, centre, .. } = payload();
                assert_eq!((mass, centre), (1.25, [0.01, -0.02, 0.1].into()));
            }
            Ok(())
        })
        .on_step(move |step, operator| {
            // The program at the controller ends with a protective stop.
            if step == 800 {
                presses.borrow_mut().press(Press::Collide);
            }
            // Once: whatever else goes wrong ends the test.
            if resets_left.get() > 0 && operator.latch() != Latch::Clear {
                let _ = operator.acknowledge();
                if operator.reset().is_ok() {
                    resets_left.set(0);
                }
            }
        })
        .run()
        .expect("the program begins again, and ends");
    // The second time the controller ran another program, which began with what is installed.
    assert_eq!(runs.get(), 2);
}

/// Goes half a radian in a second, on a cosine, and says half-way what it carries.
struct Lifting(f64);

#[generator(mp)]
fn lifting(c: &mut Lifting, t: Tick) -> Step<(Serial<6>,)> {
    if c.0 >= 1.0 {
        return Step::Done;
    }
    let before = c.0;
    c.0 = (c.0 + t.dt).min(1.0);
    let says = before < 0.5 && c.0 >= 0.5;
    let part = (1.0 - (core::f64::consts::PI * c.0).cos()) / 2.0;
    let demand = Demand::joints(start() + (there() - start()) * part);
    Step::Next((if says { demand.with_load(drill().load) } else { demand },))
}

#[test]
fn an_arm_that_moves_is_told_when_it_has_come_to_rest_and_before_the_next_motion_begins() {
    let controller = controller();
    let seen = Rc::clone(&controller);
    let told = Rc::new(RefCell::new(Vec::new()));
    let tells = Rc::clone(&told);
    let last = Shared::new(installed().mass);
    let fastest = Shared::new(0.0_f64);
    cell(Inside::new(Rc::clone(&controller)))
        .program(move |mp| {
            let mut arm = mp.robot::<Serial<6>>("arm")?;
            mp.move_robots((&mut arm,), (), Lifting(0.0))?;
            mp.move_robot(&mut arm, (), go_to(start())).map(drop)
        })
        .on_step(move |_, _| {
            let controller = seen.borrow();
            let (mass, speed) = (controller.payload().mass, controller.target_speed().amax());
            fastest.set(fastest.get().max(speed));
            if mass != last.replace(mass) {
                tells.borrow_mut().push((mass, speed, (controller.target() - there()).amax(), fastest.get()));
            }
        })
        .run()
        .expect("no fault");
    let told = told.borrow();
    let [(mass, speed, off, before)] = told[..] else { panic!("{told:?}") };
    // It has gone at pi / 4 rad/s, has come to rest, and stands where that motion has ended.
    assert!((before - core::f64::consts::FRAC_PI_4).abs() < 0.01, "{before} rad/s");
    assert!(mass == 1.25 && speed <= 1e-3 && off < 1e-4, "{told:?}");
}

#[test]
fn fault_118_a_load_that_the_controller_refuses_is_told_as_such() {
    let too_heavy = Load::point(MODEL.payload() + 1.0, [0.0, 0.0, 0.1].into());
    // Body or not, a moment beyond 133 kg m² is none that URScript takes.
    let too_long = Load { inertia: Matrix3::from_diagonal(&[150.0, 150.0, 1.0].into()), ..drill().load };
    for load in [too_heavy, too_long] {
        let controller = controller();
        let cell = cell(Inside::new(Rc::clone(&controller))).program(move |mp| {
            let mut arm = mp.robot::<Serial<6>>("arm")?;
            mp.move_robot(&mut arm, (), Tell::tool(Tool { load, ..drill() })).map(drop)
        });
        let fault = fault(cell);
        assert_eq!(fault.kind(), FaultKind::RobotStopped);
        assert!(fault.to_string().contains("ended its script when it was told the load"), "{fault}");
        assert_eq!(controller.borrow().payload(), installed());
    }
}

#[test]
fn fault_118_a_load_that_the_controller_does_not_tell_back_is_a_fault_within_its_time() {
    let controller = controller();
    let (steps, counts) = (Rc::new(Shared::new(0)), Rc::new(Shared::new(0)));
    let (began, now) = (Rc::clone(&steps), Rc::clone(&counts));
    let cell = cell(Inside::new(Rc::clone(&controller)).deaf_to_loads())
        .program(move |mp| {
            let mut arm = mp.robot::<Serial<6>>("arm")?;
            began.set(now.get());
            mp.move_robot(&mut arm, (), Tell::tool(drill())).map(drop)
        })
        .on_step(move |step, _| counts.set(step));
    let fault = fault(cell);
    assert_eq!(fault.kind(), FaultKind::DriveFault);
    assert!(fault.to_string().contains("does not tell by RTDE the load"), "{fault}");
    // An arm that stands is told within some steps of 2 ms, and the controller has 100 ms.
    let took = fault.step().expect("a step") - steps.get();
    assert!((50..60).contains(&took), "{took} steps");
}

#[test]
fn a_stop_that_needs_a_person_is_told_as_that_while_a_load_is_not_taken_yet() {
    let controller = controller();
    let (presses, tells) = (Rc::clone(&controller), Rc::new(Shared::new(None)));
    let told = Rc::clone(&tells);
    let cell = cell(Inside::new(Rc::clone(&controller)).deaf_to_loads())
        .program(move |mp| {
            let mut arm = mp.robot::<Serial<6>>("arm")?;
            told.set(Some(mp.step()));
            mp.move_robot(&mut arm, (), Tell::tool(drill())).map(drop)
        })
        .on_step(move |step, _| {
            // The controller has 50 steps for its answer.
            if tells.get().is_some_and(|told| step == told + 20) {
                presses.borrow_mut().press(Press::EmergencyStop);
            }
        });
    let fault = fault(cell);
    assert_eq!(fault.robot_stop(), Some((StopCause::EmergencyStop, ClearedBy::PersonAtRobot)));
}
