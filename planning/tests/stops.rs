//! Robots that follow a plan and are stopped in the middle of it, by the runtime's own processes.

use std::cell::RefCell;
use std::marker::PhantomData;
use std::rc::Rc;
use std::time::Duration;

use mrroc::generator::Each;
use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc::robot::JointVector;
use mrroc_planning::{HereAll, Plan, PlanError, Planner};
use mrroc_robots::clearance::{Clearance, Outline};
use mrroc_robots::{Serial, SerialOutline, Simulated};

use super::cells::{
    around_a_ball, around_a_box, bases, draw_two, seven_axes, six_axes, six_axes_with_jerk, stopping,
    two_arms, two_arms_of,
};
use super::plans::{A, B};

pub(crate) const STEP: Duration = Duration::from_millis(2);

/// Follows a plan until it throws a fault.
pub(crate) struct Breaks<R> {
    plan: Plan,
    first: usize,
    time: f64,
    wait: u32,
    left: u32,
    of: PhantomData<R>,
}

#[generator(ecp)]
fn breaks<R: Robot>(c: &mut Breaks<R>, t: Tick) -> Result<Step<R>, Fault> {
    if c.left == 0 {
        return Err(Fault::thrown("by the test"));
    }
    c.left -= 1;
    if c.time >= c.plan.duration() {
        return Ok(Step::Done);
    }
    if c.wait > 0 {
        c.wait -= 1;
    } else {
        c.time += t.dt;
    }
    let q = c.plan.at(c.time);
    Ok(Step::Next(Demand::joints(R::Joints::from_joints(|i| q[c.first + i]))))
}

impl<R> Breaks<R> {
    /// Of the robot whose `first` joint in the plan this is; it throws its fault in the step after so many.
    pub(crate) fn new(plan: &Plan, first: usize, left: u32) -> Self {
        Breaks { plan: plan.clone(), first, time: 0.0, wait: 0, left, of: PhantomData }
    }

    /// The same, which begins to move so many steps later.
    pub(crate) fn after(mut self, steps: u32) -> Self {
        self.wait = steps;
        self
    }
}

/// How near anything comes in a cell \[m\], at what the drives are told.
fn least_distance(cell: Cell, clearance: Clearance) -> f64 {
    least_distance_after(cell, clearance, 0.0).0
}

/// The same from a time on \[s\], and the number of servo periods that were looked at.
pub(crate) fn least_distance_after(cell: Cell, clearance: Clearance, after: f64) -> (f64, usize) {
    let seen = Rc::new(RefCell::new(Vec::<(f64, String, Vec<f64>)>::new()));
    let sink = Rc::clone(&seen);
    let cell = cell.watch(move |servo| {
        if servo.time >= after {
            sink.borrow_mut().push((servo.time, servo.robot.to_owned(), servo.demanded.to_vec()));
        }
    });
    // It ends with the fault that was thrown, or well.
    if let Err(error) = cell.run() {
        assert!(error.to_string().contains("by the test"), "{error}");
    }
    let seen = seen.borrow();
    let run = seen.iter().map(|(time, robot, q)| (*time, robot.as_str(), q.as_slice()));
    let closest =
        mrroc_robots::clearance::smallest_distance(clearance, run).expect("postures").expect("all robots");
    (closest.nearest.distance, seen.len())
}

pub(crate) fn setup<const N: usize>(
    name: &str,
    outline: &impl Outline<Robot = Serial<N>>,
    q: &[f64],
) -> RobotSetup<Serial<N>> {
    let robot = outline.robot().clone();
    let start = nalgebra::SVector::from_column_slice(q);
    RobotSetup::new(name, robot.clone(), Simulated::new(robot, &start))
}

/// Where the simulated drives of arms stand, which know their positions in steps of their encoders, when they are put to `q`.
pub(crate) fn standing(
    cell: Cell,
    joints: impl FnOnce(&mut Mp) -> Result<Vec<f64>, Fault> + Clone + 'static,
) -> Vec<f64> {
    let found = Rc::new(RefCell::new(Vec::new()));
    let sink = Rc::clone(&found);
    let program = move |mp: &mut Mp| {
        *sink.borrow_mut() = joints.clone()(mp)?;
        Ok(())
    };
    cell.program(program).run().expect("nothing moves");
    found.take()
}

