//! The frame of a plot: two axes with round ticks, and where values are in it.
//!
//! In: an area and what the axes span. Out: a grid with numbers, and curves as points on the page.

use nalgebra::Vector2;

use super::area::Area;
use super::axis::{Axis, Range};
use super::look::Look;
use super::palette::{GREY, GRID, RULE};
use super::text::TextStyle;
use super::thinning;
use super::ticks::Ticks;
use super::writer::Svg;

/// Room for a number below the frame \[px\].
const NUMBER: f64 = 60.0;

/// The most ticks below the frame.
const MOST_BELOW: f64 = 8.0;

/// A frame that is higher has more ticks at its side \[px\].
const HIGH: f64 = 100.0;

/// Points of a curve beyond which it is drawn coarser.
const MOST_POINTS: usize = 1200;

/// Height of the numbers \[px\].
const SIZE: f64 = 11.0;

/// The frame of a plot: values to the right and upwards. Its lengths are pixels.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    frame: Area,
    across: Axis,
    across_ticks: Ticks,
    up: Axis,
    up_ticks: Ticks,
    most_points: usize,
}

impl Axes {
    /// Axes along the lower and the left side of a frame: the lower one spans `across` just so, the left one spans `up`
    /// and goes on to the next round numbers.
    #[must_use]
    pub fn new(frame: Area, across: Range, up: Range) -> Axes {
        let most = (frame.width / NUMBER).clamp(2.0, MOST_BELOW) as u32;
        let up_ticks = Ticks::around(up, if frame.height > HIGH { 5 } else { 3 });
        Axes {
            frame,
            across: Axis::new(across, frame.x, frame.right()),
            across_ticks: Ticks::inside(across, most),
            up: Axis::new(up_ticks.range(), frame.bottom(), frame.y),
            up_ticks,
            most_points: MOST_POINTS,
        }
    }

    /// The same with curves of at most about so many points.
    #[must_use]
    pub fn with_most_points(self, most_points: usize) -> Axes {
        Axes { most_points, ..self }
    }

    /// The area between the axes \[px\].
    #[must_use]
    pub fn frame(&self) -> Area {
        self.frame
    }

    /// The ticks of the left axis.
    #[must_use]
    pub fn up_ticks(&self) -> &Ticks {
        &self.up_ticks
    }

    /// Where a pair of values is on the page \[px\].
    #[must_use]
    pub fn at(&self, across: f64, up: f64) -> Vector2<f64> {
        Vector2::new(self.across.at(across), self.up.at(up))
    }

    /// Draws a line at every tick, that at the left axis' 0 stronger, and the numbers of the left axis.
    pub fn draw_grid(&self, svg: &mut Svg) {
        let style = TextStyle::new(SIZE, GREY).end();
        let frame = self.frame;
        for value in self.across_ticks.values() {
            let x = self.across.at(value);
            let top = Vector2::new(x, frame.y);
            svg.line(top, Vector2::new(x, frame.bottom()), Look::new().stroke(GRID));
        }
        for value in self.up_ticks.values() {
            let y = self.up.at(value);
            let colour = if value == 0.0 { RULE } else { GRID };
            let left = Vector2::new(frame.x, y);
            svg.line(left, Vector2::new(frame.right(), y), Look::new().stroke(colour));
            svg.text(Vector2::new(frame.x - 6.0, y + 3.8), style, &self.up_ticks.label(value));
        }
    }

    /// Writes the numbers of the lower axis below the frame; their baseline is 16 px below it.
    pub fn draw_labels_below(&self, svg: &mut Svg) {
        let style = TextStyle::new(SIZE, GREY).middle();
        for value in self.across_ticks.values() {
            let at = Vector2::new(self.across.at(value), self.frame.bottom() + 16.0);
            svg.text(at, style, &self.across_ticks.label(value));
        }
    }

    /// The points of a curve on the page \[px\], as few as look the same. `across` never decreases; what one list has
    /// more than the other is left out.
    #[must_use]
    pub fn curve(&self, across: &[f64], up: &[f64]) -> Vec<Vector2<f64>> {
        let points: Vec<_> = across.iter().zip(up).map(|(x, y)| self.at(*x, *y)).collect();
        thinning::curve(&points, self.most_points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes() -> Axes {
        let frame = Area { x: 50.0, y: 20.0, width: 400.0, height: 120.0 };
        Axes::new(frame, Range { low: 0.0, high: 4.0 }, Range { low: -0.9, high: 3.8 })
    }

    #[test]
    fn values_are_where_the_ticks_say() {
        let axes = axes();
        // The left axis goes on to -1 and 4.
        assert!((axes.at(0.0, -1.0) - Vector2::new(50.0, 140.0)).norm() < 1e-9);
        assert!((axes.at(4.0, 4.0) - Vector2::new(450.0, 20.0)).norm() < 1e-9);
        assert!((axes.at(1.0, 1.5) - Vector2::new(150.0, 80.0)).norm() < 1e-9);
        let corner = axes.curve(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 2.0, 0.0, 9.0]);
        assert_eq!(corner, [axes.at(0.0, 0.0), axes.at(2.0, 2.0), axes.at(3.0, 0.0)]);
    }

    #[test]
    fn every_tick_has_a_line_and_a_number() {
        let axes = axes();
        let mut svg = Svg::new(1);
        svg.group(Look::new(), |svg| {
            axes.draw_grid(svg);
            axes.draw_labels_below(svg);
        });
        let text = svg.finish();
        let document = roxmltree::Document::parse(&text).unwrap();
        let labels: Vec<&str> = document
            .descendants()
            .filter(|node| node.has_tag_name("text"))
            .filter_map(|node| node.text())
            .collect();
        let up = ["−1", "0", "1", "2", "3", "4"];
        assert_eq!(labels[..up.len()], up);
        // Of six steps at most, which are round.
        assert_eq!(labels[up.len()..], ["0", "1", "2", "3", "4"]);
        let lines = document.descendants().filter(|node| node.has_tag_name("line")).count();
        assert_eq!(lines, labels.len());
    }
}
