//! Simulators that hang, end, lie, or are not alone.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use iceoryx2::prelude::*;
use mrroc::cell::{AfterFault, CellError};
use mrroc::fault::Name;
use mrroc::fault::{FaultKind, ProcessId, Role};
use mrroc::link::Clock;
use mrroc::operator::Latch;
use mrroc::prelude::*;
use mrroc::robot::{Begin, DriveFault, Driver, IdealDrives, Measured, Simulator as _};
use mrroc_counting_allocator::count;
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::{Irp6, Six};

use super::simulator::{Robot, Simulator};
use super::{Folder, two_arms, two_arms_of};
use crate::plant::message::{PlantRequest, PlantState, Says, name_of};
use crate::plant::{ENDED, LATE, NO_PORT, NONE_THERE, Plant, SILENT, TOO_LATE};
use crate::port::Ends;

const ARMS: [&str; 2] = ["left", "right"];

/// With a short timeout, where what is waited for does not come. Elsewhere the machine may be late.
const SHORT: &str = ", timeout_ms = 400";

fn edp(robot: &str) -> ProcessId {
    ProcessId::new(Role::Edp, Name::new(robot).expect("a name"))
}

/// The fault with which a cell ends in a simulator that answers so.
fn fault_of(
    timeout: &str,
    name: &str,
    answer: impl FnMut(&str, u64, PlantState) -> Option<PlantState> + Send + 'static,
) -> Fault {
    let folder = Folder::new(name);
    let mut answer = answer;
    let simulator =
        Simulator::answering(&folder.0, &ARMS, move |robot, order, state| answer(robot, order.period, state));
    let outcome = folder.cell(&two_arms(timeout)).run();
    simulator.end();
    match outcome {
        Err(CellError::Fault(fault)) => fault,
        other => panic!("{name}: {other:?}"),
    }
}

#[test]
fn fault_125_a_simulator_that_is_not_there_hangs_or_ends_is_told_and_stops_the_cell() {
    let folder = Folder::new("nobody");
    let Err(CellError::Fault(fault)) = folder.cell(&two_arms(SHORT)).run() else { panic!("nobody is there") };
    assert_eq!(fault.kind(), FaultKind::RobotStopped);
    assert!(fault.to_string().contains(NONE_THERE.to_string().as_str()), "{fault}");

    let fault = fault_of(SHORT, "hangs", |_, period, state| (period < 200).then_some(state));
    assert_eq!((fault.kind(), fault.process()), (FaultKind::RobotStopped, Some(edp("left"))));
    assert!(fault.to_string().contains(SILENT.to_string().as_str()), "{fault}");
}

#[test]
fn fault_125_a_simulator_that_ends_in_mid_motion_stops_all_robots() {
    const ENDS_IN: u64 = 200;
    let folder = Folder::new("ends");
    let simulator = RefCell::new(Some(Simulator::of(&folder.0, &["left"])));
    let told = Rc::new(RefCell::new(Vec::new()));
    let seen = Rc::clone(&told);
    // The right arm has drives of its own. The default timeout of ten seconds is not waited for.
    let cell = folder.cell(&two_arms_of("plant = { port = \"world\" }", "")).watch(move |robot| {
        if robot.robot == "right" {
            seen.borrow_mut().push(robot.demanded[0]);
        }
    });
    let cell = cell.on_step(move |step, _| {
        if step == ENDS_IN {
            simulator.take().map(Simulator::end);
        }
    });
    let bound = cell.stop_steps();
    let Err(CellError::Fault(fault)) = cell.run() else { panic!("the simulator has ended") };
    assert_eq!((fault.kind(), fault.process()), (FaultKind::RobotStopped, Some(edp("left"))));
    assert!(fault.to_string().contains(ENDED.to_string().as_str()), "{fault}");
    // Its servo periods are as long as steps.
    let told = told.borrow();
    let last = told.windows(2).rposition(|two| two[0] != two[1]).expect("it moved") as u64;
    assert!((ENDS_IN..ENDS_IN + bound).contains(&last), "{last}, {bound}");
    assert!(told[told.len() - 1] > -0.2 && told.len() as u64 > last + 2, "it stands, and not at its goal");
}

