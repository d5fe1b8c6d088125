//! New plans for robots that follow a plan.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::generator::{Class, Each, Generator, Motion};
use mrroc::prelude::*;
use mrroc::program::Recorded;
use mrroc::random::Random;
use mrroc_planning::{
    FollowPlan, Following, HereAll, Plan, PlanError, PlanGuard, Planner, Replanned, Replanner, Watched,
};
use mrroc_recording::{CutOff, Replay};
use mrroc_robots::Serial;
use mrroc_robots::clearance::{Obstacle, Outline, Stopping};

use super::cells::{Kind, around_a_box, draw_two, seven_axes, six_axes, stopping, two_arms};
use super::plans::{A, B};
use super::stops::{Breaks, STEP, facing, least_distance_after, setup, standing};

/// Above the box.
const ABOVE: [f64; 6] = [0.1, -1.6, 0.5, -0.5, -1.57, 0.0];

impl Kind {
    fn draw(self, random: &mut Random) -> Vec<f64> {
        match self {
            Kind::AroundABox => {
                (0..6).map(|j| if j == 1 { random.between(-2.5, -0.5) } else { random.within(2.0) }).collect()
            }
            Kind::TwoArms => draw_two(random),
            Kind::SevenAxes => (0..7).map(|_| random.within(1.2)).collect(),
        }
    }

    /// The limits of velocity, acceleration and jerk of a joint.
    fn limits(self, joint: usize) -> (f64, f64, Option<f64>) {
        match self {
            Kind::AroundABox | Kind::TwoArms => {
                let outline = six_axes(Pose::identity());
                let limits = outline.robot().limits();
                (limits.velocity[joint % 6], limits.acceleration[joint % 6], None)
            }
            Kind::SevenAxes => {
                let outline = seven_axes(Pose::identity());
                let limits = outline.robot().limits();
                (limits.velocity[joint], limits.acceleration[joint], limits.jerk.map(|jerk| jerk[joint]))
            }
        }
    }

    fn planner(self, seed: u64) -> Planner {
        let clearance = self.world().build(stopping()).expect("a clearance");
        Planner::new(clearance).expect("a planner").with_seed(seed).with_effort(50_000)
    }

    /// A plan, and another goal that can be reached.
    fn plan(self, planner: &mut Planner, random: &mut Random) -> (Plan, Vec<f64>) {
        loop {
            let [start, end, goal] = [(); 3].map(|()| self.draw(random));
            let Ok(plan) = planner.plan(&start, &[end]) else { continue };
            if planner.plan(&start, core::slice::from_ref(&goal)).is_ok() {
                return (plan, goal);
            }
        }
    }
}

fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// What a sweep of new plans has seen.
#[derive(Debug, Default)]
struct Sweep {
    planned: u32,
    refused: Vec<String>,
    /// The largest shares of the limits of velocity, acceleration and jerk.
    shares: [f64; 3],
    /// How long motions last from the hand-over on, by what they last from rest there.
    lasts: Vec<f64>,
}

impl Sweep {
    fn replan(&mut self, kind: Kind, seed: u64, instants: u32) {
        let mut clearance = kind.world().build(stopping()).expect("a clearance");
        let (mut planner, mut random) = (kind.planner(seed), Random::seeded(seed));
        let (plan, goal) = kind.plan(&mut planner, &mut random);
        for k in 0..instants {
            let at = plan.duration() * (f64::from(k) + random.unit()) / f64::from(instants);
            let new = match planner.replan(&plan, at, core::slice::from_ref(&goal)) {
                Ok(new) => new,
                Err(error) => {
                    self.refused.push(format!("seed {seed} at {at}: {error}"));
                    continue;
                }
            };
            self.planned += 1;
            let before = (0..=400).map(|k| at * f64::from(k) / 400.0);
            let apart = before.map(|time| farthest(&new.at(time), &plan.at(time))).fold(0.0, f64::max);
            assert!(apart < 1e-12, "{kind:?} seed {seed}: {apart} before {at}");
            assert_eq!(new.at(new.duration()), goal);
            let closest = new.closest(&mut clearance, 0.02).expect("a clearance of its robots");
            assert!(closest.distance() >= 0.02, "{kind:?} seed {seed} at {at}:\n{closest}");
            let again = Plan::from_words(&new.to_words()).expect("the words of a plan");
            assert_eq!(again.at(at + 0.1), new.at(at + 0.1));
            if let Ok(direct) = planner.plan(&plan.at(at), core::slice::from_ref(&goal)) {
                self.lasts.push((new.duration() - at) / direct.duration());
            }
            self.keeps_limits(kind, &new);
        }
    }

