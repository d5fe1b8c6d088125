//! Marks: arrows of axes, where a way begins and where it ends.
//!
//! In: places on the page \[px\]. Out: a ring for the beginning, a dot for the end; the ring is around the dot where both
//! are in one place.

use nalgebra::Vector2;

use crate::palette::INK;
use crate::svg::{Points, Px, Svg};

/// An arrow in ink.
pub(crate) fn arrow(svg: &mut Svg, from: Vector2<f64>, to: Vector2<f64>) {
    svg.line(from, to, format_args!("stroke=\"{INK}\" stroke-width=\"1.4\""));
    if let Some(direction) = (to - from).try_normalize(1e-9) {
        let side = Vector2::new(-direction.y, direction.x) * 3.0;
        let back = to - direction * 7.0;
        svg.element(
            "polygon",
            format_args!("fill=\"{INK}\" points=\"{}\"", Points(&[to, back + side, back - side])),
        );
    }
}

/// The marks of a way's beginning and end.
pub(crate) fn ends(svg: &mut Svg, first: Vector2<f64>, last: Vector2<f64>, radius: f64) {
    dot(svg, last, radius);
    ring(svg, first, if (first - last).norm() < radius { 1.9 * radius } else { radius });
}

pub(crate) fn ring(svg: &mut Svg, at: Vector2<f64>, radius: f64) {
    circle(
        svg,
        at,
        radius,
        format_args!("class=\"first\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"1.6\""),
    );
}

pub(crate) fn dot(svg: &mut Svg, at: Vector2<f64>, radius: f64) {
    circle(
        svg,
        at,
        radius,
        format_args!("class=\"last\" fill=\"{INK}\" stroke=\"#fff\" stroke-width=\"1.2\""),
    );
}

pub(crate) fn circle(svg: &mut Svg, at: Vector2<f64>, radius: f64, attributes: std::fmt::Arguments<'_>) {
    svg.element(
        "circle",
        format_args!("cx=\"{}\" cy=\"{}\" r=\"{}\" {attributes}", Px(at.x), Px(at.y), Px(radius)),
    );
}
