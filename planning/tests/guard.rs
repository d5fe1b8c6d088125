//! A guard that is asked in every step of planned motions.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::Duration;

use mrroc::fault::Name;
use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc::robot::{JointVector, Robot, RobotView};
use mrroc::sensor::EffectorState;
use mrroc_planning::{During, GuardError, HereAll, Plan, PlanError, PlanGuard, Planner, Watched};
use mrroc_robots::Serial;
use mrroc_robots::clearance::{Clearance, ClearanceBuilder, Obstacle, Outline, Stop, Stopping};
use nalgebra::{SVector, Vector3};

use super::cells::{Kind, around_a_box, draw_two, seven_axes, six_axes, stopping, two_arms};
use super::plans::{A, B};
use super::stops::{facing, setup, standing};

const STEP: Duration = Duration::from_millis(2);

impl Kind {
    /// The joints of each robot, by name.
    fn robots(self) -> &'static [(&'static str, usize)] {
        match self {
            Kind::AroundABox => &[("arm", 6)],
            Kind::TwoArms => &[("left", 6), ("right", 6)],
            Kind::SevenAxes => &[("arm", 7)],
        }
    }

    fn draw_at(self, random: &mut Random, side: f64) -> Vec<f64> {
        match self {
            Kind::AroundABox => {
                let middle = [0.9 * side, -0.3, 0.6, -1.8, -1.57, 0.0];
                middle.iter().map(|q| q + random.within(0.4)).collect()
            }
            Kind::TwoArms => draw_two(random),
            Kind::SevenAxes => (0..7).map(|j| if j == 0 { 0.9 * side } else { random.within(1.2) }).collect(),
        }
    }

    /// A plan of this seed, if there is one.
    fn planned(self, seed: u64) -> Option<Plan> {
        let clearance = self.world().build(stopping()).expect("a clearance");
        let mut planner = Planner::new(clearance).expect("a planner").with_seed(seed).with_effort(20_000);
        let mut random = Random::seeded(seed);
        let (start, goal) = (self.draw_at(&mut random, -1.0), self.draw_at(&mut random, 1.0));
        match planner.plan(&start, &[goal]) {
            Ok(plan) => Some(plan),
            Err(
                PlanError::StartNotClear(_)
                | PlanError::GoalNotClear(_)
                | PlanError::NotFound { .. }
                | PlanError::StopsNotClear { .. },
            ) => None,
            Err(error @ PlanError::Timing(_)) => {
                println!("{self:?} seed {seed}: {error}");
                None
            }
            Err(error) => panic!("seed {seed}: {error}"),
        }
    }

    /// The states of the robots `k` steps after a plan has begun.
    fn states(self, plan: &Plan, k: u32) -> Vec<RobotView> {
        let step = STEP.as_secs_f64();
        let [now, before] = [f64::from(k) * step, (f64::from(k) - 1.0) * step].map(|time| plan.at(time));
        let mut first = 0;
        let view = |(name, n): &(&str, usize)| {
            let own = first..first + n;
            first += n;
            let padded = |value: &dyn Fn(usize) -> f64| {
                let mut all = [0.0; 8];
                own.clone().zip(&mut all).for_each(|(j, place)| *place = value(j));
                all
            };
            let state = EffectorState {
                joints: padded(&|j| now[j]),
                velocity: padded(&|j| (now[j] - before[j]) / step),
                pose: Pose::identity(),
                wrench: None,
            };
            RobotView { name: Name::new(name).expect("a name"), measured: state, demanded: state }
        };
        self.robots().iter().map(view).collect()
    }
}

/// A guard that knows its plans, in a world.
fn guard(world: ClearanceBuilder) -> PlanGuard {
    PlanGuard::new(world.build(Stopping::of_guard(STEP, 1)).expect("a clearance")).expect("a guard")
}

/// What guards did on plans of many seeds.
#[derive(Debug, Default)]
struct Sweep {
    plans: u64,
    steps: u64,
    /// Plans that were stopped, by what the guard said.
    stopped: Vec<String>,
    /// Plans that were stopped where the same obstacle was put in its place again every tenth of a second.
    replaced: Vec<String>,
    /// Plans of which the guard was not sure that the robots were on them.
    lost: u64,
}

