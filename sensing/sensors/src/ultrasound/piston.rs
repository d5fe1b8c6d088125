//! The beam of a round piston in a wall.

/// A piston that sends and hears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piston {
    /// Radius \[m\], > 0.
    pub radius: f64,
    /// \[Hz\], > 0.
    pub frequency: f64,
}

impl Piston {
    /// That of the common transducers of 16 mm: half of the pressure at 25°.
    pub const SMALL: Self = Self { radius: 0.007, frequency: 40e3 };

    /// The pressure at an angle from the axis, as a share of that on the axis: `2 J1(x) / x` with `x = k a sin(angle)`. `sin_square` is that of
    /// the angle, `k` the wave number [1/m].
    #[must_use]
    pub fn directivity(&self, sin_square: f64, k: f64) -> f64 {
        // The power series of J1 (Abramowitz and Stegun 9.1.10) is in the square of x.
        let quarter = 0.25 * (k * self.radius).powi(2) * sin_square;
        let (mut sum, mut term) = (0.0, 1.0);
        for m in 1..60 {
            sum += term;
            let m = f64::from(m);
            term *= -quarter / (m * (m + 1.0));
            if term.abs() < 1e-15 {
                break;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beam_has_its_nulls_and_its_half_where_bessels_function_has_them() {
        let piston = Piston { radius: 1.0, frequency: 40e3 };
        // First zeros of J1; half at 2.2151 (SciPy's j1).
        for zero in [3.831_706, 7.015_587] {
            assert!(piston.directivity(1.0, zero).abs() < 1e-6);
        }
        assert!((piston.directivity(1.0, 2.215_089) - 0.5).abs() < 1e-4);
        // 7 mm at 40 kHz and 343.2 m/s: 25.6 degrees.
        let k = core::f64::consts::TAU * 40e3 / 343.2;
        let at = |degrees: f64| Piston::SMALL.directivity(degrees.to_radians().sin().powi(2), k);
        assert!(at(25.0) > 0.5 && at(26.2) < 0.5);
    }
}
