//! A rectangle on the page.

/// A rectangle on the page, in the page's unit: its upper left corner and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Of the left side.
    pub x: f64,
    /// Of the upper side; y grows downwards.
    pub y: f64,
    /// To the right, at least 0.
    pub width: f64,
    /// Downwards, at least 0.
    pub height: f64,
}

impl Area {
    /// The same area without a margin at each side; at least 1 wide and 1 high.
    #[must_use]
    pub fn inset(self, left: f64, top: f64, right: f64, bottom: f64) -> Area {
        Area {
            x: self.x + left,
            y: self.y + top,
            width: (self.width - left - right).max(1.0),
            height: (self.height - top - bottom).max(1.0),
        }
    }

    /// Of the right side.
    #[must_use]
    pub fn right(self) -> f64 {
        self.x + self.width
    }

    /// Of the lower side.
    #[must_use]
    pub fn bottom(self) -> f64 {
        self.y + self.height
    }
}
