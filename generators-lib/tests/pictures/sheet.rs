//! A sheet of charts over time, and of the path in space.
//!
//! In: coordinates of one thing or of two, at equal steps of time. Out: an SVG.

use mrroc_pictures::svg::palette::{GREY, HIGHLIGHT, INK, RULE, joint};
use mrroc_pictures::svg::{Area, Axes, Look, Page, Range, Svg, TextStyle, thinned};
use nalgebra::{Vector2, Vector3};

/// Width and height of a chart, and where the first one stands on the page \[px\].
const W: f64 = 560.0;
const H: f64 = 110.0;
const LEFT: f64 = 80.0;
const TOP: f64 = 54.0;
/// From one chart to the next \[px\].
const NEXT: f64 = H + 32.0;
/// Where the title stands, and what the lines are beside it \[px\].
const TITLE: f64 = 24.0;
/// From the name of a coordinate to the next \[px\].
const NAME: f64 = 24.0;
/// From the middle of a drawing of the path to its edge \[px\].
const EDGE: f64 = 130.0;
/// Where the middle of the first drawing of the path is, and how far down the next one \[px\].
const MIDDLE: Vector2<f64> = Vector2::new(820.0, 184.0);
const NEXT_PATH: f64 = 280.0;
/// Width of curves \[px\].
const CURVE: f64 = 1.5;
/// Width of a straight line between two points, wider than the axes of its colour \[px\].
const BAR: f64 = 3.0;
/// How far a path may be from what is drawn: nobody sees it \[px\].
const UNSEEN: f64 = 0.1;
/// Values as small as rounding makes them are drawn as none: displacement, velocity, acceleration, jerk in SI.
const ROUNDING: [f64; 4] = [1e-9, 1e-7, 1e-5, 1e-3];

/// Coordinates over time, such as the positions of a tool \[m\].
pub type Trace = Vec<Vector3<f64>>;

/// Values over time, of one thing or of two.
pub struct Chart {
    pub heading: String,
    pub values: Vec<Trace>,
    /// Ranges smaller than this are rounding.
    pub rounding: f64,
    /// Values that are to be kept or reached: thin lines.
    pub lines: Vec<f64>,
}

/// Paths in space, to one scale, in the coordinates that the drawing's middle is the origin of.
#[derive(Default)]
pub struct Paths {
    pub traces: Vec<Trace>,
    /// Points that are to be passed.
    pub marks: Vec<Vector3<f64>>,
    /// Straight lines between two points, such as a body between two tools.
    pub bars: Vec<[Vector3<f64>; 2]>,
    /// The names of the axes, and the unit.
    pub axes: [&'static str; 3],
    pub unit: &'static str,
    /// What is drawn besides the path.
    pub legend: &'static str,
}

/// All that a sheet shows.
pub struct Sheet {
    pub title: String,
    /// Names of the coordinates that are drawn.
    pub axes: Vec<&'static str>,
    /// What the dashed lines are.
    pub dashed: &'static str,
    pub charts: Vec<Chart>,
    pub paths: Option<Paths>,
    /// How long the charts last \[s\].
    pub duration: f64,
}

/// Central differences; at an end, the value beside it.
fn derivative(x: &[Vector3<f64>], dt: f64) -> Trace {
    let mut v: Vec<_> = x.windows(3).map(|w| (w[2] - w[0]) / (2.0 * dt)).collect();
    let first = v.first().copied().unwrap_or_default();
    let last = v.last().copied().unwrap_or_default();
    v.insert(0, first);
    v.push(last);
    v
}

/// Charts of the values, of this `name` and of this `unit`, and of their first three derivatives.
fn derivatives(name: &str, unit: &str, values: Vec<Trace>, dt: f64) -> Vec<Chart> {
    let derived = |of: &[Trace]| of.iter().map(|x| derivative(x, dt)).collect::<Vec<_>>();
    let velocity = derived(&values);
    let acceleration = derived(&velocity);
    let jerk = derived(&acceleration);
    let headings = [
        format!("{name} [{unit}]"),
        format!("velocity [{unit}/s]"),
        format!("acceleration [{unit}/s²]"),
        format!("jerk [{unit}/s³]"),
    ];
    let all = headings.into_iter().zip([values, velocity, acceleration, jerk]).zip(ROUNDING);
    all.map(|((heading, values), rounding)| Chart { heading, values, rounding, lines: Vec::new() }).collect()
}

impl Sheet {
    /// The motion of one tool or of two, whose positions \[m\] are `dt` \[s\] apart: each one's displacement from its start.
    pub fn of_tools(title: &str, tools: &[Trace], dt: f64) -> Self {
        let traces: Vec<Trace> =
            tools.iter().map(|tool| tool.iter().map(|p| p - tool[0]).collect()).collect();
        Sheet {
            title: title.to_owned(),
            axes: vec!["x", "y", "z"],
            dashed: if tools.len() > 1 { "dashed: the second arm" } else { "" },
            duration: dt * (traces[0].len() - 1) as f64,
            charts: derivatives("displacement from the start", "m", traces.clone(), dt),
            paths: Some(Paths { traces, axes: ["x", "y", "z"], unit: "m", ..Paths::default() }),
        }
    }

