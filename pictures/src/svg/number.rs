//! Numbers of a document: short, and always numbers.

use std::fmt;

use nalgebra::Vector2;

/// The most digits after the point that a number is written with.
const MOST_DIGITS: u32 = 9;

/// A number that is written with at most `digits` digits after the point and without zeros at the end. What is not
/// finite is written as 0, so that the document stays one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number {
    pub value: f64,
    pub digits: u32,
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut digits = self.digits.min(MOST_DIGITS);
        let value = if self.value.is_finite() { self.value } else { 0.0 };
        // The cast saturates far beyond what a viewer shows.
        let scaled = (value * f64::from(10_u32.pow(digits))).round() as i64;
        let mut fraction = scaled.unsigned_abs() % 10_u64.pow(digits);
        let whole = scaled.unsigned_abs() / 10_u64.pow(digits);
        let sign = if scaled < 0 { "-" } else { "" };
        if fraction == 0 {
            return write!(f, "{sign}{whole}");
        }
        while fraction.is_multiple_of(10) {
            fraction /= 10;
            digits -= 1;
        }
        write!(f, "{sign}{whole}.{fraction:0width$}", width = digits as usize)
    }
}

/// Points of a `points` attribute.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points<'a> {
    pub points: &'a [Vector2<f64>],
    pub digits: u32,
}

impl fmt::Display for Points<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = self.digits;
        for (i, point) in self.points.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            write!(f, "{gap}{},{}", Number { value: point.x, digits }, Number { value: point.y, digits })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_always_numbers() {
        let written = |value, digits| Number { value, digits }.to_string();
        let tenths = [0.04, -0.04, 1.25, -3.0, 1e3, -0.5, f64::NAN].map(|value| written(value, 1));
        assert_eq!(tenths, ["0", "0", "1.3", "-3", "1000", "-0.5", "0"]);
        let thousandths = [0.04, 1.0005, 12.3, -7.1239, f64::INFINITY].map(|value| written(value, 3));
        assert_eq!(thousandths, ["0.04", "1.001", "12.3", "-7.124", "0"]);
        assert_eq!([written(2.5, 0), written(1e300, 1)], ["3", "922337203685477580.7"]);
    }
}
