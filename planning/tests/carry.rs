//! A plate that two arms carry over a box.

use core::f64::consts::FRAC_PI_2;
use std::time::Duration;

use mrroc::pose::Pose;
use mrroc::program::Recorded;
use mrroc::random::Random;
use mrroc::robot::Robot;
use mrroc_generators::cooperation::{BodyFrame, BodyPath};
use mrroc_planning::{Carried, Holders, Plan, PlanError, Planner};
use mrroc_robots::clearance::{Clearance, Obstacle};
use mrroc_robots::{Serial, Six};
use nalgebra::Vector3;

use super::examples::carry_a_plate::{FROM, TO, arms, world};
use super::models::seven_axes_model;

const MARGIN: f64 = 0.02;

struct Cell {
    arms: [Serial<6>; 2],
    start: Vec<f64>,
    world: Clearance,
    holders: Holders,
}

fn cell() -> Cell {
    let (arms, start) = arms().expect("arms");
    let world = world(&arms, Duration::from_millis(2)).expect("a clearance");
    let holders = Holders::new().and("left", &arms[0]).and("right", &arms[1]);
    Cell { arms, start, world, holders }
}

fn carried(cell: &Cell, to: &Pose) -> Result<Carried, PlanError> {
    let mut planner = Planner::new(cell.world.clone()).expect("a planner");
    planner.carry(&cell.holders, BodyFrame::Centroid, &cell.start, to)
}

fn flanges(arms: &[Serial<6>; 2], q: &[f64]) -> [Pose; 2] {
    [0, 1].map(|i| arms[i].forward(&Six::from_column_slice(&q[6 * i..6 * i + 6])))
}

#[test]
fn two_arms_carry_a_plate_over_a_box_with_all_margins_and_limits_and_do_not_pull_at_it() {
    let mut cell = cell();
    let goal = Pose::new(Vector3::from(TO), Vector3::new(0.0, 0.1, -0.1));
    let carried = carried(&cell, &goal).unwrap_or_else(|error| panic!("{error}"));
    let (plan, step) = (carried.plan(), 1e-3);
    let held = flanges(&cell.arms, &cell.start);
    let held = held[0].inv_mul(&held[1]);
    let count = (plan.duration() / step).ceil() as usize;
    let samples: Vec<Vec<f64>> = (0..=count).map(|k| plan.at(k as f64 * step)).collect();
    let mut highest = 0.0_f64;
    for (k, q) in samples.iter().enumerate() {
        let [left, right] = flanges(&cell.arms, q);
        let off = held.inv_mul(&left.inv_mul(&right));
        assert!(off.translation.vector.norm() < 1e-9 && off.rotation.angle() < 1e-9, "at {k} ms: {off}");
        let body = BodyFrame::Centroid.pose(&[left, right]);
        let told = carried.body_at(k as f64 * step);
        assert!((body.translation.vector - told.translation.vector).norm() < 1e-9, "at {k} ms");
        highest = highest.max(told.translation.vector.z);
        let nearest = cell.world.nearest_at(&[&q[..6], &q[6..]]).expect("a posture");
        let is_own = nearest.sides[0].robot == nearest.sides[1].robot;
        assert!(is_own && nearest.distance > 0.0 || nearest.distance >= MARGIN, "at {k} ms: {nearest}");
    }
    // Through the box it would stay at 0.3 m.
    assert!(highest > FROM[2] + 0.05, "{highest}");
    let end = flanges(&cell.arms, &samples[count]);
    let body = (goal.translation.vector - BodyFrame::Centroid.pose(&end).translation.vector).norm();
    assert!(body < 1e-9, "{body}");
    let limits = cell.arms[0].limits();
    for three in samples.windows(3) {
        for (j, before) in three[0].iter().enumerate() {
            let velocity = (three[2][j] - before) / (2.0 * step);
            let acceleration = (three[2][j] - 2.0 * three[1][j] + before) / (step * step);
            let (lower, upper) = (limits.lower[j % 6], limits.upper[j % 6]);
            assert!((lower..=upper).contains(&three[1][j]), "joint {j}: {} rad", three[1][j]);
            assert!(velocity.abs() <= limits.velocity[j % 6], "joint {j}: {velocity} rad/s");
            assert!(acceleration.abs() <= limits.acceleration[j % 6], "joint {j}: {acceleration} rad/s^2");
        }
    }
}

