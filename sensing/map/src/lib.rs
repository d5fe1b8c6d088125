//! World models of mazes.

mod layout;
mod random;
mod shortest;
mod walls;

pub use layout::{Goal, Layout, LayoutError, Side};
pub use random::Chance;
pub use shortest::{Inflated, Region};
pub use walls::{Place, Wall, Walls};
