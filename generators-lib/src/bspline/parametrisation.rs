//! How far apart the knots of neighbouring points are.

use nalgebra::Vector3;

/// Knot span between two points: `h = |P_{i+1} - P_i|^alpha`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parametrisation {
    /// `alpha = 0`: every span is 1.
    Uniform,
    /// `alpha = 1/2` (Lee 1989): the least prone to loops where spacing is uneven.
    Centripetal,
    /// `alpha = 1`: the parameter is near the path length; what CAD systems do by default.
    #[default]
    Chord,
}

impl Parametrisation {
    /// Knot span `h` > 0 of two distinct points \[m\]; its unit is m^alpha.
    #[must_use]
    pub fn knot_span(self, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
        match self {
            Self::Uniform => 1.0,
            Self::Centripetal => (to - from).norm().sqrt(),
            Self::Chord => (to - from).norm(),
        }
    }
}
