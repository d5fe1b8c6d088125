//! The shortest path of a ball between walls: what paths are compared with.
//!
//! The ball's centre keeps out of the walls inflated by its radius. Inflated walls have round corners; here a quarter of a circle is two
//! chords, so a path may cut into a corner by 8 % of the radius. The result is a lower bound of the true shortest path, by less than
//! 0.3 % of its length where a ball of 4 mm is in cells of 25 mm, and exact for the polygons: a shortest path is straight from vertex to
//! vertex, and touches both (visibility graph; Lozano-Pérez and Wesley, 1979). `tests/reference/shortest.py` computes the same by others' libraries.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::walls::{Place, Wall, Walls};

/// How many vertices each inflated wall has: three at each corner.
const VERTICES: usize = 12;

/// An inflated wall, a convex polygon counterclockwise.
type Polygon = [Place; VERTICES];

/// The inflated walls of a maze.
#[derive(Clone, Debug)]
pub struct Inflated<'w> {
    walls: &'w Walls,
    polygons: Vec<Polygon>,
    /// Vertices that no other polygon covers, with their two neighbours.
    vertices: Vec<[Place; 3]>,
}

/// A rectangle of places.
pub type Region = Wall;

fn inflated(wall: &Wall, radius: f64) -> Polygon {
    let diagonal = core::f64::consts::FRAC_1_SQRT_2 * radius;
    let (l, u) = (wall.lower, wall.upper);
    let corner = |x: f64, y: f64, first: [f64; 2], middle: [f64; 2], last: [f64; 2]| {
        [first, middle, last].map(|[dx, dy]| Place::new(x + dx, y + dy))
    };
    let mut all = [Place::zeros(); VERTICES];
    let corners = [
        corner(l.x, l.y, [-radius, 0.0], [-diagonal, -diagonal], [0.0, -radius]),
        corner(u.x, l.y, [0.0, -radius], [diagonal, -diagonal], [radius, 0.0]),
        corner(u.x, u.y, [radius, 0.0], [diagonal, diagonal], [0.0, radius]),
        corner(l.x, u.y, [0.0, radius], [-diagonal, diagonal], [-radius, 0.0]),
    ];
    for (i, vertex) in corners.into_iter().flatten().enumerate() {
        all[i] = vertex;
    }
    all
}

fn cross(a: Place, b: Place) -> f64 {
    a.x * b.y - a.y * b.x
}

/// How near to an edge still counts as on it \[m\].
const EPS: f64 = 1e-9;

/// Whether a straight line runs through the inside of a polygon.
fn crosses(polygon: &Polygon, from: &Place, to: &Place) -> bool {
    let displacement = to - from;
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for i in 0..VERTICES {
        let (a, b) = (polygon[i], polygon[(i + 1) % VERTICES]);
        let edge = b - a;
        let length = edge.norm();
        if length < EPS {
            continue;
        }
        // How far it is inside of this edge, at the beginning and by how much more at the end.
        let inside = cross(edge, from - a) / length - EPS;
        let more = cross(edge, displacement) / length;
        if more.abs() < 1e-15 {
            if inside <= 0.0 {
                return false;
            }
        } else if more > 0.0 {
            first = first.max(-inside / more);
        } else {
            last = last.min(inside / -more);
        }
        if first >= last {
            return false;
        }
    }
    last > first
}

fn contains(polygon: &Polygon, at: &Place) -> bool {
    (0..VERTICES).all(|i| {
        let (a, b) = (polygon[i], polygon[(i + 1) % VERTICES]);
        cross(b - a, at - a) > EPS * (b - a).norm()
    })
}

impl<'w> Inflated<'w> {
    /// By the radius of a ball \[m\], > 0 and less than half of the narrowest passage.
    #[must_use]
    pub fn by(walls: &'w Walls, radius: f64) -> Self {
        let polygons: Vec<Polygon> = walls.boxes().iter().map(|wall| inflated(wall, radius)).collect();
        let mut vertices = Vec::new();
        for polygon in &polygons {
            for i in 0..VERTICES {
                let at = polygon[i];
                let covered = walls
                    .of_cell(walls.cell(&at))
                    .iter()
                    .any(|other| contains(&polygons[*other as usize], &at));
                if !covered {
                    vertices.push([polygon[(i + VERTICES - 1) % VERTICES], at, polygon[(i + 1) % VERTICES]]);
                }
            }
        }
        Self { walls, polygons, vertices }
    }

    /// Whether the straight line from one place to another is free.
    #[must_use]
    pub fn sees(&self, from: &Place, to: &Place) -> bool {
        let ((fx, fy), (tx, ty)) = (self.walls.cell(from), self.walls.cell(to));
        let (x0, x1) = (fx.min(tx), fx.max(tx));
        // Column by column, only the cells that the line passes.
        let order: Box<dyn Iterator<Item = usize>> =
            if fx <= tx { Box::new(x0..=x1) } else { Box::new((x0..=x1).rev()) };
        let displacement = to - from;
        let pitch = self.walls.pitch();
        for x in order {
            let (left, right) = ((x as f64 - 1.0) * pitch, x as f64 * pitch);
            let at =
                |border: f64| from.y + displacement.y * ((border - from.x) / displacement.x).clamp(0.0, 1.0);
            let (a, b) = if displacement.x.abs() > 1e-12 { (at(left), at(right)) } else { (from.y, to.y) };
            let (low, high) = (
                self.walls.cell(&Place::new(0.0, a.min(b))).1,
                self.walls.cell(&Place::new(0.0, a.max(b))).1,
            );
            for y in low.min(high)..=high.min(fy.max(ty)).max(low) {
                let blocked = self
                    .walls
                    .of_cell((x, y))
                    .iter()
                    .any(|wall| crosses(&self.polygons[*wall as usize], from, to));
                if blocked {
                    return false;
                }
            }
        }
        true
    }

