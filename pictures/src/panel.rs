//! Panels: the white grounds that the page consists of.
//!
//! In: an area \[px\]. Out: its ground, and a heading at its top left.

use nalgebra::Vector2;

use crate::palette::{GRID, INK, PANEL};
use crate::projection::Area;
use crate::svg::{Anchor, Px, Svg, Weight, Words};

/// A panel.
pub(crate) fn ground(svg: &mut Svg, area: Area) {
    svg.element(
        "rect",
        format_args!(
            "x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"8\" fill=\"{PANEL}\" stroke=\"{GRID}\"",
            Px(area.x),
            Px(area.y),
            Px(area.width),
            Px(area.height)
        ),
    );
}

/// A panel with its heading.
pub(crate) fn headed(svg: &mut Svg, area: Area, heading: &str) {
    ground(svg, area);
    let words = Words { size: 13.0, colour: INK, anchor: Anchor::Start, weight: Weight::Bold };
    svg.words(Vector2::new(area.x + 14.0, area.y + 22.0), words, heading);
}
