//! Charts over time as SVG, two in a row.

use std::fmt::Write;

/// Sizes of a chart's frame and of the margins around it \[px\].
const WIDTH: f64 = 380.0;
const HEIGHT: f64 = 130.0;
const LEFT: f64 = 78.0;
const ABOVE: f64 = 46.0;
const BELOW: f64 = 42.0;
const HEADING: f64 = 54.0;

/// A line of a chart.
pub struct Curve {
    values: Vec<f64>,
    class: &'static str,
}

impl Curve {
    pub fn measured(values: Vec<f64>) -> Self {
        Self { values, class: "true" }
    }

    pub fn demanded(values: Vec<f64>) -> Self {
        Self { values, class: "demanded" }
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

/// 1, 2 or 5 times a power of ten, of which at most `most` fit into `range`, > 0.
fn round_step(range: f64, most: f64) -> f64 {
    let least = range / most;
    let power = 10_f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// A multiple of a step, with the digits that it needs.
fn label(value: f64, step: f64) -> String {
    let digits = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
    let text = format!("{value:.digits$}");
    if text.trim_matches(['-', '0', '.']).is_empty() { "0".to_owned() } else { text.replace('-', "−") }
}

impl Chart {
    /// Draws the chart with the left upper corner of its frame at (x, y) \[px\].
    fn draw(&self, out: &mut String, x: f64, y: f64) {
        let values = || self.curves.iter().flat_map(|curve| &curve.values);
        let (low, high) = values().fold((0.0_f64, 0.0_f64), |(low, high), v| (low.min(*v), high.max(*v)));
        let (factor, prefix) = prefix(high.max(-low));
        // A curve that goes less than a line's thickness below 0 needs no space there.
        let low = if low > -0.01 * high { 0.0 } else { low };
        let step = round_step(((high - low) * factor).max(1e-9), 5.0);
        let (first, last) = ((low * factor / step).floor(), (high * factor / step).ceil().max(1.0));
        let end = self.times.last().copied().unwrap_or(1.0);
        let across = |t: f64| x + WIDTH * t / end;
        let up = |v: f64| y + HEIGHT * (last * step - v * factor) / ((last - first) * step);

        let _ = writeln!(out, r#"<text class="title" x="{x:.1}" y="{:.1}">{}</text>"#, y - 24.0, self.title);
        let _ = writeln!(out, r#"<text class="small" x="{x:.1}" y="{:.1}">{}</text>"#, y - 8.0, self.figures);
        for i in first as i64..=last as i64 {
            let value = i as f64 * step;
            let (at, class) = (up(value / factor), if i == 0 { "zero" } else { "grid" });
            let right = x + WIDTH;
            let _ = writeln!(
                out,
                r#"<line class="{class}" x1="{x:.1}" y1="{at:.1}" x2="{right:.1}" y2="{at:.1}"/>"#
            );
            let text = label(value, step);
            let _ = writeln!(
                out,
                r#"<text class="small" text-anchor="end" x="{:.1}" y="{:.1}">{text}</text>"#,
                x - 6.0,
                at + 4.0
            );
        }
        let (middle, left) = (y + 0.5 * HEIGHT, x - 56.0);
        let _ = writeln!(
            out,
            r#"<text class="small" text-anchor="middle" transform="translate({left:.1},{middle:.1}) rotate(-90)">{} [{prefix}{}]</text>"#,
            self.quantity, self.unit
        );
        let step = round_step(end * 1e3, 6.0);
        for i in 0..=(end * 1e3 / step + 1e-9).floor() as i64 {
            let value = i as f64 * step;
            let at = across(value * 1e-3);
            let bottom = y + HEIGHT;
            let _ = writeln!(
                out,
                r#"<line class="grid" x1="{at:.1}" y1="{y:.1}" x2="{at:.1}" y2="{bottom:.1}"/>"#
            );
            let text = label(value, step);
            let _ = writeln!(
                out,
                r#"<text class="small" text-anchor="middle" x="{at:.1}" y="{:.1}">{text}</text>"#,
                bottom + 15.0
            );
        }
        let _ = writeln!(
            out,
            r#"<text class="small" text-anchor="middle" x="{:.1}" y="{:.1}">time [ms]</text>"#,
            x + 0.5 * WIDTH,
            y + HEIGHT + 30.0
        );
        for curve in &self.curves {
            let mut points = String::new();
            for (t, v) in self.times.iter().zip(&curve.values) {
                let _ = write!(points, "{:.1},{:.1} ", across(*t), up(*v));
            }
            let _ = writeln!(out, r#"<polyline class="{}" points="{}"/>"#, curve.class, points.trim_end());
        }
    }
}

/// A page of charts, two in a row.
pub fn page(title: &str, rows: &[[Chart; 2]]) -> String {
    let (across, down) = (LEFT + WIDTH + 10.0, ABOVE + HEIGHT + BELOW);
    let (width, height) = (2.0 * across + 16.0, HEADING + rows.len() as f64 * down + 10.0);
    let mut charts = String::new();
    for (i, row) in rows.iter().enumerate() {
        for (k, chart) in row.iter().enumerate() {
            chart.draw(&mut charts, LEFT + k as f64 * across, HEADING + ABOVE + i as f64 * down);
        }
    }
    let style = "text{font:13px sans-serif;fill:#1c2733}.head{font-size:16px;font-weight:bold}\
        .title{font-weight:bold}.small{font-size:11px;fill:#5d6b79}\
        .grid{stroke:#e2e6ea}.zero{stroke:#b4bdc6}.true{fill:none;stroke:#0072b2;stroke-width:1.8}\
        .demanded{fill:none;stroke:#d55e00;stroke-width:1.2;stroke-dasharray:5 3}";
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\">\n<style>{style}</style>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text class=\"head\" x=\"16\" y=\"26\">{title}</text>\n\
         <text class=\"small\" x=\"16\" y=\"44\">blue: the true shaft (or demanded less true); orange, broken: demanded; \
         servo period 2 ms</text>\n{charts}</svg>\n"
    )
}
