//! World models of mazes.

mod layout;
mod map;
mod plan;
mod random;
mod shortest;
mod walls;

pub use layout::{Goal, Layout, LayoutError, Side};
pub use map::{Contact, Knowledge, Map, Thought};
pub use plan::Planner;
pub use random::Chance;
pub use shortest::{Inflated, Region};
pub use walls::{Place, Wall, Walls};
