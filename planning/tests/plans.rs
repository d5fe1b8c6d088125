//! Plans: limits, stops, and the robots that follow them.

use mrroc::robot::Robot;
use mrroc_planning::{Planner, goals_at, goals_turned};
use mrroc_robots::clearance::{Capsule, Clearance, Obstacle};
use mrroc_robots::{Irp6, Six};
use nalgebra::Vector3;

use super::cells::{around_a_box, stopping};

/// Right and left of the box, the arm stretched out low.
pub(crate) const A: [f64; 6] = [-0.9, -0.3, 0.6, -1.8, -1.57, 0.0];
pub(crate) const B: [f64; 6] = [0.9, -0.3, 0.6, -1.8, -1.57, 0.0];

#[test]
fn an_arm_goes_around_a_box() {
    let mut clearance = around_a_box().build(stopping()).expect("a clearance");
    let mut planner = Planner::new(clearance.clone()).expect("a planner");
    let plan = planner.plan(&A, &[B.to_vec()]).unwrap_or_else(|error| panic!("{error}"));
    let closest = plan.closest(&mut clearance, 2e-3).expect("a clearance of its robots");
    // Straight through the box it would be 1.8 rad.
    assert!(plan.length() > 1.9, "{}", plan.length());
    assert!(closest.distance() >= 0.02, "{closest}");
    assert_eq!((plan.at(0.0), plan.at(plan.duration())), (A.to_vec(), B.to_vec()));
}

#[test]
fn the_same_question_has_the_same_plan_to_the_bit() {
    let plan = || {
        let clearance = around_a_box().build(stopping()).expect("a clearance");
        let mut planner = Planner::new(clearance).expect("a planner").with_seed(5);
        // A planner that has planned before answers as a new one.
        let first = planner.plan(&A, &[B.to_vec()]).expect("a plan");
        let second = planner.plan(&A, &[B.to_vec()]).expect("a plan");
        (first, second)
    };
    let ((one, two), (three, _)) = (plan(), plan());
    for k in 0..200 {
        let at = |plan: &mrroc_planning::Plan| {
            let q = plan.at(0.01 * f64::from(k));
            q.into_iter().map(f64::to_bits).collect::<Vec<_>>()
        };
        assert_eq!(at(&one), at(&three), "at {k}");
        assert_eq!(at(&one), at(&two), "at {k}");
    }
}

#[test]
fn what_cannot_be_planned_is_told() {
    let clearance = around_a_box().build(stopping()).expect("a clearance");
    let mut planner = Planner::new(clearance).expect("a planner").with_effort(2000);
    let mut error =
        |start: &[f64], goal: &[f64]| planner.plan(start, &[goal.to_vec()]).expect_err("none").to_string();
    let mut through = A;
    through[0] = 0.2;
    assert!(
        error(&through, &B).starts_with("the start is not clear by the margin: arm"),
        "{}",
        error(&through, &B)
    );
    assert!(error(&A, &through).starts_with("the goal is not clear by the margin: arm"));
    assert_eq!(
        error(&A[..5], &B),
        "6 joint positions are needed, 5 were given: those of all robots, one behind the other"
    );
    let mut beyond = B;
    beyond[2] = 3.2;
    assert_eq!(
        error(&A, &beyond),
        "arm joint 3: position 3.2 of the goal is not within its limits -3.1416 to 3.1416"
    );
    beyond[2] = f64::NAN;
    assert!(error(&A, &beyond).contains("joint 3: position NaN of the goal"));
    assert_eq!(
        planner.plan(&A, &[]).expect_err("none").to_string(),
        "no goal: the pose has no solution within the limits of the joints"
    );
}

#[test]
fn a_plan_to_where_the_robots_are_lasts_no_time() {
    let clearance = around_a_box().build(stopping()).expect("a clearance");
    let plan = Planner::new(clearance).expect("a planner").plan(&A, &[A.to_vec()]).expect("a plan");
    assert_eq!((plan.duration(), plan.at(0.5)), (0.0, A.to_vec()));
}

/// An arm whose joints move its links by cranks, and share limits, is no chain: its shape is asked posture by posture.
#[test]
fn an_arm_that_is_no_chain_goes_around_a_post() {
    let robot = Irp6::nominal();
    let post = |angle: f64| {
        let at = Vector3::new(angle.cos(), angle.sin(), 0.0) * 0.8;
        Obstacle::Capsule(Capsule::new(at, at + Vector3::z() * 0.9, 0.05))
    };
    let turned = |by: f64| {
        let mut q = Irp6::READY;
        q[0] += by;
        q.as_slice().to_vec()
    };
    let ahead = robot.forward(&Irp6::READY).translation.vector;
    let build = || Clearance::with_margin(0.02).robot("irp6", Irp6::nominal()).expect("an arm");
    let clearance = build().obstacle("post", post(ahead.y.atan2(ahead.x))).expect("a post").build(stopping());
    let mut clearance = clearance.expect("a clearance");
    let mut planner = Planner::new(clearance.clone()).expect("a planner");
    let plan = planner.plan(&turned(-0.8), &[turned(0.8)]).unwrap_or_else(|error| panic!("{error}"));
    let closest = plan.closest(&mut clearance, 5e-3).expect("a clearance of its robots");
    assert!(plan.length() > 1.7, "{}", plan.length());
    assert!(closest.distance() >= 0.02, "{closest}");
}

#[test]
fn goals_of_a_region_are_turned_about_its_axis_alone() {
    let robot = Irp6::nominal();
    let (pose, near) = (robot.forward(&Irp6::READY), Irp6::READY.as_slice());
    let (axis, tolerance) = (Vector3::new(0.0, 0.0, 2.0), 0.5);
    let goals = goals_turned(&robot, &pose, axis, tolerance, near);
    let mut turns = Vec::new();
    for goal in &goals {
        let at = robot.forward(&Six::from_column_slice(goal));
        let off = pose.inverse() * at;
        assert!(off.translation.vector.norm() < 1e-9);
        let turn = off.rotation.scaled_axis();
        assert!(turn.x.hypot(turn.y) < 1e-9 && turn.z.abs() <= tolerance + 1e-9, "{turn}");
        turns.push(turn.z);
    }
    for expected in [0.0, 0.25, -0.25, 0.5, -0.5] {
        assert!(turns.iter().any(|turn| (turn - expected).abs() < 1e-9), "{expected} of {turns:?}");
    }
    let untold = goals_turned(&robot, &pose, Vector3::zeros(), tolerance, near);
    assert_eq!(untold, goals_at(&robot, &pose, near), "no axis, no turn");
}

#[test]
fn a_reaction_time_that_is_none_is_refused() {
    for reaction in [-0.1, f64::NAN, f64::INFINITY] {
        let clearance = around_a_box().build(stopping()).expect("a clearance");
        let mut planner = Planner::new(clearance).expect("a planner").with_reaction(reaction);
        let error = planner.plan(&A, &[B.to_vec()]).expect_err("refused").to_string();
        assert_eq!(error, format!("a reaction time of {reaction} s: it must be finite and at least 0"));
    }
}
