//! A drawing: a list of strokes; and what else comes out of a file.

use super::{Affine, Bounds, Stroke};

/// What is to be engraved, in millimetres with y up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// The strokes in the order of cutting.
    pub strokes: Vec<Stroke>,
}

/// What came out of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Import {
    /// The drawing.
    pub drawing: Drawing,
    /// What the reader left out or assumed, one sentence each.
    pub warnings: Vec<String>,
    /// In which order the strokes are to be cut.
    pub order: Order,
}

/// The order of strokes, and in which direction they go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Any that saves travel.
    #[default]
    Free,
    /// As they stand: a program means its order.
    AsGiven,
}

impl Drawing {
    /// The box around everything \[mm\]; `None` for an empty drawing.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        self.strokes.iter().map(Stroke::bounds).reduce(|a, b| a.union(&b))
    }

    /// The sum of the strokes' lengths \[mm\], without travel between them.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.strokes.iter().map(Stroke::length).sum()
    }

    /// The number of curve pieces.
    #[must_use]
    pub fn piece_count(&self) -> usize {
        self.strokes.iter().map(|stroke| stroke.pieces().len()).sum()
    }

    /// The drawing's image.
    #[must_use]
    pub fn transformed(&self, map: &Affine) -> Self {
        Self { strokes: self.strokes.iter().map(|stroke| stroke.transformed(map)).collect() }
    }

    /// The drawing with its strokes at this depth \[mm\] where their file says no heights.
    #[must_use]
    pub fn sunk(self, depth: f64) -> Self {
        Self { strokes: self.strokes.into_iter().map(|stroke| stroke.sunk(depth)).collect() }
    }

    /// The drawing with all strokes at this depth \[mm\], whatever their file says.
    #[must_use]
    pub fn flattened_to(self, depth: f64) -> Self {
        Self { strokes: self.strokes.into_iter().map(|stroke| stroke.flattened_to(depth)).collect() }
    }
}
