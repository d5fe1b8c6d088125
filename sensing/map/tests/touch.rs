//! A point that feels walls exactly, with its ball's radius, finds the exit of mazes by map and planner: no robot, no runtime.
//!
//! `just maze-sweep DIR` also runs all mazes of a folder, and prints figures by which planners can be compared within a minute.

use std::path::Path;

use mrroc::random::Random;
use mrroc_map::{Inflated, Knowledge, Layout, Map, Place, Planner, Region, Wall, Walls};

struct Run {
    ratio: f64,
    touches: usize,
    spacing: Option<f64>,
}

/// What the ball does where it touches.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Then {
    /// Back by 6 % of a cell.
    Back,
    /// First along the wall: as far as the leg would have gone and on by three cells at most, until the wall ends or another one is in the way.
    Slide,
}

/// In which direction the wall lies that the ball touches: level or upright; `None` at a corner.
fn into(walls: &Walls, ball: &Place, radius: f64) -> Option<Place> {
    let wall = walls.near(ball).min_by(|a, b| a.distance(ball).total_cmp(&b.distance(ball)))?;
    let towards = wall.nearest(ball) - ball;
    let (across, along) = (towards.x.abs(), towards.y.abs());
    if wall.distance(ball) > radius + 1e-4 || across.min(along) > 0.3 * across.max(along) {
        return None;
    }
    Some(if across > along {
        Place::new(towards.x.signum(), 0.0)
    } else {
        Place::new(0.0, towards.y.signum())
    })
}

/// Along the wall that lies `into`, by `most` at most: where the ball comes to, and whether another wall is in the way.
fn slid(walls: &Walls, from: Place, into: Place, along: Place, most: f64, radius: f64) -> (Place, bool) {
    let (mut at, mut gone) = (from, 0.0);
    while gone < most {
        let next = at + along * 5e-5;
        let lies = |wall: &Wall, side: Place| (wall.nearest(&next) - next).dot(&side);
        let blocks = |wall: &Wall| wall.distance(&next) < radius - 2e-5 && lies(wall, along) > 0.7 * radius;
        if walls.near(&next).any(blocks) {
            return (at, true);
        }
        let beside = |wall: &Wall| wall.distance(&next) < radius + 1e-4 && lies(wall, into) > 0.9 * radius;
        if !walls.near(&next).any(beside) {
            return (next, false);
        }
        (at, gone) = (next, gone + 5e-5);
    }
    (at, false)
}

/// A ball that touches to 0.2 mm; `None` where no path is found.
fn run(maze: &Layout, pitch: f64, seed: u64, then: Then) -> Option<Run> {
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
    let mut chance = Random::seeded(seed);
    let (mut travelled, mut touches) = (0.0, 0);
    while goal.distance(&ball) > 0.0 {
        let leg = planner.path(&map, &ball, &goal).filter(|_| touches < 2000)?[1] - ball;
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
        let wall = into(&walls, &end, known.radius).filter(|_| touched && then == Then::Slide);
        if let Some(into) = wall {
            touches += 1;
            let rest = ball + leg - end;
            let beside = rest - into * rest.dot(&into);
            let mut to = (end, false);
            if beside.norm() > 0.08 * pitch {
                let most = beside.norm() + 3.0 * pitch;
                to = slid(&walls, end, into, beside.normalize(), most, known.radius);
            }
            map.pass(&ball, &end);
            map.slide(&end, &to.0, &into);
            map.pass(&end, &to.0);
            travelled += s + (to.0 - end).norm() + 0.06 * pitch;
            ball = to.0 - into * (0.06 * pitch);
            if to.1 {
                touches += 1;
                map.slide(&to.0, &to.0, &beside.normalize());
                ball -= beside.normalize() * (0.06 * pitch);
            }
            map.pass(&to.0, &ball);
            continue;
        }
        let next = end - along * back;
        travelled += s + back;
        map.pass(&ball, &next);
        if touched {
            touches += 1;
            map.touch(&(end + Place::new(chance.within(2e-4), chance.within(2e-4))), &leg);
        }
        ball = next;
    }
    Some(Run { ratio: travelled / shortest, touches, spacing: map.spacing() })
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

fn by_chance() -> Vec<(String, Layout)> {
    (0..8).map(|seed| (format!("seed {seed}"), Layout::random(16, seed))).collect()
}

/// All these mazes: the medians of touches and of the distance through the shortest one.
fn runs(mazes: &[(String, Layout)], then: Then) -> (f64, f64) {
    let (mut ratios, mut touches, mut learned) = (vec![], vec![], 0);
    for (number, (name, maze)) in mazes.iter().enumerate() {
        let pitch = if maze.columns().max(maze.rows()) <= 16 { 0.025 } else { 0.0125 };
        let run =
            run(maze, pitch, number as u64, then).unwrap_or_else(|| panic!("{name}: no path was found"));
        // The exact path is a bound, less the 0.3 % by which it is too short.
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
        "{} mazes, {then:?}: distance, times the shortest: median {:.2}, p95 {:.2}; touches: median {}; spacing learned in {learned}",
        ratios.len(),
        ratios[middle],
        ratios[p95],
        touches[middle]
    );
    assert!(2 * learned > mazes.len());
    (touches[middle], ratios[middle])
}

#[test]
fn the_exit_is_found_by_touch_and_the_spacing_of_walls_is_learned() {
    runs(&by_chance(), Then::Back);
}

fn sliding_needs_fewer_touches(mazes: &[(String, Layout)]) {
    let [(back, _), (slide, distance)] = [Then::Back, Then::Slide].map(|then| runs(mazes, then));
    assert!(slide < back, "{slide} touches instead of {back}, {distance} times the shortest path");
}

#[test]
fn sliding_along_walls_needs_fewer_touches() {
    sliding_needs_fewer_touches(&by_chance());
}

#[test]
#[ignore = "needs a folder of mazes: `just maze-sweep DIR`"]
fn the_exits_of_all_mazes_of_a_folder_are_found_and_sliding_needs_fewer_touches() {
    let folder = std::env::var_os("MRROC_MAZES").expect("`just maze-sweep DIR` sets MRROC_MAZES");
    sliding_needs_fewer_touches(&mazes(Path::new(&folder)));
}
