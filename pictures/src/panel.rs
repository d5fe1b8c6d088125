//! Panels: the white grounds that the page consists of.
//!
//! In: an area \[px\]. Out: its ground, and a heading at its top left.

use nalgebra::Vector2;

use crate::svg::palette::{GRID, INK, WHITE};
use crate::svg::{Area, Look, Svg, TextStyle};

/// A panel.
pub(crate) fn ground(svg: &mut Svg, area: Area) {
    svg.rectangle(area, 8.0, Look::filled(WHITE).stroke(GRID));
}

/// A panel with its heading.
pub(crate) fn headed(svg: &mut Svg, area: Area, heading: &str) {
    ground(svg, area);
    svg.text(Vector2::new(area.x + 14.0, area.y + 22.0), TextStyle::new(13.0, INK).bold(), heading);
}
