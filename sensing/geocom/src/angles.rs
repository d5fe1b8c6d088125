//! Angles as GeoCOM has them, and as this workspace does.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

/// On which face the telescope is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Face {
    /// As usual.
    #[default]
    One,
    /// Turned over.
    Two,
}

/// What circles read (Hz, V of GeoCOM) as a horizontal angle from x to y (-pi to pi) and an elevation \[rad\], both as of the first face.
#[must_use]
pub fn from_circles([hz, v]: [f64; 2], face: Face) -> [f64; 2] {
    let (hz, v) = match face {
        Face::One => (hz, v),
        Face::Two => (hz - PI, TAU - v),
    };
    [PI - (hz + PI).rem_euclid(TAU), FRAC_PI_2 - v]
}

/// The opposite: Hz from 0 to 2 pi, V from 0 to 2 pi.
#[must_use]
pub fn to_circles([hz, elevation]: [f64; 2], face: Face) -> [f64; 2] {
    let (hz, v) = (-hz, FRAC_PI_2 - elevation);
    match face {
        Face::One => [hz.rem_euclid(TAU), v.rem_euclid(TAU)],
        Face::Two => [(hz + PI).rem_euclid(TAU), (TAU - v).rem_euclid(TAU)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_faces_of_one_direction_are_one_and_counted_from_x_to_y() {
        // 90 degrees to the left, 10 degrees up: Hz 270, V 80 degrees in the first face; Hz 90, V 280 in the second.
        let direction = [90.0_f64, 10.0].map(f64::to_radians);
        for (face, circles) in [(Face::One, [270.0_f64, 80.0]), (Face::Two, [90.0, 280.0])] {
            let circles = circles.map(f64::to_radians);
            for axis in 0..2 {
                assert!((to_circles(direction, face)[axis] - circles[axis]).abs() < 1e-12);
                assert!((from_circles(circles, face)[axis] - direction[axis]).abs() < 1e-12);
            }
        }
    }
}
