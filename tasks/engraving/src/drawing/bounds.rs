//! Axis-parallel boxes.

use super::Vec2;

/// An axis-parallel box \[mm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower left corner \[mm\].
    pub min: Vec2,
    /// Upper right corner \[mm\].
    pub max: Vec2,
}

impl Bounds {
    /// The box around points; `None` for none.
    #[must_use]
    pub fn around(points: impl IntoIterator<Item = Vec2>) -> Option<Self> {
        points.into_iter().fold(None, |so_far: Option<Self>, p| {
            Some(match so_far {
                None => Self { min: p, max: p },
                Some(b) => Self { min: b.min.inf(&p), max: b.max.sup(&p) },
            })
        })
    }

    /// The box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// Width and height \[mm\].
    #[must_use]
    pub fn size(&self) -> Vec2 {
        self.max - self.min
    }

    /// The middle \[mm\].
    #[must_use]
    pub fn centre(&self) -> Vec2 {
        (self.min + self.max) * 0.5
    }
}