impl Sweep {
    fn watch(&mut self, kind: Kind, plan: &Plan, seed: u64) {
        self.plans += 1;
        let steps = (plan.duration() / STEP.as_secs_f64()).ceil() as u32;
        let anew = guard(kind.world());
        let knows = guard(kind.world());
        knows.follow(plan).expect("a plan of its robots");
        anew.follow(plan).expect("a plan of its robots");
        let world = kind.world().build(stopping()).expect("a clearance");
        let mut seen = [false; 3];
        for k in 0..=steps + 1 {
            let states = kind.states(plan, k);
            self.steps += 1;
            let said = |guard: &PlanGuard| match guard.check(&states) {
                Ok(Watched::Plan(_)) => None,
                Ok(Watched::AnyPath(_)) => Some("not on its plan".to_owned()),
                Err(error) => Some(error.to_string()),
            };
            if k % 50 == 0 {
                for (name, obstacle) in world.obstacle_parts() {
                    anew.replace_obstacle(name, obstacle.clone()).expect("an obstacle of this name");
                }
            }
            for (i, (guard, stopped)) in
                [(&knows, &mut self.stopped), (&anew, &mut self.replaced)].into_iter().enumerate()
            {
                if !seen[i]
                    && let Some(text) = said(guard)
                {
                    self.lost += u64::from(text == "not on its plan");
                    stopped.push(format!("{kind:?} seed {seed} step {k} of {steps}: {text}"));
                    seen[i] = true;
                }
            }
        }
    }

    /// So many plans of a kind, from the seed `first` on; it prints how far it has got.
    fn of(kind: Kind, plans: u64, first: u64) -> Self {
        let mut all = Sweep::default();
        for seed in first.. {
            if all.plans == plans {
                break;
            }
            if let Some(plan) = kind.planned(seed) {
                all.watch(kind, &plan, seed);
                if all.plans.is_multiple_of(100) {
                    all.print(kind);
                }
            }
        }
        all
    }

    fn print(&self, kind: Kind) {
        println!(
            "{kind:?}: {} plans, {} steps, {} stopped, {} where obstacles were replaced, {} not on their plans",
            self.plans,
            self.steps,
            self.stopped.len(),
            self.replaced.len(),
            self.lost
        );
    }
}

#[test]
fn a_guard_that_knows_the_plan_is_silent_on_it() {
    for kind in [Kind::AroundABox, Kind::TwoArms, Kind::SevenAxes] {
        let all = Sweep::of(kind, 4, 1);
        assert!(all.stopped.is_empty() && all.replaced.is_empty() && all.lost == 0, "{all:#?}");
        assert!(all.steps > 1000, "{all:?}");
    }
}

#[test]
fn a_guard_that_knows_the_plan_allocates_nothing_in_a_step_also_where_an_obstacle_is_replaced() {
    let kind = Kind::AroundABox;
    let plan = (1..50).find_map(|seed| kind.planned(seed)).expect("a plan");
    let knows = guard(kind.world());
    knows.follow(&plan).expect("a plan of its robots");
    let bodies = kind.world().build(stopping()).expect("a clearance");
    let (_, body) = bodies.obstacle_parts().last().expect("a box");
    let steps = (plan.duration() / STEP.as_secs_f64()) as u32;
    for k in 0..=steps {
        let (states, body) = (kind.states(&plan, k), body.clone());
        let allocated = mrroc_counting_allocator::count(|| {
            if k % 20 == 0 {
                drop(knows.replace_obstacle("box", body));
            }
            assert!(matches!(knows.check(&states), Ok(Watched::Plan(_))));
        });
        assert_eq!(allocated.1, 0, "step {k}");
    }
}

/// So many plans of a kind, in release: `just sweep-guard`.
fn sweep(kind: Kind) {
    let count = std::env::var("MRROC_PLANS").ok().and_then(|n| n.parse().ok()).unwrap_or(3334);
    let first = std::env::var("MRROC_SEED").ok().and_then(|n| n.parse().ok()).unwrap_or(1000);
    let all = Sweep::of(kind, count, first);
    all.print(kind);
    all.stopped.iter().chain(&all.replaced).take(20).for_each(|text| println!("  {text}"));
    assert!(all.stopped.is_empty());
}

#[test]
#[ignore = "takes half an hour"]
fn a_guard_is_silent_on_thousands_of_plans_around_a_box() {
    sweep(Kind::AroundABox);
}

#[test]
#[ignore = "takes hours"]
fn a_guard_is_silent_on_thousands_of_plans_of_two_arms() {
    sweep(Kind::TwoArms);
}

