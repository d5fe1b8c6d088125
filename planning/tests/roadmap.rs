//! What a planner remembers of its queries.

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::Robot;
use mrroc_planning::{PlanError, Planner};
use mrroc_robots::Six;
use mrroc_robots::clearance::{Clearance, Outline};
use nalgebra::Vector3;

use super::cells::{around_a_box, six_axes, stopping};
use super::plans::{A, B};

/// Too few checks for any search, not for a look at what is known.
const HARDLY_ANY: u64 = 5;

fn world() -> Clearance {
    around_a_box().build(stopping()).expect("a clearance")
}

fn planner(positions: usize) -> Planner {
    Planner::new(world()).expect("a planner").with_roadmap(positions)
}

fn is_found(planner: Planner, from: &[f64], to: &[f64]) -> bool {
    match planner.with_effort(HARDLY_ANY).find(from, &[to.to_vec()]) {
        Ok(_) => true,
        Err(PlanError::NotFound { .. }) => false,
        Err(error) => panic!("{error}"),
    }
}

/// Clear positions on both sides of the box.
fn positions(count: usize) -> Vec<Vec<f64>> {
    let (mut random, mut planner) = (Random::seeded(3), planner(0));
    let mut found = Vec::new();
    while found.len() < count {
        let near = if found.len() % 2 == 0 { A } else { B };
        let q = near.map(|q| q + random.within(0.5)).to_vec();
        if planner.find_first(&q, std::slice::from_ref(&q)).is_ok() {
            found.push(q);
        }
    }
    found
}

#[test]
fn a_question_that_was_answered_needs_no_search_in_either_direction() {
    let mut planner = planner(1000);
    assert!(!is_found(planner.clone(), &A, &B), "nothing is known");
    planner.plan(&A, &[B.to_vec()]).expect("a plan");
    assert!(is_found(planner.clone(), &A, &B) && is_found(planner.clone(), &B, &A));
    assert!(!is_found(planner.with_roadmap(0), &A, &B), "nothing is remembered");
}

#[test]
fn positions_near_what_is_known_are_joined_to_it_and_the_path_keeps_the_margin() {
    let (mut planner, mut world) = (planner(1000), world());
    let all = positions(20);
    for pair in all.windows(2) {
        let path = planner.find(&pair[0], &[pair[1].clone()]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((&path[0], &path[path.len() - 1]), (&pair[0], &pair[1]));
        for (leg, k) in path.windows(2).flat_map(|leg| (0..=50).map(move |k| (leg, k))) {
            let q: Vec<f64> =
                leg[0].iter().zip(&leg[1]).map(|(a, b)| a + (b - a) * f64::from(k) / 50.0).collect();
            let nearest = world.nearest_at(&[&q]).expect("a posture");
            assert!(nearest.distance >= 0.02, "{nearest}");
        }
    }
    // From each of these positions to each other: all of them have come to hang together.
    let known = all.iter().filter(|q| is_found(planner.clone(), &all[0], q)).count();
    assert_eq!(known, 20);
}

#[test]
fn the_same_sequence_of_questions_has_the_same_plans_to_the_bit() {
    let all = positions(12);
    let answers = |mut planner: Planner| -> Vec<Vec<u64>> {
        let find = |pair: &[Vec<f64>]| planner.find(&pair[0], &[pair[1].clone()]).expect("a path");
        all.windows(2).map(find).map(|path| path.into_iter().flatten().map(f64::to_bits).collect()).collect()
    };
    // Few positions, so that some are forgotten.
    let mut first = planner(30);
    first.find(&A, &[B.to_vec()]).expect("a path");
    let (clone, mut second) = (first.clone(), planner(30));
    second.find(&A, &[B.to_vec()]).expect("a path");
    let expected = answers(first);
    assert_eq!(expected, answers(clone), "a clone goes on from what was known");
    assert_eq!(expected, answers(second), "another planner that was asked the same");
}

#[test]
fn with_something_to_keep_upright_or_beside_a_robot_nothing_is_known() {
    let elsewhere = six_axes(Pose::translation(5.0, 0.0, 0.0));
    let world = around_a_box().robot("other", elsewhere).expect("an arm");
    let world = world.ignore(("other", "link 0"), ("table", "table")).build(stopping()).expect("a clearance");
    let stands = [0.0, -1.2, 1.8, -1.8, -1.57, 0.0];
    let [from, to] = [A, B].map(|q| [q, stands].concat());
    let mut planner = Planner::new(world).expect("a planner").with_roadmap(1000);
    planner.find(&from, std::slice::from_ref(&to)).expect("a path");
    let upright = planner.clone().with_upright("arm", Vector3::z(), 3.1).expect("an axis");
    let mut beside = planner.beside_standing("other", &stands).expect("the arm");
    assert!(is_found(planner, &from, &to) && !is_found(upright, &from, &to));
    assert!(!is_found(beside.clone(), &A, &B), "nothing is known");
    beside.find(&A, &[B.to_vec()]).expect("a path");
    assert!(is_found(beside, &A, &B), "it remembers as many positions");
}

#[test]
fn a_path_that_is_made_shorter_is_known_only_where_it_is_clear() {
    let mut planner = planner(1000);
    let mut turned = A;
    turned[0] -= 0.1;
    planner.find(&A, &[turned.to_vec()]).expect("a path");
    // Straight through the box.
    let mut path = vec![A.to_vec(), B.to_vec()];
    planner.shorten(&mut path);
    assert_eq!(path, [A.to_vec(), B.to_vec()]);
    assert!(!is_found(planner, &A, &B));
}

#[test]
fn a_start_that_is_a_goal_at_the_tolerance_of_an_axis_is_found_beside_what_is_known() {
    let flange = |q: &[f64]| six_axes(Pose::identity()).robot().forward(&Six::from_column_slice(q)).rotation;
    let upright = flange(&A).inverse() * Vector3::z();
    let mut turned = A;
    turned[0] -= 0.1;
    // In single precision about half of them are tilted a little more than is allowed, so that no motion to where they are is clear.
    for k in 0..10 {
        let mut tilted = A;
        tilted[3] -= 0.3 + 0.01 * f64::from(k);
        let tolerance = (flange(&tilted) * upright).angle(&Vector3::z()) + 1e-12;
        let mut planner = planner(1000).with_upright("arm", upright, tolerance).expect("an axis");
        planner.find(&A, &[turned.to_vec()]).expect("a path");
        let path = planner.find(&tilted, &[tilted.to_vec()]).expect("it is there");
        assert_eq!(path, [tilted.to_vec(), tilted.to_vec()]);
    }
}
