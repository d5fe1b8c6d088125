//! The path of one tool alone, as large as it fits, in the plane where it spans most.
//!
//! In: an actor. Out: a drawing to scale, with a scale bar; or words when the tool stayed where it was.

use nalgebra::{Vector2, Vector3};

use crate::body::Actor;
use crate::marks::{arrow, ends};
use crate::projection::{Extent, Projection, View};
use crate::svg::palette::{GREY, GRID, INK, PALE};
use crate::svg::{Area, Look, Range, Svg, TextStyle, step};
use crate::wording::metres;

/// What spans less is a standstill \[m\].
const STILL: f64 = 2e-4;

/// Draws the path into an area, in about `most` points.
pub(crate) fn draw(svg: &mut Svg, area: Area, actor: &Actor<'_>, most: usize) {
    let tool = &actor.motion.tool;
    let style = TextStyle::new(11.5, INK).middle();
    let heading = TextStyle::new(12.0, INK).bold();
    let Plane { view, axes, from } = plane(tool);
    let ground = Area { y: area.y + 10.0, height: area.height - 10.0, ..area };
    svg.rectangle(ground, 4.0, Look::filled(PALE).stroke(GRID));
    let extent = Extent::of(tool.iter().map(|point| view.plane(*point)));
    if extent.size().max() < STILL {
        svg.text(Vector2::new(area.x, area.y), heading, "Tool path");
        let at = Vector2::new(area.x + 0.5 * area.width, area.y + 0.5 * area.height);
        svg.text(at, style.colour(GREY), "The tool stayed where it was.");
        return;
    }
    let title = format!("Tool path {from}, {}", metres(actor.path.length));
    svg.text(Vector2::new(area.x, area.y), heading, &title);
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
        (Vector2::new(24.0, 0.0), axes[0], Vector2::new(6.0, 4.0)),
        (Vector2::new(0.0, -24.0), axes[1], Vector2::new(-3.0, -4.0)),
    ] {
        arrow(svg, corner, corner + to);
        svg.text(corner + to + offset, TextStyle::new(11.5, INK), name);
    }
    let length = step(0.45 * area.width / on.scale, 1);
    let length =
        if length * on.scale > 0.6 * area.width { step(0.2 * area.width / on.scale, 1) } else { length };
    let left = Vector2::new(area.x + 12.0, area.bottom() - 14.0);
    let right = left + Vector2::new(length * on.scale, 0.0);
    let tick = Vector2::new(0.0, 4.0);
    for [from, to] in [[left, right], [left - tick, left + tick], [right - tick, right + tick]] {
        svg.line(from, to, Look::new().stroke(INK).width(1.4));
    }
    svg.text(0.5 * (left + right) - Vector2::new(0.0, 6.0), style, &metres(length));
}

/// A plane that a path is drawn in.
struct Plane {
    view: View,
    /// Names of what is to the right and of what is up.
    axes: [&'static str; 2],
    /// From where it is seen, in words.
    from: &'static str,
}

/// The plane in which points span most.
fn plane(points: &[Vector3<f64>]) -> Plane {
    let span = |axis: usize| Range::of(points.iter().map(|point| &point[axis])).width();
    let span = Vector3::new(span(0), span(1), span(2));
    if span.z <= span.x.min(span.y) {
        Plane { view: View::above(), axes: ["x", "y"], from: "from above" }
    } else if span.y <= span.x.min(span.z) {
        Plane { view: View::front(), axes: ["x", "z"], from: "from the front" }
    } else {
        Plane { view: View::side(), axes: ["y", "z"], from: "from the side" }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_seen_where_it_spans_most() {
        let line = |x, y, z| plane(&[Vector3::zeros(), Vector3::new(x, y, z)]).axes;
        assert_eq!(line(1.0, 1.0, 0.1), ["x", "y"]);
        assert_eq!(line(1.0, 0.1, 1.0), ["x", "z"]);
        assert_eq!(line(0.1, 1.0, 1.0), ["y", "z"]);
    }
}
