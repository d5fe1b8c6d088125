//! Robots that do not know where they are: no program begins before all of them have found their marks.

use std::cell::Cell as Count;
use std::rc::Rc;
use std::time::Duration;

use mrroc::fault::{Excess, FaultKind};
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Homing, Search};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault, gantry, traced};

use crate::runtime::kit::Smooth;

/// Finds its marks after so many ticks, at 0.1 m along x; trips instead when told to.
struct Blind {
    left: u32,
    trips: bool,
    ticks: Rc<Count<u32>>,
}

impl Blind {
    fn new(ticks: u32) -> (Blind, Rc<Count<u32>>) {
        let count = Rc::<Count<u32>>::default();
        (Blind { left: ticks, trips: false, ticks: Rc::clone(&count) }, count)
    }
}

impl Homing<Gantry> for Blind {
    type Drives = ExactDrive<3>;

    fn period(&self) -> Duration {
        MS
    }

    fn search(mut self) -> Result<Search<Self, ExactDrive<3>>, DriveFault> {
        self.ticks.set(self.ticks.get() + 1);
        self.left -= 1;
        match self.left {
            0 if self.trips => Err(DriveFault::exceeded(
                1,
                "distance to the synchronisation switch",
                Excess::new(0.7, 0.5, "m"),
            )),
            0 => Ok(Search::Found(ExactDrive::new(Q::<3>::new(0.1, 0.0, 0.0), MS))),
            _ => Ok(Search::Searching(self)),
        }
    }
}

#[test]
fn programs_begin_when_the_last_robot_is_homed_and_motions_where_it_was_found() {
    let ((early, _), (late, late_ticks)) = (Blind::new(40), Blind::new(250));
    let (early, early_trace) = traced(RobotSetup::unhomed("early", Gantry::default(), early));
    let (late, late_trace) = traced(RobotSetup::unhomed("late", Gantry::default(), late));
    let (known, known_trace) = gantry("known");
    Cell::new(MS)
        .robot(early)
        .robot(late)
        .robot(known)
        .program(|mp| {
            assert!((250..256).contains(&mp.step()), "step {}", mp.step());
            let (mut early, mut late, mut known) =
                (mp.robot::<Gantry>("early")?, mp.robot::<Gantry>("late")?, mp.robot::<Gantry>("known")?);
            mp.wait_until((&mut early, &mut late, &mut known), (), first_look {})?;
            assert_eq!(late.measured().joints[0], 0.1);
            assert_eq!((early.demanded().joints[0], known.demanded().joints[0]), (0.1, 0.0));
            Ok(())
        })
        .run()
        .expect("all are found");
    assert_eq!(late_ticks.get(), 250, "searched once more");
    // The early one and the one that knew its place held it all the while.
    assert!(known_trace.borrow().len() >= 250 && known_trace.borrow().iter().all(|q| q.norm() == 0.0));
    assert!(early_trace.borrow().len() >= 200 && early_trace.borrow().iter().all(|q| q[0] == 0.1));
    assert!(late_trace.borrow().iter().all(|q| q[0] == 0.1));
}

#[mrroc::condition(mp)]
fn first_look() -> bool {
    true
}

#[test]
fn an_ecp_program_of_a_cell_without_an_mp_program_moves_from_where_its_robot_was_found() {
    let (blind, _) = Blind::new(30);
    let (robot, trace) = traced(RobotSetup::unhomed("g", Gantry::default(), blind));
    let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(0.3, 0.5)).map(drop));
    Cell::new(MS).robot(robot).run().expect("found, then moved");
    let trace = trace.borrow();
    assert_eq!((trace[0][0], trace.last().expect("recorded")[0]), (0.1, 0.3));
}

#[test]
fn a_mark_that_is_not_there_stops_the_cell_with_the_robot_and_its_joint() {
    let (mut blind, ticks) = Blind::new(30);
    blind.trips = true;
    let (robot, _) = traced(RobotSetup::unhomed("g", Gantry::default(), blind));
    let (other, other_trace) = gantry("other");
    let fault = fault(
        Cell::new(MS).robot(robot).robot(other).program(|_| unreachable!("a robot is not homed")).run(),
    );
    assert_eq!((fault.kind(), fault.joint()), (FaultKind::DriveFault, Some(1)));
    let text = fault.to_string();
    assert!(text.contains("g joint 2") && text.contains("synchronisation switch"), "{text}");
    assert_eq!(ticks.get(), 30, "searched on after the fault");
    assert!(other_trace.borrow().iter().all(|q| q.norm() == 0.0));
}

#[test]
fn a_search_is_aborted_by_the_operator() {
    let (blind, ticks) = Blind::new(10_000);
    let (robot, _) = traced(RobotSetup::unhomed("g", Gantry::default(), blind));
    let outcome = Cell::new(MS)
        .robot(robot)
        .on_step(|step, operator| {
            if step == 100 {
                operator.abort();
            }
        })
        .program(|_| unreachable!("the robot is not homed"))
        .run();
    assert!(
        matches!(&outcome, Err(CellError::Fault(fault)) if fault.kind() == FaultKind::Aborted),
        "{outcome:?}"
    );
    assert!((100..110).contains(&ticks.get()), "{} ticks", ticks.get());
}

#[test]
fn a_guard_looks_at_nothing_before_all_robots_are_homed_and_then_at_all() {
    let ((early, _), (late, _)) = (Blind::new(40), Blind::new(80));
    let (known, _) = gantry("known");
    let looks = Rc::new(std::cell::RefCell::new(Vec::new()));
    let keep = Rc::clone(&looks);
    Cell::new(MS)
        .robot(RobotSetup::unhomed("early", Gantry::default(), early))
        .robot(RobotSetup::unhomed("late", Gantry::default(), late))
        .robot(known)
        .guard(5, move |robots| {
            let seen: Vec<_> =
                robots.iter().map(|robot| (robot.name.to_string(), robot.demanded.joints[0])).collect();
            keep.borrow_mut().push(seen);
            Ok(())
        })
        .program(|mp| {
            let mut known = mp.robot::<Gantry>("known")?;
            mp.wait_until((&mut known,), (), first_looks {}).map(drop)
        })
        .run()
        .expect("found");
    let expected = [("early".to_owned(), 0.1), ("late".to_owned(), 0.1), ("known".to_owned(), 0.0)];
    assert_eq!(*looks.borrow(), [expected.to_vec()]);
}

#[mrroc::condition(mp)]
fn first_looks() -> bool {
    true
}

#[test]
fn a_search_pauses_while_the_cell_is_suspended() {
    let (blind, ticks) = Blind::new(300);
    let counted = Rc::new(Count::new((0, 0)));
    let (count, keep) = (Rc::clone(&ticks), Rc::clone(&counted));
    let report = Cell::new(MS)
        .robot(RobotSetup::unhomed("g", Gantry::default(), blind))
        .on_step(move |step, operator| match step {
            50 => operator.suspend(),
            60 => keep.set((count.get(), 0)),
            200 => {
                keep.set((keep.get().0, count.get()));
                operator.resume();
            }
            _ => {}
        })
        .program(|_| Ok(()))
        .run()
        .expect("found");
    let (before, after) = counted.get();
    assert!(before == after && (49..55).contains(&before), "{before}, then {after} searches");
    assert_eq!((ticks.get(), report.steps >= 440), (300, true), "{report:?}");
}
