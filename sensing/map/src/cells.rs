//! Through which panels to go next: optimistically, and rather where nothing is known than through what is.
//!
//! ```text
//! nodes     the rooms between posts, each with the direction in which it is entered
//! cost      1 for each panel; a corner is cut, so a turn saves `TURN`; a panel that was passed costs `PASSED` more
//! path      A* (the crate `pathfinding`); panels that are not known count as open
//! ```
//!
//! A surcharge on unknown panels makes the whole path longer, not shorter: what is learned while the robot is far off saves going
//! back to it. So the surcharge is on those that are known.

use pathfinding::prelude::astar;

use crate::panels::{Panel, Panels, Which};
use crate::shortest::Region;
use crate::walls::{Place, Wall};

/// What a turn saves: two rooms around a corner are one diagonal, 2 - sqrt(2), of which a half is of each turn.
const TURN: f64 = 0.29;
/// The surcharge on a panel that the ball has passed. Measured: 0.6 is best of 0, 0.3, 0.6 and 1.
const PASSED: f64 = 0.6;

/// A room, and the direction in which it was entered.
type Node = ((usize, usize), Option<usize>);

/// To the right, up, left, down.
const DIRECTIONS: usize = 4;

/// The panel at this side of a room, and the room beyond, if there is one.
fn side(panels: &Panels, (x, y): (usize, usize), direction: usize) -> (Which, Option<(usize, usize)>) {
    match direction {
        0 => ((true, x + 1, y), (x + 1 < panels.columns).then_some((x + 1, y))),
        1 => ((false, y + 1, x), (y + 1 < panels.rows).then_some((x, y + 1))),
        2 => ((true, x, y), x.checked_sub(1).map(|x| (x, y))),
        _ => ((false, y, x), y.checked_sub(1).map(|y| (x, y))),
    }
}

/// The panels on the path from a place to a region, and the rooms between; `None` where no panel is left to try.
pub fn panels_to(panels: &Panels, from: &Place, goal: &Region) -> Option<Vec<(Which, (usize, usize))>> {
    let s = panels.spacing;
    let whole = |cost: f64| (1e4 * cost) as u32;
    let is_goal = |(x, y): (usize, usize)| {
        let lower = Place::new(x as f64, y as f64) * s;
        let room = Wall { lower, upper: lower + Place::new(s, s) };
        room.lower.x < goal.upper.x
            && room.lower.y < goal.upper.y
            && room.upper.x > goal.lower.x
            && room.upper.y > goal.lower.y
    };
    let successors = |&(room, entered): &Node| {
        (0..DIRECTIONS).filter_map(move |direction| {
            let (which, next) = side(panels, room, direction);
            let panel = panels.get(which);
            let next = next.filter(|_| panel != Panel::Wall)?;
            let turns = entered.is_some_and(|entered| (entered + direction) % 2 == 1);
            let known = if panel == Panel::Open { PASSED } else { 0.0 };
            let cost = 1.0 + known + panels.doubts(which) - if turns { TURN } else { 0.0 };
            Some(((next, Some(direction)), whole(cost)))
        })
    };
    let left = |&((x, y), _): &Node| {
        let beyond = |v: usize, lower: f64, upper: f64| {
            let v = v as f64 * s;
            (lower - v - s).max(v - upper).max(0.0) / s
        };
        let apart =
            beyond(x, goal.lower.x, goal.upper.x).ceil() + beyond(y, goal.lower.y, goal.upper.y).ceil();
        whole((1.0 - TURN) * apart)
    };
    let (nodes, _) = astar(&(panels.room(from), None), successors, left, |node| is_goal(node.0))?;
    let steps = nodes.windows(2).map(|step| {
        let direction = step[1].1.unwrap_or(0);
        (side(panels, step[0].0, direction).0, step[1].0)
    });
    Some(steps.collect())
}
