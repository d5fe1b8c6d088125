//! Motions that keep an axis of a flange upright.

use core::f64::consts::FRAC_PI_2;

use mrroc::pose::Pose;
use mrroc::robot::Robot;
use mrroc_planning::{Plan, PlanError, Planner, goals_at};
use mrroc_robots::clearance::{Clearance, Obstacle, Outline};
use mrroc_robots::{Irp6, Six};
use nalgebra::Vector3;

use super::cells::{around_a_box, six_axes, stopping, two_arms};

/// The axis of the flange that points up at `A` and `B`: the tool points sideways there.
fn axis() -> Vector3<f64> {
    -Vector3::z()
}

/// Right and left of the box: the joints 2 to 4 add up to -pi/2, and the fifth is at -pi/2.
const A: [f64; 6] = [-0.9, -0.5, 1.1, -FRAC_PI_2 - 0.6, -FRAC_PI_2, 0.0];
const B: [f64; 6] = [0.9, -0.5, 1.1, -FRAC_PI_2 - 0.6, -FRAC_PI_2, 0.0];

/// How far the axis of a robot is from the vertical, in 2,000 instants of its plan, by forward kinematics [rad].
fn most_tilted(plan: &Plan, flange: impl Fn(&[f64]) -> Pose, axis: &Vector3<f64>) -> f64 {
    let instants = (0..=2000).map(|k| plan.at(plan.duration() * f64::from(k) / 2000.0));
    instants.map(|q| (flange(&q).rotation * axis).angle(&Vector3::z())).fold(0.0, f64::max)
}

fn six_flange(q: &[f64]) -> Pose {
    six_axes(Pose::identity()).robot().forward(&Six::from_column_slice(q))
}

#[test]
fn an_arm_goes_around_a_box_with_its_tool_upright() {
    let mut clearance = around_a_box().build(stopping()).expect("a clearance");
    for (seed, tolerance) in [(1, 0.3), (2, 0.1), (3, 0.1), (4, 0.02)] {
        let planner = Planner::new(clearance.clone()).expect("a planner").with_seed(seed);
        let free = planner.clone().plan(&A, &[B.to_vec()]).expect("a plan");
        assert!(most_tilted(&free, six_flange, &axis()) > 0.5, "seed {seed}: it is tilted where it may be");
        let mut planner = planner.with_upright("arm", axis(), tolerance).expect("an axis");
        let plan = planner.plan(&A, &[B.to_vec()]).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let tilt = most_tilted(&plan, six_flange, &axis());
        assert!(tilt <= tolerance, "seed {seed}: {tilt}");
        let closest = plan.closest(&mut clearance, 0.02).expect("a clearance of its robots");
        assert!(closest.distance() >= 0.02, "seed {seed}: {closest}");
    }
}

#[test]
fn a_motion_through_a_position_and_beside_another_arm_keeps_its_tool_upright() {
    let clearance = two_arms().build(stopping()).expect("two arms");
    let planner =
        Planner::new(clearance).expect("a planner").with_upright("right", axis(), 0.1).expect("an axis");
    let stands = [0.0, -1.2, 1.8, -1.8, -1.57, 0.0];
    let mut planner = planner.beside_standing("left", &stands).expect("the right one");
    let at = |turned: f64| {
        let mut q = A.to_vec();
        q[0] = turned;
        q
    };
    let high = vec![0.2, -1.3, 0.9, -FRAC_PI_2 + 0.4, -FRAC_PI_2, 0.0];
    let stages = [vec![high], vec![at(-1.2)]];
    let plan = planner.plan_through(&at(1.2), &stages).unwrap_or_else(|error| panic!("{error}"));
    let tilt = most_tilted(&plan, six_flange, &axis());
    assert!(tilt <= 0.1, "{tilt}");
}

