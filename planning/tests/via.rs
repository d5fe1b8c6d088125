//! Motions through positions in between.

use mrroc::random::Random;
use mrroc_planning::{Plan, PlanError, Planner};

use super::cells::{around_a_box, stopping};
use super::plans::{A, B};

/// Above the box.
const ABOVE: [f64; 6] = [0.1, -1.6, 0.5, -0.5, -1.57, 0.0];

fn planner() -> Planner {
    Planner::new(around_a_box().build(stopping()).expect("a clearance")).expect("a planner")
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt()
}

/// When a plan is nearest to a position: the time \[s\], how near, and its speed then, over all joints [rad/s].
fn passes(plan: &Plan, via: &[f64]) -> (f64, f64, f64) {
    let apart = |time: f64| distance(&plan.at(time), via);
    let (mut width, mut best) = (1e-3, 0.0);
    for k in 0..=(plan.duration() / width) as usize {
        let time = width * k as f64;
        if apart(time) < apart(best) {
            best = time;
        }
    }
    while width > 1e-13 {
        width *= 0.7;
        for time in [best - width, best + width] {
            if apart(time) < apart(best) {
                best = time;
            }
        }
    }
    let h = 1e-5;
    (best, apart(best), distance(&plan.at(best - h), &plan.at(best + h)) / (2.0 * h))
}

#[test]
fn a_motion_passes_the_position_in_between_exactly_and_does_not_rest_there() {
    let mut planner = planner();
    // Nothing is near there.
    let (from, via, to) = (
        [2.0, -1.6, 0.5, -0.5, -1.57, 0.0],
        [2.8, -1.4, 0.9, -0.4, -1.2, 0.3],
        [3.1, -0.9, 0.9, -0.4, -1.0, 1.0],
    );
    let plan = planner.plan_through(&from, &[[via.to_vec()], [to.to_vec()]]).expect("a plan");
    let (time, apart, speed) = passes(&plan, &via);
    assert!(apart < 1e-9, "{apart} rad from it at {time} s");
    assert!(speed > 0.5, "{speed} rad/s at {time} s");
    assert_eq!((plan.at(0.0), plan.at(plan.duration())), (from.to_vec(), to.to_vec()));
    let two = planner.plan(&from, &[via.to_vec()]).expect("a plan").duration()
        + planner.plan(&via, &[to.to_vec()]).expect("a plan").duration();
    assert!(plan.duration() < two, "{} s, and {two} s with a rest", plan.duration());
}

#[test]
fn a_motion_between_obstacles_passes_the_position_in_between_too() {
    let plan = planner().plan_through(&A, &[[ABOVE.to_vec()], [B.to_vec()]]).expect("a plan");
    let (time, apart, speed) = passes(&plan, &ABOVE);
    assert!(apart < 1e-9 && speed > 0.05, "{apart} rad from it at {speed} rad/s at {time} s");
    assert_eq!((plan.at(0.0), plan.at(plan.duration())), (A.to_vec(), B.to_vec()));
}

#[test]
fn motions_through_random_positions_are_clear_and_pass_all_of_them_in_their_order() {
    let mut clearance = around_a_box().build(stopping()).expect("a clearance");
    let (mut planned, mut at_speed, mut all) = (0, 0, 0);
    for seed in 1..=30 {
        let mut random = Random::seeded(seed);
        let mut planner = planner().with_seed(seed).with_effort(50_000);
        // Positions that are clear.
        let mut draw = || loop {
            let q: Vec<f64> = (0..6)
                .map(|j| if j == 1 { random.between(-2.5, -0.5) } else { random.within(2.0) })
                .collect();
            if planner.find_first(&q, core::slice::from_ref(&q)).is_ok() {
                break q;
            }
        };
        let (start, vias) = (draw(), [draw(), draw(), draw()]);
        let plan = match planner.plan_through(&start, &vias.clone().map(|via| [via])) {
            Ok(plan) => plan,
            Err(PlanError::Stage { .. }) => continue,
            Err(error) => panic!("seed {seed}: {error}"),
        };
        planned += 1;
        let mut before = 0.0;
        for via in &vias[..2] {
            let (time, apart, speed) = passes(&plan, via);
            // Where there is no room, within 1e-4.
            assert!(apart < 1e-4 && time > before, "seed {seed}: {apart} rad from it at {time} s");
            before = time;
            all += 1;
            if speed > 0.1 {
                assert!(apart < 1e-9, "seed {seed}: {apart} rad from it at {speed} rad/s");
                at_speed += 1;
            }
        }
        assert_eq!(plan.at(plan.duration()), vias[2]);
        let closest = plan.closest(&mut clearance, 0.01).expect("a clearance of its robots");
        assert!(closest.distance() >= 0.02, "seed {seed}:\n{closest}");
    }
    assert!(planned >= 15 && 10 * at_speed >= 9 * all, "{planned} plans, {at_speed} of {all} at speed");
}

