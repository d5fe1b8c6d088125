//! The dynamic behaviour of a robot, and its redundancy, chosen by a demand.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, Measured, Regulators};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault, gantry};

/// An exact drive with three parameter sets in its first joint, which writes down what is chosen, by tick.
struct Tuned {
    drive: ExactDrive<3>,
    ticks: u64,
    chosen: Rc<RefCell<Vec<(u64, Regulators)>>>,
}

impl Driver<Gantry> for Tuned {
    fn period(&self) -> Duration {
        MS
    }

    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::measured(&self.drive)
    }

    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        self.ticks += 1;
        Driver::<Gantry>::tick(&mut self.drive, demanded)
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        set == 0 || (joint == 0 && set < 3)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.chosen.borrow_mut().push((self.ticks, *sets));
    }
}

/// Holds, and chooses a set in its 5th and its 9th step.
struct Choose {
    step: u32,
    sets: [Regulators; 2],
}

#[generator(ecp)]
fn choose(c: &mut Choose) -> Step<Gantry> {
    c.step += 1;
    match c.step {
        5 => Step::Next(Demand::hold().with_regulators(c.sets[0])),
        9 => Step::Next(Demand::hold().with_regulators(c.sets[1])),
        20.. => Step::Done,
        _ => Step::Next(Demand::hold()),
    }
}

#[test]
fn a_demand_chooses_the_regulators_from_its_own_step_on() {
    let chosen = Rc::<RefCell<Vec<(u64, Regulators)>>>::default();
    let drive = Tuned { drive: ExactDrive::at_origin(), ticks: 0, chosen: Rc::clone(&chosen) };
    let sets = [Regulators::default().with(0, 2), Regulators::uniform(0)];
    let robot = RobotSetup::new("g", Gantry::default(), drive)
        .program(move |ecp| ecp.move_robot((), Choose { step: 0, sets }).map(drop));
    Cell::new(MS).robot(robot).run().expect("sets that are there");
    let chosen = chosen.borrow();
    let [(first, soft), (second, usual)] = chosen[..] else { panic!("{chosen:?}") };
    assert_eq!((soft, usual), (sets[0], sets[1]));
    assert_eq!((soft.set(0), soft.set(1), soft.set(7), soft.set(8)), (2, 0, 0, 0));
    assert_eq!(second - first, 4, "chosen before ticks {first} and {second}");
    // START comes in step 1; the demand of the generator's 5th step in step 5, before whose tick there were those of 0 to 4.
    assert_eq!(first, 5, "of another step");
}

#[test]
fn a_parameter_set_that_a_drive_does_not_have_is_a_fault_with_the_joint() {
    for (sets, joint) in [(Regulators::uniform(1), 1), (Regulators::default().with(0, 3), 0)] {
        let drive = Tuned { drive: ExactDrive::at_origin(), ticks: 0, chosen: Rc::default() };
        let robot = RobotSetup::new("g", Gantry::default(), drive)
            .program(move |ecp| ecp.move_robot((), Choose { step: 0, sets: [sets; 2] }).map(drop));
        let fault = fault(Cell::new(MS).robot(robot).run());
        assert_eq!((fault.kind(), fault.joint()), (FaultKind::NoRegulator, Some(joint)), "{fault}");
        assert!(fault.to_string().contains(&format!("parameter set {}", sets.set(joint))), "{fault}");
    }
}

/// One demand.
struct Once(Option<Demand<Gantry>>);

#[generator(ecp)]
fn once(c: &mut Once) -> Step<Gantry> {
    c.0.take().map_or(Step::Done, Step::Next)
}

#[test]
fn a_redundancy_is_for_poses_of_robots_that_have_one() {
    let pose = mrroc::pose::Pose::identity();
    for (demand, kind, text) in [
        (
            Demand::pose(pose).with_redundancy(0.2),
            FaultKind::NoInverseKinematics,
            "redundancy is demanded of a robot",
        ),
        (Demand::pose(pose).with_redundancy(f64::NAN), FaultKind::DemandNotFinite, "the redundancy"),
        (Demand::hold().with_redundancy(0.2), FaultKind::Program, "not for joint positions"),
        (Demand::joints(Q::<3>::zeros()).with_redundancy(0.2), FaultKind::Program, "not for joint positions"),
    ] {
        let (robot, _) = gantry("g");
        let robot = robot.program(move |ecp| ecp.move_robot((), Once(Some(demand))).map(drop));
        let fault = fault(Cell::new(MS).robot(robot).run());
        assert_eq!(fault.kind(), kind, "{fault}");
        assert!(fault.to_string().contains(text), "{fault}");
    }
}
