//! Several arms in one plan, who reach across each other.

use mrroc_planning::{PlanError, Planner};
use mrroc_robots::clearance::Clearance;

use super::table::{Kind, MARGIN, Problem};

/// What the search for the first path of four arms takes at most, in checks; the default of a plan is 400,000.
const EFFORT: u64 = 60_000;

fn planner(clearance: &Clearance) -> Planner {
    Planner::new(clearance.clone()).expect("a planner").with_effort(EFFORT)
}

/// The joints of each arm.
const fn joints(kind: Kind) -> usize {
    match kind {
        Kind::Six => 6,
        Kind::Seven => 7,
    }
}

/// Whether a straight motion keeps the margin, at samples.
fn is_straight_clear(clearance: &mut Clearance, kind: Kind, from: &[f64], to: &[f64]) -> bool {
    (0..=50).all(|k| {
        let q: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + (b - a) * f64::from(k) / 50.0).collect();
        let nearest = clearance.nearest_at(&q.chunks(joints(kind)).collect::<Vec<_>>()).expect("a posture");
        // Links of one robot must only not meet; `nearest_at` tells of them where they overlap.
        let is_own = nearest.sides[0].robot == nearest.sides[1].robot;
        !is_own && nearest.distance >= MARGIN
    })
}

#[test]
fn two_arms_that_face_each_other_change_sides() {
    let mut blocked = 0;
    let tables = [Kind::Six, Kind::Seven].map(|kind| (kind, kind.table(2)));
    for ((kind, table), seed) in tables.iter().flat_map(|of| (1..=6).map(move |seed| (of, seed))) {
        let kind = *kind;
        let Problem { mut clearance, start, goal } = table.problem(seed);
        let found = planner(&clearance).find(&start, std::slice::from_ref(&goal));
        let points = found.unwrap_or_else(|error| panic!("{kind:?}, seed {seed}: {error}"));
        assert_eq!((&points[0], &points[points.len() - 1]), (&start, &goal));
        for leg in points.windows(2) {
            assert!(is_straight_clear(&mut clearance, kind, &leg[0], &leg[1]), "{kind:?}, seed {seed}");
        }
        blocked += u32::from(!is_straight_clear(&mut clearance, kind, &start, &goal));
    }
    assert!(blocked >= 4, "{blocked} of 12 cannot go straight");
}

#[test]
fn a_plan_of_four_arms_across_each_other_keeps_the_margin_in_its_stops_too() {
    let table = Kind::Six.table(4);
    let crossing = (1..=12).map(|seed| table.problem(seed)).find_map(|mut problem| {
        let is_clear = is_straight_clear(&mut problem.clearance, Kind::Six, &problem.start, &problem.goal);
        (!is_clear).then_some(problem)
    });
    let Problem { mut clearance, start, goal } = crossing.expect("a problem that is not solved straight");
    let plan = planner(&clearance).plan(&start, std::slice::from_ref(&goal));
    let plan = plan.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((plan.at(0.0), plan.at(plan.duration())), (start, goal));
    let closest = plan.closest(&mut clearance, 1e-2).expect("a clearance of its robots");
    assert!(closest.distance() >= MARGIN, "{closest}");
}

/// By checks, not by time. Searched in all joints at once, three of these 16 problems are solved by 400,000 checks.
#[test]
fn four_arms_find_their_paths_by_few_checks() {
    let tables = [Kind::Six, Kind::Seven].map(|kind| (kind, kind.table(4)));
    for ((kind, table), seed) in tables.iter().flat_map(|of| (1..=8).map(move |seed| (of, seed))) {
        let Problem { clearance, start, goal } = table.problem(seed);
        let found = planner(&clearance).find_first(&start, &[goal]);
        assert!(found.is_ok(), "{kind:?}, seed {seed}: {found:?}");
    }
}

#[test]
fn an_arm_that_is_where_it_shall_be_stays_there() {
    let (table, mut planned) = (Kind::Six.table(2), 0);
    for seed in 1..=12 {
        let Problem { clearance, start, mut goal } = table.problem(seed);
        goal[..6].copy_from_slice(&start[..6]);
        match planner(&clearance).find(&start, &[goal]) {
            Ok(points) => {
                planned += 1;
                assert!(points.iter().all(|q| q[..6] == start[..6]), "seed {seed}: {points:?}");
            }
            // Where the other one wants to be.
            Err(PlanError::GoalNotClear(_)) => {}
            Err(error) => panic!("seed {seed}: {error}"),
        }
    }
    assert!(planned >= 4, "{planned} of 12");
}

#[test]
fn several_arms_have_the_same_path_to_the_bit() {
    let Problem { clearance, start, goal } = Kind::Seven.table(4).problem(2);
    let bits = |planner: &mut Planner| -> Vec<u64> {
        let points = planner.find(&start, std::slice::from_ref(&goal)).expect("a path");
        points.into_iter().flatten().map(f64::to_bits).collect()
    };
    let mut one = planner(&clearance);
    let first = bits(&mut one);
    assert_eq!(first, bits(&mut one), "a planner that has planned before");
    assert_eq!(first, bits(&mut planner(&clearance)), "another planner");
    assert_ne!(first, bits(&mut planner(&clearance).with_seed(7)), "another seed");
}
