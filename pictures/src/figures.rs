//! A table of a robot's joints: where each began and ended, how far it went, and how well it followed; and where
//! the tool was.
//!
//! In: a history. Out: words in columns.

use nalgebra::Vector2;

use crate::history::History;
use crate::sample::Sample;
use crate::svg::palette::{self, GREY, GRID, INK};
use crate::svg::{Area, Look, Svg, TextStyle};
use crate::wording::{figure, position};

/// Height of a row \[px\].
const ROW: f64 = 17.0;

/// How high the table of a robot with so many joints is \[px\].
pub(crate) fn height(joints: usize) -> f64 {
    ROW * (joints as f64 + 5.0) + 24.0
}

/// Draws the table at the top of an area.
pub(crate) fn draw(svg: &mut Svg, area: Area, history: &History, samples: &[&Sample]) {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else { return };
    let left = TextStyle::new(11.0, GREY);
    let right = left.end();
    let columns = [0.34, 0.53, 0.71, 1.0].map(|share| area.x + share * area.width);
    let mut y = area.y + 12.0;
    svg.text(Vector2::new(area.x, y), left, "joint");
    for (x, text) in columns.iter().zip(["start", "end", "travel", "follow. err."]) {
        svg.text(Vector2::new(*x, y), right, text);
    }
    let rule = Vector2::new(area.x, y + 5.0);
    svg.line(rule, rule + Vector2::new(area.width, 0.0), Look::new().stroke(GRID));
    for (joint, (kind, range)) in history.joints.iter().zip(&history.ranges).enumerate() {
        y += ROW;
        let name = TextStyle::new(11.5, palette::joint(joint)).bold();
        svg.text(Vector2::new(area.x, y), name, &format!("q{}", joint + 1));
        svg.text(Vector2::new(area.x + 20.0, y), left, kind.unit(0));
        let at = |sample: &Sample| sample.measured.get(joint).copied().unwrap_or(0.0);
        let row = [
            position(at(first)),
            position(at(last)),
            position(range.travel()),
            figure(range.following_error),
        ];
        for (x, text) in columns.iter().zip(row) {
            svg.text(Vector2::new(*x, y), right.colour(INK), &text);
        }
    }
    y += 1.6 * ROW;
    svg.text(Vector2::new(area.x, y), left, "tool [m]");
    for (x, axis) in columns.iter().zip(["x", "y", "z"]) {
        svg.text(Vector2::new(*x, y), right, axis);
    }
    let rule = Vector2::new(area.x, y + 5.0);
    svg.line(rule, rule + Vector2::new(columns[2] - area.x, 0.0), Look::new().stroke(GRID));
    for (name, sample) in [("start", first), ("end", last)] {
        y += ROW;
        svg.text(Vector2::new(area.x, y), left, name);
        for (x, value) in columns.iter().zip(sample.tool.translation.vector.iter()) {
            svg.text(Vector2::new(*x, y), right.colour(INK), &position(*value));
        }
    }
}
