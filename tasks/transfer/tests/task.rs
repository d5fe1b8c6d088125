//! The task with nothing between the hands: what is demanded of the arms, whatever the operator does.

use crate::support::{Demands, apart, off_path, task, watched};
use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_generators::cooperation::Displacement;
use mrroc_robots::{Polycrank, Rnt};
use transfer::generators::Trigger;
use transfer::orders::{Arms, Hands, Phase};
use transfer::places::{End, back, bar, grasp, legs};
use transfer::{cell, file, first, plant};

/// How far demands may be off the body's path [m and rad].
const EXACT: f64 = 1e-9;
/// Joints of both arms and of their hands.
const JOINTS: usize = 6 + 7 + 1 + 1;

#[test]
#[allow(non_snake_case)]
fn both_tools_carry_the_body_along_its_path_and_leave_it_where_it_belongs() {
    let (cell, demands) = task();
    let report = cell.run().expect("within all limits");
    let demands = demands.borrow();
    // Legs of 0.12, 0.25 and 0.12 m at 15/8 of the mean velocity: 1.875 * 0.49 m / 0.1 m/s = 9.19 s, and some steps between.
    let carried = demands.carrying.len() as f64 * 2e-3;
    assert!(
        (9.19..9.3).contains(&carried) && report.time.as_secs_f64() > carried + 8.0,
        "{carried} s, {report:?}"
    );
    assert!(off_path(&demands) <= EXACT, "{}", off_path(&demands));
    // As src/places.rs says.
    let [rnt, polycrank] = demands.singularity;
    assert!(rnt > 0.15 && polycrank > 0.085, "{rnt} {polycrank}");
    // The last of the bar is where the legs lead; the tools have gone back from it.
    let X_WB = legs().iter().fold(bar(), |X_WB, X_BsB| X_WB * X_BsB);
    for (tool, end) in demands.last.iter().zip([End::Near, End::Far]) {
        let (distance, angle) = apart(tool, &(X_WB * grasp(end) * back()));
        assert!(distance < EXACT && angle < EXACT, "{distance} {angle}");
    }
}

/// Suspends in one of `every` 29 steps, and resumes.
fn the_operator_suspends_and_resumes(every: usize) {
    let (undisturbed, calm) = task();
    let steps = undisturbed.run().expect("within all limits").steps;
    // Slowing down takes some hundred steps. The first suspension of a run comes ever later, the next follow it, so that
    // so many steps of all phases are some in which the operator suspends.
    const PERIOD: u64 = 1160;
    for offset in (0..PERIOD).step_by(29 * every) {
        let (cell, demands) = task();
        let report = cell
            .on_step(move |step, operator| match (step + PERIOD - offset) % PERIOD {
                0 => operator.suspend(),
                400 => operator.resume(),
                _ => {}
            })
            .run();
        let report = report.unwrap_or_else(|error| panic!("suspended in step {offset} and later: {error}"));
        assert!(report.steps > steps + 400, "{} steps", report.steps);
        let demands = demands.borrow();
        assert!(off_path(&demands) <= EXACT, "{} when suspended in step {offset}", off_path(&demands));
        for (tool, calm) in demands.last.iter().zip(&calm.borrow().last) {
            let (distance, angle) = apart(tool, calm);
            assert!(distance < EXACT && angle < EXACT, "{distance} {angle} when suspended in step {offset}");
        }
    }
}

#[test]
fn wherever_the_operator_suspends_and_resumes_both_arms_stay_on_the_bodys_path() {
    the_operator_suspends_and_resumes(5);
}

/// Aborts in one of `every` 97 steps.
fn the_operator_aborts(every: usize) {
    let (undisturbed, _) = task();
    let steps = undisturbed.run().expect("within all limits").steps;
    for at in (10..steps).step_by(97 * every) {
        let (cell, demands) = task();
        let outcome = cell
            .on_step(move |step, operator| {
                if step == at {
                    operator.abort();
                }
            })
            .run();
        let Err(CellError::Fault(fault)) = outcome else { panic!("aborted in step {at}: {outcome:?}") };
        assert_eq!(fault.kind(), FaultKind::Aborted, "{fault}");
        let demands = demands.borrow();
        assert!(off_path(&demands) <= EXACT, "{} when aborted in step {at}", off_path(&demands));
        // At rest, but for the last of a rate that falls by 5/s, 0.01 in a step: 0.125 m/s * 2 ms * 0.01.
        assert!(demands.moved < 2.5e-6, "{} m in the last period when aborted in step {at}", demands.moved);
    }
}

