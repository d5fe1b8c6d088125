//! World models of mazes, for robots that find their way by touch, and for measuring how well they do.
//!
//! ```text
//! text  -> Layout -> Walls -> Inflated -> the shortest path of a ball, to compare with
//! seen boxes -> Walls, a path from Inflated -> Taut, the same path as a taut string of lines and arcs, to move along
//! touches, moves -> Map -> Planner -> a path through what is not known to be wall
//! ```
//!
//! It knows no robot, and nothing of the runtime but its random numbers. [`Layout`] reads and writes the text format of micromouse contests, and draws mazes by chance.
//!
//! ```
//! use mrroc_map::{Inflated, Knowledge, Layout, Map, Place, Planner, Region, Walls};
//!
//! let maze: Layout = "o---o---o\n| S | G |\no   o   o\n|       |\no---o---o".parse()?;
//! let walls = Walls::of(&maze, 0.025, 0.002);
//! let start = Place::new(0.0125, 0.0375);
//! let goal = Region { lower: Place::new(0.029, 0.029), upper: Place::new(0.046, 0.046) };
//! let (shortest, _) = Inflated::by(&walls, 0.002).shortest(&start, &goal).expect("a path");
//!
//! // Nothing is known: straight through the wall between. Its touch shows a path around.
//! let known = Knowledge { size: [0.05, 0.05], radius: 0.002, thickness: 0.002, passage: 0.015, wall: 0.025 };
//! let mut map = Map::new(known);
//! let path = Planner::of(&known, 0.0012).path(&map, &start, &goal).expect("all may be free");
//! assert!(path.last().is_some_and(|end| goal.distance(end) == 0.0));
//! map.touch(&Place::new(0.022, 0.0375), &Place::new(1.0, 0.0));
//! let around = Planner::of(&known, 0.0012).path(&map, &Place::new(0.0205, 0.0375), &goal).expect("a path");
//! assert!(around.len() > 2 && shortest < 0.05);
//! # Ok::<(), mrroc_map::LayoutError>(())
//! ```

mod cells;
mod contact;
mod layout;
mod map;
mod panels;
mod plan;
mod portals;
mod random;
mod shortest;
mod spacing;
mod taut;
mod walls;

pub use contact::{Contact, Knowledge};
pub use layout::{Goal, LARGEST, Layout, LayoutError, Side};
pub use map::{Map, Thought};
pub use plan::Planner;
pub use shortest::{Inflated, Region};
pub use spacing::spacing;
pub use taut::{Piece, Taut};
pub use walls::{Place, Wall, Walls};

// The files in `tests/` use this crate by its name, as its users do.
#[cfg(test)]
extern crate self as mrroc_map;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod usage;