#[test]
#[ignore = "takes half an hour"]
fn a_guard_is_silent_on_thousands_of_plans_with_limits_of_jerk() {
    sweep(Kind::SevenAxes);
}

/// What a guard did where a ball was moved into an arm's way.
struct Moved {
    /// How long before the arm, going on, would have come too near to it \[s\].
    ahead: f64,
    /// The least distance of everything in the run, with the ball where it was moved \[m\].
    least: f64,
    /// With what the cell ended.
    text: String,
}

/// An arm follows a plan in a world with a ball, first far away. Its guard moves the ball to where the flange will be at a share of
/// the plan, at many instants before: one run for each.
fn moved<const N: usize>(
    arm: &(impl Outline<Robot = Serial<N>> + Clone),
    world: fn(Obstacle) -> ClearanceBuilder,
    ends: [&[f64]; 2],
    share: f64,
) -> Vec<Moved>
where
    SVector<f64, N>: JointVector,
    Serial<N>: Robot<Joints = SVector<f64, N>>,
{
    let step = STEP.as_secs_f64();
    let start = standing(Cell::new(STEP).robot(setup("arm", arm, ends[0])), |mp| {
        let mut arm = mp.robot::<Serial<N>>("arm")?;
        Ok(mp.wait_until((&mut arm,), (), HereAll::<(Serial<N>,)>::default())?.joints())
    });
    let far = Obstacle::ball(Vector3::new(5.0, 5.0, 0.5), 0.05);
    let clearance = world(far.clone()).build(stopping()).expect("a clearance");
    let plan = Planner::new(clearance).expect("a planner").plan(&start, &[ends[1].to_vec()]).expect("a plan");
    let there = plan.at(share * plan.duration());
    let centre = arm.robot().forward(&SVector::from_column_slice(&there)).translation.vector;
    let ball = Obstacle::ball(centre, 0.05);
    let mut with_ball = world(ball.clone()).build(stopping()).expect("a clearance");
    let mut distance = |q: &[f64]| with_ball.nearest_at(&[q]).expect("a posture").distance;
    let hit = (0..=(plan.duration() / step) as u32).find(|k| distance(&plan.at(f64::from(*k) * step)) < 0.02);
    let hit = hit.expect("the ball is in the way");
    let mut all = Vec::new();
    for when in (5..hit).step_by(37) {
        let guard = guard(world(far.clone()));
        let (watch, ball, mut looks) = (guard.clone(), ball.clone(), 0);
        let seen = Rc::new(RefCell::new(Vec::new()));
        let (sink, plan) = (Rc::clone(&seen), plan.clone());
        let result = Cell::new(STEP)
            .robot(setup("arm", arm, ends[0]))
            .guard(1, move |robots| {
                looks += 1;
                if looks == when {
                    let replaced = watch.replace_obstacle("ball", ball.clone());
                    replaced.map_err(|error| Fault::thrown(&error.to_string()))?;
                }
                watch.check(robots).map(drop).map_err(Fault::from)
            })
            .watch(move |servo| sink.borrow_mut().push(servo.demanded.to_vec()))
            .program(move |mp| {
                let mut arm = mp.robot::<Serial<N>>("arm")?;
                guard.follow(&plan)?;
                mp.move_robot(&mut arm, (), plan.motion("arm")?).map(drop)
            })
            .run();
        let text = result.expect_err("the guard stops it").to_string();
        let least = seen.borrow().iter().map(|q| distance(q)).fold(f64::INFINITY, f64::min);
        all.push(Moved { ahead: f64::from(hit - when) * step, least, text });
    }
    all
}

#[test]
fn an_arm_stops_on_its_plan_before_an_obstacle_that_is_moved_into_its_way() {
    let arm = six_axes(Pose::identity());
    let world = |ball| around_a_box().obstacle("ball", ball).expect("a ball");
    let mut stops = 0;
    for share in [0.55, 0.8, 1.0] {
        for Moved { ahead, least, text } in moved(&arm, world, [&A, &B], share) {
            assert!(
                text.contains("and ball ") && text.contains(" ahead on the plan"),
                "{ahead} s ahead: {text}"
            );
            // The path time that a stop takes at most, by docs/src/stops.md, at the velocity limit of the joints; and two steps more.
            if ahead >= 0.006 + 0.1 + 1.392 * (core::f64::consts::PI / 8.0 + 0.002) + 0.004 {
                assert!(least >= 0.02 - 1e-9, "{ahead} s ahead, {least} m: {text}");
                stops += 1;
            }
        }
    }
    assert!(stops >= 20, "{stops}");
}

