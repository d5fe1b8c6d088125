//! A sheet of charts over time, and of the path in space.
//!
//! In: coordinates of one thing or of two, at equal steps of time. Out: an SVG.

use std::fmt::Write as _;

use nalgebra::Vector3;

/// Width and height of a chart, and where the first one stands on the page \[px\].
const W: f64 = 560.0;
const H: f64 = 110.0;
const LEFT: f64 = 80.0;
const TOP: f64 = 50.0;
/// From one chart to the next \[px\].
const NEXT: f64 = H + 32.0;
/// From the middle of a drawing of the path to its edge \[px\].
const EDGE: f64 = 130.0;
const COLOURS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];
/// How the lines are dashed: the first thing's are whole.
const DASHES: [&str; 2] = ["", " stroke-dasharray=\"5 3\""];
/// Values as small as rounding makes them are drawn as none: way, velocity, acceleration, jerk in SI.
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
    pub ways: Vec<Trace>,
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
    /// The motion of one tool or of two, whose positions \[m\] are `dt` \[s\] apart: each one's way from its start.
    pub fn of_tools(title: &str, tools: &[Trace], dt: f64) -> Self {
        let ways: Vec<Trace> = tools.iter().map(|tool| tool.iter().map(|p| p - tool[0]).collect()).collect();
        Sheet {
            title: title.to_owned(),
            axes: vec!["x", "y", "z"],
            dashed: if tools.len() > 1 { "dashed: the second arm" } else { "" },
            duration: dt * (ways[0].len() - 1) as f64,
            charts: derivatives("way from the start", "m", ways.clone(), dt),
            paths: Some(Paths { ways, axes: ["x", "y", "z"], unit: "m", ..Paths::default() }),
        }
    }

    /// The SVG.
    pub fn draw(&self) -> String {
        let width = if self.paths.is_some() { 1000.0 } else { LEFT + W + 20.0 };
        let height = TOP + self.charts.len() as f64 * NEXT + 22.0;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n",
        );
        let title = format!("<tspan font-weight=\"bold\" font-size=\"15\">{}</tspan>", self.title);
        words(&mut svg, LEFT, 24.0, "start", &title);
        let names = LEFT + W - 24.0 * self.axes.len().max(1) as f64;
        for (axis, name) in self.axes.iter().enumerate() {
            let name = format!("<tspan fill=\"{}\">{name}</tspan>", COLOURS[axis]);
            words(&mut svg, names + 24.0 * (axis + 1) as f64, 24.0, "end", &name);
        }
        words(&mut svg, names - 12.0, 24.0, "end", self.dashed);
        for (row, chart) in self.charts.iter().enumerate() {
            chart.draw(&mut svg, TOP + row as f64 * NEXT, self.axes.len());
        }
        let below = TOP + self.charts.len() as f64 * NEXT - 16.0;
        words(&mut svg, LEFT, below, "start", "0 s");
        words(&mut svg, LEFT + 0.5 * W, below, "middle", "time");
        words(&mut svg, LEFT + W, below, "end", &format!("{:.3} s", self.duration));
        if let Some(paths) = &self.paths {
            paths.draw(&mut svg);
        }
        svg + "</svg>\n"
    }
}

/// A line through points of the page, of which those on a level between their neighbours are left out.
fn line(svg: &mut String, points: impl Iterator<Item = (f64, f64)>, colour: &str, dashes: &str) {
    let _ = write!(svg, "<polyline fill=\"none\" stroke=\"{colour}\"{dashes} stroke-width=\"1.5\" points=\"");
    let points: Vec<_> = points.map(|(x, y)| (format!("{x:.1}"), format!("{y:.1}"))).collect();
    for (i, (x, y)) in points.iter().enumerate() {
        let level = |k: usize| points.get(k).is_some_and(|(_, other)| other == y);
        if !(i > 0 && level(i - 1) && level(i + 1)) {
            let _ = write!(svg, "{x},{y} ");
        }
    }
    svg.push_str("\"/>\n");
}