    /// The shortest path from a place to a region, and its length \[m\]; `None` where there is none.
    #[must_use]
    pub fn shortest(&self, start: &Place, goal: &Region) -> Option<(f64, Vec<Place>)> {
        /// Orders non-negative numbers.
        fn key(distance: f64) -> u64 {
            distance.to_bits()
        }
        // Number 0 is the start, 1 the goal, then the vertices.
        let count = self.vertices.len() + 2;
        let place = |number: usize| if number == 0 { *start } else { self.vertices[number - 2][1] };
        let supports = |number: usize, direction: &Place| {
            let [before, at, after] = self.vertices[number - 2];
            let (a, b) = (cross(*direction, before - at), cross(*direction, after - at));
            a >= -1e-15 && b >= -1e-15 || a <= 1e-15 && b <= 1e-15
        };
        let left = |at: &Place| goal.distance(at);
        let mut best = vec![f64::INFINITY; count];
        let mut from = vec![0; count];
        let mut done = vec![false; count];
        best[0] = 0.0;
        let mut open = BinaryHeap::from([(Reverse(key(left(start))), 0_usize)]);
        while let Some((_, number)) = open.pop() {
            if core::mem::replace(&mut done[number], true) {
                continue;
            }
            if number == 1 {
                let mut path = vec![];
                let mut number = from[1];
                path.push(goal.nearest(&place(number)));
                while number != 0 {
                    path.push(place(number));
                    number = from[number];
                }
                path.push(*start);
                path.reverse();
                return Some((best[1], path));
            }
            let at = place(number);
            let mut offer = |next: usize, to: Place, rest: f64| {
                let length = best[number] + (to - at).norm();
                if length < best[next] && self.sees(&at, &to) {
                    best[next] = length;
                    from[next] = number;
                    open.push((Reverse(key(length + rest)), next));
                }
            };
            offer(1, goal.nearest(&at), 0.0);
            for (next, vertex) in (2..count).zip(&self.vertices) {
                let to = vertex[1];
                let leg = to - at;
                if !done[next] && supports(next, &leg) && (number == 0 || supports(number, &leg)) {
                    offer(next, to, left(&to));
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Layout;

    fn region(maze: &Layout, pitch: f64, margin: f64) -> Region {
        let goal = maze.goal();
        let m = Place::new(margin, margin);
        Region {
            lower: Place::new(goal.lower.0 as f64, goal.lower.1 as f64) * pitch + m,
            upper: Place::new(goal.upper.0 as f64 + 1.0, goal.upper.1 as f64 + 1.0) * pitch - m,
        }
    }

    #[test]
    fn the_path_around_one_wall_has_the_length_of_its_closed_form() {
        let maze: Layout = "o---o---o\n| S | G |\no   o   o\n|       |\no---o---o".parse().expect("a maze");
        let walls = Walls::of(&maze, 0.025, 0.002);
        let (start, goal) = (Place::new(0.0125, 0.0375), region(&maze, 0.025, 0.0125));
        let (length, path) = Inflated::by(&walls, 0.002).shortest(&start, &goal).expect("a path");
        // Around the end of the wall, which is at y = 24 mm: tangent to a circle of 2 mm about a corner, over the end, and up again.
        let corner = Place::new(0.024, 0.024);
        let away = (start - corner).norm();
        let tangent = (away * away - 4e-6_f64).sqrt();
        let angle = ((start.x - corner.x).abs() / away).asin();
        // From the tangent's direction to level it turns by 90 degrees less that direction's slope.
        let turn = core::f64::consts::FRAC_PI_2 - (angle - (2e-3 / away).asin());
        let exact = 2.0 * (tangent + 2e-3 * turn) + 2e-3;
        assert!(length <= exact + 1e-12 && length > exact * 0.995, "{length} {exact} {path:?}");
    }

    #[test]
    fn a_maze_without_a_path_has_none() {
        let maze: Layout = "o---o---o\n| S | G |\no---o---o".parse().expect("a maze");
        let walls = Walls::of(&maze, 0.025, 0.002);
        let inflated = Inflated::by(&walls, 0.002);
        assert_eq!(inflated.shortest(&Place::new(0.0125, 0.0125), &region(&maze, 0.025, 0.0125)), None);
    }

    #[test]
    fn no_part_of_a_shortest_path_is_nearer_to_a_wall_than_the_ball_allows() {
        for seed in 0..3 {
            let maze = Layout::random(16, seed);
            let walls = Walls::of(&maze, 0.025, 0.002);
            let goal = region(&maze, 0.025, 0.003);
            let (length, path) =
                Inflated::by(&walls, 0.002).shortest(&Place::new(0.0125, 0.0125), &goal).expect("a path");
            let sum: f64 = path.windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum();
            assert!((sum - length).abs() < 1e-12);
            // Never longer than through the middles of cells.
            let cells = maze.cells_to_goal().expect("a path") as f64 * 0.025;
            assert!(length < cells, "{length} {cells}");
            for leg in path.windows(2) {
                for i in 0..=50 {
                    let at = leg[0] + (leg[1] - leg[0]) * (f64::from(i) / 50.0);
                    // Chords cut 8 % of the radius off at the most: 1 - cos(22.5 degrees).
                    assert!(
                        walls.clearance(&at) > 0.002 * 0.9238,
                        "seed {seed}: {at} {}",
                        walls.clearance(&at)
                    );
                }
            }
        }
    }
}
