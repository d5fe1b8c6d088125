//! A point that feels walls exactly, with its ball's radius, finds the exit of mazes by map and planner: no robot, no runtime.
//!
//! `MRROC_MAZES=DIR cargo test --release -p mrroc-map --test touch -- --nocapture` runs all mazes of a folder instead of a few by
//! chance, and prints figures by which planners can be compared within a minute.

use std::path::Path;

use mrroc_map::{Chance, Inflated, Knowledge, Layout, Map, Place, Planner, Region, Walls};

struct Run {
    ratio: f64,
    touches: usize,
    spacing: Option<f64>,
}

/// A ball that touches to 0.2 mm, and goes back by 6 % of a cell after each touch; `None` where no way is found.
fn run(maze: &Layout, pitch: f64, seed: u64) -> Option<Run> {
    let known = Knowledge {
        size: [maze.columns() as f64 * pitch, maze.rows() as f64 * pitch],
        radius: 0.08 * pitch,
        thickness: 0.08 * pitch,
        passage: 0.6 * pitch,
        wall: pitch,
    };
    let walls = Walls::of(maze, pitch, known.thickness);
    let at = |(x, y): (usize, usize), off: f64| Place::new(x as f64 + off, y as f64 + off) * pitch;
    let goal = Region { lower: at(maze.goal().lower, 0.16), upper: at(maze.goal().upper, 0.84) };
    let mut ball = at(maze.start(), 0.5);
    let (shortest, _) = Inflated::by(&walls, known.radius).shortest(&ball, &goal)?;
    let (mut map, planner) = (Map::new(known), Planner::of(&known, 0.048 * pitch));
    let mut chance = Chance::seeded(seed);
    let (mut way, mut touches) = (0.0, 0);
    while goal.distance(&ball) > 0.0 {
        let leg = planner.way(&map, &ball, &goal).filter(|_| touches < 2000)?[1] - ball;
        let along = leg.normalize();
        let clearance = |s: f64| walls.clearance(&(ball + along * s)) - known.radius;
        // As far as there is room: never further than the nearest wall is.
        let (mut s, mut touched) = (0.0, false);
        while s < leg.norm() && !touched {
            let room = clearance(s);
            touched = room < 1e-6 && clearance(s + 2e-5) < room;
            s += if touched { 0.0 } else { room.max(1e-5) };
        }
        s = s.min(leg.norm());
        let (end, back) = (ball + along * s, if touched { s.min(0.06 * pitch) } else { 0.0 });
        let next = end - along * back;
        way += s + back;
        map.pass(&ball, &next);
        if touched {
            touches += 1;
            map.touch(&(end + Place::new(chance.within(2e-4), chance.within(2e-4))), &leg);
        }
        ball = next;
    }
    Some(Run { ratio: way / shortest, touches, spacing: map.spacing() })
}

fn mazes(folder: &Path) -> Vec<(String, Layout)> {
    let files = std::fs::read_dir(folder).expect("a folder").filter_map(|entry| Some(entry.ok()?.path()));
    let read = |file: std::path::PathBuf| {
        let maze: Layout = std::fs::read_to_string(&file).ok()?.parse().ok()?;
        maze.cells_to_goal()?;
        Some((file.display().to_string(), maze))
    };
    let mut mazes: Vec<_> = files.filter_map(read).collect();
    mazes.sort_by(|a, b| a.0.cmp(&b.0));
    mazes
}

#[test]
fn the_exit_is_found_by_touch_and_the_spacing_of_walls_is_learned() {
    let mazes = match std::env::var_os("MRROC_MAZES") {
        Some(folder) => mazes(Path::new(&folder)),
        None => (0..8).map(|seed| (format!("seed {seed}"), Layout::random(16, seed))).collect(),
    };
    let (mut ratios, mut touches, mut learned) = (vec![], vec![], 0);
    for (number, (name, maze)) in mazes.iter().enumerate() {
        let pitch = if maze.columns().max(maze.rows()) <= 16 { 0.025 } else { 0.0125 };
        let run = run(maze, pitch, number as u64).unwrap_or_else(|| panic!("{name}: no way was found"));
        // The exact way is a bound, less the 0.3 % by which it is too short.
        assert!(run.ratio > 0.999, "{name}: {}", run.ratio);
        // Never another spacing than the true one by the end, in mazes with some touches.
        if let Some(spacing) = run.spacing {
            assert!((spacing - pitch).abs() < 1e-9 || run.touches < 30, "{name}: {spacing} m");
            learned += 1;
        }
        ratios.push(run.ratio);
        touches.push(run.touches as f64);
    }
    ratios.sort_by(f64::total_cmp);
    touches.sort_by(f64::total_cmp);
    let (middle, p95) = (ratios.len() / 2, ratios.len() * 95 / 100);
    println!(
        "{} mazes: way, times the shortest: median {:.2}, p95 {:.2}; touches: median {}; spacing learned in {learned}",
        ratios.len(),
        ratios[middle],
        ratios[p95],
        touches[middle]
    );
    assert!(2 * learned > mazes.len());
}