#[test]
fn a_path_of_a_body_begins_where_it_is_and_ends_exactly_once() {
    let cell = cell();
    let goal = Pose::translation(FROM[0], 0.05, FROM[2] + 0.1);
    let carried = carried(&cell, &goal).unwrap_or_else(|error| panic!("{error}"));
    let begin = BodyFrame::Centroid.pose(&flanges(&cell.arms, &cell.start));
    let mut path = carried.path();
    path.begin(&begin).expect("it is there");
    let mut last = None;
    while let Some(pose) = path.advance(2e-3).expect("a path") {
        last = Some(pose);
    }
    assert_eq!(last, Some(goal));
    let elsewhere = begin * Pose::translation(0.0, 0.0, 0.001);
    let text = path.begin(&elsewhere).expect_err("refused").to_string();
    assert!(text.contains("1.00e-3 m"), "{text}");
}

#[test]
fn the_same_body_has_the_same_motion_to_the_bit_and_stays_where_it_is_told_to() {
    let cell = cell();
    let goal = Pose::translation(TO[0], TO[1], TO[2]);
    let bits = || -> Vec<u64> {
        let carried = carried(&cell, &goal).expect("a plan");
        let plan = carried.plan();
        (0..50).flat_map(|k| plan.at(0.05 * f64::from(k))).map(f64::to_bits).collect()
    };
    assert_eq!(bits(), bits());
    let begin = BodyFrame::Centroid.pose(&flanges(&cell.arms, &cell.start));
    let still = carried(&cell, &begin).expect("a plan");
    assert_eq!((still.plan().duration(), still.plan().at(0.0)), (0.0, cell.start.clone()));
}

#[test]
fn what_cannot_be_carried_is_told() {
    let cell = cell();
    let far = carried(&cell, &Pose::translation(-2.0, 0.0, 0.3)).err().expect("out of reach");
    assert_eq!(
        far.to_string(),
        "left cannot hold the body at the goal: no joint positions within the limits on the branch of the start"
    );
    let low = carried(&cell, &Pose::translation(TO[0] + 0.15, 0.0, 0.3)).err().expect("in the box");
    assert!(low.to_string().starts_with("the goal is not clear by the margin"), "{low}");
    let refused = |world: &Clearance, holders: &Holders| {
        let mut planner = Planner::new(world.clone()).expect("a planner");
        let goal = Pose::translation(TO[0], TO[1], TO[2]);
        planner.carry(holders, BodyFrame::Centroid, &cell.start, &goal).err().expect("refused")
    };
    let stranger = Holders::new().and("middle", &cell.arms[0]);
    assert!(matches!(refused(&cell.world, &stranger), PlanError::NoRobot { .. }));
    assert_eq!(refused(&cell.world, &Holders::new()), PlanError::NoHolder);
    let longer = Holders::new().and("left", &seven_axes_model(Pose::identity()));
    assert_eq!(refused(&cell.world, &longer), PlanError::Joints { expected: 6, actual: 7 });
    // The base of the left arm is 0.35 m from the origin.
    let forgotten = Holders::new().and("left", &cell.arms[0].clone().with_base(Pose::identity()));
    let text = refused(&cell.world, &forgotten).to_string();
    assert!(text.starts_with("left: its flange is 3.50e-1 m from where the clearance has it"), "{text}");
    let mut world = cell.world.clone();
    world.release("left", "plate").expect("it has grasped the plate");
    let text = refused(&world, &cell.holders).to_string();
    assert!(text.contains("(left, right)") && text.contains("`Clearance::grasp`"), "{text}");
}

