//! Prints what a guard that knows its plan costs in a step, on this machine: `cargo bench -p mrroc-planning --bench guard`.
//!
//! Two six-axis arms that face each other, on a plan past one another. Steps in which nothing has changed, and steps in which an obstacle has been replaced, so
//! that all of the path that a stop may take is proven anew; of each the mean and the most over all steps of the plan.

use std::error::Error;
use std::hint::black_box;
use std::time::{Duration, Instant};

use mrroc::fault::Name;
use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::RobotView;
use mrroc::sensor::EffectorState;
use mrroc_planning::{Plan, PlanGuard, Planner};
use mrroc_robots::clearance::{Clearance, ClearanceBuilder, ClearanceError, Obstacle, Stopping};
use mrroc_robots::{Serial, SerialOutline, Six};
use nalgebra::Vector3;

const STEP: f64 = 2e-3;
/// Runs over the plan, of which the best counts.
const RUNS: usize = 20;

fn arm(base: Pose) -> Result<SerialOutline<6>, Box<dyn Error>> {
    let urdf = include_str!("../../robots/tests/reference/urdf/three_parallel.urdf");
    let robot = Serial::<6>::from_urdf(urdf, "base", "wrist_3")?.with_acceleration(Six::repeat(8.0))?;
    Ok(SerialOutline::new(robot.with_base(base), 0.06))
}

fn world(table: Obstacle) -> Result<ClearanceBuilder, Box<dyn Error>> {
    let turned = Pose::new(Vector3::new(0.9, 0.0, 0.0), Vector3::z() * core::f64::consts::PI);
    let built = |builder: ClearanceBuilder| -> Result<ClearanceBuilder, ClearanceError> {
        builder.obstacle("table", table)
    };
    let builder =
        Clearance::with_margin(0.02).robot("left", arm(Pose::identity())?)?.robot("right", arm(turned)?)?;
    Ok(built(builder)?)
}

fn states(plan: &Plan, k: usize) -> Result<[RobotView; 2], Box<dyn Error>> {
    let (now, before) = (plan.at(k as f64 * STEP), plan.at((k as f64 - 1.0) * STEP));
    let view = |name: &str, first: usize| -> Result<RobotView, Box<dyn Error>> {
        let padded =
            |of: &dyn Fn(usize) -> f64| core::array::from_fn(|i| if i < 6 { of(first + i) } else { 0.0 });
        let state = EffectorState {
            joints: padded(&|j| now[j]),
            velocity: padded(&|j| (now[j] - before[j]) / STEP),
            pose: Pose::identity(),
            wrench: None,
        };
        Ok(RobotView { name: Name::new(name)?, measured: state, demanded: state })
    };
    Ok([view("left", 0)?, view("right", 6)?])
}

fn main() -> Result<(), Box<dyn Error>> {
    let table = Obstacle::table(-0.1);
    let clearance = || -> Result<Clearance, Box<dyn Error>> {
        Ok(world(table.clone())?.build(Stopping::of_guard(Duration::from_secs_f64(STEP), 1))?)
    };
    let (mut planner, mut random) = (Planner::new(clearance()?)?, Random::seeded(7));
    let mut draw = || -> Vec<f64> {
        let joint = |j: usize| match j % 6 {
            0 => random.within(0.8),
            1 => random.between(-1.4, -0.2),
            2 => random.between(0.0, 1.8),
            _ => random.within(1.8),
        };
        (0..12).map(joint).collect()
    };
    let plan = (0..200).find_map(|_| planner.plan(&draw(), &[draw()]).ok()).ok_or("no plan")?;
    let steps = (plan.duration() / STEP) as usize;
    let states: Vec<[RobotView; 2]> = (0..=steps).map(|k| states(&plan, k)).collect::<Result<_, _>>()?;
    let mut any = clearance()?;
    let print = |what: &str, guard: &PlanGuard, look: &mut dyn FnMut(&[RobotView; 2])| {
        let mut best = vec![f64::INFINITY; states.len()];
        let mut follow = f64::INFINITY;
        for _ in 0..RUNS {
            let start = Instant::now();
            drop(black_box(guard.follow(&plan)));
            follow = follow.min(start.elapsed().as_secs_f64());
            for (best, states) in best.iter_mut().zip(&states) {
                let start = Instant::now();
                look(states);
                *best = best.min(start.elapsed().as_secs_f64());
            }
        }
        let mean = best.iter().sum::<f64>() / best.len() as f64;
        let most = best.iter().copied().fold(0.0, f64::max);
        let [mean, most, follow] = [mean, most, follow].map(|seconds| 1e6 * seconds);
        println!(
            "{what:40} mean {mean:7.2} us, most {most:7.2} us; to prove all of the plan {follow:7.2} us"
        );
    };
    let guard = PlanGuard::new(clearance()?)?;
    print("any path", &guard, &mut |states| drop(black_box(any.check(states))));
    print("on its plan", &guard, &mut |states| drop(black_box(guard.check(states))));
    print("on its plan, an obstacle replaced", &guard, &mut |states| {
        drop(black_box(guard.replace_obstacle("table", table.clone())));
        drop(black_box(guard.check(states)));
    });
    Ok(())
}
