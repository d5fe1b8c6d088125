//! The way of one tool alone, as large as it fits, in the plane where it spans most.
//!
//! In: an actor. Out: a drawing to scale, with a scale bar; or words when the tool stayed where it was.

use nalgebra::{Vector2, Vector3};

use crate::marks::{arrow, ends};
use crate::palette::{GREY, GRID, INK};
use crate::projection::{Area, Extent, Projection, View};
use crate::scene::Actor;
use crate::svg::{Anchor, Px, Svg, Weight, Words};
use crate::ticks::step;
use crate::wording::metres;

/// What spans less is a standstill \[m\].
const STILL: f64 = 2e-4;

/// Draws the way into an area, in about `most` points.
pub(crate) fn draw(svg: &mut Svg, area: Area, actor: &Actor<'_>, most: usize) {
    let tool = &actor.motion.tool;
    let words = Words { size: 11.5, colour: GREY, anchor: Anchor::Start, weight: Weight::Normal };
    let heading = Words { size: 12.0, colour: INK, weight: Weight::Bold, ..words };
    let (view, names, from) = plane(tool);
    svg.element(
        "rect",
        format_args!(
            "x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"4\" fill=\"#fafbfc\" stroke=\"{GRID}\"",
            Px(area.x),
            Px(area.y + 10.0),
            Px(area.width),
            Px(area.height - 10.0)
        ),
    );
    let extent = Extent::of(tool.iter().map(|point| view.plane(*point)));
    if extent.size().max() < STILL {
        svg.words(Vector2::new(area.x, area.y), heading, "Tool path");
        let at = Vector2::new(area.x + 0.5 * area.width, area.y + 0.5 * area.height);
        svg.words(at, Words { anchor: Anchor::Middle, ..words }, "The tool stayed where it was.");
        return;
    }
    svg.words(
        Vector2::new(area.x, area.y),
        heading,
        &format!("Tool path {from}, {}", metres(actor.path.length)),
    );
    let room = area.inset(30.0, 34.0, 30.0, 48.0);
    let extent = extent.at_least(0.02 * extent.size().max());
    let on = Projection::new(view, &extent, room, extent.scale(room));
    actor.path.draw(svg, &actor.motion, &on, 2.4, most);
    actor.path.arrows(svg, &actor.motion, &on, 5.0, 14);
    if let (Some(first), Some(last)) = (tool.first(), tool.last()) {
        ends(svg, on.at(*first), on.at(*last), 3.8);
    }
    let corner = Vector2::new(area.x + area.width - 40.0, area.y + area.height - 14.0);
    for (to, name, offset) in [
        (Vector2::new(24.0, 0.0), names[0], Vector2::new(6.0, 4.0)),
        (Vector2::new(0.0, -24.0), names[1], Vector2::new(-3.0, -4.0)),
    ] {
        arrow(svg, corner, corner + to);
        svg.words(corner + to + offset, Words { colour: INK, ..words }, name);
    }
    let length = step(0.45 * area.width / on.scale, 1);
    let length =
        if length * on.scale > 0.6 * area.width { step(0.2 * area.width / on.scale, 1) } else { length };
    let (a, b) = (
        Vector2::new(area.x + 12.0, area.y + area.height - 14.0),
        Vector2::new(area.x + 12.0 + length * on.scale, area.y + area.height - 14.0),
    );
    let tick = Vector2::new(0.0, 4.0);
    for (a, b) in [(a, b), (a - tick, a + tick), (b - tick, b + tick)] {
        svg.line(a, b, format_args!("stroke=\"{INK}\" stroke-width=\"1.4\""));
    }
    svg.words(
        0.5 * (a + b) - Vector2::new(0.0, 6.0),
        Words { anchor: Anchor::Middle, colour: INK, ..words },
        &metres(length),
    );
}

/// The plane in which points span most: its view, its axes' names, and from where it is seen.
fn plane(points: &[Vector3<f64>]) -> (View, [&'static str; 2], &'static str) {
    let infinite = Vector3::repeat(f64::INFINITY);
    let (low, high) =
        points.iter().fold((infinite, -infinite), |(low, high), point| (low.inf(point), high.sup(point)));
    let span = high - low;
    if span.z <= span.x.min(span.y) {
        (View::above(), ["x", "y"], "from above")
    } else if span.y <= span.x.min(span.z) {
        (View::front(), ["x", "z"], "from the front")
    } else {
        (View::side(), ["y", "z"], "from the side")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_is_seen_where_it_spans_most() {
        let line = |x, y, z| plane(&[Vector3::zeros(), Vector3::new(x, y, z)]).1;
        assert_eq!(line(1.0, 1.0, 0.1), ["x", "y"]);
        assert_eq!(line(1.0, 0.1, 1.0), ["x", "z"]);
        assert_eq!(line(0.1, 1.0, 1.0), ["y", "z"]);
    }
}
