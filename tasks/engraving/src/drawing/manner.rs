//! What a file says of the cutting of a stroke, beside its shape.

/// How a stroke is cut, as far as its file says it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Manner {
    /// Feed along the stroke [mm/s], > 0.
    pub feed: Option<f64>,
    /// The tool rests so long at the end \[s\], >= 0.
    pub dwell: f64,
    /// Greatest height at which the tool travels to the start \[mm\], > 0.
    pub approach: Option<f64>,
    /// The tool comes to the start from the end of the stroke before it without lifting: it is there, or above it in the
    /// same hole.
    pub goes_on: bool,
}
