//! Faults of the legs: each is named, and the machine stands.

use std::cell::RefCell;

use legs::ground::{Ground, Lane};
use legs::leg::Leg;
use legs::places::{NAMES, hip, stance, start};
use legs::plant::{Drawn, Plant};
use legs::run::Ready;
use legs::walk::{Footstep, Gait, LEAST, Part, Refused, Stance, regular};
use mrroc::fault::{Name, ProcessId, Role};
use mrroc_testing::{Case, Injected, Sweep};
use nalgebra::Vector3;

/// Four footsteps on level ground: the first leg is lifted in step 510.
fn short() -> Gait {
    Gait { footsteps: 4, ..Gait::default() }
}

/// Stands for so long after a run \[s\], as the drives' brakes hold it: the least margin once it has rocked for 0.5 s, and whether it has
/// fallen. A foot that bears little may leave the ground for a moment when the others are stopped.
fn stands(plant: &Plant, seconds: f64) -> (f64, bool) {
    let world = plant.world();
    let mut world = world.borrow_mut();
    let mut least = f64::INFINITY;
    for k in 0..(seconds / legs::plant::PERIOD) as usize {
        world.stand();
        if k > 250 {
            least = least.min(world.standing().margin());
        }
    }
    (least, world.standing().has_fallen())
}

#[test]
fn fault_209_an_unstable_footstep_is_refused_before_anything_moves() {
    let gait = Gait { sway: 0.0, ..short() };
    let outcome = Ready::new(&Drawn::level(0.7), &gait, 0).expect("a cell").run();
    let fault = outcome.report.expect_err("unstable").to_string();
    assert!(fault.contains("footstep of") && fault.contains("is unstable"), "{fault}");
    assert!(outcome.seen.steps.is_empty() && outcome.seen.film.len() < 5, "it moved");
}

#[test]
fn fault_209_a_footstep_to_a_place_that_would_tip_the_machine_over_is_refused_by_its_margin() {
    let gait = Gait::default();
    let legs = [0, 1, 2, 3].map(|i| Leg::at(hip(i)));
    // The trunk has set off, and is so far to the left over its feet.
    let ahead = gait.advance(0.0) - gait.advance(-gait.ramp);
    let plan = |left: f64| {
        let feet = stance(&gait).map(|foot| foot - Vector3::new(ahead, left, 0.0));
        let q = core::array::from_fn(|i| legs[i].reach_for(&feet[i], &start()[i]).expect("in reach"));
        let at = Stance { q, feet, lean: [0.0; 2] };
        let hold = regular(&gait, 0);
        Footstep::plan(&gait, Part::Footstep(0), Some((3, hold)), &legs, &Ground::level(), &at)
    };
    match plan(-0.02) {
        Err(Refused::Unstable { leg: "rh", margin, .. }) => assert!(margin < LEAST, "{margin}"),
        other => panic!("{other:?}"),
    }
    assert!(plan(gait.sway).is_ok_and(|plan| plan.margin() >= LEAST));
}

#[test]
fn a_foot_that_finds_no_ground_where_it_should_be_is_a_named_fault() {
    let hole = Lane { edges: vec![0.35], heights: vec![0.0, -0.08] };
    let level = Drawn::level(0.7);
    // The first leg in front steps into it.
    let drawn = Drawn { ground: Ground { right: hole, ..level.ground.clone() }, ..level };
    let ready = Ready::new(&drawn, &short(), 0).expect("a cell");
    let outcome = ready.run();
    let fault = outcome.report.expect_err("no ground").to_string();
    assert!(fault.contains("rf found no ground"), "{fault}");
}

thread_local! {
    /// The machine of the last cell that was made.
    static LAST: RefCell<Option<Plant>> = const { RefCell::new(None) };
}

/// Kills the EDPs of legs in steps: all stop, and the machine stands.
fn legs_are_killed(cases: impl IntoIterator<Item = (u64, usize)>) {
    let cell = || {
        let ready = Ready::new(&Drawn::level(0.7), &short(), 0).expect("a cell");
        LAST.set(Some(ready.plant));
        ready.cell
    };
    let sweep = Sweep::new(cell).end_tolerance(1.0);
    for (at, leg) in cases {
        let name = Name::new(NAMES[leg]).expect("a name");
        let injected = Injected::Kill(ProcessId::new(Role::Edp, name));
        let report = sweep.repeat(&Case { injected, at, seed: 1 });
        assert!(report.is_clean(), "{report}");
        let plant = LAST.take().expect("a machine");
        let seen = plant.world().borrow().seen.clone();
        let (margin, fallen) = stands(&plant, 2.0);
        assert!(!fallen && !seen.fallen, "{} killed in step {at}: it fell", NAMES[leg]);
        assert!(margin >= LEAST, "{} killed in step {at}: {margin} m", NAMES[leg]);
    }
}

#[test]
fn fault_231_a_leg_whose_edp_is_killed_stops_all_and_the_machine_stands() {
    // A leg that swings, and one that bears most.
    legs_are_killed([(560, 3), (760, 0), (900, 1)]);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just legs-whole`"]
    fn fault_231_a_leg_whose_edp_is_killed_stops_all_and_the_machine_stands() {
        // In the swing of each leg, and while all stand.
        let steps = (400..1400).step_by(13).enumerate();
        super::legs_are_killed(steps.flat_map(|(i, at)| [(at, i % 4), (at, (i + 1) % 4)]));
    }
}