    /// By differences of positions at the instants of steps.
    fn keeps_limits(&mut self, kind: Kind, plan: &Plan) {
        let h = STEP.as_secs_f64();
        let steps = (plan.duration() / h) as u32 + 5;
        let q: Vec<Vec<f64>> = (0..steps).map(|k| plan.at((f64::from(k) - 3.0) * h)).collect();
        for j in 0..q[0].len() {
            let (velocity, acceleration, jerk) = kind.limits(j);
            for q in q.windows(4) {
                let [a, b, c, d] = [0, 1, 2, 3].map(|i| q[i][j]);
                let now = [
                    (d - c).abs() / h / velocity,
                    (d - 2.0 * c + b).abs() / (h * h) / acceleration,
                    jerk.map_or(0.0, |jerk| (d - 3.0 * c + 3.0 * b - a).abs() / (h * h * h) / jerk),
                ];
                self.shares.iter_mut().zip(now).for_each(|(most, now)| *most = most.max(now));
            }
        }
    }

    /// Velocity and acceleration go on without a break if their limits hold over it; the rest is for the operator's speed.
    fn check(mut self, kind: Kind) {
        let Sweep { planned, refused, shares: [velocity, acceleration, jerk], lasts } = &mut self;
        lasts.sort_by(f64::total_cmp);
        let middle = lasts.get(lasts.len() / 2);
        println!(
            "{kind:?}: {planned} plans, {velocity:.3} {acceleration:.3} {jerk:.3} of the limits, {middle:?} of a motion from rest"
        );
        assert!(refused.is_empty(), "{refused:#?}");
        assert!(*velocity < 0.99 && *acceleration < 0.9 && *jerk < 0.9, "{velocity} {acceleration} {jerk}");
    }
}

#[test]
fn a_new_plan_is_the_old_one_until_its_instant_and_keeps_limits_and_margins_over_it() {
    for (kind, seeds) in [(Kind::AroundABox, 3), (Kind::SevenAxes, 3), (Kind::TwoArms, 1)] {
        let mut all = Sweep::default();
        (1..=seeds).for_each(|seed| all.replan(kind, seed, 4));
        all.check(kind);
    }
}

#[test]
fn robots_that_stand_are_given_a_goal_within_their_limits_of_jerk() {
    let kind = Kind::SevenAxes;
    let (mut planner, mut random) = (kind.planner(1), Random::seeded(1));
    let (other, goal) = kind.plan(&mut planner, &mut random);
    let here = other.at(0.0);
    let plan = planner.plan(&here, core::slice::from_ref(&here)).expect("a plan that stays");
    assert_eq!(plan.duration(), 0.0);
    let new = planner.replan(&plan, 0.0, core::slice::from_ref(&goal)).expect("a plan");
    assert_eq!((new.at(0.0), new.at(new.duration())), (here.clone(), goal));
    let mut all = Sweep::default();
    all.keeps_limits(kind, &new);
    all.check(kind);
    // There is nothing to do.
    assert!(matches!(planner.replan(&plan, 0.0, &[here]), Err(PlanError::HandOver { .. })));
}