#[test]
fn fault_122_what_a_simulator_answers_and_cannot_be_is_named_with_its_robot() {
    type Lie = fn(PlantState) -> PlantState;
    let lies: [(&str, Lie, &str); 7] = [
        (
            "nan",
            |mut state| {
                state.position[2] = f64::NAN;
                state
            },
            "not finite",
        ),
        (
            "wrench",
            |mut state| {
                state.wrench[5] = f64::INFINITY;
                state
            },
            "not finite",
        ),
        ("other", |state| PlantState { robot: name_of("left"), ..state }, "for another robot"),
        ("version", |state| PlantState { version: 2, ..state }, "another version of the port"),
        ("layout", |state| PlantState { layout: 1, session: 0, ..state }, "another version of the port"),
        ("joints", |state| PlantState { joints: 5, ..state }, "another number of joints"),
        ("future", |state| PlantState { period: state.period + 1, ..state }, "has not begun"),
    ];
    for (name, lie, told) in lies {
        let fault = fault_of("", name, move |robot, period, state| {
            Some(if robot == "right" && period == 200 { lie(state) } else { state })
        });
        assert_eq!((fault.kind(), fault.process()), (FaultKind::DriveFault, Some(edp("right"))), "{name}");
        assert!(fault.to_string().contains(told), "{name}: {fault}");
    }
    let failed = |robot: &str, period, state| {
        let fails = robot == "left" && period == 100;
        Some(if fails { PlantState { kind: Says::Failed as u32, ..state } } else { state })
    };
    assert!(fault_of("", "failed", failed).to_string().contains("cannot go on"));
}

#[test]
fn fault_122_after_a_lie_the_other_robot_brakes_in_the_simulator_and_a_reset_begins_where_both_stand() {
    let folder = Folder::new("reset");
    let simulator = Simulator::answering(&folder.0, &ARMS, |robot, order, mut state| {
        if robot == "right" && order.period == 200 {
            state.position[0] = f64::NAN;
        }
        Some(state)
    });
    let ends = Rc::new(RefCell::new(Vec::new()));
    let seen = Rc::clone(&ends);
    let cell = folder.cell(&two_arms("")).after_fault(AfterFault::AwaitReset).watch(move |robot| {
        seen.borrow_mut().push((robot.robot.to_owned(), robot.measured[0]));
    });
    let cell = cell.on_step(|_, operator| match operator.latch() {
        Latch::Latched => drop(operator.acknowledge()),
        Latch::Acknowledged => drop(operator.reset()),
        Latch::Clear | Latch::Stopping | Latch::Resetting => {}
    });
    cell.run().expect("the second run of the program ends well");
    let periods = simulator.end();
    let asked =
        |kind: PlantRequest| periods.iter().filter(|(_, of)| of.get("left") == Some(&(kind as u32))).count();
    assert!(asked(PlantRequest::Follow) > 500, "the arm that was not lied about brakes, and moves again");
    assert!(asked(PlantRequest::StandBy) > 0, "it has no power between its stop and the reset");
    let ordered: Vec<_> = periods.iter().filter(|(_, of)| of.contains_key("left")).map(|(n, _)| *n).collect();
    assert!(ordered.windows(2).all(|two| two[1] == two[0] + 1), "and orders every period all the same");
    let last = |robot: &str| ends.borrow().iter().rev().find(|(name, _)| name == robot).map(|(_, q)| *q);
    let (left, right) = (last("left").expect("seen"), last("right").expect("seen"));
    // Each turned a part of its displacement before the fault, and 0.2 rad after the reset.
    assert!(left > 0.2 && left < 0.4 && right < -0.2 && right > -0.4, "{left} {right}");
}

