//! Plans: limits, stops, and the robots that follow them.

use mrroc_planning::Planner;

use super::cells::{around_a_box, stopping};

/// Right and left of the box, the arm stretched out low.
pub(crate) const A: [f64; 6] = [-0.9, -0.3, 0.6, -1.8, -1.57, 0.0];
pub(crate) const B: [f64; 6] = [0.9, -0.3, 0.6, -1.8, -1.57, 0.0];

#[test]
fn an_arm_goes_around_a_box() {
    let mut clearance = around_a_box().build(stopping()).expect("a clearance");
    let mut planner = Planner::new(clearance.clone()).expect("a planner");
    let plan = planner.plan(&A, &[B.to_vec()]).unwrap_or_else(|error| panic!("{error}"));
    let closest = plan.closest(&mut clearance, 1e-3).expect("a clearance of its robots");
    // Straight through the box it would be 1.8 rad.
    assert!(plan.length() > 1.9, "{}", plan.length());
    println!("{} s, {} rad, {} at {} s", plan.duration(), plan.length(), closest.nearest, closest.time);
    assert!(closest.nearest.distance >= 0.02, "{}", closest.nearest);
    assert_eq!((plan.at(0.0), plan.at(plan.duration())), (A.to_vec(), B.to_vec()));
}