#[test]
fn an_arm_with_limits_of_jerk_stops_before_an_obstacle_that_is_moved_into_its_way() {
    let arm = seven_axes(Pose::identity());
    let world = |ball| {
        Clearance::with_margin(0.02)
            .robot("arm", seven_axes(Pose::identity()))
            .expect("an arm")
            .obstacle("ball", ball)
            .expect("a ball")
            .ignore_own("arm")
    };
    let ends: [&[f64]; 2] = [&[-1.5, 0.4, 0.0, -1.2, 0.0, 0.9, 0.0], &[1.5, -0.5, 0.4, -1.6, -0.6, 1.1, 0.8]];
    for Moved { ahead, least, text } in moved(&arm, world, ends, 0.9) {
        println!("{ahead:.3} s ahead: {:.1} mm: {text}", 1e3 * least);
        assert!(text.contains("and ball ") && text.contains(" ahead on the plan"), "{ahead} s ahead: {text}");
        // Its stop leaves the path when the stop time is over; that is far from the ball where there is time enough.
        if ahead >= 0.6 {
            assert!(least >= 0.02 - 1e-9, "{ahead} s ahead, {least} m: {text}");
        }
    }
}

/// Where the path keeps the margin of an obstacle that was put beside it, but fault stops do not, which `closest` tells by samples in double precision.
#[test]
fn a_guard_stops_where_fault_stops_would_not_keep_the_margin_of_an_obstacle_that_was_replaced() {
    let world = |ball| around_a_box().obstacle("ball", ball).expect("a ball");
    let far = Obstacle::ball(Vector3::new(5.0, 5.0, 0.5), 0.03);
    let clearance = world(far.clone()).build(stopping()).expect("a clearance");
    let plan = Planner::new(clearance).expect("a planner").plan(&A, &[B.to_vec()]).expect("a plan");
    let robot = Outline::robot(&six_axes(Pose::identity())).clone();
    let (mut random, mut stopped, mut silent) = (Random::seeded(4), 0, 0);
    let steps = (plan.duration() / STEP.as_secs_f64()) as u32;
    for _ in 0..400 {
        let q = plan.at(random.between(0.1, 0.9) * plan.duration());
        let flange = robot.forward(&SVector::from_column_slice(&q)).translation.vector;
        let beside = Vector3::from_fn(|_, _| random.within(0.15));
        let ball = Obstacle::ball(flange + beside, 0.03);
        let alone = Clearance::with_margin(0.02).robot("arm", six_axes(Pose::identity())).expect("an arm");
        let alone = alone.ignore_own("arm").obstacle("ball", ball.clone()).expect("a ball");
        let mut with_ball = alone.build(stopping()).expect("a clearance");
        let closest = plan.closest(&mut with_ball, 0.02).expect("a clearance of its robots");
        let motion = closest.during(During::Motion).expect("a row").nearest.distance;
        if motion < 0.0205 {
            continue;
        }
        let knows = guard(world(far.clone()));
        knows.follow(&plan).expect("a plan of its robots");
        knows.replace_obstacle("ball", ball).expect("a ball");
        let fault = (0..=steps).find_map(|k| knows.check(&Kind::AroundABox.states(&plan, k)).err());
        if closest.distance() < 0.0195 {
            let text = fault.expect("a stop would not keep the margin").to_string();
            assert!(text.contains("ball"), "{text}");
            stopped += 1;
        } else if closest.distance() > 0.05 {
            assert_eq!(fault, None, "{closest}");
            silent += 1;
        }
    }
    println!("{stopped} stopped, {silent} silent");
    assert!(stopped >= 3 && silent >= 10, "{stopped} {silent}");
}

