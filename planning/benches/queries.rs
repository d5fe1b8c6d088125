//! Plans many motions in one world, with a roadmap of the queries before and without, and prints as JSON what it gains.
//!
//! Run with `cargo bench -p mrroc-planning --bench queries -- [WORLDS] [QUERIES] [FIRST] [POSITIONS] [KIND..]`: 3 worlds of each kind unless said
//! otherwise, from the seed FIRST (1) on, of 60 queries each, and a roadmap of 10,000 positions. A query begins where the one before ended. A line for
//! each kind of world, of goals and of planner: over all queries the time of the thread on its processor \[ms\] for a path with its
//! shortcuts, to which stops and times come; over those that both solve the length of the path [rad].
//!
//! - `table`: a six-axis arm among boxes on a table.
//! - `window`: a six-axis arm and a wall with a window, through which it reaches; half of the goals are on the other side.
//! - `two`: two arms at the table that reach across each other.
//! - `four`: four arms that go to and fro between the start and the goal of a problem of `tests/table.rs`.
//!
//! Goals are drawn for each query (`drawn`), or are eight that come again in any order (`again`). Positions that are hard to reach from the first one, by
//! more than 10,000 checks, are left out: no effort reaches most of them.

use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::Robot;
use mrroc_planning::{PlanError, Planner, goals_at};
use mrroc_robots::clearance::{Clearance, ClearanceError, Obstacle};
use mrroc_robots::{Serial, Six};
use nalgebra::Vector3;
use rustix::time::{ClockId, clock_gettime};
use serde_json::{Value, json};

// The tests have more models than are needed here.
#[allow(dead_code)]
#[path = "../tests/models.rs"]
mod models;
#[allow(dead_code)]
#[path = "../tests/table.rs"]
mod table;

use models::{six_axes, six_axes_model, stopping};

/// How many goals there are that come again.
const AGAIN: usize = 8;
/// The effort by which positions must be reached from the first.
const EFFORT: u64 = 10_000;

/// Where queries are asked.
struct World {
    clearance: Clearance,
    arms: Vec<Serial<6>>,
    /// Where the middle of the window in a wall is: its y and z \[m\].
    window: Option<[f64; 2]>,
    /// All positions of start and goal, if none are drawn.
    places: Vec<Vec<f64>>,
}

/// A kind of world, by its name, of which one is drawn.
type Kind = (&'static str, fn(&mut Random) -> Result<World, ClearanceError>);

/// What came of a query: the time \[ms\] and, if it was solved, the length of the path [rad].
type Answered = (f64, Option<f64>);

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let numbers: Vec<u64> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let number = |place: usize, unless: u64| numbers.get(place).copied().unwrap_or(unless);
    let (worlds, queries, first, positions) = (number(0, 3), number(1, 60), number(2, 1), number(3, 10_000));
    let kinds: [Kind; 4] = [
        ("table", |random| boxes(random, 1)),
        ("window", window),
        ("two", |random| boxes(random, 2)),
        ("four", four),
    ];
    let named: Vec<&String> = words.iter().filter(|word| word.parse::<u64>().is_err()).collect();
    for (kind, world) in kinds {
        if !named.is_empty() && !named.iter().any(|name| *name == kind) {
            continue;
        }
        for again in [false, true].into_iter().filter(|again| *again || kind != "four") {
            let mut all: [Vec<Answered>; 2] = Default::default();
            for seed in first..first + worlds {
                let mut random = Random::seeded(seed);
                let world = world(&mut random)?;
                let places = draw(&world, if again { AGAIN } else { queries as usize + 1 }, &mut random)?;
                let mut order = vec![0];
                for k in 1..=queries as usize {
                    let farther = 1 + random.below(places.len() - 1);
                    order.push(if again { (order[k - 1] + farther) % places.len() } else { k });
                }
                for (answered, positions) in all.iter_mut().zip([0, positions as usize]) {
                    let mut planner = Planner::new(world.clearance.clone())?.with_roadmap(positions);
                    for pair in order.windows(2) {
                        let [from, to] = [0, 1].map(|i| places[pair[i]].clone());
                        let begun = now();
                        let found = planner.find(&from, &[to]);
                        answered.push((1e3 * (now() - begun), found.ok().map(|path| length(&path))));
                    }
                }
            }
            let both = || all[0].iter().zip(&all[1]).filter_map(|(a, b)| Some([a.1?, b.1?]));
            for (i, (answered, name)) in all.iter().zip(["without", "with"]).enumerate() {
                let solved = answered.iter().filter(|of| of.1.is_some()).count();
                let line = json!({
                    "world": kind, "goals": if again { "again" } else { "drawn" }, "roadmap": name,
                    "queries": answered.len(), "solved": solved,
                    "find_ms": figures(answered.iter().map(|of| of.0)),
                    "length": figures(both().map(|pair| pair[i])),
                });
                println!("{line}");
            }
        }
    }
    Ok(())
}