#[test]
fn wherever_the_operator_aborts_both_arms_stop_on_the_bodys_path() {
    the_operator_aborts(6);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just test-whole`"]
    fn wherever_the_operator_suspends_and_resumes_both_arms_stay_on_the_bodys_path() {
        super::the_operator_suspends_and_resumes(1);
    }

    #[test]
    #[ignore = "takes minutes: `just test-whole`"]
    fn wherever_the_operator_aborts_both_arms_stop_on_the_bodys_path() {
        super::the_operator_aborts(1);
    }
}

#[test]
fn halves_that_disagree_are_refused_before_anything_moves() {
    // The coordinator orders displacements where the arms expect a phase.
    #[generator(mp)]
    fn hurry() -> Always<(Rnt, Polycrank), Displacement> {
        Always((
            Displacement { pose: mrroc::pose::Pose::identity() },
            Displacement { pose: mrroc::pose::Pose::identity() },
        ))
    }
    let file = file().expect("in order");
    let cell = cell(&file, &plant::drives()).expect("in order").program(|mp| {
        let (mut rnt, mut polycrank) = (mp.robot("rnt")?, mp.robot("polycrank")?);
        mp.move_robots((&mut rnt, &mut polycrank), (), hurry {}).map(drop)
    });
    let (cell, demands) = watched(cell, &file);
    let Err(CellError::Fault(fault)) = cell.run() else { panic!("the halves disagree") };
    assert_eq!(fault.kind(), FaultKind::PayloadMismatch, "{fault}");
    assert_still(&demands.borrow());
}

#[test]
fn a_phase_that_is_not_a_robots_is_refused_before_anything_moves() {
    // Twice the same slip: the coordinator takes arms for hands, or hands for arms; in the task, and as it was begun.
    for programs in [transfer::ecp::programs, first::programs] {
        for (phase, known) in [(Phase::Close, "order Approach"), (Phase::Withdraw, "order Close or Open")] {
            let file = file().expect("in order");
            let cell = programs(file.cell(&plant::drives()).expect("in order")).program(move |mp| {
                if phase == Phase::Close {
                    let (mut rnt, mut polycrank) = (mp.robot("rnt")?, mp.robot("polycrank")?);
                    mp.move_robots((&mut rnt, &mut polycrank), (), Trigger::<Arms>::to(phase)).map(drop)
                } else {
                    let mut hands = (mp.robot("rnt-hand")?, mp.robot("polycrank-hand")?);
                    mp.move_robots([&mut hands.0, &mut hands.1], (), Trigger::<Hands>::to(phase)).map(drop)
                }
            });
            let (cell, demands) = watched(cell, &file);
            let Err(CellError::Fault(fault)) = cell.run() else { panic!("{phase:?} is not theirs") };
            assert_eq!(fault.kind(), FaultKind::Program, "{fault}");
            assert!(fault.to_string().contains(known), "{fault}");
            assert_still(&demands.borrow());
        }
    }
}

/// Nothing moved: what the drives of each robot got is what they got first.
fn assert_still(demands: &Demands) {
    assert!(demands.bits.len() >= JOINTS, "nothing was seen");
    assert!(!demands.is_moved, "something moved");
}

#[test]
fn the_program_as_it_was_begun_does_the_same_task() {
    let file = file().expect("in order");
    let begun = first::programs(file.cell(&plant::drives()).expect("in order")).program(first::coordinate);
    let (begun, demands) = watched(begun, &file);
    begun.run().expect("within all limits");
    let (tuned, calm) = task();
    tuned.run().expect("within all limits");
    assert!(off_path(&demands.borrow()) <= EXACT);
    for (tool, calm) in demands.borrow().last.iter().zip(&calm.borrow().last) {
        let (distance, angle) = apart(tool, calm);
        assert!(distance < EXACT && angle < EXACT, "{distance} {angle}");
    }
}

#[test]
fn runs_are_the_same_to_the_bit() {
    let run = || {
        let (cell, demands) = task();
        cell.run().expect("within all limits");
        demands.take().bits
    };
    assert!(run() == run());
}