fn words(svg: &mut String, x: f64, y: f64, anchor: &str, text: &str) {
    if !text.is_empty() {
        let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>");
    }
}

impl Chart {
    fn draw(&self, svg: &mut String, top: f64, axes: usize) {
        let of_values = || self.values.iter().flatten().flat_map(|p| p.iter().take(axes).copied());
        let all = of_values().chain(self.lines.iter().copied());
        let mut low: f64 = 0.0;
        let mut high: f64 = 0.0;
        for x in all {
            low = low.min(x);
            high = high.max(x);
        }
        let scale = if high - low > self.rounding { H / (high - low) } else { 0.0 };
        if scale == 0.0 {
            low = 0.0;
            high = 0.0;
        }
        let y = |x: f64| top + H - (x - low) * scale;
        let _ = writeln!(
            svg,
            "<path stroke=\"#999\" fill=\"none\" d=\"M{LEFT},{top}V{0}M{LEFT},{1}H{2}\"/>",
            top + H,
            y(0.0),
            LEFT + W
        );
        words(svg, LEFT, top - 6.0, "start", &self.heading);
        // Not where another label stands.
        words(svg, LEFT - 6.0, y(0.0) + 4.0, "end", "0.000");
        for x in [low, high].into_iter().filter(|x| (y(*x) - y(0.0)).abs() > 12.0) {
            words(svg, LEFT - 6.0, y(x) + 4.0, "end", &format!("{x:.3}"));
        }
        for x in &self.lines {
            let _ = writeln!(
                svg,
                "<path stroke=\"#c00\" stroke-width=\"0.8\" stroke-dasharray=\"2 3\" d=\"M{LEFT},{0:.1}H{1}\"/>",
                y(*x),
                LEFT + W
            );
        }
        for (values, dashes) in self.values.iter().zip(DASHES) {
            let steps = (values.len() - 1).max(1) as f64;
            for (axis, colour) in COLOURS.iter().enumerate().take(axes) {
                let points =
                    values.iter().enumerate().map(|(i, p)| (LEFT + W * i as f64 / steps, y(p[axis])));
                line(svg, points, colour, dashes);
            }
        }
    }
}

impl Paths {
    /// From two sides.
    fn draw(&self, svg: &mut String) {
        let points = self.ways.iter().flatten().chain(&self.marks).chain(self.bars.iter().flatten());
        let size = points.map(|p| p.amax()).fold(1e-6, f64::max);
        for (k, [right, up]) in [[0, 1], [0, 2]].into_iter().enumerate() {
            let x0 = 820.0;
            let y0 = 180.0 + 280.0 * k as f64;
            let place = |p: &Vector3<f64>| (x0 + EDGE * p[right] / size, y0 - EDGE * p[up] / size);
            let _ = writeln!(
                svg,
                "<path stroke=\"#ccc\" fill=\"none\" d=\"M{0},{y0}h260M{x0},{1}v260\"/>",
                x0 - EDGE,
                y0 - EDGE
            );
            let [x, y] = [self.axes[right], self.axes[up]];
            let heading = format!("path: {x} right, {y} up; edge at {size:.3} {}", self.unit);
            words(svg, x0, y0 - 138.0, "middle", &heading);
            for bar in &self.bars {
                line(svg, bar.iter().map(place), "#aaa", "");
            }
            for (way, dashes) in self.ways.iter().zip(DASHES) {
                line(svg, way.iter().map(place), "#222", dashes);
            }
            for mark in &self.marks {
                let (x, y) = place(mark);
                let _ = writeln!(
                    svg,
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"none\" stroke=\"#d55e00\"/>"
                );
            }
            for way in &self.ways {
                let (x, y) = way.first().map_or((x0, y0), place);
                let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"#222\"/>");
            }
        }
        words(svg, 820.0, 606.0, "middle", &format!("dot: the start{}", self.legend));
    }
}
