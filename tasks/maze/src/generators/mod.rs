//! How the arm moves.

mod leg;

pub use leg::Leg;