    /// All that is drawn to scale: the values, the lines and the points.
    pub fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let charts =
            self.charts.iter().flat_map(|chart| chart.values.iter().flatten().flatten().chain(&chart.lines));
        let points = self.paths.iter().flat_map(|paths| paths.points().flatten());
        charts.chain(points).copied().chain([self.duration])
    }

    /// How many values each curve and each path has.
    pub fn lengths(&self) -> impl Iterator<Item = usize> + '_ {
        let paths = self.paths.iter().flat_map(|paths| &paths.traces);
        self.charts.iter().flat_map(|chart| &chart.values).chain(paths).map(Vec::len)
    }

    /// The SVG.
    pub fn draw(&self) -> String {
        let width = if self.paths.is_some() { 1000.0 } else { LEFT + W + 20.0 };
        let height = TOP + self.charts.len() as f64 * NEXT + 22.0;
        Page::new(&self.title, width, height).draw(|svg| {
            svg.text(Vector2::new(LEFT, TITLE), TextStyle::new(15.0, INK).bold(), &self.title);
            self.draw_legend(svg);
            for (row, chart) in self.charts.iter().enumerate() {
                let frame = Area { x: LEFT, y: TOP + row as f64 * NEXT, width: W, height: H };
                let axes = chart.draw(svg, frame, self.axes.len(), self.duration);
                if row + 1 == self.charts.len() {
                    axes.draw_labels_below(svg);
                    let below = Vector2::new(LEFT + 0.5 * W, frame.bottom() + 32.0);
                    svg.text(below, heading().middle(), &format!("time [s], {:.3} in all", self.duration));
                }
            }
            if let Some(paths) = &self.paths {
                paths.draw(svg);
            }
        })
    }

    /// Which colour is which coordinate, and what the dashed lines are, beside the title.
    fn draw_legend(&self, svg: &mut Svg) {
        let names = LEFT + W - NAME * self.axes.len() as f64;
        for (axis, name) in self.axes.iter().enumerate() {
            let at = Vector2::new(names + NAME * (axis + 1) as f64, TITLE);
            svg.text(at, heading().colour(joint(axis)).bold().end(), name);
        }
        svg.text(Vector2::new(names - 12.0, TITLE), heading().colour(GREY).end(), self.dashed);
    }
}

/// How headings are written.
fn heading() -> TextStyle {
    TextStyle::new(12.0, INK)
}

/// The first thing's lines are whole, the second's dashed.
fn dashed(look: Look, thing: usize) -> Look {
    if thing == 0 { look } else { look.dashed(5.0, 3.0) }
}