#[test]
fn a_path_that_turns_back_does_so_within_a_ten_thousandth() {
    let mut up = A;
    up[1] -= 0.6;
    let plan = planner().plan_through(&A, &[[up.to_vec()], [A.to_vec()]]).expect("a plan");
    let (_, apart, speed) = passes(&plan, &up);
    assert!(apart < 1e-4 && speed < 0.1, "{apart} rad from it at {speed} rad/s");
}

#[test]
fn paths_that_nearly_turn_back_have_a_motion() {
    for k in 1..=24 {
        let mut up = A;
        up[1] -= 0.6;
        let mut aside = A;
        aside[0] -= 0.05 * f64::from(k);
        let plan = planner().plan_through(&A, &[[up.to_vec()], [aside.to_vec()]]);
        let plan = plan.unwrap_or_else(|error| panic!("{k}: {error}"));
        assert!(passes(&plan, &up).1 < 1e-4, "{k}: {:?}", passes(&plan, &up));
    }
}

#[test]
fn a_position_that_is_not_clear_is_left_out_for_another_one_of_its_list() {
    let mut through = A;
    through[0] = 0.2;
    let plan = planner().plan_through(&A, &[vec![through.to_vec(), ABOVE.to_vec()], vec![B.to_vec()]]);
    assert!(passes(&plan.expect("a plan"), &ABOVE).1 < 1e-9);
}

#[test]
fn positions_where_the_robot_is_already_change_nothing() {
    let at =
        |plan: &Plan, k: u32| plan.at(0.01 * f64::from(k)).into_iter().map(f64::to_bits).collect::<Vec<_>>();
    let plain = planner().plan(&A, &[B.to_vec()]).expect("a plan");
    let through = planner().plan_through(&A, &[[A.to_vec()], [B.to_vec()]]).expect("a plan");
    let again = planner().plan_through(&A, &[[A.to_vec()], [B.to_vec()]]).expect("a plan");
    for k in 0..200 {
        assert_eq!(at(&through, k), at(&again, k), "at {k}");
    }
    assert_eq!((through.at(0.0), through.at(9.0)), (plain.at(0.0), plain.at(9.0)));
    assert_eq!(planner().plan_through(&A, &[[A.to_vec()], [A.to_vec()]]).expect("a plan").duration(), 0.0);
}

#[test]
fn the_same_motion_through_positions_is_the_same_to_the_bit() {
    let mut planner = planner().with_seed(9);
    let mut plan = || planner.plan_through(&A, &[[ABOVE.to_vec()], [B.to_vec()]]).expect("a plan");
    let (one, two) = (plan(), plan());
    for k in 0..300 {
        let at = |plan: &Plan| plan.at(0.01 * f64::from(k)).into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(at(&one), at(&two), "at {k}");
    }
}

#[test]
fn what_fails_in_between_is_told_with_its_list() {
    let mut planner = planner();
    let none: [Vec<Vec<f64>>; 0] = [];
    assert_eq!(
        planner.plan_through(&A, &none).expect_err("none").to_string(),
        "no list of goals: a motion through positions needs at least one list, that of its end"
    );
    let mut through = A;
    through[0] = 0.2;
    let error =
        planner.plan_through(&A, &[[ABOVE.to_vec()], [through.to_vec()]]).expect_err("none").to_string();
    assert!(
        error.starts_with("no motion to list 2 of 2: the goal is not clear by the margin: arm"),
        "{error}"
    );
    let lists = [vec![], vec![B.to_vec()]];
    assert_eq!(
        planner.plan_through(&A, &lists).expect_err("none").to_string(),
        "no motion to list 1 of 2: no goal: the pose has no solution within the limits of the joints"
    );
}