#[test]
fn a_guard_of_two_arms_is_silent_at_runtime_and_watches_their_plan() {
    let guard = guard(two_arms());
    let left = [1.6, -1.0, 0.9, 0.3, 0.8, 0.0];
    let right = [1.6, -1.1, 1.0, 0.2, 0.6, 0.0];
    let (watch, on_plan) = (guard.clone(), Rc::new(RefCell::new((0, 0))));
    let counts = Rc::clone(&on_plan);
    let result = facing(&[left, right].concat())
        .guard(1, move |robots| {
            let watched = watch.check(robots).map_err(Fault::from)?;
            let mut counts = counts.borrow_mut();
            match watched {
                Watched::Plan(_) => counts.0 += 1,
                Watched::AnyPath(_) => counts.1 += 1,
            }
            Ok(())
        })
        .program(move |mp| {
            let (mut left, mut right) = (mp.robot::<Serial<6>>("left")?, mp.robot::<Serial<6>>("right")?);
            let here = mp
                .wait_until((&mut left, &mut right), (), HereAll::<(Serial<6>, Serial<6>)>::default())?
                .joints();
            let world = two_arms().build(stopping()).expect("a clearance");
            let (mut planner, mut random) = (Planner::new(world)?.with_effort(20_000), Random::seeded(3));
            let plan =
                (0..50).find_map(|_| planner.plan(&here, &[Kind::TwoArms.draw_at(&mut random, 1.0)]).ok());
            let plan = plan.ok_or_else(|| Fault::thrown("no plan"))?;
            guard.follow(&plan)?;
            let each = mrroc::generator::Each::of((plan.motion("left")?, plan.motion("right")?));
            mp.move_robots((&mut left, &mut right), (), each).map(drop)
        })
        .run();
    result.unwrap_or_else(|error| panic!("{error}"));
    let (known, unknown) = *on_plan.borrow();
    assert!(known > 200 && unknown < 10, "{known} {unknown}");
}

#[test]
fn a_guard_finds_robots_on_their_plan_where_it_looks_seldom_and_where_the_path_turns_back() {
    let kind = Kind::AroundABox;
    let world = || around_a_box().build(stopping()).expect("a clearance");
    let plan = Planner::new(world()).expect("a planner").plan(&A, &[B.to_vec()]).expect("a plan");
    let last = |plan: &Plan| (plan.duration() / STEP.as_secs_f64()).ceil() as u32 + 3;
    let seldom = around_a_box().build(Stopping::of_guard(STEP, 10)).expect("a clearance");
    let seldom = PlanGuard::new(seldom).expect("a guard");
    seldom.follow(&plan).expect("a plan of its robots");
    for k in (0..last(&plan)).step_by(10) {
        let watched = seldom.check(&kind.states(&plan, k));
        let time = (f64::from(k) * STEP.as_secs_f64()).min(plan.duration());
        // The latest time at which they are there: behind the end it is the end.
        assert!(matches!(watched, Ok(Watched::Plan(at)) if (at - time).abs() < 2e-3), "{k}: {watched:?}");
    }
    // Up and back on one line: joint 2 alone.
    let mut there = A;
    there[1] -= 0.6;
    let mut planner = Planner::new(world()).expect("a planner");
    let plan = planner.plan_through(&A, &[vec![there.to_vec()], vec![A.to_vec()]]).expect("a plan");
    let knows = guard(around_a_box());
    knows.follow(&plan).expect("a plan of its robots");
    for k in 0..last(&plan) {
        let watched = knows.check(&kind.states(&plan, k));
        assert!(matches!(watched, Ok(Watched::Plan(_))), "{k} of {}: {watched:?}", last(&plan));
    }
}

#[test]
fn a_guard_does_not_take_robots_that_go_back_or_jump_for_ones_on_their_plan() {
    let kind = Kind::AroundABox;
    let world = around_a_box().build(stopping()).expect("a clearance");
    let plan = Planner::new(world).expect("a planner").plan(&A, &[B.to_vec()]).expect("a plan");
    let knows = guard(around_a_box());
    knows.follow(&plan).expect("a plan of its robots");
    let is_on_plan = |states: &[RobotView]| matches!(knows.check(states), Ok(Watched::Plan(_)));
    assert!((0..300).all(|k| is_on_plan(&kind.states(&plan, k))));
    let mut back = kind.states(&plan, 300);
    back[0].demanded.velocity.iter_mut().for_each(|v| *v = -*v);
    assert!(!is_on_plan(&back));
    assert!(!is_on_plan(&kind.states(&plan, 200)), "it does not go back");
    // A tenth of a second ahead at once; there they are found when so much time may have passed.
    let ahead = kind.states(&plan, 350);
    let looks = (0..100).find(|_| is_on_plan(&ahead));
    assert!(looks.is_some_and(|looks| looks > 2), "{looks:?}");
}

