//! Goals out of reach, which generators name in their first steps.

use core::cell::Cell as Shared;
use std::rc::Rc;
use std::time::Duration;

use mrroc::generator::{Generator, Motion};
use mrroc::observe::ServoRecord;
use mrroc::prelude::*;
use mrroc_generators::generators::JointMove;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

use super::registry::rows;

fn start() -> Six {
    Irp6::READY
}

/// The fault of a Move by the MP, and how far any joint was demanded to go meanwhile \[rad\].
pub fn moved(
    generator: impl Generator<Robots = Irp6, Language = Motion, Sensors = (), Order = ()> + 'static,
) -> (Fault, f64) {
    let irp6 = Irp6::nominal();
    let farthest = Rc::new(Shared::new(0.0_f64));
    let seen = Rc::clone(&farthest);
    let arm = RobotSetup::new("arm", irp6.clone(), SimulatedIrp6::new(irp6, &start())).observe(
        move |record: &ServoRecord<Irp6>| seen.set(seen.get().max((record.demanded - start()).amax())),
    );
    let mut generator = Some(generator);
    let cell = Cell::new(Duration::from_millis(2)).robot(arm).program(move |mp| {
        let mut arm = mp.robot::<Irp6>("arm")?;
        let there_and_back = |goal| JointMove::to(goal, Six::repeat(0.4), Six::repeat(0.8));
        mp.move_robot(&mut arm, (), there_and_back(start() + Six::x() * 0.001))?;
        mp.move_robot(&mut arm, (), there_and_back(start()))?;
        let generator = generator.take().ok_or_else(|| Fault::thrown("once"))?;
        mp.move_robot(&mut arm, (), generator).map(drop)
    });
    match cell.run() {
        Err(mrroc::cell::CellError::Fault(fault)) => (fault, farthest.get()),
        other => panic!("it is out of reach: {other:?}"),
    }
}

/// It is refused for its goal, in the third Move, before anything has moved that a person would see.
#[test]
fn fault_130_a_goal_out_of_reach_is_refused_in_the_first_steps_by_every_generator_that_knows_it() {
    for row in rows() {
        let name = row.type_name;
        for (kind, run) in row.out_of_reach {
            let (fault, farthest) = run();
            let told = fault.to_string();
            assert_eq!(fault.kind(), kind, "{told}");
            assert!(
                told.contains("its goal") && told.contains(&format!("in Move 3 ({name}) at step")),
                "{told}"
            );
            assert!(fault.help().is_some_and(|help| help.contains("goal")), "{told}");
            // The two Moves before go 1 mrad.
            assert!(farthest < 1.1e-3, "{name}: {farthest} rad");
        }
    }
}

#[test]
fn a_motion_names_its_goal_once_and_its_demands_are_the_same() {
    let goal = start() + Six::x() * 0.1;
    let motion = JointMove::to(goal, Six::repeat(0.2), Six::repeat(0.4));
    let demands = mrroc_generators::rehearsal::rehearse(motion, &Irp6::nominal(), start(), 0.002);
    for (i, demand) in demands.expect("in reach").iter().enumerate() {
        let bare = Demand::<Irp6>::joints(demand.as_joints().expect("joints"));
        assert_eq!(*demand, if i == 0 { bare.with_goal(Demand::joints(goal)) } else { bare }, "{i}");
    }
}
