//! Robots whose MP is on another machine, at the other end of a wire on which messages are late and lost: under the virtual clock.

use std::time::Duration;

use mrroc::fault::{Name, ProcessId, Role};
use mrroc::prelude::*;
use mrroc::testing::{Case, Channel, Injected, LinkFault, Sweep, SweepReport, Wire};
use mrroc_tests::{Gantry, MS};

use super::cells::{Phase, Smooth, gantry, nudged, posed};

/// Whether all cases are tried, and not a share of them.
fn is_long() -> bool {
    std::env::var("MRROC_LONG").is_ok_and(|long| long == "1")
}

/// Wires of 0 to 15 ms to and fro, half of it each way: always the same, or each message by itself.
fn wires(lost_per_mille: u32) -> impl Iterator<Item = Wire> {
    (0..=15_u32).flat_map(move |ms| {
        let most = 500 * ms;
        [[most, most], [0, most]].map(|takes_us| Wire { takes_us, lost_per_mille })
    })
}

/// Two robots that go there and back, each by its own program.
fn loose(step: Duration) -> Cell {
    let program = |ecp: &mut Ecp<Gantry>| {
        // 10/√3 length/duration²: 3.2 m/s² of 10, and 5.1.
        ecp.obey(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.05, 0.3)).map(drop))?;
        ecp.obey(|ecp, _: Phase| ecp.move_robot((), Smooth::to(-0.03, 0.3)).map(drop))
    };
    let [a, b] = ["a", "b"].map(|name| gantry(name, MS).program(program));
    Cell::new(step).robot(a).robot(b).program(nudged)
}

/// The loose motions at the other end of each wire, which begins in one of `every` steps, or ends in one of them.
fn over(wires: impl Iterator<Item = Wire>, step_ms: u32, every: u64, seed: u64) -> SweepReport {
    let cell = move || loose(step_ms * MS);
    let sweep = wires.fold(Sweep::new(cell).seed(seed), |sweep, wire| {
        sweep.apart(None, wire, u32::MAX).apart(None, wire, 150 / step_ms)
    });
    // Where it ends is compared to the bit.
    sweep.every(every).end_tolerance(0.0).threads(2).run()
}

#[test]
fn fault_150_a_delay_of_up_to_fifteen_milliseconds_changes_nothing_of_where_a_loose_move_ends() {
    for step_ms in [1, 2, 4, 8] {
        let report = over(wires(0), step_ms, (if is_long() { 13 } else { 601 }) / u64::from(step_ms), 1);
        println!("steps of {step_ms} ms\n{report}");
        let total = report.total();
        assert!(report.is_clean() && total.cases >= 60 && total.survived == total.cases, "{report}");
    }
}

#[test]
fn fault_151_a_wire_that_loses_up_to_five_in_a_hundred_changes_nothing_or_all_robots_stop_in_order() {
    let seeds = if is_long() { 40 } else { 1 };
    for step_ms in [1, 2, 4, 8] {
        let mut report = SweepReport::default();
        for seed in 1..=seeds {
            for lost_per_mille in [10, 20, 50] {
                report.absorb(over(
                    wires(lost_per_mille).step_by(5),
                    step_ms,
                    601 / u64::from(step_ms),
                    seed,
                ));
            }
        }
        let total = report.total();
        println!(
            "steps of {step_ms} ms: {} of {} at their end, {} stopped",
            total.survived, total.cases, total.stopped
        );
        assert!(report.is_clean() && total.survived * 10 >= total.cases * 9, "{report}");
    }
}

/// What the tight Move of this cell comes to where replies of robot b take `late` more for so many steps.
fn tight(step: Duration, from_mp: bool, late: Duration, steps: u32) -> SweepReport {
    let b = ProcessId { role: Role::Ecp, name: Name::new("b").ok() };
    let (from, to) = if from_mp { (ProcessId::MP, b) } else { (b, ProcessId::MP) };
    let us = late.as_micros() as u32;
    let wire = LinkFault::Wire(Wire { takes_us: [us, us], lost_per_mille: 0 });
    let at = (Duration::from_millis(80).as_nanos() / step.as_nanos()) as u64;
    let injected = Injected::Link(Channel { from, to }, wire, steps);
    Sweep::new(move || posed(step)).repeat(&Case { injected, at, seed: 1 })
}

/// The table of nodes.md: `r + w < 2 Ts` where every message takes as long, and an order that is later than the others, with all
/// that follow it, by less than a step. Here nothing is worked for.
#[test]
fn fault_154_a_tight_move_bears_a_delay_of_less_than_two_steps_and_beyond_all_robots_stop_together() {
    for step in [MS, 2 * MS, 4 * MS, 8 * MS] {
        // Steps begin with the MP's within half a servo period or half a step: later than that is the next one.
        let grace = MS.min(step) / 2;
        let little = step / 20;
        // Always: a node goes by the arrival of orders, so what is late is the answer.
        let borne = tight(step, false, 2 * step - little, u32::MAX);
        assert!(borne.is_clean() && borne.total().survived == 1, "{step:?}: {borne}");
        let beyond = tight(step, false, 2 * step + grace + little, u32::MAX);
        assert!(beyond.is_clean() && beyond.total().stopped == 1, "{step:?}: {beyond}");
        // Once: an order and what is sent in place of it.
        let borne = tight(step, true, step - little, 1);
        assert!(borne.is_clean() && borne.total().survived == 1, "{step:?}, order: {borne}");
        let beyond = tight(step, true, step + grace + little, 3);
        assert!(beyond.is_clean() && beyond.total().stopped == 1, "{step:?}, order: {beyond}");
    }
}
