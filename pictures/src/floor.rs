//! The floor of the scene, and the world's axes at its corner.
//!
//! In: what the floor spans \[m\]. Out: its corners; arrows of one tile's length, which is their scale.

use nalgebra::{Vector2, Vector3};

use crate::marks::arrow;
use crate::projection::Projection;
use crate::svg::palette::{INK, WHITE};
use crate::svg::{Range, Svg, TextStyle};
use crate::wording::metres;

/// What the robots stand on: whole tiles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Floor {
    /// \[m\]
    pub x: Range,
    /// \[m\]
    pub y: Range,
    /// \[m\]
    pub height: f64,
    /// Edge of a tile \[m\].
    pub tile: f64,
}

impl Floor {
    /// Its corners, from where x and y are least round to where y is greatest.
    pub fn corners(&self) -> [Vector3<f64>; 4] {
        let Floor { x, y, height, .. } = *self;
        [[x.low, y.low], [x.high, y.low], [x.high, y.high], [x.low, y.high]]
            .map(|[x, y]| Vector3::new(x, y, height))
    }
}

/// Arrows along the world's axes from the floor's corner, of a known length \[m\].
pub(crate) fn axes(svg: &mut Svg, on: &Projection, corner: Vector3<f64>, length: f64) {
    let style = TextStyle::new(12.0, INK).middle();
    let from = on.at(corner);
    for (axis, name) in [(Vector3::x(), "x"), (Vector3::y(), "y"), (Vector3::z(), "z")] {
        let to = on.at(corner + axis * length);
        arrow(svg, from, to);
        let direction = (to - from).try_normalize(1e-9).unwrap_or_else(Vector2::zeros);
        svg.text_on_lines(to + direction * 11.0 + Vector2::new(0.0, 4.0), style.bold(), WHITE, name);
    }
    let middle = 0.5 * (from + on.at(corner + Vector3::x() * length));
    svg.text_on_lines(middle + Vector2::new(-4.0, 18.0), style.size(11.5), WHITE, &metres(length));
}
