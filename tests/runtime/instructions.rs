//! What those who look on at a run are shown of its instructions.

use core::cell::RefCell;
use std::rc::Rc;

use mrroc::fault::ProcessId;
use mrroc::link::Nanos;
use mrroc::observe::witness::{What, Witness};
use mrroc::operator::state::Doing;
use mrroc::prelude::*;
use mrroc_tests::{Gantry, MS, gantry};

use crate::runtime::kit::{Phase, Smooth};

/// Notes when an instruction begins or is over, of which process.
#[derive(Default)]
struct Notes(RefCell<Vec<(Nanos, String, Doing, String)>>);

impl Witness for Notes {
    fn see(&self, time: Nanos, by: ProcessId, what: &What, _: &[u64]) {
        if let What::Instruction { doing, by: of, .. } = what {
            self.0.borrow_mut().push((time, by.to_string(), *doing, of.to_string()));
        }
    }
}

impl Notes {
    /// What a process did, in order, with the steps of 1 ms that each took.
    fn of(&self, process: &str) -> Vec<(Doing, String, u64)> {
        let notes = self.0.borrow();
        let own: Vec<_> = notes.iter().filter(|(_, by, ..)| by == process).collect();
        let pairs = own.as_chunks::<2>().0.iter();
        let took = pairs.map(|[begun, over]| {
            assert_eq!((over.2, &over.3), (Doing::Nothing, &begun.3), "{process}: {notes:?}");
            (begun.2, begun.3.clone(), (over.0 - begun.0) / 1_000_000)
        });
        took.collect()
    }
}

struct Rests(u64);

#[condition(ecp)]
fn rests(c: &mut Rests) -> bool {
    c.0 = c.0.saturating_sub(1);
    c.0 == 0
}

#[generator(mp)]
fn ask() -> Always<(Gantry,), Phase> {
    Always((Phase::Approach,))
}

/// A Move and a Wait as an ECP's program writes them.
fn approach(ecp: &mut Ecp<Gantry>) -> Result<(), Fault> {
    ecp.move_robot((), Smooth::to(0.1, 0.4))?;
    ecp.wait_until((), Rests(50)).map(drop)
}

#[test]
fn programs_of_ecps_show_their_own_generators_and_conditions() {
    for coordinated in [false, true] {
        let notes = Rc::new(Notes::default());
        let (robot, _) = gantry("g");
        let cell = Cell::new(MS).witnessed_by(Rc::clone(&notes) as Rc<dyn Witness>);
        let cell = match coordinated {
            false => cell.robot(robot.program(approach)),
            true => {
                let obeys = |ecp: &mut Ecp<Gantry>| ecp.obey(|ecp, _: Phase| approach(ecp));
                cell.robot(robot.program(obeys)).program(|mp| {
                    let mut g = mp.robot::<Gantry>("g")?;
                    mp.move_robots((&mut g,), (), ask {}).map(drop)
                })
            }
        };
        cell.run().expect("the motion keeps the limits");
        let ecp = notes.of("ecp g");
        let shown: Vec<_> = ecp.iter().map(|(doing, by, _)| (*doing, by.as_str())).collect();
        assert_eq!(shown, [(Doing::Move, "Smooth"), (Doing::Wait, "Rests")]);
        // 0.4 s, and the steps in which it begins and learns of its end; 50 steps of the Wait.
        assert!((400..=403).contains(&ecp[0].2) && (49..=52).contains(&ecp[1].2), "{ecp:?}");
        let mp = notes.of("mp");
        let moves: Vec<_> = mp.iter().filter(|(doing, ..)| *doing == Doing::Move).collect();
        // An MP without a program lets the ECPs' programs run, and has no generator.
        let generator = if coordinated { "ask" } else { "" };
        assert!(moves.len() == 1 && moves[0].1 == generator && moves[0].2 >= 450, "{mp:?}");
    }
}

#[test]
fn the_instructions_of_transparent_ecps_are_those_of_the_mp() {
    let notes = Rc::new(Notes::default());
    let (robot, _) = gantry("g");
    let cell = Cell::new(MS).witnessed_by(Rc::clone(&notes) as Rc<dyn Witness>).robot(robot);
    let cell = cell.program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        // One motion by itself, and beside others in a list, are shown by the names that the program writes.
        mp.move_robot(&mut g, (), Smooth::to(0.1, 0.4))?;
        mp.move_robots((&mut g,), (), Each::of((Smooth::to(0.0, 0.4),))).map(drop)
    });
    cell.run().expect("the motion keeps the limits");
    assert_eq!(notes.of("ecp g"), []);
    let moves = notes.of("mp").into_iter().filter(|(doing, ..)| *doing == Doing::Move);
    assert_eq!(moves.map(|(_, by, _)| by).collect::<Vec<_>>(), ["Smooth", "Smooth"]);
}
