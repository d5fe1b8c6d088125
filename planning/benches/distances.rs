//! Distances of two arms of one kind, all pairs of their links, for `tests/peers/planning/coal_distances.py`, which asks coal for the same.
//!
//! `cargo bench -p mrroc-planning --bench distances -- PROBLEMS COVERS`: the robot of a file that `tests/peers/planning/problems.py` writes. COVERS is
//! written as that script reads it, with the key `zero`: the capsules are where they are with all joints at 0. To standard output goes a JSON line:
//! `ns`, the time for one posture of both arms, which are placed and asked for the least distance, the best of 20 rounds \[ns\], and `sum`,
//! the sum of the distances, 0 for those that overlap \[m\].

#[path = "../examples/plans/problem.rs"]
#[allow(dead_code)]
mod problem;

use std::collections::BTreeMap;
use std::error::Error;
use std::time::Instant;

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc_robots::clearance::{Clearance, Stop, Stopping};
use nalgebra::Vector3;
use problem::Problems;
use serde_json::json;

/// How many postures, and how often all of them are asked for.
const POSTURES: usize = 300;
const ROUNDS: usize = 20;
/// From one base to the other \[m\].
const APART: f64 = 1.1;

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let [problems, covers] = &files[..] else { return Err("distances PROBLEMS COVERS".into()) };
    let problems = Problems::read(problems, "urdf")?;
    let left = problems.outline(problems.arm::<6>(5.0)?)?;
    let base = Pose::new(Vector3::new(APART, 0.0, 0.0), Vector3::z() * core::f64::consts::PI);
    let right = problems.outline(problems.arm::<6>(5.0)?.with_base(base))?;
    let clearance = Clearance::with_margin(0.0).robot("left", left)?.robot("right", right)?;
    let clearance = clearance.ignore_own("left").ignore_own("right");
    let mut clearance = clearance.build(Stopping { reaction: 0.0, stop: Stop::Braking })?;
    clearance.nearest_at(&[&[0.0; 6], &[0.0; 6]])?;
    let mut links = BTreeMap::<String, Vec<[f64; 7]>>::new();
    clearance.capsules(&mut |robot, link, capsule| {
        if robot == "left" {
            let [a, b] = capsule.ends;
            let words = [a.x, a.y, a.z, b.x, b.y, b.z, capsule.radius];
            links.entry(link.name.to_string()).or_default().push(words);
        }
    });
    let mut random = Random::seeded(1);
    let mut draw = || -> Vec<f64> { (0..6).map(|_| random.within(2.5)).collect() };
    let postures: Vec<[Vec<f64>; 2]> = (0..POSTURES).map(|_| [draw(), draw()]).collect();
    let links: Vec<_> =
        links.into_iter().map(|(link, capsules)| json!({"link": link, "capsules": capsules})).collect();
    let robot = &problems.robot;
    let covers_of = json!({
        "urdf": robot["urdf"], "joints": robot["joints"], "zero": true, "links": links, "postures": postures,
        "bases": [[0, 0, 0, 0, 0, 0, 1], [APART, 0, 0, 0, 0, 1, 0]],
    });
    std::fs::write(covers, covers_of.to_string())?;
    let (mut best, mut sum) = (f64::INFINITY, 0.0);
    for _ in 0..ROUNDS {
        sum = 0.0;
        let begun = Instant::now();
        for [left, right] in &postures {
            sum += clearance.nearest_at(&[left, right])?.distance.max(0.0);
        }
        best = best.min(begun.elapsed().as_secs_f64() * 1e9 / POSTURES as f64);
    }
    println!("{}", json!({"ns": best, "sum": sum, "postures": POSTURES}));
    Ok(())
}