/// Its joints share limits and move bars, so its shape is asked posture by posture.
#[test]
fn an_arm_that_is_no_chain_keeps_its_tool_upright() {
    let robot = Irp6::nominal();
    let pose = robot.forward(&Irp6::READY);
    let axis = pose.rotation.inverse() * Vector3::z();
    let clearance = Clearance::with_margin(0.02)
        .robot("irp6", Irp6::nominal())
        .expect("an arm")
        .obstacle("floor", Obstacle::table(-0.5))
        .expect("a floor");
    let planner = Planner::new(clearance.build(stopping()).expect("a clearance")).expect("a planner");
    let mut planner = planner.with_upright("irp6", axis, 0.05).expect("an axis");
    let turned = Pose::new(Vector3::new(0.0, 0.0, -0.2), Vector3::z() * 0.9) * pose;
    let goals = goals_at(&robot, &turned, Irp6::READY.as_slice());
    let plan = planner.plan(Irp6::READY.as_slice(), &goals).unwrap_or_else(|error| panic!("{error}"));
    let tilt = most_tilted(&plan, |q| robot.forward(&Six::from_column_slice(q)), &axis);
    assert!(tilt <= 0.05, "{tilt}");
}

#[test]
fn what_is_not_upright_or_no_axis_is_told() {
    let clearance = around_a_box().build(stopping()).expect("a clearance");
    let planner = Planner::new(clearance).expect("a planner");
    let told = |error: PlanError| error.to_string();
    let refused = |planner: Result<Planner, PlanError>| told(planner.err().expect("refused"));
    assert_eq!(
        refused(planner.clone().with_upright("left", axis(), 0.1)),
        "no robot is called left here: the robots are arm"
    );
    for (axis, tolerance) in
        [(Vector3::zeros(), 0.1), (Vector3::repeat(f64::NAN), 0.1), (axis(), 0.0), (axis(), 4.0)]
    {
        let error = refused(planner.clone().with_upright("arm", axis, tolerance));
        assert!(error.starts_with("arm: an axis that is kept upright is finite and not zero"), "{error}");
    }
    let mut planner = planner.with_upright("arm", 3.0 * axis(), 0.1).expect("of any length");
    let mut tilted = A;
    tilted[3] -= 0.25;
    let expected = |place: &str| {
        format!(
            "arm: the axis that is kept upright is tilted by 0.2500 rad at the {place}, 0.1000 rad are allowed"
        )
    };
    assert_eq!(told(planner.plan(&tilted, &[B.to_vec()]).expect_err("tilted")), expected("start"));
    assert_eq!(told(planner.plan(&A, &[tilted.to_vec()]).expect_err("tilted")), expected("goal"));
    planner.plan(&A, &[tilted.to_vec(), B.to_vec()]).expect("one of two is upright");
}

/// They cross each other, so one of them has to step aside or to wait.
#[test]
fn two_arms_in_one_plan_keep_both_tools_upright() {
    let mut clearance = two_arms().build(stopping()).expect("two arms");
    let planner = Planner::new(clearance.clone()).expect("a planner");
    let planner = planner.with_upright("left", axis(), 0.1).expect("an axis");
    let mut planner = planner.with_upright("right", axis(), 0.1).expect("an axis");
    let at = |turned: [f64; 2]| -> Vec<f64> {
        let of = |turned: f64| [turned, -0.9, 1.5, -FRAC_PI_2 - 0.6, -FRAC_PI_2, 0.0];
        [of(turned[0]), of(turned[1])].concat()
    };
    let plan = planner.plan(&at([0.9, 0.9]), &[at([-0.9, -0.9])]).unwrap_or_else(|error| panic!("{error}"));
    for first in [0, 6] {
        let tilt = most_tilted(&plan, |q| six_flange(&q[first..first + 6]), &axis());
        assert!(tilt <= 0.1, "{tilt}");
    }
    let closest = plan.closest(&mut clearance, 0.02).expect("a clearance of its robots");
    assert!(closest.distance() >= 0.02, "{closest}");
}
