//! A sheet of a motion: way, velocity, acceleration and jerk over time, and the path in space.
//!
//! In: positions of one tool or of several at steps of [`DT`]. Out: an SVG.

use mrroc_pictures::svg::palette::{GREY, INK, RULE, joint};
use mrroc_pictures::svg::{Area, Axes, Look, Page, Range, Svg, TextStyle, thinned};
use nalgebra::{Vector2, Vector3};

/// Path time of a step \[s\].
pub const DT: f64 = 4e-3;
/// Width and height of the page \[px\].
const PAGE: [f64; 2] = [1000.0, 640.0];
/// Width and height of a chart, where the first one stands on the page, and from one to the next \[px\].
const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 110.0;
const LEFT: f64 = 80.0;
const TOP: f64 = 54.0;
const DOWN: f64 = 142.0;
/// Half the side of a path's square \[px\].
const HALF: f64 = 130.0;
/// Width of curves \[px\].
const CURVE: f64 = 1.5;

/// Positions of a tool over time \[m\].
pub type Trace = Vec<Vector3<f64>>;

/// Central differences; at an end, the value beside it.
fn derivative(x: &[Vector3<f64>]) -> Trace {
    let mut v: Vec<_> = x.windows(3).map(|w| (w[2] - w[0]) / (2.0 * DT)).collect();
    let first = v.first().copied().unwrap_or_default();
    let last = v.last().copied().unwrap_or_default();
    v.insert(0, first);
    v.push(last);
    v
}

/// The derivatives of all tools' values.
fn derivatives(tools: &[Trace]) -> Vec<Trace> {
    tools.iter().map(|x| derivative(x)).collect()
}

/// The first tool's lines are whole, the second's dashed.
fn dashed(look: Look, tool: usize) -> Look {
    if tool == 0 { look } else { look.dashed(5.0, 3.0) }
}

/// A value to a thousandth, with a true minus sign.
fn thousandths(value: f64) -> String {
    let text = format!("{value:.3}");
    if text == "-0.000" { "0.000".to_owned() } else { text.replace('-', "−") }
}

/// A quantity of all tools over time.
struct Chart<'a> {
    heading: &'static str,
    tools: &'a [Trace],
    /// What is as small as this is rounding, and drawn as 0 [SI].
    rounding: f64,
}

impl Chart<'_> {
    /// The values of all axes of all tools.
    fn values(&self) -> impl Iterator<Item = &f64> {
        self.tools.iter().flatten().flatten()
    }

    /// What the values span; nothing where all is rounding.
    fn range(&self) -> Range {
        let range = Range::of(self.values());
        if range.low.abs().max(range.high.abs()) > self.rounding {
            range
        } else {
            Range { low: 0.0, high: 0.0 }
        }
    }

    /// Draws the chart in a frame.
    fn draw(&self, svg: &mut Svg, frame: Area) -> Axes {
        let steps = self.tools.iter().map(Vec::len).max().unwrap_or(0).saturating_sub(1).max(1);
        let range = self.range();
        let up = Range::with_zero([range.low, range.high].iter(), 0.0);
        let axes = Axes::new(frame, Range { low: 0.0, high: DT * steps as f64 }, up);
        svg.text(Vector2::new(frame.x, frame.y - 7.0), TextStyle::new(12.0, INK), self.heading);
        let extremes = format!("{} to {}", thousandths(range.low), thousandths(range.high));
        svg.text(Vector2::new(frame.right(), frame.y - 7.0), TextStyle::new(11.0, GREY).end(), &extremes);
        axes.draw_grid(svg);
        let times: Vec<f64> = (0..=steps).map(|i| DT * i as f64).collect();
        for (tool, values) in self.tools.iter().enumerate() {
            for axis in 0..3 {
                let values: Vec<f64> = values.iter().map(|p| p[axis]).collect();
                svg.polyline(&axes.curve(&times, &values), dashed(Look::line(joint(axis), CURVE), tool));
            }
        }
        axes
    }
}

/// The paths of all tools in the plane of two axes, `extent` \[m\] from the middle to the edge.
fn draw_path(svg: &mut Svg, middle: Vector2<f64>, [right, up]: [usize; 2], extent: f64, ways: &[Trace]) {
    let names = ["x", "y", "z"];
    let heading = format!("path, {} right, {} up: {extent:.3} m to the edge", names[right], names[up]);
    svg.text(middle - Vector2::new(0.0, HALF + 8.0), TextStyle::new(12.0, INK).middle(), &heading);
    for arm in [Vector2::new(HALF, 0.0), Vector2::new(0.0, HALF)] {
        svg.line(middle - arm, middle + arm, Look::line(RULE, 1.0));
    }
    for (tool, way) in ways.iter().enumerate() {
        let at = |p: &Vector3<f64>| middle + Vector2::new(p[right], -p[up]) * (HALF / extent);
        let points: Vec<_> = way.iter().map(at).collect();
        svg.polyline(&thinned(&points, 0.1), dashed(Look::line(INK, CURVE), tool));
    }
}

/// Which colour is which axis, and which line which arm, beside the title.
fn draw_legend(svg: &mut Svg, tools: usize) {
    let right = LEFT + WIDTH;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let at = Vector2::new(right - 60.0 + 24.0 * axis as f64, 24.0);
        svg.text(at, TextStyle::new(12.0, joint(axis)).bold(), name);
    }
    if tools > 1 {
        svg.text(
            Vector2::new(right - 80.0, 24.0),
            TextStyle::new(12.0, GREY).end(),
            "dashed: the second arm",
        );
    }
}

/// The sheet of the tools' motion; all have as many positions.
pub fn draw(name: &str, tools: &[Trace]) -> String {
    let ways: Vec<Trace> = tools.iter().map(|tool| tool.iter().map(|p| p - tool[0]).collect()).collect();
    let velocity = derivatives(&ways);
    let acceleration = derivatives(&velocity);
    let jerk = derivatives(&acceleration);
    let charts = [
        Chart { heading: "way [m]", tools: &ways, rounding: 1e-9 },
        Chart { heading: "velocity [m/s]", tools: &velocity, rounding: 1e-7 },
        Chart { heading: "acceleration [m/s²]", tools: &acceleration, rounding: 1e-5 },
        Chart { heading: "jerk [m/s³]", tools: &jerk, rounding: 1e-3 },
    ];
    let duration = DT * (ways[0].len() - 1) as f64;
    let extent = ways.iter().flatten().map(|p| p.amax()).fold(1e-6, f64::max);
    Page::new(name, PAGE[0], PAGE[1]).draw(|svg| {
        svg.text(Vector2::new(LEFT, 24.0), TextStyle::new(15.0, INK).bold(), name);
        draw_legend(svg, tools.len());
        for (row, chart) in charts.iter().enumerate() {
            let frame = Area { x: LEFT, y: TOP + DOWN * row as f64, width: WIDTH, height: HEIGHT };
            let axes = chart.draw(svg, frame);
            if row + 1 == charts.len() {
                axes.draw_labels_below(svg);
                let end = Vector2::new(frame.right() + 18.0, frame.bottom() + 16.0);
                svg.text(end, TextStyle::new(11.0, INK), &format!("time [s], {duration:.3} in all"));
            }
        }
        draw_path(svg, Vector2::new(820.0, 184.0), [0, 1], extent, &ways);
        draw_path(svg, Vector2::new(820.0, 464.0), [0, 2], extent, &ways);
    })
}
