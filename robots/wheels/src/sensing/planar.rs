//! A pose on the floor.

use mrroc::payload::Payload;
use nalgebra::Vector2;

use crate::model::angle;

/// Where something stands on a floor, and where it looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Planar {
    /// [m, floor].
    pub x: f64,
    /// [m, floor].
    pub y: f64,
    /// Of its x axis from that of the floor, counterclockwise \[rad\].
    pub heading: f64,
}

impl Planar {
    /// Its place [m, floor].
    #[must_use]
    pub const fn at(&self) -> Vector2<f64> {
        Vector2::new(self.x, self.y)
    }

    /// Where a place that is given in its frame is on the floor \[m\].
    ///
    /// ```
    /// use mrroc_wheels::Planar;
    /// use nalgebra::Vector2;
    /// let base = Planar { x: 1.0, y: 0.0, heading: core::f64::consts::FRAC_PI_2 };
    /// assert!((base.place(&Vector2::new(0.2, 0.0)) - Vector2::new(1.0, 0.2)).norm() < 1e-15);
    /// ```
    #[must_use]
    pub fn place(&self, inside: &Vector2<f64>) -> Vector2<f64> {
        let (sine, cosine) = self.heading.sin_cos();
        Vector2::new(
            self.x + cosine * inside.x - sine * inside.y,
            self.y + sine * inside.x + cosine * inside.y,
        )
    }

    /// A place on the floor as it is seen in its frame \[m\].
    #[must_use]
    pub fn seen(&self, place: &Vector2<f64>) -> Vector2<f64> {
        let (sine, cosine) = self.heading.sin_cos();
        let off = place - self.at();
        Vector2::new(cosine * off.x + sine * off.y, cosine * off.y - sine * off.x)
    }

    /// After it has gone `distance` \[m\] while it turned by `turn` \[rad\], on an arc.
    #[must_use]
    pub fn moved(&self, distance: f64, turn: f64) -> Self {
        // The chord of the arc: 2 sin(turn / 2) / turn of it.
        let half = 0.5 * turn;
        let chord = if half.abs() < 1e-4 {
            distance * (1.0 - half * half / 6.0)
        } else {
            distance * half.sin() / half
        };
        let (sine, cosine) = (self.heading + half).sin_cos();
        Self { x: self.x + chord * cosine, y: self.y + chord * sine, heading: self.heading + turn }
    }

    /// How far this one is turned from another, within half a turn \[rad\].
    #[must_use]
    pub fn turned_from(&self, other: &Self) -> f64 {
        angle(self.heading - other.heading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_in_one_step_ends_where_many_short_steps_do() {
        let start = Planar { x: 0.1, y: -0.2, heading: 0.7 };
        for (distance, turn) in [(0.5, 1.3), (0.4, 1e-6), (-0.3, -2.0), (0.0, 1.0)] {
            let whole = start.moved(distance, turn);
            let mut parts = start;
            for _ in 0..10_000 {
                parts = parts.moved(distance * 1e-4, turn * 1e-4);
            }
            assert!((whole.at() - parts.at()).norm() < 1e-10, "{distance} {turn}");
            // The centre of the circle: a distance over a turn to the left.
            if turn.abs() > 0.1 {
                let centre = start.place(&Vector2::new(0.0, distance / turn));
                assert!((whole.place(&Vector2::new(0.0, distance / turn)) - centre).norm() < 1e-12);
            }
        }
    }
}