#[test]
fn a_body_is_carried_where_another_arm_stands_hardly_farther_than_its_margin_from_something() {
    let mut cell = cell();
    let holders = Holders::new().and("left", &cell.arms[0]);
    // The right arm points up, 0.35 m beside the plate's middle.
    cell.start[6..].copy_from_slice(&[0.0, -FRAC_PI_2, 0.0, -FRAC_PI_2, 0.0, 0.0]);
    let goal = Pose::translation(FROM[0] - 0.1, -0.25, FROM[2] + 0.05);
    let half = Vector3::new(0.05, 0.1, 0.2);
    let mut carried_beside = |x: f64| {
        let at = Pose::translation(x + half.x, 0.35, 0.5);
        cell.world.replace_obstacle("box", Obstacle::Box { X_WO: at, half }).expect("a box");
        let mut planner = Planner::new(cell.world.clone()).expect("a planner");
        planner.carry(&holders, BodyFrame::Centroid, &cell.start, &goal)
    };
    let is_too_near = |found: &Result<Carried, PlanError>| matches!(found, Err(PlanError::StartNotClear(_)));
    assert!(is_too_near(&carried_beside(0.05)));
    // At the first place that is far enough the box is clear by less than 0.1 mm more than the margin.
    let first =
        (0..1000).map(|k| carried_beside(0.05 + 1e-4 * f64::from(k))).find(|found| !is_too_near(found));
    let carried = first.expect("a place").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(carried.body_at(carried.plan().duration()), goal);
}

#[test]
fn robots_that_carry_a_body_get_no_other_plan_of_their_joints() {
    let cell = cell();
    let goal = Pose::translation(FROM[0], 0.05, FROM[2] + 0.1);
    let carried = carried(&cell, &goal).unwrap_or_else(|error| panic!("{error}"));
    let mut planner = Planner::new(cell.world.clone()).expect("a planner");
    let recorded = Plan::from_words(&carried.plan().to_words()).expect("the words of a plan");
    for plan in [carried.plan(), &recorded] {
        let error = planner.replan(plan, 0.1, std::slice::from_ref(&cell.start)).expect_err("refused");
        assert_eq!(error, PlanError::CarriesBody);
    }
}

/// As decision 7 has it: all arms go on along the twist of their last step, and brake by 0.8 of the acceleration of the joint that brakes the longest.
#[test]
fn arms_that_brake_on_the_common_twist_anywhere_on_the_path_keep_the_margin() {
    let mut cell = cell();
    let begin = BodyFrame::Centroid.pose(&flanges(&cell.arms, &cell.start));
    let grasps = flanges(&cell.arms, &cell.start).map(|flange| begin.inv_mul(&flange));
    let acceleration = cell.arms[0].limits().acceleration;
    let mut random = Random::seeded(4);
    let (mut planned, mut instants) = (0, 0);
    while planned < 6 {
        let at = Vector3::new(TO[0], random.within(0.08), random.between(0.3, 0.42));
        let turn = Vector3::new(random.within(0.1), random.within(0.15), random.within(0.15));
        let Ok(carried) = carried(&cell, &Pose::new(at, turn)) else { continue };
        planned += 1;
        let plan = carried.plan();
        let (mut time, h) = (0.02, 1e-4);
        while time < plan.duration() - h {
            let [before, behind] = [time - h, time + h].map(|time| (plan.at(time), carried.body_at(time)));
            let braking =
                |j: usize| (behind.0[j] - before.0[j]).abs() / (2.0 * h) / (0.8 * acceleration[j % 6]);
            let far = 0.03 + 0.5 * (0..12).map(braking).fold(0.0, f64::max);
            // The displacement of 2 h is repeated, a part of it for what is left.
            let step = behind.1 * before.1.inverse();
            let (mut body, mut q) = (carried.body_at(time), plan.at(time));
            for k in 0..(far / (2.0 * h)) as usize {
                body = step * body;
                if k % 20 != 0 {
                    continue;
                }
                for (i, grasp) in grasps.iter().enumerate() {
                    let own = 6 * i..6 * i + 6;
                    let near = Six::from_column_slice(&q[own.clone()]);
                    let found = cell.arms[i].inverse(&(body * grasp), &near).expect("a posture");
                    q[own].copy_from_slice(found.as_slice());
                }
                let nearest = cell.world.nearest_at(&[&q[..6], &q[6..]]).expect("a posture");
                let is_own = nearest.sides[0].robot == nearest.sides[1].robot;
                assert!(is_own || nearest.distance >= MARGIN, "plan {planned}, from {time} s: {nearest}");
            }
            instants += 1;
            time += 0.02;
        }
    }
    assert!(instants > 500, "{instants}");
}
