//! What a motion of the curve takes, and how far it gets.

/// Duration and displacement of the ramps, as the module's `T + a0 / J` and `D + c`, and the displacement's slope by the piece's variable.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Value {
    pub time: f64,
    pub displacement: f64,
    pub slope: f64,
}
