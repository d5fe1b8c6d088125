//! A sheet of a motion: way, velocity, acceleration and jerk over time, and the path in space.
//!
//! In: positions of one tool or of several at steps of [`DT`]. Out: an SVG.

use std::fmt::Write as _;

use nalgebra::Vector3;

/// Path time of a step \[s\].
pub const DT: f64 = 4e-3;
/// Width and height of a chart, and where the first one stands on the page \[px\].
const W: f64 = 560.0;
const H: f64 = 110.0;
const LEFT: f64 = 80.0;
const TOP: f64 = 50.0;
const COLOURS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];
/// How a tool's lines are dashed: the first are whole.
const DASHES: [&str; 2] = ["", " stroke-dasharray=\"5 3\""];
/// Values as small as rounding makes them are drawn as none: way, velocity, acceleration, jerk in SI.
const ROUNDING: [f64; 4] = [1e-9, 1e-7, 1e-5, 1e-3];

/// Positions of a tool over time \[m\].
pub type Trace = Vec<Vector3<f64>>;

/// Central differences; at an end, the value beside it.
fn derivative(x: &[Vector3<f64>]) -> Trace {
    let mut v: Vec<_> = x.windows(3).map(|w| (w[2] - w[0]) / (2.0 * DT)).collect();
    let (first, last) = (v.first().copied().unwrap_or_default(), v.last().copied().unwrap_or_default());
    v.insert(0, first);
    v.push(last);
    v
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
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>");
}

/// Values of all tools over time, below a heading.
fn chart(svg: &mut String, row: usize, heading: &str, tools: &[Trace]) {
    let top = TOP + row as f64 * (H + 32.0);
    let all = || tools.iter().flatten().flat_map(|p| p.iter().copied());
    let (low, high) = all().fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    let scale = if high - low > ROUNDING[row] { H / (high - low) } else { 0.0 };
    let (low, high) = if scale > 0.0 { (low, high) } else { (0.0, 0.0) };
    let y = |x: f64| top + H - (x - low) * scale;
    let _ = writeln!(
        svg,
        "<path stroke=\"#999\" fill=\"none\" d=\"M{LEFT},{top}V{0}M{LEFT},{1}H{2}\"/>",
        top + H,
        y(0.0),
        LEFT + W
    );
    words(svg, LEFT, top - 6.0, "start", heading);
    // Not where another label stands.
    for x in [low, 0.0, high].into_iter().filter(|x| *x == 0.0 || (y(*x) - y(0.0)).abs() > 12.0) {
        words(svg, LEFT - 6.0, y(x) + 4.0, "end", &format!("{:.3}", x + 0.0));
    }
    for (values, dashes) in tools.iter().zip(DASHES) {
        let steps = (values.len() - 1).max(1) as f64;
        for (axis, colour) in COLOURS.iter().enumerate() {
            let points = values.iter().enumerate().map(|(i, p)| (LEFT + W * i as f64 / steps, y(p[axis])));
            line(svg, points, colour, dashes);
        }
    }
}

/// The paths of all tools from above and from the side, to one scale.
fn paths(svg: &mut String, ways: &[Trace]) {
    let size = ways.iter().flatten().map(|p| p.amax()).fold(1e-6, f64::max);
    for (k, (heading, axes)) in [("x right, y up", (0, 1)), ("x right, z up", (0, 2))].into_iter().enumerate()
    {
        let (x0, y0) = (820.0, 180.0 + 280.0 * k as f64);
        let _ = writeln!(
            svg,
            "<path stroke=\"#ccc\" fill=\"none\" d=\"M{0},{y0}h260M{x0},{1}v260\"/>",
            x0 - 130.0,
            y0 - 130.0
        );
        words(svg, x0, y0 - 138.0, "middle", &format!("path, {heading}: {size:.3} m to the edge"));
        for (way, dashes) in ways.iter().zip(DASHES) {
            let points = way.iter().map(|p| (x0 + 130.0 * p[axes.0] / size, y0 - 130.0 * p[axes.1] / size));
            line(svg, points, "#222", dashes);
        }
    }
}

/// The sheet of the tools' motion; all have as many positions.
pub fn draw(name: &str, tools: &[Trace]) -> String {
    let ways: Vec<Trace> = tools.iter().map(|tool| tool.iter().map(|p| p - tool[0]).collect()).collect();
    let derived = |of: &[Trace]| of.iter().map(|x| derivative(x)).collect::<Vec<_>>();
    let velocity = derived(&ways);
    let acceleration = derived(&velocity);
    let jerk = derived(&acceleration);
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1000 640\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"1000\" height=\"640\" fill=\"#fff\"/>\n",
    );
    let title = format!("<tspan font-weight=\"bold\" font-size=\"15\">{name}</tspan>");
    words(&mut svg, LEFT, 24.0, "start", &title);
    let rows = [
        ("way [m]", &ways),
        ("velocity [m/s]", &velocity),
        ("acceleration [m/s²]", &acceleration),
        ("jerk [m/s³]", &jerk),
    ];
    for (row, (heading, values)) in rows.into_iter().enumerate() {
        chart(&mut svg, row, heading, values);
    }
    let duration = DT * (ways[0].len() - 1) as f64;
    words(&mut svg, LEFT + W, TOP + 4.0 * (H + 32.0) - 16.0, "end", &format!("{duration:.3} s"));
    paths(&mut svg, &ways);
    for (axis, colour) in COLOURS.iter().enumerate() {
        let name = format!("<tspan fill=\"{colour}\">{}</tspan>", ["x", "y", "z"][axis]);
        words(&mut svg, LEFT + W - 60.0 + 24.0 * axis as f64, 24.0, "start", &name);
    }
    if tools.len() > 1 {
        words(&mut svg, LEFT + W - 80.0, 24.0, "end", "dashed: the second arm");
    }
    svg + "</svg>\n"
}
