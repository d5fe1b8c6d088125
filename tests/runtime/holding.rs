//! Hold-to-run at reduced speed: robots move only while a person holds, and no tool faster than 250 mm/s.

use mrroc::cell::{CellError, RunReport};
use mrroc::fault::FaultKind;
use mrroc::operator::{LAPSE, Operator, REDUCED_SPEED, Renewal};
use mrroc::prelude::*;
use mrroc_tests::{MS, Q, fault, gantry};

use crate::runtime::kit::Smooth;

/// Positions along x in each step of a motion of `distance` \[m\] in a second of path time, and how it ended; `operate` is called at the
/// beginning of each step.
fn run(
    distance: f64,
    mut operate: impl FnMut(u64, &Operator) + 'static,
) -> (Vec<f64>, Result<RunReport, CellError>) {
    let (setup, trace) = gantry("g");
    let cell = Cell::new(MS)
        .robot(setup.program(move |ecp| ecp.move_robot((), Smooth::to(distance, 1.0)).map(drop)))
        .on_step(move |step, operator| {
            assert!(step < 20_000, "for ever");
            operate(step, operator);
        });
    let outcome = cell.run();
    let along_x = trace.borrow().iter().map(|q: &Q<3>| q[0]).collect();
    (along_x, outcome)
}

/// The first step from which on the robot stands for a tenth of a second, not before step `from`.
fn stands_from(x: &[f64], from: usize) -> usize {
    (from..).find(|&step| x[step..step + 100].iter().all(|at| *at == x[step])).expect("it stands")
}

/// A hold that is renewed every tenth of a second in these steps.
fn held(operator: &Operator, renewal: &mut Renewal, step: u64, steps: std::ops::Range<u64>) {
    if steps.contains(&step) && step % 100 == steps.start % 100 {
        operator.renew_hold(*renewal);
        *renewal = renewal.next().expect("not the last");
    }
}

#[test]
fn fault_05_at_reduced_speed_robots_move_only_while_a_person_holds() {
    let (mut first, mut second) = (Renewal::first(1), Renewal::first(2));
    let (x, outcome) = run(0.1, move |step, operator| {
        match step {
            1 => operator.set_reduced(true),
            // What was held once is held no more.
            1500 => operator.renew_hold(first),
            2200 => operator.let_go(2),
            2201 => operator.renew_hold(second),
            3000 => operator.set_reduced(false),
            4000 => operator.resume(),
            _ => {}
        }
        // The last renewal comes in step 800.
        held(operator, &mut first, step, 500..801);
        held(operator, &mut second, step, 2000..2200);
    });
    outcome.expect("it goes on when it is resumed");
    assert!(x[..500].iter().all(|at| *at == 0.0), "before anybody holds");
    assert!(x[1000] > 0.01, "{}", x[1000]);
    // The rate falls from the third step on after the lapse: the displacement of a step is never greater than before.
    let lapse = 800 + LAPSE.as_millis() as usize;
    let displacements: Vec<_> = x.windows(2).map(|two| two[1] - two[0]).collect();
    assert!(
        displacements[lapse + 5] < displacements[lapse],
        "{} {}",
        displacements[lapse],
        displacements[lapse + 5]
    );
    let stands = stands_from(&x, lapse);
    assert!(stands < lapse + 400, "{stands}");
    assert!(x[stands..1999].iter().all(|at| *at == x[stands]), "a hold that has ended stays so");
    assert!(x[2150] > x[1999], "another one does not");
    let stands = stands_from(&x, 2200);
    assert!(stands < 2600, "{stands}");
    assert!(x[stands..3999].iter().all(|at| *at == x[stands]), "at full speed again, it waits to be resumed");
    assert!((x[x.len() - 1] - 0.1).abs() < 1e-12);
}

#[test]
fn fault_05_a_tool_that_is_too_fast_for_reduced_speed_is_refused_and_at_a_lower_speed_is_not() {
    // At its fastest a motion of w in a second goes at 1.5 w.
    let at = |speed: f64| {
        let mut renewal = Renewal::first(1);
        run(0.4, move |step, operator| {
            if step == 1 {
                operator.set_reduced(true);
                operator.set_speed(speed).expect("a share");
            }
            held(operator, &mut renewal, step, 10..20_000);
        })
    };
    let (x, outcome) = at(1.0);
    let told = fault(outcome);
    assert_eq!((told.kind(), told.message()), (FaultKind::DemandedVelocity, "the tool at reduced speed"));
    assert!(told.excess().is_some_and(|excess| excess.limit == REDUCED_SPEED && excess.actual > 0.25));
    assert!(told.help().is_some_and(|help| help.contains("speed 10%")));
    let fastest = |x: &[f64]| x.windows(2).map(|two| (two[1] - two[0]) / 1e-3).fold(0.0, f64::max);
    assert!(fastest(&x) <= 0.25 * (1.0 + 1e-9), "{}", fastest(&x));
    let (x, outcome) = at(0.4);
    outcome.expect("it keeps the limit");
    assert!((fastest(&x) - 0.24).abs() < 1e-3, "{}", fastest(&x));
}

#[test]
fn fault_05_reduced_speed_in_motion_brings_robots_to_a_standstill_before_its_limit_is_in_force() {
    let (x, outcome) = run(0.4, |step, operator| match step {
        600 => operator.set_reduced(true),
        3000 => operator.set_reduced(false),
        3001 => operator.resume(),
        _ => {}
    });
    outcome.expect("nothing is refused");
    let stands = stands_from(&x, 600);
    assert!(stands < 1100 && x[stands] > 0.2, "{stands} {}", x[stands]);
    assert!((x[x.len() - 1] - 0.4).abs() < 1e-12);
}
