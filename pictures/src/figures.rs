//! A table of a robot's joints: where each began and ended, how far it went, and how well it followed; and where
//! the tool was.
//!
//! In: a take. Out: words in columns.

use nalgebra::Vector2;

use crate::palette::{self, GREY, GRID, INK};
use crate::projection::Area;
use crate::svg::{Anchor, Svg, Weight, Words};
use crate::take::{Sample, Take};
use crate::wording::{figure, position};

/// Height of a row \[px\].
const ROW: f64 = 17.0;

/// How high the table of a robot with so many joints is \[px\].
pub(crate) fn height(joints: usize) -> f64 {
    ROW * (joints as f64 + 5.0) + 24.0
}

/// Draws the table at the top of an area.
pub(crate) fn draw(svg: &mut Svg, area: Area, take: &Take, samples: &[&Sample]) {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else { return };
    let words = Words { size: 11.0, colour: GREY, anchor: Anchor::End, weight: Weight::Normal };
    let columns = [0.34, 0.53, 0.71, 1.0].map(|share| area.x + share * area.width);
    let mut y = area.y + 12.0;
    let left = Words { anchor: Anchor::Start, ..words };
    svg.words(Vector2::new(area.x, y), left, "joint");
    for (x, text) in columns.iter().zip(["start", "end", "travel", "follow. err."]) {
        svg.words(Vector2::new(*x, y), words, text);
    }
    let rule = y + 5.0;
    svg.line(
        Vector2::new(area.x, rule),
        Vector2::new(area.x + area.width, rule),
        format_args!("stroke=\"{GRID}\""),
    );
    for (joint, (kind, range)) in take.joints.iter().zip(&take.ranges).enumerate() {
        y += ROW;
        let colour = palette::joint(joint);
        svg.words(
            Vector2::new(area.x, y),
            Words { colour, weight: Weight::Bold, size: 11.5, ..left },
            &format!("q{}", joint + 1),
        );
        svg.words(Vector2::new(area.x + 20.0, y), left, kind.unit(0));
        let at = |sample: &Sample| sample.measured.get(joint).copied().unwrap_or(0.0);
        let row = [
            position(at(first)),
            position(at(last)),
            position(range.travel()),
            figure(range.following_error),
        ];
        for (x, text) in columns.iter().zip(row) {
            svg.words(Vector2::new(*x, y), Words { colour: INK, ..words }, &text);
        }
    }
    y += 1.6 * ROW;
    svg.words(Vector2::new(area.x, y), left, "tool [m]");
    for (x, axis) in columns.iter().zip(["x", "y", "z"]) {
        svg.words(Vector2::new(*x, y), words, axis);
    }
    let rule = Vector2::new(area.x, y + 5.0);
    svg.line(rule, rule + Vector2::new(columns[2] - area.x, 0.0), format_args!("stroke=\"{GRID}\""));
    for (name, sample) in [("start", first), ("end", last)] {
        y += ROW;
        svg.words(Vector2::new(area.x, y), left, name);
        for (x, value) in columns.iter().zip(sample.tool.translation.vector.iter()) {
            svg.words(Vector2::new(*x, y), Words { colour: INK, ..words }, &position(*value));
        }
    }
}