/// As many seeds as `MRROC_PLANS` says, in release.
#[test]
#[ignore = "takes minutes"]
fn new_plans_of_many_seeds_keep_limits_and_margins() {
    let seeds = std::env::var("MRROC_PLANS").ok().and_then(|n| n.parse().ok()).unwrap_or(30);
    for kind in [Kind::AroundABox, Kind::SevenAxes, Kind::TwoArms] {
        let mut all = Sweep::default();
        (101..=100 + seeds).for_each(|seed| all.replan(kind, seed, 6));
        all.check(kind);
    }
}

/// Where the drives of the arm stand when they are put to `A`.
fn start() -> Vec<f64> {
    standing(arm(), |mp| {
        let mut arm = mp.robot::<Serial<6>>("arm")?;
        Ok(mp.wait_until((&mut arm,), (), HereAll::<(Serial<6>,)>::default())?.joints())
    })
}

fn arm() -> Cell {
    Cell::new(STEP).robot(setup("arm", &six_axes(Pose::identity()), &A))
}

#[test]
fn an_arm_that_is_stopped_around_a_hand_over_keeps_its_margin() {
    let clearance = around_a_box().build(stopping()).expect("a clearance");
    let mut planner = Planner::new(clearance.clone()).expect("a planner");
    let plan = planner.plan(&start(), &[B.to_vec()]).expect("a plan");
    let mut states = 0;
    for at in [0.3, 0.6] {
        let at = at * plan.duration();
        let new = planner.replan(&plan, at, &[ABOVE.to_vec()]).expect("a plan");
        let around = (at / STEP.as_secs_f64()) as u32;
        for k in (around - 40..around + 140).step_by(6) {
            let new = new.clone();
            let cell = arm().program(move |mp| {
                let mut arm = mp.robot::<Serial<6>>("arm")?;
                mp.move_robot(&mut arm, (), Breaks::new(&new, 0, k)).map(drop)
            });
            let (distance, seen) =
                least_distance_after(cell, clearance.clone(), f64::from(k) * STEP.as_secs_f64());
            assert!(distance >= 0.02 - 1e-4, "a fault in step {k}, {around} is the hand-over: {distance}");
            states += seen;
        }
    }
    assert!(states > 2000, "{states}");
}

#[test]
fn arms_that_do_not_stop_together_around_a_hand_over_keep_their_margins() {
    let clearance = two_arms().build(stopping()).expect("a clearance");
    let (mut planner, mut random) = (Kind::TwoArms.planner(2), Random::seeded(2));
    let (start, plan, goal) = loop {
        let (plan, goal) = Kind::TwoArms.plan(&mut planner, &mut random);
        let start = plan.at(0.0);
        let here = standing(facing(&start), |mp| {
            let (mut left, mut right) = (mp.robot::<Serial<6>>("left")?, mp.robot::<Serial<6>>("right")?);
            let here = HereAll::<(Serial<6>, Serial<6>)>::default();
            Ok(mp.wait_until((&mut left, &mut right), (), here)?.joints())
        });
        if let Ok(plan) = planner.plan(&here, &[plan.at(9.0)]) {
            break (start, plan, goal);
        }
    };
    let at = 0.4 * plan.duration();
    let new = planner.replan(&plan, at, &[goal]).expect("a plan");
    let around = (at / STEP.as_secs_f64()) as u32;
    for k in (around - 20..around + 100).step_by(10) {
        let (first, second) = if k % 20 == 0 { (k, k + 1) } else { (k + 1, k) };
        let new = new.clone();
        let cell = facing(&start).program(move |mp| {
            let (mut left, mut right) = (mp.robot::<Serial<6>>("left")?, mp.robot::<Serial<6>>("right")?);
            let (one, two) = (Breaks::new(&new, 0, first), Breaks::new(&new, 6, second));
            mp.move_robots((&mut left, &mut right), (), Each::of((one, two))).map(drop)
        });
        let (distance, _) = least_distance_after(cell, clearance.clone(), f64::from(k) * STEP.as_secs_f64());
        assert!(distance >= 0.02 - 1e-4, "a fault in step {k}, {around} is the hand-over: {distance}");
    }
}

