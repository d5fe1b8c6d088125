//! Robots whose MP is on another machine, at the other end of a wire on which messages are late and lost: under the virtual clock.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use mrroc::fault::{Name, ProcessId, Role};
use mrroc::prelude::*;
use mrroc::robot::JointVector;
use mrroc::testing::{Case, Channel, Injected, LinkFault, Sweep, SweepReport, Wire};
use mrroc_robots::{Polycrank, Rnt};
use mrroc_tests::{Gantry, MS};

use super::cells::{Phase, Smooth, gantry, posed, triggered};

/// Wires of 0 to 15 ms to and fro, half of it in each direction: always the same, or each message by itself.
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
        ecp.serve(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.05, 0.3)).map(drop))?;
        ecp.serve(|ecp, _: Phase| ecp.move_robot((), Smooth::to(-0.03, 0.3)).map(drop))
    };
    let [a, b] = ["a", "b"].map(|name| gantry(name, MS).program(program));
    Cell::new(step).robot(a).robot(b).program(triggered)
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

fn messages_are_late(every: u64) {
    for step_ms in [1, 2, 4, 8] {
        let report = over(wires(0), step_ms, every / u64::from(step_ms), 1);
        println!("steps of {step_ms} ms\n{report}");
        let total = report.total();
        assert!(report.is_clean() && total.cases >= 60 && total.survived == total.cases, "{report}");
    }
}

#[test]
fn fault_150_a_delay_of_up_to_fifteen_milliseconds_changes_nothing_of_where_a_loose_move_ends() {
    messages_are_late(601);
}