/// Arms at a table with boxes.
#[allow(non_snake_case)]
fn boxes(random: &mut Random, arms: usize) -> Result<World, ClearanceError> {
    let bases = [Pose::translation(0.5, 0.0, 0.0), Pose::new(Vector3::x() * -0.5, Vector3::z() * PI)];
    let mut builder = Clearance::with_margin(0.02).obstacle("table", Obstacle::table(-0.02))?;
    let mut count = 0;
    while count < 6 {
        let at = Vector3::new(random.within(0.6), random.within(0.6), 0.0);
        let half =
            Vector3::new(random.between(0.03, 0.08), random.between(0.03, 0.08), random.between(0.05, 0.18));
        if bases.iter().all(|base| (base.translation.vector - at).norm() > 0.3) {
            let X_WO = Pose::new(at + Vector3::z() * half.z, Vector3::z() * random.within(1.5));
            builder = builder.obstacle(&format!("box {count}"), Obstacle::Box { X_WO, half })?;
            count += 1;
        }
    }
    for (i, base) in bases.iter().enumerate().take(arms) {
        let name = format!("arm{i}");
        builder = builder.robot(&name, six_axes(*base))?.ignore((&name, "link 0"), ("table", "table"));
    }
    let models = bases.iter().take(arms).map(|base| six_axes_model(*base)).collect();
    Ok(World { clearance: builder.build(stopping())?, arms: models, window: None, places: Vec::new() })
}

/// A wall 0.45 m ahead of an arm, with a window of 0.24 x 0.24 m.
fn window(random: &mut Random) -> Result<World, ClearanceError> {
    let (side, height, half) = (random.within(0.2), random.between(0.3, 0.5), 0.12);
    let part = |y: [f64; 2], z: [f64; 2]| Obstacle::Box {
        X_WO: Pose::translation(-0.45, 0.5 * (y[0] + y[1]), 0.5 * (z[0] + z[1])),
        half: Vector3::new(0.01, 0.5 * (y[1] - y[0]), 0.5 * (z[1] - z[0])),
    };
    let clearance = Clearance::with_margin(0.01)
        .robot("arm0", six_axes(Pose::identity()))?
        .obstacle("table", Obstacle::table(-0.1))?
        .obstacle("left", part([-1.5, side - half], [-0.1, 1.5]))?
        .obstacle("right", part([side + half, 1.5], [-0.1, 1.5]))?
        .obstacle("below", part([side - half, side + half], [-0.1, height - half]))?
        .obstacle("above", part([side - half, side + half], [height + half, 1.5]))?
        .ignore(("arm0", "link 0"), ("table", "table"));
    let arms = vec![six_axes_model(Pose::identity())];
    let window = Some([side, height]);
    Ok(World { clearance: clearance.build(stopping())?, arms, window, places: Vec::new() })
}

/// Four arms that reach across each other.
fn four(random: &mut Random) -> Result<World, ClearanceError> {
    let table::Problem { clearance, start, goal } =
        table::Kind::Six.table(4).problem(random.below(1000) as u64);
    Ok(World { clearance, arms: Vec::new(), window: None, places: vec![start, goal] })
}

/// Clear positions of all arms, whose flanges are in front of them, above the table; every second one is behind the wall where there is one.
fn draw(world: &World, count: usize, random: &mut Random) -> Result<Vec<Vec<f64>>, PlanError> {
    if !world.places.is_empty() {
        return Ok(world.places.clone());
    }
    let mut planner = Planner::new(world.clearance.clone())?.with_effort(EFFORT);
    let mut places: Vec<Vec<f64>> = Vec::new();
    while places.len() < count {
        let mut place = Vec::new();
        for arm in &world.arms {
            let is_behind = world.window.is_some() && places.len() % 2 == 1;
            let q = loop {
                if let Some([side, height]) = world.window.filter(|_| is_behind) {
                    let at = Vector3::new(
                        random.between(-0.7, -0.6),
                        side + random.within(0.05),
                        height + random.within(0.05),
                    );
                    let turned = Pose::new(
                        Vector3::zeros(),
                        Vector3::new(random.within(0.3), random.within(0.3), 0.0),
                    );
                    let ahead = Pose::new(at, Vector3::y() * -FRAC_PI_2) * turned;
                    let goals = goals_at(arm, &ahead, &[0.0; 6]);
                    if goals.is_empty() {
                        continue;
                    }
                    break Six::from_column_slice(&goals[random.below(goals.len())]);
                }
                let q = Six::from_fn(|_, _| random.within(PI));
                let at = arm.forward(&q).translation.vector;
                let is_wanted = if world.window.is_some() {
                    at.y.abs() < 0.6 && (0.1..0.7).contains(&at.z) && (-0.4..0.3).contains(&at.x)
                } else {
                    at.xy().norm() < 0.45 && (0.1..0.5).contains(&at.z)
                };
                if is_wanted {
                    break q;
                }
            };
            place.extend_from_slice(q.as_slice());
        }
        let first = places.first().unwrap_or(&place).clone();
        if planner.find_first(&first, std::slice::from_ref(&place)).is_ok() {
            places.push(place);
        }
    }
    Ok(places)
}

/// Mean, median, 95th percentile and the largest.
fn figures(values: impl Iterator<Item = f64>) -> Value {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let round = |x: f64| (x * 1e4).round() / 1e4;
    let at = |share: f64| values.get((share * values.len() as f64) as usize).map(|x| round(*x));
    let mean = round(values.iter().sum::<f64>() / values.len() as f64);
    json!({ "mean": mean, "median": at(0.5), "p95": at(0.95), "max": values.last().map(|x| round(*x)) })
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
