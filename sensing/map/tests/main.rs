//! Shortest paths, and mazes by touches, as users of this crate have them.

mod shortest;
mod touch;
