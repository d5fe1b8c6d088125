//! The basic shapes as chains of exact pieces.

use crate::drawing::{EllipticalArc, Piece, Vec2};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A rectangle with corner radii, clockwise on the screen from its upper left as SVG 2 has it.
#[must_use]
pub fn rectangle(x: f64, y: f64, width: f64, height: f64, rx: f64, ry: f64) -> Vec<Piece> {
    let (rx, ry) = (rx.clamp(0.0, width / 2.0), ry.clamp(0.0, height / 2.0));
    let line =
        |ax: f64, ay: f64, bx: f64, by: f64| Piece::Line { from: Vec2::new(ax, ay), to: Vec2::new(bx, by) };
    let corner = |cx: f64, cy: f64, start: f64| {
        Piece::Arc(EllipticalArc {
            centre: Vec2::new(cx, cy),
            u: Vec2::new(rx, 0.0),
            v: Vec2::new(0.0, ry),
            start_angle: start,
            sweep: FRAC_PI_2,
        })
    };
    let (r, b) = (x + width, y + height);
    if rx <= 0.0 || ry <= 0.0 {
        return vec![line(x, y, r, y), line(r, y, r, b), line(r, b, x, b), line(x, b, x, y)];
    }
    vec![
        line(x + rx, y, r - rx, y),
        corner(r - rx, y + ry, -FRAC_PI_2),
        line(r, y + ry, r, b - ry),
        corner(r - rx, b - ry, 0.0),
        line(r - rx, b, x + rx, b),
        corner(x + rx, b - ry, FRAC_PI_2),
        line(x, b - ry, x, y + ry),
        corner(x + rx, y + ry, PI),
    ]
}

/// An ellipse from three o'clock.
#[must_use]
pub fn ellipse(centre: Vec2, rx: f64, ry: f64) -> Vec<Piece> {
    vec![Piece::Arc(EllipticalArc {
        centre,
        u: Vec2::new(rx, 0.0),
        v: Vec2::new(0.0, ry),
        start_angle: 0.0,
        sweep: TAU,
    })]
}

/// Lines from point to point.
#[must_use]
pub fn polyline(points: &[Vec2]) -> Vec<Piece> {
    points.windows(2).map(|w| Piece::Line { from: w[0], to: w[1] }).collect()
}
