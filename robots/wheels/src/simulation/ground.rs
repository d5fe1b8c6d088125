//! The floor that a base stands on, and the walls on it.

use mrroc_map::Walls;

/// The floor and its walls.
#[derive(Clone, Debug)]
pub struct Ground {
    /// Friction of the tyres on it.
    pub friction: f64,
    /// What drags at the axle, dry: carpet, or a load that is towed \[N\].
    pub drag: f64,
    /// The radii of the left and the right wheel, as shares of what they are said to be.
    pub rims: [f64; 2],
    /// Walls, in the frame of the floor.
    pub walls: Option<Walls>,
}

impl Default for Ground {
    /// Rubber on a board, nothing that drags, no walls.
    fn default() -> Self {
        Self { friction: 0.9, drag: 0.0, rims: [1.0; 2], walls: None }
    }
}
