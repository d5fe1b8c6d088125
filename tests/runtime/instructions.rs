//! What those who look on at a run are shown of its instructions.

use core::cell::RefCell;
use std::rc::Rc;

use mrroc::cell::AfterFault;
use mrroc::fault::{FaultWords, ProcessId};
use mrroc::link::Nanos;
use mrroc::observe::step_observer::{StepEvent, StepObserver};
use mrroc::operator::Latch;
use mrroc::operator::state::InstructionKind;
use mrroc::prelude::*;
use mrroc_tests::{Gantry, MS, fault, gantry};

use crate::runtime::kit::{Phase, Smooth};

/// Notes when an instruction begins or is over, of which process.
#[derive(Default)]
struct Notes(RefCell<Vec<(Nanos, String, InstructionKind, String)>>);

impl StepObserver for Notes {
    fn see(&self, time: Nanos, by: ProcessId, what: &StepEvent, _: &[u64]) {
        if let StepEvent::Instruction { doing, by: of, .. } = what {
            self.0.borrow_mut().push((time, by.to_string(), *doing, of.to_string()));
        }
    }
}

impl Notes {
    /// What a process did, in order, with the steps of 1 ms that each took.
    fn of(&self, process: &str) -> Vec<(InstructionKind, String, u64)> {
        let notes = self.0.borrow();
        let own: Vec<_> = notes.iter().filter(|(_, by, ..)| by == process).collect();
        let pairs = own.as_chunks::<2>().0.iter();
        let took = pairs.map(|[begun, over]| {
            assert_eq!((over.2, &over.3), (InstructionKind::Nothing, &begun.3), "{process}: {notes:?}");
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
        let cell = Cell::new(MS).observed_by(Rc::clone(&notes) as Rc<dyn StepObserver>);
        let cell = match coordinated {
            false => cell.robot(robot.program(approach)),
            true => {
                let serves = |ecp: &mut Ecp<Gantry>| ecp.serve(|ecp, _: Phase| approach(ecp));
                cell.robot(robot.program(serves)).program(|mp| {
                    let mut g = mp.robot::<Gantry>("g")?;
                    mp.move_robots((&mut g,), (), ask {}).map(drop)
                })
            }
        };
        cell.run().expect("the motion keeps the limits");
        let ecp = notes.of("ecp g");
        let shown: Vec<_> = ecp.iter().map(|(doing, by, _)| (*doing, by.as_str())).collect();
        assert_eq!(shown, [(InstructionKind::Move, "Smooth"), (InstructionKind::Wait, "Rests")]);
        // 0.4 s, and the steps in which it begins and learns of its end; 50 steps of the Wait.
        assert!((400..=403).contains(&ecp[0].2) && (49..=52).contains(&ecp[1].2), "{ecp:?}");
        let mp = notes.of("mp");
        let moves: Vec<_> = mp.iter().filter(|(doing, ..)| *doing == InstructionKind::Move).collect();
        // An MP without a program lets the ECPs' programs run, and has no generator.
        let generator = if coordinated { "ask" } else { "" };
        assert!(moves.len() == 1 && moves[0].1 == generator && moves[0].2 >= 450, "{mp:?}");
    }
}

#[test]
fn the_instructions_of_transparent_ecps_are_those_of_the_mp() {
    let notes = Rc::new(Notes::default());
    let (robot, _) = gantry("g");
    let cell = Cell::new(MS).observed_by(Rc::clone(&notes) as Rc<dyn StepObserver>).robot(robot);
    let cell = cell.program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        // One motion by itself, and beside others in a list, are shown by the names that the program writes.
        mp.move_robot(&mut g, (), Smooth::to(0.1, 0.4))?;
        mp.move_robots((&mut g,), (), Each::of((Smooth::to(0.0, 0.4),))).map(drop)
    });
    cell.run().expect("the motion keeps the limits");
    assert_eq!(notes.of("ecp g"), []);
    let moves = notes.of("mp").into_iter().filter(|(doing, ..)| *doing == InstructionKind::Move);
    assert_eq!(moves.map(|(_, by, _)| by).collect::<Vec<_>>(), ["Smooth", "Smooth"]);
}

/// Too fast in between: its speed rises to 1.35 m/s, of 1 m/s.
fn too_fast() -> Smooth {
    Smooth::to(0.9, 1.0)
}

#[condition(mp)]
fn never() -> bool {
    false
}

