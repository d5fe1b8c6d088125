//! What a run shows of protective stops: those that the operator has asked for, and no other.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use nalgebra::Vector3;

use super::arms_without_mp::{Arm, Exact, Six, program, slides_and_turns};
use crate::cell::{Cell, CellError, RobotSetup};
use crate::model::fault::{FaultKind, ProcessId};
use crate::model::pose::Pose;
use crate::model::time::Nanos;
use crate::observe::step_observer::{StepEvent, StepObserver, StepRecord};

/// The steps that were shown, each with whether a protective stop was asked for.
#[derive(Default)]
struct Steps(RefCell<Vec<(u64, bool)>>);

impl StepObserver for Steps {
    fn see(&self, _: Nanos, _: ProcessId, what: &StepEvent, _: &[u64]) {
        if let StepEvent::Step(StepRecord { step, stopping, .. }) = what {
            self.0.borrow_mut().push((*step, *stopping));
        }
    }
}

/// Runs two arms, and asks for a protective stop in a step, if one is given.
fn run(stop: Option<u64>) -> (Vec<(u64, bool)>, Result<(), CellError>) {
    let steps = Rc::new(Steps::default());
    let mut cell = Cell::new(Duration::from_millis(2))
        .program(program)
        .on_step(move |step, operator| {
            if stop == Some(step) {
                operator.protective_stop();
            }
        })
        .observed_by(Rc::clone(&steps) as Rc<dyn StepObserver>);
    let turned = Pose::new(Vector3::new(1.0, 0.8, 0.3), Vector3::new(0.3, -0.4, 2.0));
    for (name, base) in [("left", Pose::identity()), ("right", turned)] {
        let arm = Arm::on(base, slides_and_turns(10.0, 20.0));
        let start = Six::new(0.1, 0.2, 0.3, 0.1, -0.2, 0.3);
        cell = cell.robot(RobotSetup::new(name, arm, Exact(start, Duration::from_millis(2))));
    }
    let outcome = cell.run().map(drop);
    (steps.0.take(), outcome)
}

/// A release build of rustc 1.95 showed one in every step (decision 24); so did its recordings, which could not be replayed.
#[test]
fn a_step_shows_a_protective_stop_only_where_the_operator_has_asked_for_one() {
    let (steps, outcome) = run(None);
    outcome.expect("nobody stops it");
    assert!(steps.len() > 100, "{} steps", steps.len());
    assert_eq!(steps.iter().find(|(_, stopping)| *stopping), None);
    let (steps, outcome) = run(Some(40));
    assert!(matches!(outcome, Err(CellError::Fault(fault)) if fault.kind() == FaultKind::ProtectiveStop));
    let stopping: Vec<_> = steps.iter().filter(|(_, stopping)| *stopping).map(|(step, _)| *step).collect();
    assert_eq!(stopping, [40]);
}
