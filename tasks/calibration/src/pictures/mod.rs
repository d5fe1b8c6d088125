//! Pictures of a calibration: the cell with its lines of sight, errors before and after, and how sure what was found is.

mod cell;
mod errors;
mod statistics;

pub use cell::cell;
pub use errors::errors;
pub use statistics::{correlations, observability, residuals};

use mrroc_pictures::svg::palette::{GREY, INK};
use mrroc_pictures::svg::{Area, Axes, Range, Svg, TextStyle};
use nalgebra::{Vector2, Vector3};

const WIDTH: f64 = 1200.0;
const MARGIN: f64 = 60.0;

/// A title, and a line below it.
fn heading(svg: &mut Svg, title: &str, below: &str) {
    svg.text(Vector2::new(MARGIN, 36.0), TextStyle::new(20.0, INK).bold(), title);
    svg.text(Vector2::new(MARGIN, 58.0), TextStyle::new(12.0, GREY), below);
}

/// A view of the cell along one of the world's axes, both of its own drawn to one scale.
struct View {
    axes: Axes,
    up: usize,
}

impl View {
    /// In an area of the page \[px\]: x about its middle to the right, and axis `up` from the lowest to the highest \[m\], which are whole steps of
    /// its ticks.
    fn new(area: Area, middle: f64, up: usize, [low, high]: [f64; 2]) -> Self {
        let wide = (high - low) * area.width / area.height;
        let across = Range { low: middle - 0.5 * wide, high: middle + 0.5 * wide };
        Self { axes: Axes::new(area, across, Range { low, high }), up }
    }

    fn at(&self, point: &Vector3<f64>) -> Vector2<f64> {
        self.axes.at(point.x, point[self.up])
    }
}