/// The fault of a cell: what it says of its instruction, and whether its words say so, too.
fn stopped(cell: Cell) -> Option<String> {
    let fault = fault(cell.run());
    let named = fault.instruction().map(|instruction| instruction.to_string());
    let told = fault.to_string();
    assert!(named.as_ref().is_none_or(|named| told.contains(&format!(" in {named}"))), "{told}");
    assert_eq!(fault.step().is_some(), told.contains(" at step "), "{told}");
    // As it travels.
    let sent = Fault::from(FaultWords::from(&fault));
    assert_eq!((sent.instruction(), sent.to_string()), (fault.instruction(), told));
    named
}

#[test]
fn a_fault_names_the_instruction_of_the_program_in_which_it_happened() {
    let cell = |program: fn(&mut Mp) -> Result<(), Fault>| {
        stopped(Cell::new(MS).robot(gantry("g").0).robot(gantry("other").0).program(program))
    };
    let in_the_third = cell(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robot(&mut g, (), Smooth::to(0.1, 0.4))?;
        // One that ends in order names its own.
        let late = mp.wait_at_most((&mut g,), (), never {}, 10).err();
        let late = late.and_then(|fault| fault.instruction()).map(|named| named.to_string());
        assert_eq!(late.as_deref(), Some("Wait 2 (never)"));
        mp.move_robot(&mut g, (), too_fast()).map(drop)
    });
    assert_eq!(in_the_third.as_deref(), Some("Move 3 (Smooth)"));
    // Between two instructions, none.
    assert_eq!(cell(|_| Err(Fault::thrown("the tray is empty"))), None);
    // The motion in the background is the first one, whatever the program does meanwhile.
    let beside = cell(|mp| {
        let (mut g, mut other) = (mp.robot::<Gantry>("g")?, mp.robot::<Gantry>("other")?);
        mp.start_robot(&mut other, too_fast())?;
        mp.move_robot(&mut g, (), Smooth::to(0.1, 2.0)).map(drop)
    });
    assert_eq!(beside.as_deref(), Some("Move 1 (Smooth)"));
    let panics = cell(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robots((&mut g,), (), Breaks(0)).map(drop)
    });
    assert_eq!(panics.as_deref(), Some("Move 1 (Breaks)"));
}

struct Breaks(u32);

#[generator(mp)]
fn breaks(c: &mut Breaks) -> Step<(Gantry,)> {
    c.0 += 1;
    assert!(c.0 < 5, "not written yet");
    Step::Next((Demand::hold(),))
}

#[test]
fn a_fault_of_an_ecp_names_the_instruction_of_its_own_program() {
    for coordinated in [false, true] {
        let program = |ecp: &mut Ecp<Gantry>| {
            approach(ecp)?;
            ecp.move_robot((), too_fast()).map(drop)
        };
        let cell = match coordinated {
            false => Cell::new(MS).robot(gantry("g").0.program(program)),
            true => {
                let robot = gantry("g").0.program(move |ecp| ecp.serve(|ecp, _: Phase| program(ecp)));
                Cell::new(MS).robot(robot).program(|mp| {
                    let mut g = mp.robot::<Gantry>("g")?;
                    mp.move_robots((&mut g,), (), ask {}).map(drop)
                })
            }
        };
        let fault = fault(cell.run());
        let named = fault.instruction().expect("it was in one");
        assert_eq!(
            (named.ordinal(), named.doing(), named.by()),
            (3, InstructionKind::Move, "Smooth"),
            "{fault}"
        );
        assert!(
            named.is_of_ecp() && fault.to_string().contains(" in Move 3 (Smooth) of its ECP at step"),
            "{fault}"
        );
    }
}

#[test]
fn after_a_reset_instructions_count_from_the_first_line_again() {
    let told = Rc::new(RefCell::new(Vec::new()));
    let keep = Rc::clone(&told);
    let cell = Cell::new(MS).robot(gantry("g").0).after_fault(AfterFault::AwaitReset);
    let cell = cell.on_step(move |_, operator| {
        if operator.latch() == Latch::Latched {
            let named = operator.fault().and_then(|fault| fault.instruction());
            keep.borrow_mut().push(named.map(|named| named.ordinal()));
            if keep.borrow().len() == 2 {
                return operator.give_up();
            }
            operator.acknowledge().and_then(|()| operator.reset()).expect("nothing persists");
        }
    });
    let stopped = stopped(cell.program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robot(&mut g, (), Smooth::to(0.0, 0.4))?;
        mp.move_robot(&mut g, (), too_fast()).map(drop)
    }));
    assert_eq!(stopped.as_deref(), Some("Move 2 (Smooth)"));
    assert_eq!(*told.borrow(), [Some(2), Some(2)]);
}