#[test]
fn an_arm_that_is_stopped_anywhere_on_its_plan_keeps_its_margin() {
    let mut clearance = around_a_box().build(stopping()).expect("a clearance");
    let start = standing(Cell::new(STEP).robot(setup("arm", &six_axes(Pose::identity()), &A)), |mp| {
        let mut arm = mp.robot::<Serial<6>>("arm")?;
        Ok(mp.wait_until((&mut arm,), (), HereAll::<(Serial<6>,)>::default())?.joints())
    });
    let plan = Planner::new(clearance.clone()).expect("a planner").plan(&start, &[B.to_vec()]);
    let plan = plan.unwrap_or_else(|error| panic!("{error}"));
    let steps = (plan.duration() / STEP.as_secs_f64()) as u32;
    let mut least = f64::INFINITY;
    for k in (0..=steps + 1).step_by(7) {
        let plan = plan.clone();
        let cell = Cell::new(STEP).robot(setup("arm", &six_axes(Pose::identity()), &A)).program(move |mp| {
            let mut arm = mp.robot::<Serial<6>>("arm")?;
            mp.move_robot(&mut arm, (), Breaks::new(&plan, 0, k)).map(drop)
        });
        let distance = least_distance(cell, clearance.clone());
        assert!(distance >= 0.02 - 1e-4, "a fault in step {k} of {steps}: {distance}");
        least = least.min(distance);
    }
    // What the plan says of its stops is no better than what the runtime's own do, but for the samples between which it looks.
    let closest = plan.closest(&mut clearance, 2e-3).expect("a clearance of its robots");
    assert!((0.02..least + 1e-4).contains(&closest.distance()), "{closest}, and {least} at runtime");
    println!("{steps} steps, least distance {least}");
}

#[test]
fn stops_of_arms_that_do_not_brake_together_keep_the_margin_in_double_precision() {
    for seed in 1..=3 {
        let mut clearance = two_arms().build(stopping()).expect("a clearance");
        let mut planner = Planner::new(clearance.clone()).expect("a planner").with_seed(seed);
        let mut random = Random::seeded(seed);
        let plan = loop {
            let mut draw = || -> Vec<f64> {
                (0..12)
                    .map(|j| if j % 6 == 1 { random.between(-2.5, -0.5) } else { random.within(1.5) })
                    .collect()
            };
            if let Ok(plan) = planner.plan(&draw(), &[draw()]) {
                break plan;
            }
        };
        let closest = plan.closest(&mut clearance, 0.02).expect("a clearance of its robots");
        assert_eq!(closest.rows().len(), 4);
        assert!(closest.distance() >= 0.02, "seed {seed}:\n{closest}");
    }
}

#[test]
fn stops_with_limits_of_jerk_keep_the_margin_from_any_acceleration() {
    let mut clearance = around_a_ball().build(stopping()).expect("a clearance");
    let mut planned = 0;
    for seed in 1..=40 {
        let mut planner = Planner::new(clearance.clone()).expect("a planner").with_seed(seed);
        let mut random = Random::seeded(seed);
        let mut draw = |side: f64| -> Vec<f64> {
            (0..7).map(|j| if j == 0 { side } else { random.within(1.2) }).collect()
        };
        let Ok(plan) = planner.plan(&draw(-0.9), &[draw(0.9)]) else { continue };
        planned += 1;
        let closest = plan.closest(&mut clearance, 4e-3).expect("a clearance of its robots");
        assert_eq!(closest.rows().len(), 3);
        assert!(closest.distance() >= 0.02, "seed {seed}:\n{closest}");
    }
    assert!(planned >= 10, "{planned}");
}

#[test]
fn joints_with_limits_of_jerk_follow_a_plan_within_them() {
    let clearance = Clearance::with_margin(0.02)
        .robot("arm", seven_axes(Pose::identity()))
        .expect("an arm")
        .obstacle("table", mrroc_robots::clearance::Obstacle::table(-0.2))
        .expect("a table")
        .ignore_own("arm");
    let clearance = clearance.build(stopping()).expect("a clearance");
    let planner = Planner::new(clearance).expect("a planner");
    let start = [0.0, 0.4, 0.0, -1.2, 0.0, 0.9, 0.0];
    let goal = [1.5, -0.5, 0.4, -1.6, -0.6, 1.1, 0.8];
    let lasts = Rc::new(RefCell::new(0.0));
    let kept = Rc::clone(&lasts);
    let report = Cell::new(STEP)
        .robot(setup("arm", &seven_axes(Pose::identity()), &start))
        .program(move |mp| {
            let mut arm = mp.robot::<Serial<7>>("arm")?;
            let here = mp.wait_until((&mut arm,), (), HereAll::<(Serial<7>,)>::default())?.joints();
            let plan = planner.clone().plan(&here, &[goal.to_vec()])?;
            *kept.borrow_mut() = plan.duration();
            mp.move_robot(&mut arm, (), plan.motion("arm")?).map(drop)
        })
        .run()
        .unwrap_or_else(|error| panic!("{error}"));
    let (lasted, planned) = (report.time.as_secs_f64(), *lasts.borrow());
    assert!(planned > 0.5 && lasted >= planned && lasted < planned + 0.1, "{lasted} {planned}");
}

