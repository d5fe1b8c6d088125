//! What flows into a moving segment, and what flows out.

use super::Span;
use nalgebra::Vector3;

/// Whether the path turns a corner at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Junction {
    /// The turn angle decides.
    #[default]
    Auto,
    /// A corner: the curve ends here at rest and another begins.
    Corner,
    /// No corner, however sharp the turn.
    Smooth,
}

/// Whether spans that start at a point belong to the path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Part {
    /// They do.
    #[default]
    Drawn,
    /// They only lead into or out of a closed path and are not emitted.
    Lead,
}

/// A point of the path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SplinePoint {
    /// Position \[m\], finite.
    pub position: Vector3<f64>,
    /// Corner, smooth, or by the turn angle.
    pub junction: Junction,
    /// Path, or lead of a closed path.
    pub part: Part,
}

impl From<Vector3<f64>> for SplinePoint {
    #[inline]
    fn from(position: Vector3<f64>) -> Self {
        Self { position, ..Self::default() }
    }
}

/// How a span ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpanEnd {
    /// The next span of the run continues it.
    Continued,
    /// At a corner, or at the end of the path: motion comes to rest here.
    Rest,
}

/// A span of the curve, as it comes out of a moving segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSpan {
    /// The curve.
    pub span: Span,
    /// How it ends.
    pub end: SpanEnd,
}