/// What a program has been told, and where its robot was demanded to be at last.
#[derive(Clone, Debug, Default, PartialEq)]
struct Told {
    plans: u32,
    kept: Vec<String>,
    end: Vec<f64>,
}

/// An arm that goes from `A` to `B`, and on the way to `goals`, one after the other, each from `lead` of path time after it was told.
fn pursuing(goals: Vec<Vec<f64>>, lead: f64, told: &Rc<RefCell<Told>>) -> Cell {
    let clearance = around_a_box().build(stopping()).expect("a clearance");
    let replanner = Replanner::new(Planner::new(clearance).expect("a planner")).expect("a thread");
    let (replanner, told) = (RefCell::new(replanner), Rc::clone(told));
    arm().program(move |mp| {
        let mut replanner = replanner.borrow_mut();
        let mut arm = mp.robot::<Serial<6>>("arm")?;
        let here = mp.wait_until((&mut arm,), (), HereAll::<(Serial<6>,)>::default())?.joints();
        let plan = mp.recorded("plan", || Ok(replanner.planner().plan(&here, &[B.to_vec()])?))?;
        let following = Following::new(&plan);
        mp.start_robot(&mut arm, following.motion("arm")?)?;
        for goal in &goals {
            mp.wait_until((), (), following.reached(following.time() + 0.1))?;
            match replanner.hand_over(mp, &following, lead, core::slice::from_ref(goal))? {
                Replanned::HandedOver(_) => told.borrow_mut().plans += 1,
                Replanned::Kept(why) => told.borrow_mut().kept.push(why.message().to_string()),
            }
        }
        mp.wait_until((), (), following.reached(f64::INFINITY))?;
        mp.end_robot(&mut arm)?;
        let here = mp.wait_until((&mut arm,), (), HereAll::<(Serial<6>,)>::default())?;
        told.borrow_mut().end = here.joints();
        Ok(())
    })
}

/// Runs a cell; the demands of its arm, servo period by servo period.
fn demands(cell: Cell) -> Vec<Vec<f64>> {
    let seen = Rc::new(RefCell::new(Vec::new()));
    let sink = Rc::clone(&seen);
    cell.watch(move |servo| sink.borrow_mut().push(servo.demanded.to_vec()))
        .run()
        .unwrap_or_else(|error| panic!("{error}"));
    seen.take()
}

/// Velocities and accelerations of demands within the limits of the arm.
fn keep_limits(demands: &[Vec<f64>]) {
    let h = STEP.as_secs_f64();
    for (k, q) in demands.windows(3).enumerate() {
        for (j, ((a, b), c)) in q[0].iter().zip(&q[1]).zip(&q[2]).enumerate() {
            let (velocity, acceleration, _) = Kind::AroundABox.limits(j);
            let [v, a] = [(c - b).abs() / h, (c - 2.0 * b + a).abs() / (h * h)];
            assert!(v <= velocity && a <= acceleration, "period {k}, joint {}: {v} {a}", j + 1);
        }
    }
}

#[test]
fn an_arm_that_is_given_new_goals_during_its_motion_reaches_the_last_one_without_a_rest() {
    let mut aside = A;
    aside[0] -= 0.4;
    let goals = vec![ABOVE.to_vec(), B.to_vec(), ABOVE.to_vec(), aside.to_vec()];
    let told = Rc::default();
    let demands = demands(pursuing(goals, 0.2, &told));
    let told = told.take();
    assert_eq!((told.plans, &told.kept, &told.end), (4, &vec![], &aside.to_vec()));
    keep_limits(&demands);
    // It moves from its first step to its last one, but for where it turns back.
    let rests = demands.windows(2).filter(|q| farthest(&q[0], &q[1]) < 1e-7).count();
    assert!(rests < 60, "{rests} of {}", demands.len());
}

