//! Marks: arrows of axes, where a path begins and where it ends.
//!
//! In: places on the page \[px\]. Out: a ring for the beginning, a dot for the end; the ring is around the dot where both
//! are in one place.

use nalgebra::Vector2;

use crate::svg::palette::{INK, WHITE};
use crate::svg::{Look, Svg};

/// An arrow in ink.
pub(crate) fn arrow(svg: &mut Svg, from: Vector2<f64>, to: Vector2<f64>) {
    svg.line(from, to, Look::new().stroke(INK).width(1.4));
    if let Some(direction) = (to - from).try_normalize(1e-9) {
        let side = Vector2::new(-direction.y, direction.x) * 3.0;
        let back = to - direction * 7.0;
        svg.polygon(&[to, back + side, back - side], Look::filled(INK));
    }
}

/// The marks of a path's beginning and end.
pub(crate) fn ends(svg: &mut Svg, first: Vector2<f64>, last: Vector2<f64>, radius: f64) {
    dot(svg, last, radius);
    ring(svg, first, if (first - last).norm() < radius { 1.9 * radius } else { radius });
}

pub(crate) fn ring(svg: &mut Svg, at: Vector2<f64>, radius: f64) {
    svg.circle(at, radius, Look::line(INK, 1.6).class("first"));
}

pub(crate) fn dot(svg: &mut Svg, at: Vector2<f64>, radius: f64) {
    svg.circle(at, radius, Look::filled(INK).stroke(WHITE).width(1.2).class("last"));
}
