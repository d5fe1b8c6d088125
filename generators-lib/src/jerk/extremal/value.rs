//! What a motion of the curve takes, and how far it gets.

/// Duration and way of the ramps, as the module's `T + a0 / J` and `D + c`, and the way's slope by the piece's variable.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Value {
    pub time: f64,
    pub way: f64,
    pub way_slope: f64,
}