#[test]
fn an_arm_that_is_suspended_while_it_is_planned_for_goes_on_to_its_new_goal() {
    for steps in [[60, 90], [100, 400], [151, 160]] {
        let told = Rc::default();
        let cell = pursuing(vec![ABOVE.to_vec()], 0.2, &told).on_step(move |step, operator| {
            if step == steps[0] {
                operator.suspend();
            } else if step == steps[1] {
                operator.resume();
            }
        });
        keep_limits(&demands(cell));
        assert_eq!(*told.borrow(), Told { plans: 1, kept: vec![], end: ABOVE.to_vec() }, "{steps:?}");
    }
}

#[test]
fn an_arm_without_a_new_plan_follows_the_old_one_to_its_end() {
    let mut through = A;
    through[0] = 0.2;
    let told = Rc::default();
    keep_limits(&demands(pursuing(vec![through.to_vec()], 0.2, &told)));
    let told: Told = told.take();
    assert_eq!((told.plans, told.end), (0, B.to_vec()));
    assert!(told.kept[0].starts_with("the goal is not clear by the margin: arm"), "{:?}", told.kept);
}

#[test]
fn a_new_plan_that_comes_too_late_is_refused_and_the_old_one_is_followed() {
    let clearance = around_a_box().build(stopping()).expect("a clearance");
    let replanner = Replanner::new(Planner::new(clearance).expect("a planner")).expect("a thread");
    let replanner = RefCell::new(replanner);
    let cell = arm().program(move |mp| {
        let mut replanner = replanner.borrow_mut();
        let mut arm = mp.robot::<Serial<6>>("arm")?;
        let here = mp.wait_until((&mut arm,), (), HereAll::<(Serial<6>,)>::default())?.joints();
        let plan = replanner.planner().plan(&here, &[B.to_vec()])?;
        let following = Following::new(&plan);
        mp.start_robot(&mut arm, following.motion("arm")?)?;
        for lead in [0.0, f64::NAN, 0.049] {
            assert!(matches!(replanner.ask(&following, lead, &[]), Err(PlanError::Lead { .. })), "{lead}");
        }
        let at = replanner.ask(&following, 0.1, &[ABOVE.to_vec()])?;
        mp.wait_until((), (), following.reached(at + 0.05))?;
        let Replanned::Kept(why) = replanner.take(mp, &following)? else { panic!("it is late") };
        assert!(why.message().to_string().starts_with("the new plan leaves the old one at 0.1"), "{why}");
        // What has been taken is not there again.
        assert!(matches!(replanner.take(mp, &following)?, Replanned::Kept(_)));
        // A plan that was made from another one is none for these robots.
        let other = replanner.planner().plan(&here, &[ABOVE.to_vec()])?;
        let other = replanner.planner().replan(&other, 0.7, &[B.to_vec()])?;
        assert_eq!(following.hand_over(&other), Err(PlanError::OtherPlan));
        mp.wait_until((), (), following.reached(f64::INFINITY))?;
        mp.end_robot(&mut arm)?;
        let end = mp.wait_until((&mut arm,), (), HereAll::<(Serial<6>,)>::default())?.joints();
        assert_eq!(end, B.to_vec());
        let late = replanner.planner().replan(&plan, 9.0, &[ABOVE.to_vec()])?;
        assert!(matches!(following.hand_over(&late), Err(PlanError::TooLate { .. })), "it is over");
        Ok(())
    });
    keep_limits(&demands(cell));
}

