//! Mazes by chance, like those of contests.

use mrroc::random::Random;

use crate::layout::{Goal, Layout, Side};

impl Layout {
    /// The share of the walls that is taken away to make loops.
    const OPENED: f64 = 0.07;

    /// A maze of `size` by `size` cells, 6 to 256 and even, as contests have them: the start in a corner and closed on three sides, the
    /// goal four cells in the middle with one entrance, a wall at every post but that in the middle of the goal, and loops.
    ///
    /// It is grown as a tree from the start to all cells (a depth-first walk), and then one of 14 of its walls is taken away.
    ///
    /// # Panics
    /// With a size out of range.
    ///
    /// ```
    /// use mrroc_map::Layout;
    /// let maze = Layout::random(16, 7);
    /// assert_eq!(maze.to_string().parse(), Ok(maze.clone()));
    /// assert_ne!(maze, Layout::random(16, 8));
    /// ```
    #[must_use]
    pub fn random(size: usize, seed: u64) -> Self {
        assert!((6..=256).contains(&size) && size.is_multiple_of(2), "a size of 6 to 256 cells, even");
        let middle = size / 2;
        let goal = Goal { lower: (middle - 1, middle - 1), upper: (middle, middle) };
        let mut chance = Random::seeded(seed);
        let mut maze = Self::open(size, size, (0, 0), goal);
        let cells = || (0..size * size).map(move |i| (i % size, i / size));
        for cell in cells() {
            for side in Side::ALL {
                maze.set_wall(cell, side, true);
            }
        }
        let mut seen = vec![false; size * size];
        let index = |(x, y): (usize, usize)| y * size + x;
        let mut path = vec![(0, 0)];
        seen[0] = true;
        let mut entered = false;
        while let Some(&cell) = path.last() {
            let is_open = |side: &Side| {
                maze.beyond(cell, *side).is_some_and(|next| !seen[index(next)])
                    && (cell != (0, 0) || *side == Side::Up)
            };
            let sides: Vec<Side> = Side::ALL.into_iter().filter(is_open).collect();
            if sides.is_empty() {
                path.pop();
                continue;
            }
            let side = sides[chance.below(sides.len())];
            maze.set_wall(cell, side, false);
            let Some(next) = maze.beyond(cell, side) else { continue };
            if goal.contains(next) && !entered {
                // Its four cells are one, which is a dead end.
                entered = true;
                for x in [middle - 1, middle] {
                    maze.set_wall((x, middle), Side::Down, false);
                    maze.set_wall((middle, x), Side::Left, false);
                }
                for x in middle - 1..=middle {
                    for y in middle - 1..=middle {
                        seen[index((x, y))] = true;
                    }
                }
            } else {
                seen[index(next)] = true;
                path.push(next);
            }
        }
        for cell in cells() {
            for side in [Side::Right, Side::Up] {
                let Some(next) = maze.beyond(cell, side) else { continue };
                let kept = cell == (0, 0) || goal.contains(cell) || goal.contains(next);
                if !kept && maze.has_wall(cell, side) && chance.unit() < Self::OPENED {
                    let (x, y) = cell;
                    let posts = match side {
                        Side::Right => [(x + 1, y), (x + 1, y + 1)],
                        Side::Up | Side::Left | Side::Down => [(x, y + 1), (x + 1, y + 1)],
                    };
                    if posts.iter().all(|post| maze.walls_at(post.0, post.1) > 1) {
                        maze.set_wall(cell, side, false);
                    }
                }
            }
        }
        maze
    }

    /// How many cells one passes from the start to the goal at least; `None` where there is no path.
    #[must_use]
    pub fn cells_to_goal(&self) -> Option<usize> {
        let successors = |cell: &(usize, usize)| {
            let cell = *cell;
            Side::ALL.into_iter().filter_map(move |side| self.next(cell, side)).collect::<Vec<_>>()
        };
        let path = pathfinding::prelude::bfs(&self.start(), successors, |cell| self.goal().contains(*cell))?;
        Some(path.len() - 1)
    }

    /// How many cells the left-hand rule passes from the start to the goal: without a map, always on along the wall to its left.
    /// `None` where it comes back to where it was, and so never gets there.
    #[must_use]
    pub fn cells_by_the_left_hand(&self) -> Option<usize> {
        let mut cell = self.start();
        let mut heading = Side::Up;
        let mut seen = std::collections::HashSet::new();
        let mut passed = 0;
        while !self.goal().contains(cell) {
            if !seen.insert((cell, heading as usize)) {
                return None;
            }
            // Left, ahead, right, back.
            let side = [1, 0, 3, 2]
                .map(|turn| heading.turned(turn))
                .into_iter()
                .find(|side| self.next(cell, *side).is_some())?;
            cell = self.next(cell, side)?;
            heading = side;
            passed += 1;
        }
        Some(passed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mazes_by_chance_keep_the_rules_of_contests() {
        for seed in 0..200 {
            let maze = Layout::random(16, seed);
            assert!(maze.cells_to_goal().is_some(), "{seed}\n{maze}");
            let sides = Side::ALL.map(|side| maze.has_wall((0, 0), side));
            assert_eq!(sides, [true, false, true, true], "{seed}");
            for x in 0..=16 {
                for y in 0..=16 {
                    assert!(
                        maze.walls_at(x, y) > 0 || (x, y) == (8, 8),
                        "seed {seed}: nothing at post {x} {y}\n{maze}"
                    );
                }
            }
            let entrances = Side::ALL.map(|side| {
                (7..=8)
                    .flat_map(|x| (7..=8).map(move |y| (x, y)))
                    .filter(|cell| maze.next(*cell, side).is_some_and(|next| !maze.goal().contains(next)))
                    .count()
            });
            assert_eq!(entrances.iter().sum::<usize>(), 1, "seed {seed}\n{maze}");
        }
    }

    #[test]
    fn the_left_hand_goes_along_the_wall_and_never_gets_to_a_goal_within_a_ring() {
        let ring = "o---o---o---o\n|           |\no   o---o   o\n| S   G |   |\no   o---o   o\n|           |\no---o---o---o";
        let maze: Layout = ring.parse().expect("a maze");
        assert_eq!((maze.cells_to_goal(), maze.cells_by_the_left_hand()), (Some(1), None));
        let open: Layout = ring
            .replace("o   o---o   o\n|           |\no-", "o   o---o---o\n|           |\no-")
            .parse()
            .expect("a maze");
        // To the dead end at the right and back along the inner wall: 4 cells there, 4 back, and in.
        assert_eq!(open.cells_by_the_left_hand(), Some(9));
    }
}
