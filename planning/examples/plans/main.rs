//! Plans MotionBenchMaker's problems, and writes the motions of the plans and stops from them, for `tests/peers/planning`.
//!
//! `cargo run -p mrroc-examples --example plans -- PROBLEMS PATHS STOPS`: a file that `tests/peers/planning/problems.py` writes, and where
//! motions and stops go, as `tests/peers/planning/meshes.py` reads them: a line for each with the keys set, index, what, and joints, a list of
//! positions [rad or m]. A motion is written every 4 ms of path time, between which it is off a straight line by 2e-5 rad at
//! most. A stop is written from where the fault happens to where the robot stands: of the kinds that `Plan::closest` tells.
//!
//! - `--seed` and `--seeds`: the first seed and how many, each of which plans all problems (1 and 1).
//! - `--stops`: at how many instants of a plan a fault happens (6). With 0 the points of a path are written, as `Planner::find` gives them.
//! - `--acceleration` [rad/s²] (10) and `--jerk` [rad/s³] (none): limits of all joints.
//! - `--least`: how many plans there must be at least (1).

mod problem;

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::time::Instant;

use mrroc_planning::{Plan, PlanError, Planner};
use mrroc_robots::clearance::Outline;
use nalgebra::SVector;
use problem::Problems;
use serde_json::{Value, json};

/// Path time between positions of a motion that are written \[s\].
const STEP: f64 = 4e-3;

/// What is asked for.
struct Asked {
    seeds: core::ops::Range<u64>,
    stops: u32,
    acceleration: f64,
    jerk: Option<f64>,
    least: usize,
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut files, mut options) = (Vec::new(), BTreeMap::<String, f64>::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.strip_prefix("--") {
            Some(option) => {
                let value = words.next().ok_or_else(|| format!("{word} NUMBER"))?;
                options.insert(option.to_owned(), value.parse().map_err(|_| format!("{word} {value}"))?);
            }
            None => files.push(word),
        }
    }
    let [problems, paths, stops] = &files[..] else { return Err("plans PROBLEMS PATHS STOPS".into()) };
    let mut option = |name: &str| options.remove(name);
    let (first, count) = (option("seed").unwrap_or(1.0) as u64, option("seeds").unwrap_or(1.0) as u64);
    let asked = Asked {
        seeds: first..first + count,
        stops: option("stops").unwrap_or(6.0) as u32,
        acceleration: option("acceleration").unwrap_or(10.0),
        jerk: option("jerk"),
        least: option("least").unwrap_or(1.0) as usize,
    };
    if let Some(unknown) = options.keys().next() {
        return Err(format!("--{unknown} is no option").into());
    }
    let problems = Problems::read(problems, "urdf")?;
    let out = [BufWriter::new(File::create(paths)?), BufWriter::new(File::create(stops)?)];
    match problems.joints() {
        6 => run::<6>(&problems, &asked, out),
        7 => run::<7>(&problems, &asked, out),
        8 => run::<8>(&problems, &asked, out),
        n => Err(format!("no arm of {n} joints here").into()),
    }
}

fn run<const N: usize>(
    problems: &Problems,
    asked: &Asked,
    [mut paths, mut stops]: [BufWriter<File>; 2],
) -> Result<(), Box<dyn Error>> {
    let mut arm = problems.arm::<N>(asked.acceleration)?;
    if let Some(jerk) = asked.jerk {
        arm = arm.with_jerk(SVector::repeat(jerk))?;
    }
    let begun = Instant::now();
    let outline = problems.outline(arm)?;
    let covered = Instant::now();
    let (mut planned, mut refused) = (0, BTreeMap::<String, u32>::new());
    for problem in &problems.problems {
        let planner = Planner::new(problem::clearance(&outline, problem, 0.0)?)?;
        let (start, goals) = problem::ends::<N>(problem)?;
        for seed in asked.seeds.clone() {
            let mut planner = planner.clone().with_seed(seed);
            let found = if asked.stops == 0 {
                planner.find(&start, &goals).map(|joints| (joints, None))
            } else {
                planner.plan(&start, &goals).map(|plan| (motion(&plan), Some(plan)))
            };
            match found {
                Ok((joints, plan)) => {
                    planned += 1;
                    write(&mut paths, problem, format!("motion of seed {seed}"), &joints)?;
                    if let Some(plan) = plan {
                        write_stops(&mut stops, problem, seed, &plan, asked.stops)?;
                    }
                }
                Err(error) => *refused.entry(why(&error)).or_default() += 1,
            }
        }
    }
    let questions = problems.problems.len() * asked.seeds.clone().count();
    println!(
        "{}",
        json!({
            "robot": problems.robot["robot"], "capsules": outline.links().len(), "questions": questions,
            "plans": planned, "refused": refused, "covers_s": (covered - begun).as_secs_f64(), "plans_s": covered.elapsed().as_secs_f64(),
        })
    );
    if planned < asked.least {
        return Err(
            format!("{planned} plans for {questions} questions, and {} are expected", asked.least).into()
        );
    }
    paths.flush()?;
    stops.flush()?;
    Ok(())
}

/// The positions of a motion.
fn motion(plan: &Plan) -> Vec<Vec<f64>> {
    let count = (plan.duration() / STEP).ceil() as usize;
    (0..=count).map(|k| plan.at(k as f64 * STEP)).collect()
}

/// Stops from so many instants, evenly spaced.
fn write_stops(out: &mut impl Write, problem: &Value, seed: u64, plan: &Plan, count: u32) -> io::Result<()> {
    for k in 0..count {
        let time = plan.duration() * (f64::from(k) + 0.5) / f64::from(count);
        for stop in plan.fault_stops(time) {
            let joints: Vec<Vec<f64>> = core::iter::once(plan.at(time)).chain(stop.positions).collect();
            write(out, problem, format!("{} at {time:.3} s of seed {seed}", stop.during), &joints)?;
        }
    }
    Ok(())
}

fn write(out: &mut impl Write, problem: &Value, what: String, joints: &[Vec<f64>]) -> io::Result<()> {
    let line = json!({ "set": problem["set"], "index": problem["index"], "what": what, "joints": joints });
    writeln!(out, "{line}")
}

/// Why there is no plan, in a few words.
fn why(error: &PlanError) -> String {
    match error {
        PlanError::StartNotClear(nearest) => format!("start: {} - {}", nearest.sides[0], nearest.sides[1]),
        PlanError::GoalNotClear(nearest) => format!("goal: {} - {}", nearest.sides[0], nearest.sides[1]),
        PlanError::NotFound { .. } => "not found".to_owned(),
        other => other.to_string(),
    }
}