#[test]
fn a_guard_that_knows_a_plan_refuses_other_robots_and_other_stops() {
    let brakes = around_a_box().build(stopping()).expect("a clearance");
    assert!(matches!(PlanGuard::new(brakes), Err(PlanError::GuardBrakes)));
    let world = around_a_box().build(stopping()).expect("a clearance");
    let plan = Planner::new(world).expect("a planner").plan(&A, &[B.to_vec()]).expect("a plan");
    assert!(matches!(guard(two_arms()).follow(&plan), Err(PlanError::NoRobot { .. })));
    // Off the plan it is the guard that knows none: 10 mrad beside it, at speed.
    let knows = guard(around_a_box());
    knows.follow(&plan).expect("a plan of its robots");
    let mut states = Kind::AroundABox.states(&plan, 150);
    states[0].demanded.joints[1] += 0.01;
    let mut any = around_a_box().build(Stopping::of_guard(STEP, 1)).expect("a clearance");
    match (knows.check(&states), any.check(&states)) {
        (Ok(Watched::AnyPath(one)), Ok(other)) => assert_eq!(one, other),
        (Err(GuardError::AnyPath(one)), Err(other)) => assert_eq!(one, other),
        (one, other) => panic!("{one:?} {other:?}"),
    }
}

impl Kind {
    /// The limit of acceleration of all joints [rad/s²].
    const ACCELERATION: f64 = 8.0;

    /// Whether robots that went straight on for the time that passes on the path in a stop would be too near to something: one of the
    /// motions that a guard which does not know the path cannot exclude.
    fn is_blocked_straight_on(self, clearance: &mut Clearance, states: &[RobotView]) -> bool {
        let speeds = states.iter().flat_map(|state| state.demanded.velocity);
        let slowest = speeds.map(|v| v.abs() / Self::ACCELERATION).fold(0.0, f64::max);
        let time = 0.1 + 1.392 * (slowest + STEP.as_secs_f64());
        (1..=20).any(|k| {
            let time = time * f64::from(k) / 20.0;
            let at: Vec<[f64; 8]> = states
                .iter()
                .map(|state| {
                    core::array::from_fn(|i| state.demanded.joints[i] + time * state.demanded.velocity[i])
                })
                .collect();
            let at: Vec<&[f64]> = at.iter().map(|joints| &joints[..]).collect();
            let nearest = clearance.nearest_at(&at).expect("a posture");
            let own = nearest.sides[0].robot == nearest.sides[1].robot;
            nearest.distance < if own { 0.0 } else { 0.02 }
        })
    }
}

/// How many plans a guard stops that does not know them.
#[test]
#[ignore = "a measurement"]
fn what_a_guard_stops_that_does_not_know_the_plan() {
    let count: u64 = std::env::var("MRROC_PLANS").ok().and_then(|n| n.parse().ok()).unwrap_or(100);
    for kind in [Kind::AroundABox, Kind::TwoArms, Kind::SevenAxes] {
        let build = |stopping| kind.world().build(stopping).expect("a clearance");
        let mut on_path = build(Stopping::of_guard(STEP, 1));
        let mut braking = build(Stopping { reaction: 0.006, stop: Stop::Braking });
        let (mut plans, mut stopped, mut braked, mut blocked, mut seed) = (0, 0, 0, 0, 0);
        let mut by: BTreeMap<String, u32> = BTreeMap::new();
        while plans < count {
            seed += 1;
            let Some(plan) = kind.planned(seed) else { continue };
            plans += 1;
            let steps = (plan.duration() / STEP.as_secs_f64()).ceil() as u32;
            let mut seen = [false; 3];
            for k in 0..=steps {
                let states = kind.states(&plan, k);
                if !seen[0]
                    && let Err(error) = on_path.check(&states)
                {
                    let text = error.to_string();
                    let pair = text.split(" are ").next().unwrap_or_default().to_owned();
                    *by.entry(pair).or_default() += 1;
                    seen[0] = true;
                }
                seen[1] = seen[1] || braking.check(&states).is_err();
                seen[2] = seen[2] || kind.is_blocked_straight_on(&mut on_path, &states);
            }
            for (count, seen) in [&mut stopped, &mut braked, &mut blocked].into_iter().zip(seen) {
                *count += u64::from(seen);
            }
        }
        println!(
            "{kind:?}: of {plans} plans {stopped} stopped on the path, {braked} by a guard that brakes, {blocked} blocked straight on"
        );
        let mut by: Vec<_> = by.into_iter().collect();
        by.sort_by_key(|(_, n)| core::cmp::Reverse(*n));
        by.iter().take(6).for_each(|(pair, n)| println!("  {n} {pair}"));
    }
}
