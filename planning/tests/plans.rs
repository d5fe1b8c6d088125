//! Plans: limits, stops, and the robots that follow them.

use mrroc_planning::Planner;

use super::cells::{around_a_box, stopping};

/// Right and left of the box, the arm stretched out low.
const A: [f64; 6] = [-0.9, -0.6, 0.8, -1.8, -1.57, 0.0];
const B: [f64; 6] = [0.9, -0.6, 0.8, -1.8, -1.57, 0.0];

#[test]
fn an_arm_goes_around_a_box() {
    let mut clearance = around_a_box().build(stopping()).expect("a clearance");
    let mut planner = Planner::new(clearance.clone()).expect("a planner");
    let plan = planner.plan(&A, &[B.to_vec()]).unwrap_or_else(|error| panic!("{error}"));
    let closest = plan.closest(&mut clearance, 1e-3).expect("a clearance of its robots");
    println!("{} s, {} rad, {:?}", plan.duration(), plan.length(), closest);
    assert!(closest.nearest.distance >= 0.02, "{}", closest.nearest);
    assert_eq!((plan.at(0.0), plan.at(plan.duration())), (A.to_vec(), B.to_vec()));
}