/// Arms without limits of jerk, and with limits [rad/s³] that accelerations of 8 rad/s² take 1.6 ms and 16 ms to reach.
const JERKS: [Option<f64>; 3] = [None, Some(5000.0), Some(500.0)];

/// 1,000,000 states of stops of two arms on plans of many seeds, in release: `just sweep-plans`.
#[test]
#[ignore = "takes minutes"]
fn a_million_states_of_stops_keep_the_margin() {
    let mut states = 0;
    for jerk in JERKS {
        let mut all = Sweep::of(jerk);
        let mut seed = 100;
        while all.states < 334_000 {
            seed += 1;
            all.plan_and_stop(seed, 12);
        }
        println!("{all:?}");
        states += all.states;
    }
    assert!(states > 1_000_000, "{states}");
}

#[test]
fn stops_of_some_seeds_keep_the_margin() {
    for jerk in JERKS {
        let mut all = Sweep::of(jerk);
        (1..=4).for_each(|seed| all.plan_and_stop(seed, 4));
        assert!(all.states > 500, "{all:?}");
    }
}

/// What a sweep of stops has seen.
#[derive(Debug)]
struct Sweep {
    /// The limit of jerk of all joints [rad/s³].
    jerk: Option<f64>,
    plans: u32,
    /// Questions that had no path within the effort.
    unsolved: u32,
    /// Questions that had no speed slow enough for the stops.
    refused: u32,
    stops: u32,
    /// Servo periods of both arms in stops.
    states: usize,
    /// The least distance of bodies of different owners \[m\].
    least: f64,
}

impl Sweep {
    fn of(jerk: Option<f64>) -> Self {
        Sweep { jerk, plans: 0, unsolved: 0, refused: 0, stops: 0, states: 0, least: f64::INFINITY }
    }

    /// Plans from and to random positions of two arms, and stops them so many times: by a fault of either one's motion.
    fn plan_and_stop(&mut self, seed: u64, stops: u32) {
        let jerk = self.jerk;
        let arm = move |base: Pose| match jerk {
            Some(jerk) => six_axes_with_jerk(base, jerk),
            None => six_axes(base),
        };
        let clearance = two_arms_of(arm).build(stopping()).expect("a clearance");
        let mut planner =
            Planner::new(clearance.clone()).expect("a planner").with_seed(seed).with_effort(100_000);
        let mut random = Random::seeded(seed);
        let (plan, here) = loop {
            let (start, goal) = (draw_two(&mut random), draw_two(&mut random));
            let here = standing(facing_of(arm, &start), |mp| {
                let (mut left, mut right) = (mp.robot::<Serial<6>>("left")?, mp.robot::<Serial<6>>("right")?);
                Ok(mp
                    .wait_until((&mut left, &mut right), (), HereAll::<(Serial<6>, Serial<6>)>::default())?
                    .joints())
            });
            match planner.plan(&here, &[goal]) {
                Ok(plan) => break (plan, start),
                Err(PlanError::StartNotClear(_) | PlanError::GoalNotClear(_)) => {}
                Err(PlanError::NotFound { .. }) => self.unsolved += 1,
                Err(PlanError::StopsNotClear { .. }) => self.refused += 1,
                Err(error) => panic!("seed {seed}: {error}"),
            }
        };
        self.plans += 1;
        let steps = (plan.duration() / STEP.as_secs_f64()) as usize;
        for _ in 0..stops {
            let k = random.below(steps) as u32;
            // One of them may be told of the fault later than the other.
            let (first, second) = if random.below(2) == 0 { (k, k + 1) } else { (k + 1, k) };
            let plan = plan.clone();
            let cell = facing_of(arm, &here).program(move |mp| {
                let (mut left, mut right) = (mp.robot::<Serial<6>>("left")?, mp.robot::<Serial<6>>("right")?);
                let (one, two) = (Breaks::new(&plan, 0, first), Breaks::new(&plan, 6, second));
                mp.move_robots((&mut left, &mut right), (), Each::of((one, two))).map(drop)
            });
            let after = f64::from(k) * STEP.as_secs_f64();
            let (distance, states) = least_distance_after(cell, clearance.clone(), after);
            self.stops += 1;
            self.states += states;
            self.least = self.least.min(distance);
            assert!(distance >= 0.02 - 1e-4, "seed {seed}, a fault in step {k} of {steps}: {distance}");
        }
    }
}

/// Two arms that face each other, standing there.
pub(crate) fn facing(q: &[f64]) -> Cell {
    facing_of(six_axes, q)
}

/// Two that have this shape at their bases.
fn facing_of(arm: impl Fn(Pose) -> SerialOutline<6>, q: &[f64]) -> Cell {
    let [left, right] = bases();
    Cell::new(STEP).robot(setup("left", &arm(left), &q[..6])).robot(setup("right", &arm(right), &q[6..]))
}