#[test]
fn a_replay_hands_an_arm_over_to_the_recorded_plan_in_the_same_step() {
    let file = std::env::temp_dir().join(format!("mrroc-replan-{}.mcap", std::process::id()));
    let mut through = A;
    through[0] = 0.2;
    // One of them has no plan.
    let goals = vec![ABOVE.to_vec(), through.to_vec(), A.to_vec()];
    let (told, again) = (Rc::default(), Rc::default());
    let recorded = pursuing(goals.clone(), 0.2, &told).record(mrroc_recording::to(&file));
    recorded.run().unwrap_or_else(|error| panic!("{error}"));
    let compared = pursuing(goals, 0.2, &again).replay(&file, CutOff::Refused);
    let compared = compared.unwrap_or_else(|error| panic!("{error}"));
    std::fs::remove_file(&file).expect("it is there");
    assert!(compared.is_identical(), "{compared:?}");
    let (told, again): (Told, Told) = (told.take(), again.take());
    assert_eq!((told.plans, told.kept.len()), (2, 1));
    assert_eq!((&told.plans, &told.kept), (&again.plans, &again.kept));
    assert_eq!(told.end, A.to_vec());
}

#[test]
fn a_guard_that_is_told_of_new_plans_finds_the_arm_on_them() {
    let world = || around_a_box().build(Stopping::of_guard(STEP, 1)).expect("a clearance");
    let guard = PlanGuard::new(world()).expect("a guard");
    let replanner =
        RefCell::new(Replanner::new(Planner::new(world()).expect("a planner")).expect("a thread"));
    let watch = guard.clone();
    let mut clearance = world();
    let seen = Rc::new(RefCell::new((0, 0)));
    let count = Rc::clone(&seen);
    let cell = arm()
        .guard(1, move |robots| {
            let watched = watch.check(robots).map_err(Fault::from)?;
            let mut count = count.borrow_mut();
            match watched {
                Watched::Plan(_) => count.0 += 1,
                Watched::AnyPath(_) => count.1 += 1,
            }
            Ok(())
        })
        .program(move |mp| {
            let mut replanner = replanner.borrow_mut();
            let mut arm = mp.robot::<Serial<6>>("arm")?;
            let here = mp.wait_until((&mut arm,), (), HereAll::<(Serial<6>,)>::default())?.joints();
            let plan = replanner.planner().plan(&here, &[B.to_vec()])?;
            let following = Following::new(&plan);
            guard.follow(&plan)?;
            mp.start_robot(&mut arm, following.motion("arm")?)?;
            // There and back again, many times: the plan does not grow.
            for k in 0..30 {
                let goal = if k % 2 == 0 { A } else { B };
                match replanner.hand_over(mp, &following, 0.2, &[goal.to_vec()])? {
                    Replanned::HandedOver(plan) => {
                        let closest = plan.closest(&mut clearance, 0.05)?;
                        assert!(closest.distance() >= 0.02, "{k}: {closest}");
                        guard.follow_from(&plan, following.time())?;
                    }
                    Replanned::Kept(why) => panic!("{k}: {why}"),
                }
                mp.wait_until((), (), following.reached(following.time() + 0.15))?;
            }
            let words = following.plan().to_words().len();
            assert!(words < 3 * plan.to_words().len(), "{words} words, {}", plan.to_words().len());
            mp.wait_until((), (), following.reached(f64::INFINITY))?;
            mp.end_robot(&mut arm)
        });
    keep_limits(&demands(cell));
    let (known, unknown) = *seen.borrow();
    assert!(known > 1500 && unknown < 10, "{known} {unknown}");
}

#[test]
fn a_new_plan_goes_around_what_has_been_put_in_the_way_since() {
    let mut planner =
        Planner::new(around_a_box().build(stopping()).expect("a clearance")).expect("a planner");
    let plan = planner.plan(&A, &[B.to_vec()]).expect("a plan");
    // A ball where the flange would be at four fifths of the motion.
    let flange = six_axes(Pose::identity())
        .robot()
        .forward(&nalgebra::SVector::from_column_slice(&plan.at(0.8 * plan.duration())))
        .translation
        .vector;
    let world = || around_a_box().obstacle("ball", Obstacle::ball(flange, 0.05)).expect("a ball");
    let mut clearance = world().build(stopping()).expect("a clearance");
    assert!(plan.closest(&mut clearance, 0.01).expect("its robots").distance() < 0.0);
    let mut planner = Planner::new(clearance.clone()).expect("a planner");
    let new = planner.replan(&plan, 0.2 * plan.duration(), &[B.to_vec()]).expect("a plan");
    let closest = new.closest(&mut clearance, 0.01).expect("its robots");
    assert!(closest.distance() >= 0.02, "{closest}");
    // At its place the robots cannot turn off any more.
    assert!(planner.replan(&plan, 0.77 * plan.duration(), &[B.to_vec()]).is_err());
}

