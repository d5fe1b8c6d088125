//! The air that sound goes through.

/// Air of a temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// \[°C\], above -273.15.
    pub celsius: f64,
}

impl Air {
    /// Loss of sound of 40 kHz over distance [dB/m].
    pub const LOSS: f64 = 1.3;

    /// Speed of sound [m/s]: 331.3 at 0 °C, and as the root of the absolute temperature.
    #[must_use]
    pub fn speed(&self) -> f64 {
        331.3 * (1.0 + self.celsius / 273.15).sqrt()
    }

    /// The share of a pressure that is left after a distance there and back \[m\].
    #[must_use]
    pub fn left(range: f64) -> f64 {
        10.0_f64.powf(-Self::LOSS * 2.0 * range / 20.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sound_is_as_fast_as_tables_say() {
        // 343.2 m/s at 20 °C, 346.1 m/s at 25 °C in dry air.
        for (celsius, speed) in [(0.0, 331.3), (20.0, 343.2), (25.0, 346.1)] {
            assert!((Air { celsius }.speed() - speed).abs() < 0.15, "{celsius}");
        }
    }
}
