//! Plans MotionBenchMaker's problems, and prints as JSON how many are solved, in what time, and how long the paths are.
//!
//! Run with `cargo bench -p mrroc-planning --bench problems -- PROBLEMS [OUT] [--spheres] [--margin M]`: a file that
//! `tests/peers/planning/problems.py` writes, and where the paths go, a line for each problem.

use std::error::Error;
use std::io::Write;

use mrroc::pose::Pose;
use mrroc_planning::{PlanError, Planner};
use mrroc_robots::clearance::{Clearance, ClearanceBuilder, Obstacle, Stop, Stopping};
use mrroc_robots::{Meshes, Serial, SerialOutline};
use nalgebra::{Quaternion, SVector, Translation3, UnitQuaternion, Vector3};
use rustix::time::{ClockId, clock_gettime};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let is_option = |word: &&String| word.starts_with("--");
    let files: Vec<&String> =
        words.iter().filter(|word| !is_option(word) && word.parse::<f64>().is_err()).collect();
    let Some(problems) = files.first() else {
        println!("problems: give the file that tests/peers/planning/problems.py writes");
        return Ok(());
    };
    let margin =
        words.iter().position(|word| word == "--margin").and_then(|i| words.get(i + 1)?.parse().ok());
    let key = if words.iter().any(|word| word == "--spheres") { "spheres" } else { "urdf" };
    let text = std::fs::read_to_string(problems)?;
    let mut lines = text.lines();
    let robot: Value = serde_json::from_str(lines.next().ok_or("an empty file")?)?;
    let problems = lines.map(serde_json::from_str).collect::<Result<Vec<Value>, _>>()?;
    let urdf = std::fs::read_to_string(robot[key].as_str().ok_or("no URDF")?)?;
    let out = files.get(1).map(|path| std::fs::File::create(path)).transpose()?;
    match robot["joints"].as_array().map_or(0, Vec::len) {
        6 => run::<6>(&robot, &urdf, &problems, margin.unwrap_or(0.0), out),
        7 => run::<7>(&robot, &urdf, &problems, margin.unwrap_or(0.0), out),
        8 => run::<8>(&robot, &urdf, &problems, margin.unwrap_or(0.0), out),
        n => Err(format!("no arm of {n} joints here").into()),
    }
}

fn run<const N: usize>(
    robot: &Value,
    urdf: &str,
    problems: &[Value],
    margin: f64,
    mut out: Option<std::fs::File>,
) -> Result<(), Box<dyn Error>> {
    let ends = ["base", "tip"].map(|key| robot[key].as_str().unwrap_or_default());
    let arm = Serial::<N>::from_urdf(urdf, ends[0], ends[1])?.with_acceleration(SVector::repeat(5.0))?;
    let arm = arm.with_positions(vector(&robot["lower"])?, vector(&robot["upper"])?)?;
    let meshes = Meshes::below(robot["meshes"].as_str().unwrap_or("."));
    let outline = SerialOutline::from_urdf(arm, urdf, ends[0], ends[1], &meshes)?;
    let (mut first, mut both, mut before, mut after) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut why = std::collections::BTreeMap::<String, u32>::new();
    for problem in problems {
        let builder = Clearance::with_margin(margin).robot("arm", outline.clone())?;
        let clearance =
            obstacles(builder, problem)?.build(Stopping { reaction: 0.02, stop: Stop::Braking })?;
        let mut planner = Planner::new(clearance)?;
        let start = vector::<N>(&problem["start"])?.as_slice().to_vec();
        let goals = problem["goals"].as_array().ok_or("no goals")?;
        let goals = goals.iter().map(|goal| Ok(vector::<N>(goal)?.as_slice().to_vec()));
        let goals = goals.collect::<Result<Vec<_>, Box<dyn Error>>>()?;
        let begun = now();
        let found = planner.find_first(&start, &goals);
        let found_after = now() - begun;
        match found {
            Ok(mut path) => {
                before.push(length(&path));
                planner.shorten(&mut path);
                both.push(1e6 * (now() - begun));
                first.push(1e6 * found_after);
                after.push(length(&path));
                if let Some(out) = &mut out {
                    writeln!(
                        out,
                        "{}",
                        json!({ "set": problem["set"], "index": problem["index"], "joints": path })
                    )?;
                }
            }
            Err(error) => {
                let kind = match error {
                    PlanError::StartNotClear(nearest) => {
                        format!("start: {} - {}", nearest.sides[0], nearest.sides[1])
                    }
                    PlanError::GoalNotClear(nearest) => {
                        format!("goal: {} - {}", nearest.sides[0], nearest.sides[1])
                    }
                    PlanError::NotFound { .. } => format!("not found: {}", problem["set"]),
                    other => other.to_string(),
                };
                *why.entry(kind).or_default() += 1;
            }
        }
    }
    let of = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values.get((share * values.len() as f64) as usize).copied().unwrap_or(f64::NAN);
        json!({ "median": at(0.5), "p95": at(0.95), "mean": values.iter().sum::<f64>() / values.len() as f64 })
    };
    let solved = first.len();
    println!(
        "{}",
        json!({
            "robot": robot["robot"], "problems": problems.len(), "solved": solved,
            "plan_us": of(&mut first), "plan_and_shorten_us": of(&mut both),
            "length_first": of(&mut before), "length": of(&mut after), "unsolved": why,
        })
    );
    Ok(())
}

/// Time of the processor in this thread \[s\]: other programs do not count.
fn now() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

fn length(path: &[Vec<f64>]) -> f64 {
    path.windows(2).map(|p| p[0].iter().zip(&p[1]).map(|(a, b)| (b - a).powi(2)).sum::<f64>().sqrt()).sum()
}

fn numbers(value: &Value) -> Result<Vec<f64>, Box<dyn Error>> {
    let list = value.as_array().ok_or("no list")?;
    Ok(list.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>().ok_or("no numbers")?)
}

fn vector<const N: usize>(value: &Value) -> Result<SVector<f64, N>, Box<dyn Error>> {
    let numbers = numbers(value)?;
    if numbers.len() == N {
        Ok(SVector::from_column_slice(&numbers))
    } else {
        Err("too many or too few numbers".into())
    }
}

#[allow(non_snake_case)]
fn obstacles(mut builder: ClearanceBuilder, problem: &Value) -> Result<ClearanceBuilder, Box<dyn Error>> {
    let place = |body: &Value| -> Result<Pose, Box<dyn Error>> {
        let q = vector::<4>(&body["quaternion"])?;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[3], q[0], q[1], q[2]));
        Ok(Pose::from_parts(Translation3::from(vector::<3>(&body["center"])?), turn))
    };
    let name = |body: &Value| body["name"].as_str().unwrap_or("body").to_owned();
    for body in problem["boxes"].as_array().into_iter().flatten() {
        let half: Vector3<f64> = vector::<3>(&body["half_extents"])?;
        builder = builder.obstacle(&name(body), Obstacle::Box { X_WO: place(body)?, half })?;
    }
    for body in problem["cylinders"].as_array().into_iter().flatten() {
        let number = |key: &str| body[key].as_f64().ok_or("no number");
        let (radius, half_length) = (number("radius")?, number("half_length")?);
        builder =
            builder.obstacle(&name(body), Obstacle::Cylinder { X_WO: place(body)?, radius, half_length })?;
    }
    for body in problem["spheres"].as_array().into_iter().flatten() {
        let radius = body["radius"].as_f64().ok_or("no number")?;
        builder = builder.obstacle(&name(body), Obstacle::ball(vector::<3>(&body["center"])?, radius))?;
    }
    Ok(builder)
}
