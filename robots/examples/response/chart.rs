//! Charts over time, two in a row.

use mrroc_pictures::svg::{Area, Axes, Look, Page, Range, Svg, TextStyle, palette};
use nalgebra::Vector2;

/// Sizes of a chart's frame and of the margins around it \[px\].
const WIDTH: f64 = 380.0;
const HEIGHT: f64 = 130.0;
const LEFT: f64 = 78.0;
const ABOVE: f64 = 46.0;
const BELOW: f64 = 42.0;
const HEADING: f64 = 54.0;

/// What all curves mean.
const LEGEND: &str =
    "blue: the true shaft (or demanded less true); orange, broken: demanded; servo period 2 ms";

/// A line of a chart.
pub struct Curve {
    values: Vec<f64>,
    look: Look,
}

impl Curve {
    pub fn measured(values: Vec<f64>) -> Self {
        Self { values, look: Look::line(palette::joint(0), 1.8).class("true") }
    }

    pub fn demanded(values: Vec<f64>) -> Self {
        Self { values, look: Look::line(palette::joint(1), 1.2).dashed(5.0, 3.0).class("demanded") }
    }
}

/// Curves over the same times.
pub struct Chart {
    pub title: String,
    /// A line of text with the figures.
    pub figures: String,
    pub quantity: String,
    /// SI unit of the curves.
    pub unit: &'static str,
    pub curves: Vec<Curve>,
    /// \[s\]
    pub times: Vec<f64>,
}

/// A prefix with which `size` is 0.3 to 300 units, and how many of these units make one unit without it.
fn prefix(size: f64) -> (f64, &'static str) {
    match size {
        s if s >= 0.3 => (1.0, ""),
        s if s >= 0.3e-3 => (1e3, "m"),
        _ => (1e6, "µ"),
    }
}

/// A value with a readable unit.
pub fn with_prefix(value: f64, unit: &str) -> String {
    let (factor, prefix) = prefix(value.abs());
    format!("{:.*} {prefix}{unit}", if value.abs() * factor < 9.95 { 2 } else { 0 }, value * factor)
}

impl Chart {
    /// Draws the chart with the left upper corner of its frame at (x, y) \[px\].
    fn draw(&self, svg: &mut Svg, x: f64, y: f64) {
        let values = Range::with_zero(self.curves.iter().flat_map(|curve| &curve.values), 0.0);
        let (factor, prefix) = prefix(values.high.max(-values.low));
        let end = self.times.last().copied().unwrap_or(1.0);
        let frame = Area { x, y, width: WIDTH, height: HEIGHT };
        let axes = Axes::new(frame, Range { low: 0.0, high: end * 1e3 }, values.scaled(factor));

        let bold = TextStyle::new(13.0, palette::INK).bold().class("title");
        let small = TextStyle::new(11.0, palette::GREY);
        svg.text(Vector2::new(x, y - 24.0), bold, &self.title);
        svg.text(Vector2::new(x, y - 8.0), small, &self.figures);
        axes.draw_grid(svg);
        axes.draw_labels_below(svg);
        let quantity = format!("{} [{prefix}{}]", self.quantity, self.unit);
        svg.text(Vector2::new(x - 56.0, y + 0.5 * HEIGHT), small.middle().upwards(), &quantity);
        svg.text(Vector2::new(x + 0.5 * WIDTH, y + HEIGHT + 30.0), small.middle(), "time [ms]");
        let milliseconds: Vec<f64> = self.times.iter().map(|t| t * 1e3).collect();
        for curve in &self.curves {
            let values: Vec<f64> = curve.values.iter().map(|value| value * factor).collect();
            svg.polyline(&axes.curve(&milliseconds, &values), curve.look);
        }
    }
}

/// A page of charts, two in a row.
pub fn page(title: &str, rows: &[[Chart; 2]]) -> String {
    let across = LEFT + WIDTH + 10.0;
    let down = ABOVE + HEIGHT + BELOW;
    let width = 2.0 * across + 16.0;
    let height = HEADING + rows.len() as f64 * down + 10.0;
    Page::new(title, width, height).draw(|svg| {
        svg.text(Vector2::new(16.0, 26.0), TextStyle::new(16.0, palette::INK).bold(), title);
        svg.text(Vector2::new(16.0, 44.0), TextStyle::new(11.0, palette::GREY), LEGEND);
        for (i, row) in rows.iter().enumerate() {
            for (k, chart) in row.iter().enumerate() {
                chart.draw(svg, LEFT + k as f64 * across, HEADING + ABOVE + i as f64 * down);
            }
        }
    })
}