impl Chart {
    /// Draws the chart of the first `coordinates` of the values in a frame.
    fn draw(&self, svg: &mut Svg, frame: Area, coordinates: usize, duration: f64) -> Axes {
        let values = self.values.iter().flatten().flat_map(|p| p.iter().take(coordinates));
        let extremes = Range::of(values);
        let mut up = Range::with_zero(self.lines.iter().chain(&[extremes.low, extremes.high]), 0.0);
        if up.width() <= self.rounding {
            up = Range { low: 0.0, high: 0.0 };
        }
        let axes = Axes::new(frame, Range { low: 0.0, high: duration }, up);
        svg.text(Vector2::new(frame.x, frame.y - 7.0), heading(), &self.heading);
        let [low, high] = [extremes.low, extremes.high].map(|x| axes.up_ticks().figure(x));
        svg.text(
            Vector2::new(frame.right(), frame.y - 7.0),
            TextStyle::new(11.0, GREY).end(),
            &format!("{low} to {high}"),
        );
        axes.draw_grid(svg);
        for x in &self.lines {
            let look = Look::line(HIGHLIGHT, 0.8).dashed(2.0, 3.0);
            svg.line(axes.at(0.0, *x), axes.at(duration, *x), look);
        }
        for (thing, values) in self.values.iter().enumerate() {
            let steps = (values.len() - 1).max(1) as f64;
            let times: Vec<f64> = (0..values.len()).map(|i| duration * i as f64 / steps).collect();
            for axis in 0..coordinates {
                let values: Vec<f64> = values.iter().map(|p| p[axis]).collect();
                svg.polyline(&axes.curve(&times, &values), dashed(Look::line(joint(axis), CURVE), thing));
            }
        }
        axes
    }
}

impl Paths {
    /// All points that are drawn.
    fn points(&self) -> impl Iterator<Item = &Vector3<f64>> {
        self.traces.iter().flatten().chain(&self.marks).chain(self.bars.iter().flatten())
    }

    /// From two sides, and below what the signs are.
    fn draw(&self, svg: &mut Svg) {
        let size = self.points().map(|p| p.amax()).fold(1e-6, f64::max);
        let below = MIDDLE + Vector2::new(0.0, NEXT_PATH);
        self.draw_side(svg, MIDDLE, [0, 1], size);
        self.draw_side(svg, below, [0, 2], size);
        let legend = format!("dot: the start{}", self.legend);
        svg.text(below + Vector2::new(0.0, EDGE + 16.0), heading().middle(), &legend);
    }

    /// In the plane of two axes; from the middle to the edge it is `size` in the unit of the points.
    fn draw_side(&self, svg: &mut Svg, middle: Vector2<f64>, [right, up]: [usize; 2], size: f64) {
        let place = |p: &Vector3<f64>| middle + Vector2::new(p[right], -p[up]) * (EDGE / size);
        let [x, y] = [self.axes[right], self.axes[up]];
        let above = format!("path: {x} right, {y} up; edge at {size:.3} {}", self.unit);
        svg.text(middle - Vector2::new(0.0, EDGE + 8.0), heading().middle(), &above);
        let cross =
            [Vector2::new(EDGE, 0.0), Vector2::new(0.0, EDGE)].map(|arm| [middle - arm, middle + arm]);
        svg.path(&cross, Look::line(RULE, 1.0));
        for [from, to] in &self.bars {
            svg.line(place(from), place(to), Look::line(RULE, BAR));
        }
        for (thing, trace) in self.traces.iter().enumerate() {
            let points: Vec<_> = trace.iter().map(place).collect();
            svg.polyline(&thinned(&points, UNSEEN), dashed(Look::line(INK, CURVE), thing));
        }
        for mark in &self.marks {
            svg.circle(place(mark), 4.0, Look::line(joint(1), 1.0));
        }
        for trace in &self.traces {
            svg.circle(trace.first().map_or(middle, place), 3.0, Look::filled(INK));
        }
    }
}
