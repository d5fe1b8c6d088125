//! A ball without a robot walks mazes by touch: how good is the map's planning?

use mrroc_map::{Inflated, Knowledge, Layout, Map, Place, Planner, Region, Walls};

const PITCH: f64 = 0.025;
const THICKNESS: f64 = 0.002;
const RADIUS: f64 = 0.002;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|a| a.parse::<f64>().expect("number"));
    let (from, to) = (arguments.next().unwrap_or(0.0) as u64, arguments.next().unwrap_or(20.0) as u64);
    let wall = arguments.next().unwrap_or(0.025);
    let price = arguments.next().unwrap_or(0.06);
    let margin = arguments.next().unwrap_or(0.0012);
    let planner = Planner { price, margin, ..Planner::default() };
    let (mut ratios, mut touches, mut lost, mut plans) = (vec![], vec![], 0, 0.0);
    for seed in from..to {
        let maze = Layout::random(16, seed);
        let walls = Walls::of(&maze, PITCH, THICKNESS);
        let m = Place::new(0.004, 0.004);
        let goal = Region {
            lower: Place::new(maze.goal().lower.0 as f64, maze.goal().lower.1 as f64) * PITCH + m,
            upper: Place::new(maze.goal().upper.0 as f64 + 1.0, maze.goal().upper.1 as f64 + 1.0) * PITCH - m,
        };
        let start = Place::new(0.5, 0.5) * PITCH;
        let (shortest, _) = Inflated::by(&walls, RADIUS).shortest(&start, &goal).expect("a way");
        let known = Knowledge { size: [0.4, 0.4], radius: RADIUS, thickness: THICKNESS, passage: 0.015, wall };
        let mut map = Map::new(known);
        let (mut at, mut length) = (start, 0.0);
        let mut trace = vec![start];
        let began = std::time::Instant::now();
        'walk: while goal.distance(&at) > 0.0 {
            if map.contacts().len() > 2000 { lost += 1; break; }
            let Some(way) = planner.way(&map, &at, &goal) else {
                println!("seed {seed}: no way after {} touches\n", map.contacts().len());
                lost += 1;
                break;
            };
            for to in &way[1..] {
                let begin = at;
                let direction = (to - begin).normalize();
                let whole = (to - begin).norm();
                let mut s = 0.0;
                while s < whole {
                    s = (s + 2e-4).min(whole);
                    at = begin + direction * s;
                    if walls.clearance(&at) < RADIUS {
                        // back to where it was free, and a bit more
                        map.pass(&begin, &(begin + direction * (s - 1e-3).max(0.0)));
                        map.touch(&at, &direction);
                        let back = (s - 1.5e-3).max(0.0);
                        length += s + (s - back);
                        trace.push(at);
                        at = begin + direction * back;
                        trace.push(at);
                        continue 'walk;
                    }
                }
                length += whole;
                trace.push(at);
                map.pass(&begin, &at);
            }
        }
        plans += began.elapsed().as_secs_f64();
        if to - from <= 3 {
            use std::fmt::Write as _;
            let mut svg = String::from("<svg xmlns='http://www.w3.org/2000/svg' viewBox='-5 -405 410 410' width='1000' height='1000'><rect x='-5' y='-405' width='410' height='410' fill='white'/><g transform='scale(1,-1)'>");
            for w in walls.boxes() { write!(svg, "<rect x='{}' y='{}' width='{}' height='{}' fill='#bbb'/>", w.lower.x*1e3, w.lower.y*1e3, (w.upper.x-w.lower.x)*1e3, (w.upper.y-w.lower.y)*1e3).unwrap(); }
            let points: Vec<String> = trace.iter().map(|p| format!("{:.2},{:.2}", p.x*1e3, p.y*1e3)).collect();
            write!(svg, "<polyline points='{}' fill='none' stroke='#06c' stroke-width='0.7'/>", points.join(" ")).unwrap();
            for c in map.contacts() { write!(svg, "<line x1='{}' y1='{}' x2='{}' y2='{}' stroke='red' stroke-width='1'/><circle cx='{}' cy='{}' r='0.8' fill='red'/>", c.at.x*1e3, c.at.y*1e3, (c.at.x+c.into.x*4e-3)*1e3, (c.at.y+c.into.y*4e-3)*1e3, c.at.x*1e3, c.at.y*1e3).unwrap(); }
            svg.push_str("</g></svg>");
            std::fs::write(format!("/tmp/w/maze-out/walk{seed}.svg"), svg).unwrap();
        }
        println!("{seed} {:.2}", length / shortest);
        ratios.push(length / shortest);
        touches.push(map.contacts().len());
    }
    ratios.sort_by(f64::total_cmp);
    touches.sort_unstable();
    let n = ratios.len();
    println!("{n} mazes, lost {lost}: ratio median {:.3} p95 {:.2} worst {:.2}; touches median {} p95 {}; {:.0} ms a maze", ratios[n / 2], ratios[n * 95 / 100], ratios[n - 1], touches[n / 2], touches[n * 95 / 100], 1e3 * plans / n as f64);
}