#[test]
fn fault_123_a_second_simulator_and_a_second_cell_are_refused_and_the_first_stay() {
    let folder = Folder::new("second");
    let plant =
        |file: &CellFile| Plant::new(file.robots()[0].plant().expect("in a simulator"), folder.0.clone());
    let file = two_arms("");
    let simulator = Simulator::of(&folder.0, &["left"]);
    let start = [0.5; 6];
    let begin = Begin { clock: Clock::Virtual, period: Duration::from_millis(2), start: &start, first: 0 };
    let mut first = plant(&file);
    assert_eq!(first.open(&begin).map(|state| state.position[5]), Ok(0.5));
    assert_eq!(plant(&file).open(&begin), Err(NO_PORT));
    let ends = Ends::open(&folder.0).expect("a node");
    assert!(Robot::open(&ends, "left").is_err_and(|why| why.contains("ExceedsMaxSupportedPublishers")));
    first.step(0, Some(&[1.0; 6])).expect("the first simulator answers");
    let state = first.step(1, Some(&[1.0; 6])).expect("the first simulator answers");
    assert_eq!((state.position[0], state.wrench.map(|wrench| wrench.torque[2])), (0.75, Some(1.0)));
    first.close();
    simulator.end();
    // Messages of another size cannot even be opened.
    let name = ServiceName::new("mrroc/world/right/states").expect("a name");
    let small = ends.node.service_builder(&name).publish_subscribe::<u64>().create().expect("a service");
    let mut right = Plant::new(file.robots()[1].plant().expect("in a simulator"), folder.0.clone());
    assert_eq!(right.open(&begin), Err(NO_PORT));
    drop(small);
}

#[test]
fn fault_123_a_robot_with_a_real_drive_is_refused_a_simulator() {
    struct Real(Six);
    impl Driver<Irp6> for Real {
        fn period(&self) -> Duration {
            Duration::from_millis(2)
        }
        fn measured(&self) -> Result<Measured<Six>, DriveFault> {
            Ok(Measured { position: self.0, velocity: Six::zeros() })
        }
        fn tick(&mut self, _: &Six) -> Result<Measured<Six>, DriveFault> {
            Err(DriveFault::NoAnswer)
        }
        fn hardware(&self) -> Option<String> {
            Some("udp 10.0.0.7:30004".to_owned())
        }
    }
    let folder = Folder::new("real");
    let kinds = folder.kinds().with("irp6", |entry| {
        let robot = Irp6::nominal();
        let start = entry.start(&robot)?;
        Ok(RobotSetup::new(entry.name(), robot, Real(start)))
    });
    let told = two_arms("").cell(&kinds).map(drop).expect_err("real drives").to_string();
    assert!(told.contains("robot `left` has real drives, udp 10.0.0.7:30004, and a simulator"), "{told}");
    let told = two_arms("").cell(&mrroc_robots::simulated()).map(drop).expect_err("no port").to_string();
    assert!(told.contains("this program has no port for one"), "{told}");
    let unhomed = "step_ms = 2\n[robots.arm]\nkind = \"irp6\"\nhomed = false\nstart = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]\nplant = { \
                   port = \"world\" }";
    let file = CellFile::parse("cell.toml", unhomed).expect("well-formed");
    let told = file.cell(&folder.kinds()).map(drop).expect_err("it looks for marks").to_string();
    assert!(told.contains("looks for its reference marks, and is in a simulator"), "{told}");
}