#[test]
fn questions_for_a_new_plan_that_make_no_sense_are_told() {
    let mut planner =
        Planner::new(around_a_box().build(stopping()).expect("a clearance")).expect("a planner");
    let plan = planner.plan(&A, &[B.to_vec()]).expect("a plan");
    let text = |found: Result<Plan, PlanError>| found.expect_err("refused").to_string();
    let goals = [ABOVE.to_vec()];
    for at in [-0.1, f64::NAN] {
        let expected = format!("no new plan from {at} s of path time: the plan begins at 0.000 s");
        assert_eq!(text(planner.replan(&plan, at, &goals)), expected);
    }
    let mut two = Kind::TwoArms.planner(1);
    let refused = text(two.replan(&plan, 0.1, &goals));
    assert_eq!(refused, "the plan is of the robots arm, the planner plans for left, right");
    assert!(text(planner.replan(&plan, 0.1, &[])).starts_with("no goal"));
    // From its beginning and from its end on it is a motion from rest.
    for at in [0.0, plan.duration(), f64::INFINITY] {
        let new = planner.replan(&plan, at, &goals).expect("a plan");
        assert_eq!(new.at(new.duration()), ABOVE, "{at}");
    }
}

/// A motion whose steps are looked at.
struct Counted {
    motion: FollowPlan<Serial<6>>,
    allocated: Rc<RefCell<Vec<usize>>>,
}

impl Generator for Counted {
    type Robots = Serial<6>;
    type Language = Motion;
    type Sensors = ();
    type Order = ();
    const CLASS: Class = <FollowPlan<Serial<6>> as Generator>::CLASS;

    fn first_step(
        &mut self,
        order: &Order<()>,
        e: &State<Serial<6>>,
        v: &Reading<()>,
        t: Tick,
    ) -> Result<Step<Serial<6>>, Fault> {
        self.motion.first_step(order, e, v, t)
    }

    fn next_step(
        &mut self,
        order: &Order<()>,
        e: &State<Serial<6>>,
        v: &Reading<()>,
        t: Tick,
    ) -> Result<Step<Serial<6>>, Fault> {
        let (step, allocated) = mrroc_counting_allocator::count(|| self.motion.next_step(order, e, v, t));
        self.allocated.borrow_mut().push(allocated);
        step
    }
}

#[test]
fn steps_of_a_motion_that_is_handed_over_allocate_nothing() {
    let allocated = Rc::new(RefCell::new(Vec::with_capacity(5000)));
    let counted = Rc::clone(&allocated);
    let mut planner =
        Planner::new(around_a_box().build(stopping()).expect("a clearance")).expect("a planner");
    let plan = planner.plan(&start(), &[B.to_vec()]).expect("a plan");
    let new = planner.replan(&plan, 0.4, &[ABOVE.to_vec()]).expect("a plan");
    let cell = arm().program(move |mp| {
        let mut arm = mp.robot::<Serial<6>>("arm")?;
        let following = Following::new(&plan);
        let motion = Counted { motion: following.motion("arm")?, allocated: Rc::clone(&counted) };
        mp.start_robot(&mut arm, motion)?;
        mp.wait_until((), (), following.reached(0.2))?;
        following.hand_over(&new)?;
        mp.wait_until((), (), following.reached(f64::INFINITY))?;
        mp.end_robot(&mut arm)
    });
    keep_limits(&demands(cell));
    let allocated = allocated.borrow();
    assert!(allocated.len() > 500 && allocated.iter().all(|count| *count == 0), "{allocated:?}");
}
