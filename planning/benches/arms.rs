//! Plans motions of two and of four arms across each other, and prints as JSON how many are solved, in what time, and how long the paths are.
//!
//! Run with `cargo bench -p mrroc-planning --bench arms -- [SEEDS] [FIRST] [FILE..]`: 100 problems of each kind unless said otherwise, from the seed
//! FIRST (1) on; `tests/table.rs` tells what they are. The kinds are two arms of the tests, or the robots of files that
//! `tests/peers/planning/problems.py` writes, whose links are meshes. A line for each kind and number of arms. Times are those of the thread on its processor \[s\]: of the search
//! of a first path, of making it shorter, of the rest of a plan (corners, times, stops), and of all together. `within_1s` is the share of all
//! problems that have a plan in at most a second; `stretch` the length of a path by that of the straight line, which may not be clear.
//! Effort is the default. To standard error goes what was not solved.

use std::error::Error;

use mrroc_planning::Planner;
use nalgebra::SVector;
use rustix::time::{ClockId, clock_gettime};
use serde_json::{Value, json};

// The tests have more models than are needed here.
#[allow(dead_code)]
#[path = "../tests/models.rs"]
mod models;
#[path = "../examples/plans/problem.rs"]
#[allow(dead_code)]
mod problem;
#[path = "../tests/table.rs"]
mod table;

use problem::Problems;
use table::{Kind, Problem, Table};

/// The limits of a Panda, those of acceleration [rad/s²] of a UR5 too, which has none of jerk [rad/s³].
const ACCELERATION: f64 = 7.5;
const JERK: f64 = 3750.0;

/// Makes a table with so many arms of a kind.
type Tables = Box<dyn Fn(usize) -> Table>;

/// What came of a problem.
struct Solved {
    /// Times of the search, of making shorter, and of a whole plan \[s\].
    times: [f64; 3],
    /// Lengths of the straight line, of the first path and of the plan [rad].
    lengths: [f64; 3],
    /// How long the motion takes \[s\].
    duration: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let numbers: Vec<u64> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let (seeds, first) = (numbers.first().copied().unwrap_or(100), numbers.get(1).copied().unwrap_or(1));
    let mut kinds: Vec<(String, Tables)> = Vec::new();
    for file in words.iter().filter(|word| word.parse::<u64>().is_err()) {
        kinds.push(read(file)?);
    }
    if kinds.is_empty() {
        for kind in [Kind::Six, Kind::Seven] {
            kinds.push((format!("{kind:?}"), Box::new(move |arms| kind.table(arms))));
        }
    }
    for (arms, (kind, table)) in [2, 4].iter().flat_map(|arms| kinds.iter().map(move |kind| (*arms, kind))) {
        let table = table(arms);
        let mut all = Vec::new();
        for seed in first..first + seeds {
            match solve(table.problem(seed)) {
                Ok(solved) => all.push(solved),
                Err(error) => eprintln!("{arms} {kind}, seed {seed}: {error}"),
            }
        }
        let times = |of: &dyn Fn(&Solved) -> f64| figures(all.iter().map(of));
        let within = all.iter().filter(|solved| solved.times[2] <= 1.0).count();
        let line = json!({
            "arms": arms, "kind": kind, "problems": seeds,
            "solved": all.len() as f64 / seeds as f64,
            "within_1s": within as f64 / seeds as f64,
            "search_s": times(&|solved| solved.times[0]),
            "shorten_s": times(&|solved| solved.times[1]),
            "rest_s": times(&|solved| solved.times[2] - solved.times[0] - solved.times[1]),
            "all_s": times(&|solved| solved.times[2]),
            "stretch_first": times(&|solved| solved.lengths[1] / solved.lengths[0]),
            "stretch": times(&|solved| solved.lengths[2] / solved.lengths[0]),
            "duration_s": times(&|solved| solved.duration),
        });
        println!("{line}");
    }
    Ok(())
}

/// The robot of a file by its name, and a table with so many of them.
fn read(file: &str) -> Result<(String, Tables), Box<dyn Error>> {
    let problems = Problems::read(file, "urdf")?;
    let name = problems.robot["robot"].as_str().unwrap_or("robot").to_owned();
    Ok(match problems.joints() {
        6 => {
            let outline = problems.outline(problems.arm::<6>(ACCELERATION)?)?;
            (name, Box::new(move |arms| Table::new(&outline, arms)))
        }
        7 => {
            let arm = problems.arm::<7>(ACCELERATION)?.with_jerk(SVector::repeat(JERK))?;
            let outline = problems.outline(arm)?;
            (name, Box::new(move |arms| Table::new(&outline, arms)))
        }
        n => return Err(format!("no arm of {n} joints here").into()),
    })
}

fn solve(problem: Problem) -> Result<Solved, Box<dyn Error>> {
    let Problem { clearance, start, goal } = problem;
    let mut planner = Planner::new(clearance)?;
    let goals = [goal.clone()];
    let begun = now();
    let mut path = planner.clone().find_first(&start, &goals)?;
    let found = now();
    let first = length(&path);
    planner.clone().shorten(&mut path);
    let shortened = now();
    let plan = planner.plan(&start, &goals)?;
    Ok(Solved {
        times: [found - begun, shortened - found, now() - shortened],
        lengths: [length(&[start, goal]), first, plan.length()],
        duration: plan.duration(),
    })
}

/// Median, 95th percentile and the largest.
fn figures(values: impl Iterator<Item = f64>) -> Value {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * values.len() as f64) as usize).map(|x| (x * 1e4).round() / 1e4);
    json!({ "median": at(0.5), "p95": at(0.95), "max": values.last() })
}

/// Time of the processor in this thread \[s\]: other programs do not count.
fn now() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// The length of a path [rad].
fn length(path: &[Vec<f64>]) -> f64 {
    path.windows(2).map(|p| p[0].iter().zip(&p[1]).map(|(a, b)| (b - a).powi(2)).sum::<f64>().sqrt()).sum()
}
