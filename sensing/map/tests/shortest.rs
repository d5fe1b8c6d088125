//! Shortest paths beside those of others' libraries.

use mrroc_map::{Inflated, Layout, Place, Region, Walls};

/// `tests/reference/shortest.py` computes them by shapely: the union of the inflated walls, what is visible, and Dijkstra's algorithm.
#[test]
fn shortest_paths_are_those_that_shapely_finds() {
    let mazes = [
        ("posts", include_str!("reference/posts.txt")),
        ("rooms", include_str!("reference/rooms.txt")),
        ("slalom", include_str!("reference/slalom.txt")),
    ];
    let reference = include_str!("reference/shortest.csv").lines().skip(1);
    for ((name, text), line) in mazes.into_iter().zip(reference) {
        let length: f64 = line.strip_prefix(name).expect(name)[1..].parse().expect("a length");
        let maze: Layout = text.parse().expect(name);
        let walls = Walls::of(&maze, 0.025, 0.002);
        let middle = |(x, y): (usize, usize)| Place::new(x as f64 + 0.5, y as f64 + 0.5) * 0.025;
        let (start, goal) = (middle(maze.start()), middle(maze.goal().lower));
        let region = Region { lower: goal, upper: goal };
        let (found, _) = Inflated::by(&walls, 0.002).shortest(&start, &region).expect("a path");
        assert!((found - length).abs() < 1e-9, "{name}: {found} m, by others {length} m");
    }
}