#[test]
fn fault_123_robots_of_one_simulator_must_have_one_servo_period() {
    let folder = Folder::new("periods");
    let kinds = folder.kinds().with("slow", |entry| {
        let robot = Irp6::nominal();
        let start = entry.start(&robot)?;
        let drives = IdealDrives::new(&robot, start, Duration::from_millis(4));
        Ok(RobotSetup::new(entry.name(), robot, drives))
    });
    let start = "start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]\nplant = { port = \"world\" }";
    let text =
        format!("step_ms = 4\n[robots.a]\nkind = \"irp6\"\n{start}\n[robots.b]\nkind = \"slow\"\n{start}");
    let file = CellFile::parse("cell.toml", &text).expect("well-formed");
    let told = file.cell(&kinds).map(drop).expect_err("two periods").to_string();
    let words = "robots `a` and `b` share a simulator and have servo periods of 2 ms and 4 ms";
    assert!(told.contains(words), "{told}");
}

#[test]
fn fault_124_answers_that_are_late_in_real_time_are_counted_and_too_many_are_a_fault() {
    let folder = Folder::new("late");
    let file = two_arms("");
    let mut plant = Plant::new(file.robots()[0].plant().expect("in a simulator"), folder.0.clone());
    let ends = Ends::open(&folder.0).expect("a node");
    let mut robot = Robot::open(&ends, "left").expect("the only simulator");
    let period = Duration::from_millis(2);
    let start = [0.5; 6];
    let begin = Begin { clock: Clock::Real, period, start: &start, first: 0 };
    assert_eq!(plant.open_again(&begin), Ok(None), "it returns at once");
    robot.hear();
    let asked = robot.queue.pop().expect("an order to begin");
    assert_eq!((asked.kind, asked.clock, asked.demanded[0]), (PlantRequest::Begin as u32, 1, 0.5));
    robot.position = asked.demanded;
    robot.send(robot.state(&asked, Says::Placed));
    assert!(plant.open_again(&begin).expect("it is there").is_some());
    let in_a_row = u64::try_from(LATE.as_nanos() / period.as_nanos()).expect("few");
    // The first period has no answer to wait for.
    for n in 0..in_a_row {
        assert_eq!(plant.step(n, Some(&[0.6; 6])).expect("not too late yet").position[0], 0.5, "{n}");
    }
    robot.hear();
    let last = robot.queue.pop().expect("an order");
    assert_eq!((last.period, last.late), (in_a_row - 1, in_a_row - 1));
    robot.position = [0.55; 8];
    robot.send(robot.state(&last, Says::Stepped));
    let state = plant.step(in_a_row, Some(&[0.6; 6])).expect("in time again");
    assert_eq!(state.position[0], 0.55);
    for n in 1..in_a_row {
        assert!(plant.step(in_a_row + n, Some(&[0.6; 6])).is_ok(), "{n}");
    }
    assert_eq!(plant.step(2 * in_a_row, Some(&[0.6; 6])), Err(TOO_LATE));
    robot.hear();
    let last = robot.queue.pop().expect("an order");
    assert_eq!((last.kind, last.late), (PlantRequest::End as u32, 2 * in_a_row - 1));
}

#[test]
fn a_servo_period_allocates_nothing_but_what_iceoryx2_takes_to_lend_a_sample() {
    for clock in [Clock::Virtual, Clock::Real] {
        let folder = Folder::new(&format!("memory-{clock:?}"));
        let simulator = Simulator::of(&folder.0, &["left"]);
        let file = two_arms("");
        let mut plant = Plant::new(file.robots()[0].plant().expect("in a simulator"), folder.0.clone());
        let start = [0.5; 6];
        let begin = Begin { clock, period: Duration::from_millis(2), start: &start, first: 0 };
        plant.open(&begin).expect("it is there");
        plant.step(0, Some(&start)).expect("in time");
        let lends = || drop(plant.link.as_ref().expect("open").orders.loan_uninit());
        let ((), lent) = count(lends);
        let (stepped, allocations) =
            count(|| (1..20).try_for_each(|n| plant.step(n, Some(&start)).map(drop)));
        assert_eq!((stepped, allocations), (Ok(()), 19 * lent), "{clock:?}");
        plant.close();
        simulator.end();
    }
}
