//! Mazes that are to be run.

use mrroc_map::{Layout, LayoutError};

/// A maze, and how it is run: the same run whatever else is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Seeded {
    /// Which maze.
    pub name: String,
    /// Its walls.
    pub layout: Layout,
    /// Of where it stands, and of the sensors.
    pub seed: u64,
}

impl Seeded {
    /// The maze of a text in the format of micromouse contests.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn read(name: &str, text: &str, seed: u64) -> Result<Self, LayoutError> {
        Ok(Self { name: name.to_owned(), layout: text.parse()?, seed })
    }

    /// A maze of 16 by 16 cells by chance.
    #[must_use]
    pub fn by_chance(seed: u64) -> Self {
        Self { name: format!("seed {seed}"), layout: Layout::random(16, seed), seed }
    }

    /// Those of the folder `mazes`: `islands`, where the left-hand rule goes round, and `comb`.
    ///
    /// # Errors
    /// None: both are read by tests.
    pub fn shipped(seed: u64) -> Result<[Self; 2], LayoutError> {
        Ok([
            Self::read("islands", include_str!("../mazes/islands.txt"), seed)?,
            Self::read("comb", include_str!("../mazes/comb.txt"), seed)?,
        ])
    }
}
