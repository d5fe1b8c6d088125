//! Plans MotionBenchMaker's problems, and prints as JSON how many are solved, in what time, and how long the paths are.
//!
//! Run with `cargo bench -p mrroc-planning --bench problems -- PROBLEMS [OUT] [--spheres] [--margin M] [--rounds N]`: a file that
//! `tests/peers/planning/problems.py` writes, and where the paths go, a line for each problem. All problems that are valid are planned once
//! unmeasured, then in `N` rounds (5); the time of a problem is the median of its rounds. Prints a line for each set, and one for `all`, with
//! the keys of `tests/peers/planning/vamp_paths.py`, but for the wall clock. Times are those of the thread on its processor. To standard
//! error go the capsules of each link, and what was not solved.

#[path = "../examples/plans/problem.rs"]
mod problem;

use std::collections::BTreeMap;
use std::error::Error;
use std::io::Write;

use mrroc_planning::{PlanError, Planner};
use mrroc_robots::clearance::Outline;
use problem::Problems;
use rustix::time::{ClockId, clock_gettime};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let option =
        |name: &str| words.iter().position(|word| word == name).and_then(|i| words.get(i + 1)?.parse().ok());
    let is_option = |word: &&String| word.starts_with("--");
    let files: Vec<&String> =
        words.iter().filter(|word| !is_option(word) && word.parse::<f64>().is_err()).collect();
    let Some(problems) = files.first() else {
        println!("problems: give the file that tests/peers/planning/problems.py writes");
        return Ok(());
    };
    let (margin, rounds): (f64, f64) = (option("--margin").unwrap_or(0.0), option("--rounds").unwrap_or(5.0));
    let rounds = rounds as usize;
    let key = if words.iter().any(|word| word == "--spheres") { "spheres" } else { "urdf" };
    let problems = Problems::read(problems, key)?;
    let out = files.get(1).map(std::fs::File::create).transpose()?;
    match problems.joints() {
        6 => run::<6>(&problems, margin, rounds, out),
        7 => run::<7>(&problems, margin, rounds, out),
        8 => run::<8>(&problems, margin, rounds, out),
        n => Err(format!("no arm of {n} joints here").into()),
    }
}

/// A problem that is ready to be planned, and what came of it.
struct Task<'a> {
    problem: &'a Value,
    planner: Planner,
    start: Vec<f64>,
    goals: Vec<Vec<f64>>,
    /// Times of planning and of making shorter [us], of each round.
    times: Vec<[f64; 2]>,
    /// Lengths before and after [rad], and the path; why there is none.
    found: Result<(f64, f64, Vec<Vec<f64>>), String>,
}

fn run<const N: usize>(
    problems: &Problems,
    margin: f64,
    rounds: usize,
    mut out: Option<std::fs::File>,
) -> Result<(), Box<dyn Error>> {
    let robot = &problems.robot;
    let arm = problems.arm::<N>(5.0)?;
    let begun = now();
    let outline = problems.outline(arm)?;
    let mut capsules = BTreeMap::<String, u32>::new();
    for link in outline.links() {
        *capsules.entry(link.name.to_string()).or_default() += 1;
    }
    eprintln!("{}: {} s for the capsules of {capsules:?}", robot["robot"], now() - begun);
    let mut tasks = Vec::new();
    for problem in &problems.problems {
        let planner = Planner::new(problem::clearance(&outline, problem, margin)?)?;
        let (start, goals) = problem::ends::<N>(problem)?;
        tasks.push(Task { problem, planner, start, goals, times: Vec::new(), found: Err(String::new()) });
    }
    for round in 0..=rounds {
        for task in &mut tasks {
            let begun = now();
            let found = task.planner.find_first(&task.start, &task.goals);
            let planned = now();
            task.found = match found {
                Ok(mut path) => {
                    let before = length(&path);
                    let again = now();
                    task.planner.shorten(&mut path);
                    if round > 0 {
                        task.times.push([1e6 * (planned - begun), 1e6 * (now() - again)]);
                    }
                    Ok((before, length(&path), path))
                }
                Err(error) => Err(why(&error, task.problem)),
            };
        }
    }
    let mut sets = BTreeMap::<&str, Vec<&Task<'_>>>::new();
    let mut unsolved = BTreeMap::<&str, u32>::new();
    for task in &tasks {
        for set in [task.problem["set"].as_str().unwrap_or_default(), "all"] {
            sets.entry(set).or_default().push(task);
        }
        match &task.found {
            Ok((.., path)) => {
                let Task { problem, .. } = task;
                let line = json!({ "set": problem["set"], "index": problem["index"], "joints": path });
                if let Some(out) = &mut out {
                    writeln!(out, "{line}")?;
                }
            }
            Err(why) => *unsolved.entry(why).or_default() += 1,
        }
    }
    eprintln!("{}: not solved: {unsolved:?}", robot["robot"]);
    for (set, tasks) in sets {
        let median = |of: &dyn Fn(&[f64; 2]) -> f64| {
            figures(tasks.iter().filter(|task| task.found.is_ok()).map(|task| {
                let mut times: Vec<f64> = task.times.iter().map(of).collect();
                times.sort_by(f64::total_cmp);
                times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
            }))
        };
        let solved = || tasks.iter().filter_map(|task| task.found.as_ref().ok());
        let line = json!({
            "planner": "mrroc", "robot": robot["robot"], "set": set, "problems": tasks.len(),
            "solved": solved().count() as f64 / tasks.len() as f64,
            "plan_us": median(&|times| times[0]), "simplify_us": median(&|times| times[1]),
            "total_us": median(&|times| times[0] + times[1]),
            "cost_before": figures(solved().map(|found| found.0)), "cost_after": figures(solved().map(|found| found.1)),
        });
        println!("{line}");
    }
    Ok(())
}

/// Median, 95th percentile and mean.
fn figures(values: impl Iterator<Item = f64>) -> Value {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * values.len() as f64) as usize).copied();
    json!({ "median": at(0.5), "p95": at(0.95), "mean": values.iter().sum::<f64>() / values.len() as f64 })
}

/// What kind of problem this is, in a few words.
fn why(error: &PlanError, problem: &Value) -> String {
    match error {
        PlanError::StartNotClear(nearest) => format!("start: {} - {}", nearest.sides[0], nearest.sides[1]),
        PlanError::GoalNotClear(nearest) => format!("goal: {} - {}", nearest.sides[0], nearest.sides[1]),
        PlanError::NotFound { .. } => format!("not found: {}", problem["set"]),
        other => other.to_string(),
    }
}

/// Time of the processor in this thread \[s\]: other programs do not count.
fn now() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

fn length(path: &[Vec<f64>]) -> f64 {
    path.windows(2).map(|p| p[0].iter().zip(&p[1]).map(|(a, b)| (b - a).powi(2)).sum::<f64>().sqrt()).sum()
}