fn messages_are_lost(seeds: u64) {
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

#[test]
fn fault_151_a_wire_that_loses_up_to_five_in_a_hundred_changes_nothing_or_all_robots_stop_in_order() {
    messages_are_lost(1);
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

/// The table of nodes.md: `r + w < L₂ Ts` where every message takes as long, and an order that is later than the others, with all
/// that follow it, by less than a step. Here nothing is worked for.
#[test]
fn fault_154_a_tight_move_bears_a_delay_of_less_than_its_bridged_steps_and_beyond_all_robots_stop_together() {
    // `n (n + 1) / 2 · 2 m/s² · Ts² <= 0.05 mm`: 21 and 28 of 25, 6 and 10 of 6.25, 1 and 3 of 1.6 and of 0.4, where it is two.
    for (step, bridged) in [(MS, 6), (2 * MS, 3), (4 * MS, 2), (8 * MS, 2)] {
        // Steps begin with the MP's within half a servo period or half a step: later than that is the next one.
        let grace = MS.min(step) / 2;
        let little = step / 20;
        // Always: a node goes by the arrival of orders, so what is late is the answer.
        let borne = tight(step, false, bridged * step - little, u32::MAX);
        assert!(borne.is_clean() && borne.total().survived == 1, "{step:?}: {borne}");
        let beyond = tight(step, false, bridged * step + grace + little, u32::MAX);
        assert!(beyond.is_clean() && beyond.total().stopped == 1, "{step:?}: {beyond}");
        // Once: an order and what is sent in place of it.
        let borne = tight(step, true, step - little, 1);
        assert!(borne.is_clean() && borne.total().survived == 1, "{step:?}, order: {borne}");
        let beyond = tight(step, true, (bridged - 1) * step + grace + little, bridged + 1);
        assert!(beyond.is_clean() && beyond.total().stopped == 1, "{step:?}, order: {beyond}");
    }
}

/// The table of nodes.md of a network of 0.3 ms there and back: which steps it carries, with each message late by itself as well.
fn a_network_carries_steps(every: u64) {
    println!("step [ms]  one way [ms]  loose  tight");
    for step_ms in [1, 2, 4] {
        for takes_us in [[150, 150], [50, 250], [150, 450]] {
            let wire = Wire { takes_us, lost_per_mille: 0 };
            let sweep = |cell: fn(Duration) -> Cell, end: f64| {
                let sweep = Sweep::new(move || cell(step_ms * MS)).seed(7).apart(None, wire, u32::MAX);
                sweep.every(every).end_tolerance(end).threads(2).run()
            };
            let reports = [sweep(loose, 0.0), sweep(posed, 0.0)];
            let [loose, tight] = reports.each_ref().map(|report| {
                let total = report.total();
                assert!(
                    report.is_clean() && total.cases > 0 && total.survived == total.cases,
                    "{step_ms} ms, {takes_us:?}: {report}"
                );
                format!("{} of {}", total.survived, total.cases)
            });
            let [least, most] = takes_us.map(|us| f64::from(us) * 1e-3);
            println!("{step_ms:9}  {least:.2} to {most:.2}   {loose}  {tight}");
        }
    }
}

#[test]
fn a_network_of_three_tenths_of_a_millisecond_carries_steps_of_one_millisecond_also_with_jitter() {
    a_network_carries_steps(601);
}

/// Where both flanges are at the end of every servo period: the time [us], and the poses.
#[derive(Default)]
struct Trace {
    flanges: [Vec<(u64, Pose)>; 2],
}

impl Trace {
    /// The pose of the second flange in the first one, and where the first one is, at each time that both have.
    fn relative(&self) -> Vec<(u64, Pose, Pose)> {
        let [rnt, polycrank] = &self.flanges;
        let both = rnt.iter().filter_map(|&(time, a)| {
            let at = polycrank.binary_search_by_key(&time, |&(time, _)| time).ok()?;
            Some((time, a.inv_mul(&polycrank[at].1), a))
        });
        both.collect()
    }
}

/// Distance \[m\] or angle \[rad\] between poses, the larger one.
fn apart(a: &Pose, b: &Pose) -> f64 {
    let by = a.inv_mul(b);
    by.translation.vector.norm().max(by.rotation.angle())
}

/// The transfer in steps of so many milliseconds.
fn transfer_in(step_ms: u64) -> CellFile {
    let text = include_str!("../../tasks/transfer/cell.toml");
    let text = text.replace("step_ms = 2", &format!("step_ms = {step_ms}"));
    CellFile::parse("cell.toml", &text).expect("in order")
}

/// The traces of runs.
type Traces = Mutex<Vec<Arc<Mutex<Trace>>>>;

/// The transfer, each cell of which is written down in a trace of its own.
fn traced(step_ms: u64, traces: &Traces) -> Cell {
    let trace = Arc::new(Mutex::new(Trace::default()));
    traces.lock().unwrap_or_else(PoisonError::into_inner).push(Arc::clone(&trace));
    let file = transfer_in(step_ms);
    let base = |name: &str| file.robots().iter().find(|entry| entry.name() == name).expect("named").base();
    let (rnt, polycrank) = (Rnt::new().with_base(base("rnt")), Polycrank::new().with_base(base("polycrank")));
    super::tasks::transfer_of(&file).watch(move |seen| {
        let (place, pose) = match seen.robot {
            "rnt" => (0, rnt.forward(&<Rnt as Robot>::Joints::from_joints(|i| seen.demanded[i]))),
            "polycrank" => {
                (1, polycrank.forward(&<Polycrank as Robot>::Joints::from_joints(|i| seen.demanded[i])))
            }
            _ => return,
        };
        let time = (seen.time * 1e6).round() as u64;
        trace.lock().unwrap_or_else(PoisonError::into_inner).flanges[place].push((time, pose));
    })
}

/// By how much the relative pose of the arms is off at most \[m, rad\] from a time \[µs\] on.
fn off_from(trace: &[(u64, Pose, Pose)], time: u64) -> f64 {
    let at = trace.iter().position(|(at, ..)| *at >= time).unwrap_or(trace.len() - 1);
    let before = trace[at - 1].1;
    trace[at..].iter().map(|(_, relative, _)| apart(relative, &before)).fold(0.0, f64::max)
}

/// What cuts of a wire come to while both arms carry.
#[derive(Default)]
struct Cuts {
    all: usize,
    /// By how much the relative pose is off at most \[m, rad\].
    worst: f64,
}

/// Cuts the wire to an arm in every `every`-th step of the transfer.
fn cut(step_ms: u64, arm: &str, every: u64) -> Cuts {
    let lost = Wire { takes_us: [0, 0], lost_per_mille: 1000 };
    let traces = Traces::default();
    let sweep = Sweep::new(|| traced(step_ms, &traces)).apart(Name::new(arm).ok(), lost, u32::MAX);
    let report = sweep.every(every).run();
    assert!(report.is_clean() && report.total().stopped > 2, "{report}");
    let traces = traces.into_inner().expect("whole");
    // Undisturbed, twice; then one cut after the other, the first in step 1.
    let calm = traces[0].lock().expect("whole").relative();
    // Where the arms are carrying: both move, and one stands still in the other.
    let carries = |i: usize| {
        i > 2 && i + 2 < calm.len() && {
            let (a, b) = (&calm[i - 2], &calm[i + 2]);
            apart(&a.2, &b.2) > 1e-5 && apart(&a.1, &b.1) < 1e-8
        }
    };
    let mut cuts = Cuts::default();
    for (n, trace) in traces.iter().skip(2).enumerate() {
        let step = 1 + n as u64 * every;
        let trace = trace.lock().expect("whole").relative();
        let at = trace.iter().position(|(time, ..)| *time >= step * step_ms * 1000).unwrap_or(0);
        if carries(at) {
            cuts.all += 1;
            cuts.worst = cuts.worst.max(off_from(&trace, trace[at].0));
        }
    }
    println!(
        "steps of {step_ms} ms, {arm}: {} cuts while both carry, off by {:.1e} m or rad at most",
        cuts.all, cuts.worst
    );
    cuts
}

/// How well the relative pose is kept \[m, rad\].
const KEPT: f64 = 1e-6;

fn wires_are_cut(cases: &[(u64, &str, u64)]) {
    for &(step_ms, arm, every) in cases {
        let Cuts { all, worst } = cut(step_ms, arm, every);
        assert!(all > 1 && worst <= KEPT, "steps of {step_ms} ms, {arm}");
    }
}

#[test]
fn fault_153_a_wire_that_is_cut_in_a_tight_move_stops_both_arms_on_their_common_twist() {
    wires_are_cut(&[(2, "polycrank", 2267)]);
}

/// By how much the relative pose is off at most \[m, rad\] where the MP dies in a step.
fn off_without_mp(step_ms: u64, at: u64) -> f64 {
    let traces = Traces::default();
    let case = Case { injected: Injected::Kill(ProcessId::MP), at, seed: 1 };
    assert!(Sweep::new(|| traced(step_ms, &traces)).repeat(&case).is_clean());
    let traces = traces.into_inner().expect("whole");
    let trace = traces.last().expect("a run").lock().expect("whole").relative();
    off_from(&trace, at * step_ms * 1000)
}

/// In this leg of the transfer the twist alone takes up to a third of the limit of the Polycrank's elbow: what braking may take is less.
fn the_mp_dies(every: usize) {
    for at in (6080..6420).step_by(every) {
        let off = off_without_mp(2, at);
        assert!(off <= 1e-9, "step {at}: {off:e}");
    }
}

#[test]
fn fault_03_arms_on_a_twist_that_bends_a_joint_hard_stay_together_until_they_stand() {
    the_mp_dies(80);
}

mod whole {
    use super::{a_network_carries_steps, messages_are_late, messages_are_lost, the_mp_dies, wires_are_cut};

    #[test]
    #[ignore = "takes minutes: `just wires-whole`"]
    fn fault_150_a_delay_of_up_to_fifteen_milliseconds_changes_nothing_of_where_a_loose_move_ends() {
        messages_are_late(13);
    }

    #[test]
    #[ignore = "takes minutes: `just wires-whole`"]
    fn fault_151_a_wire_that_loses_up_to_five_in_a_hundred_changes_nothing_or_all_robots_stop_in_order() {
        messages_are_lost(40);
    }

    #[test]
    #[ignore = "takes minutes: `just wires-whole`"]
    fn a_network_of_three_tenths_of_a_millisecond_carries_steps_of_one_millisecond_also_with_jitter() {
        a_network_carries_steps(13);
    }

    #[test]
    #[ignore = "takes minutes: `just wires-whole`"]
    fn fault_153_a_wire_that_is_cut_in_a_tight_move_stops_both_arms_on_their_common_twist() {
        wires_are_cut(&[(1, "polycrank", 50), (2, "polycrank", 50), (2, "rnt", 50), (4, "polycrank", 50)]);
    }

    #[test]
    #[ignore = "takes minutes: `just wires-whole`"]
    fn fault_03_arms_on_a_twist_that_bends_a_joint_hard_stay_together_until_they_stand() {
        the_mp_dies(10);
    }
}
