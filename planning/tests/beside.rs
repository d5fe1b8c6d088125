//! Plans beside robots that stand or follow a plan of their own.

use mrroc::generator::Each;
use mrroc::random::Random;
use mrroc_planning::{Plan, PlanError, Planner};
use mrroc_robots::Serial;
use mrroc_robots::clearance::Clearance;

use super::cells::{stopping, two_arms};
use super::stops::{Breaks, STEP, facing, least_distance_after};

fn clearance() -> Clearance {
    two_arms().build(stopping()).expect("two arms")
}

fn planner() -> Planner {
    Planner::new(clearance()).expect("a planner").with_effort(100_000)
}

/// A position in which an arm reaches into the middle, more often on its own side.
fn draw(random: &mut Random) -> Vec<f64> {
    (0..6)
        .map(|j| match j {
            0 => random.between(-0.2, 0.9),
            1 => random.between(-1.4, -0.2),
            2 => random.between(0.0, 1.8),
            _ => random.within(1.8),
        })
        .collect()
}

/// A plan of one arm of the two beside the other, which stands there.
fn plan_of_one(random: &mut Random, stands: &str, there: &[f64]) -> Plan {
    let mut planner = planner().beside_standing(stands, there).expect("the other one");
    loop {
        match planner.plan(&draw(random), &[draw(random)]) {
            Ok(plan) => return plan,
            Err(PlanError::StartNotClear(_) | PlanError::GoalNotClear(_) | PlanError::NotFound { .. }) => {}
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn what_an_arm_sweeps_is_no_farther_away_than_the_arm_is_at_any_time() {
    let mut random = Random::seeded(3);
    for _ in 0..2 {
        let left = plan_of_one(&mut random, "right", &[1.5, -1.5, 0.3, 0.0, 0.0, 0.0]);
        for from in [0.0, 0.6 * left.duration()] {
            let beside = planner().beside(&left, from).expect("the right one");
            let (mut swept, mut both) = (beside.clearance().clone(), clearance());
            let mut least = f64::INFINITY;
            for _ in 0..200 {
                let right = draw(&mut random);
                let at = left.at(random.between(from, left.duration() + 0.1));
                let apart = both.nearest_at(&[&at, &right]).expect("a posture");
                // Whatever is nearest, only what is between the two arms has changed.
                let known = swept.nearest_at(&[&right]).expect("a posture");
                assert!(known.distance <= apart.distance + 1e-9, "{known}, and {apart}");
                least = least.min(known.distance - apart.distance);
            }
            assert!(least < 0.0, "one of them is nearer");
        }
    }
}

#[test]
fn an_arm_at_the_end_of_its_plan_is_as_far_away_as_the_arm_that_stands_there() {
    let mut random = Random::seeded(5);
    let left = plan_of_one(&mut random, "right", &[1.5, -1.5, 0.3, 0.0, 0.0, 0.0]);
    let end = left.at(left.duration());
    let mut both = clearance();
    let over = planner().beside(&left, left.duration()).expect("the right one");
    let stands = planner().beside_standing("left", &end).expect("the right one");
    for planner in [over, stands] {
        let mut alone = planner.clearance().clone();
        for _ in 0..300 {
            let right = draw(&mut random);
            let [one, other] = [both.nearest_at(&[&end, &right]), alone.nearest_at(&[&right])];
            let (one, other) = (one.expect("a posture"), other.expect("a posture"));
            // Links of the left arm that overlap one another are not seen any more.
            if one.sides.iter().any(|side| side.robot.is_some_and(|name| name.as_str() == "right")) {
                assert!((one.distance - other.distance).abs() < 1e-9, "{one}, and {other}");
            }
        }
    }
}

/// The left arm passes the middle, the right one must pass it too, at another height. They begin at different times, and are stopped at
/// any: one of them up to a step later than the other.
#[test]
fn two_arms_with_plans_of_their_own_keep_the_margin_whenever_they_begin_and_stop() {
    let at = |turned: f64| vec![turned, -0.7, 0.9, -1.8, -1.57, 0.0];
    let folded = |turned: f64| vec![turned, -1.2, 1.8, -1.8, -1.57, 0.0];
    let mut random = Random::seeded(11);
    let mut least = f64::INFINITY;
    for seed in 1..=3 {
        let side = random.between(0.4, 0.7);
        let left = planner().beside_standing("right", &at(1.6)).expect("the left one").with_seed(seed);
        let left =
            left.clone().plan(&folded(side), &[folded(-side)]).unwrap_or_else(|error| panic!("{error}"));
        let mut right = planner().beside(&left, 0.0).expect("the right one").with_seed(seed);
        let right = right.plan(&at(1.6), &[at(-1.6)]).unwrap_or_else(|error| panic!("{error}"));
        let [steps, others] = [&left, &right].map(|plan| (plan.duration() / STEP.as_secs_f64()) as usize);
        let here = [left.at(0.0), right.at(0.0)].concat();
        for _ in 0..8 {
            let waits = [random.below(others), random.below(steps)].map(|wait| wait as u32);
            let last = (steps + waits[0] as usize).max(others + waits[1] as usize);
            let k = random.below(last) as u32;
            let (left, right) = (left.clone(), right.clone());
            let cell = facing(&here).program(move |mp| {
                let (mut one, mut two) = (mp.robot::<Serial<6>>("left")?, mp.robot::<Serial<6>>("right")?);
                let motions =
                    (Breaks::new(&left, 0, k).after(waits[0]), Breaks::new(&right, 0, k + 1).after(waits[1]));
                mp.move_robots((&mut one, &mut two), (), Each::of(motions)).map(drop)
            });
            let (distance, _) = least_distance_after(cell, clearance(), 0.0);
            assert!(distance >= 0.02 - 1e-4, "waits {waits:?}, a fault in step {k}: {distance}");
            least = least.min(distance);
        }
    }
    println!("least {least}");
}

#[test]
fn a_plan_goes_around_an_arm_that_stands_in_between() {
    let stands = [0.0, -1.0, 1.3, -1.8, -1.57, 0.0];
    let at = |turned: f64| vec![turned, -0.7, 0.9, -1.8, -1.57, 0.0];
    let (from, to) = (at(-1.3), at(0.6));
    let mut beside = planner().beside_standing("right", &stands).expect("the left one");
    let plan = beside.plan(&from, core::slice::from_ref(&to)).unwrap_or_else(|error| panic!("{error}"));
    let mut both = clearance();
    for k in 0..=500 {
        let at = plan.at(plan.duration() * f64::from(k) / 500.0);
        let nearest = both.nearest_at(&[&at, &stands]).expect("a posture");
        assert!(nearest.distance >= 0.02, "{nearest}");
    }
    let between = both.nearest_at(&[&at(-0.6), &stands]).expect("a posture");
    assert!(between.distance < 0.0, "{between}: the straight motion would meet it");
    assert_eq!(plan.at(plan.duration()), to);
    let closest = plan.closest(&mut beside.clearance().clone(), 5e-3).expect("a clearance of its robots");
    assert!(closest.distance() >= 0.02, "{closest}");
}

#[test]
fn who_cannot_be_planned_beside_is_told() {
    let planner = planner();
    let told = |result: Result<Planner, PlanError>| result.err().expect("refused").to_string();
    let q = [0.0; 6];
    assert_eq!(
        told(planner.beside_standing("middle", &q)),
        "no robot is called middle here: the robots are left, right"
    );
    assert!(told(planner.beside_standing("left", &q[..5])).starts_with("6 joint positions are needed, 5"));
    let nan = [0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0];
    assert!(
        told(planner.beside_standing("left", &nan)).starts_with("left: the joints of the standing position")
    );
    let right = planner.beside_standing("left", &q).expect("one is left");
    assert_eq!(told(right.beside_standing("right", &q)), "a planner takes 1 to 4 robots, here are 0");
    let blocked = right.clone().plan(&q, &[q.to_vec()]).expect_err("both reach to the middle").to_string();
    assert!(blocked.starts_with("the start is not clear by the margin: right link"), "{blocked}");
    assert!(blocked.contains(" and left "), "{blocked}");
}
