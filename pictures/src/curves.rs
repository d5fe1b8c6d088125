//! Curves over time, one chart above the other: measured thick, demanded thin, their names and figures at the right end.
//!
//! In: charts. Out: lines with round ticks on a common time axis; where animations are shown, a line that moves along
//! with the robots.

use nalgebra::Vector2;

use crate::bands::{self, Row};
use crate::chart::{Chart, Curve, Ends, HEADING, LABEL, Span};
use crate::labels;
use crate::playback::{self, Playback};
use crate::svg::palette::{GREY, INK};
use crate::svg::{Area, Axes, Axis, Look, Range, Svg, TextStyle};

/// Room for ticks at the left end of a chart, and usually for labels at its right end \[px\].
const TICKS: f64 = 54.0;
pub(crate) const LABELS: f64 = 108.0;

/// Values that are so many times farther from 0 than from one another have an axis without 0.
const FAR: f64 = 2.0;

/// A time axis and what is drawn over it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Timeline<'a> {
    /// When the run began and ended \[s\].
    pub run: Range,
    pub playback: Option<&'a Playback>,
    /// The most points of a line.
    pub most: usize,
    /// Room for labels \[px\].
    pub labels: f64,
    /// When the cell was suspended \[s\].
    pub suspensions: &'a [Range],
}

impl Timeline<'_> {
    /// Draws charts, and rows of bands below their time axis.
    pub fn draw(&self, svg: &mut Svg, area: Area, charts: &[Chart], rows: &[Row]) {
        let left = area.x + TICKS;
        let right = area.right() - self.labels;
        let unit = TimeUnit::of(self.run.width());
        let time = Axis::new(self.run, left, right);
        let frames: f64 = charts.iter().map(|chart| HEADING + chart.height).sum();
        let frames =
            Area { x: left, y: area.y + HEADING, width: right - left, height: (frames - HEADING).max(0.0) };
        bands::shade(svg, &time, self.suspensions, frames);
        let mut top = area.y;
        let mut lowest = None;
        for chart in charts {
            let frame = Area { x: left, y: top + HEADING, width: right - left, height: chart.height };
            let axes = Axes::new(frame, self.run.scaled(1.0 / unit.seconds), chart.range());
            let axes = axes.with_most_points(self.most);
            let times: Vec<f64> = chart.times.iter().map(|t| t / unit.seconds).collect();
            chart.draw(svg, &axes, &times, self.labels);
            top += HEADING + chart.height;
            lowest = Some(axes);
        }
        if let Some(axes) = lowest {
            axes.draw_labels_below(svg);
        }
        let at = Vector2::new(right + 32.0, top + 16.0);
        svg.text(at, TextStyle::new(11.0, INK), &format!("time [{}]", unit.name));
        bands::draw(svg, &time, Range { low: left, high: right }, top, rows);
        if let Some(playback) = self.playback {
            let from = area.y + HEADING;
            let line = |svg: &Svg, time: f64| {
                let [x, from, to] = [time, from, top].map(|value| svg.number(value));
                format!("M{x},{from}V{to}")
            };
            playback::moving(svg, |svg| {
                let look = svg.attributes(Look::new().stroke(INK).stroke_opacity(0.55));
                let at_start = line(svg, left);
                svg.containing("path", format_args!("{look} d=\"{at_start}\""), |svg| {
                    let ends = [self.run.low, self.run.high].map(|t| line(svg, time.at(t)));
                    playback.animate(svg, "d", ends.to_vec());
                });
            });
        }
    }
}

impl Chart {
    /// What the left axis spans.
    fn range(&self) -> Range {
        let lines = self.curves.iter().flat_map(|curve| [Some(&curve.measured), curve.demanded.as_ref()]);
        let values = lines.flatten().flatten();
        match self.span {
            Span::WithZero(least) => Range::with_zero(values, least),
            Span::Fixed(range) => range,
            Span::Values => {
                let range = Range::of(values);
                let away = range.low.abs().min(range.high.abs());
                let is_far = range.low * range.high > 0.0 && away > FAR * range.width();
                // A constant has an axis of its own size about it.
                let half = 0.05 * away;
                match (is_far, range.width() > 0.0) {
                    (true, true) => range,
                    (true, false) => Range { low: range.low - half, high: range.high + half },
                    (false, _) => Range::with_zero(&[range.low, range.high], f64::MIN_POSITIVE),
                }
            }
        }
    }

    fn draw(&self, svg: &mut Svg, axes: &Axes, times: &[f64], room: f64) {
        let frame = axes.frame();
        let heading = match self.unit {
            "" => self.heading.clone(),
            unit => format!("{} [{unit}]", self.heading),
        };
        svg.text(Vector2::new(frame.x, frame.y - 9.0), TextStyle::new(12.0, INK).bold(), &heading);
        axes.draw_grid(svg);
        svg.group(Look::new().no_fill().round(), |svg| {
            for curve in &self.curves {
                let look = Look::new().class(self.class).stroke(curve.colour);
                let look = match curve.demanded {
                    Some(_) => look.width(3.2).stroke_opacity(0.5),
                    None => look.width(1.4),
                };
                pieces(svg, axes, times, &curve.measured, look);
            }
            for curve in &self.curves {
                if let Some(demanded) = &curve.demanded {
                    let class = if self.class == "measured" { "demanded" } else { "wanted" };
                    let look = Look::new().class(class).stroke(curve.colour).width(1.0);
                    pieces(svg, axes, times, demanded, look);
                }
            }
        });
        self.labels(svg, axes, times, room);
    }

    /// At the right end: which curve is which, and its last or largest value.
    fn labels(&self, svg: &mut Svg, axes: &Axes, times: &[f64], room: f64) {
        let frame = axes.frame();
        let ticks = axes.up_ticks();
        let right = frame.right();
        let end = times.last().map_or(right, |time| axes.at(*time, 0.0).x);
        let height = |value: f64| axes.at(0.0, value).y;
        let caption = match self.ends {
            Ends::Last => "at the end",
            Ends::Largest => "largest",
        };
        if !self.curves.is_empty() {
            svg.text(Vector2::new(right + 20.0, frame.y - 9.0), TextStyle::new(11.0, GREY), caption);
        }
        let last = |curve: &Curve| {
            curve.measured.iter().rev().find(|value| value.is_finite()).copied().unwrap_or(0.0)
        };
        // Those that came back stand in their order, whatever their play.
        let play = 0.01 * ticks.range().width();
        let wish = |value: f64| height(if value.abs() < play { 0.0 } else { value });
        let wishes: Vec<f64> = match self.ends {
            Ends::Last => self.curves.iter().map(|curve| wish(last(curve))).collect(),
            Ends::Largest => (0..self.curves.len()).map(|i| frame.y + 6.0 + LABEL * i as f64).collect(),
        };
        let heights = labels::spread(&wishes, LABEL, Range { low: frame.y + 4.0, high: frame.bottom() });
        for (curve, (wish, y)) in self.curves.iter().zip(wishes.iter().zip(heights)) {
            let value = match self.ends {
                Ends::Last => last(curve),
                Ends::Largest => {
                    let seen = curve.measured.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                    curve.peak.unwrap_or(seen)
                }
            };
            if self.ends == Ends::Last {
                let leader = [
                    Vector2::new(end, *wish),
                    Vector2::new(right + 8.0, *wish),
                    Vector2::new(right + 16.0, y),
                ];
                svg.polyline(&leader, Look::line(curve.colour, 1.0).stroke_opacity(0.5));
            }
            let at = Vector2::new(right + 20.0, y + 4.0);
            svg.text(at, TextStyle::new(11.5, curve.colour).bold(), &curve.label);
            let at = Vector2::new(right + room - 6.0, y + 4.0);
            svg.text(at, TextStyle::new(11.5, INK).end(), &ticks.figure(value));
        }
    }
}

/// Draws a curve, with gaps where its values or its times are no numbers; a value between two gaps as a dot.
fn pieces(svg: &mut Svg, axes: &Axes, times: &[f64], values: &[f64], look: Look) {
    let samples: Vec<(f64, f64)> = times.iter().copied().zip(values.iter().copied()).collect();
    for piece in samples.split(|(time, value)| !time.is_finite() || !value.is_finite()) {
        let (times, values): (Vec<f64>, Vec<f64>) = piece.iter().copied().unzip();
        match (times.as_slice(), values.as_slice()) {
            ([], _) | (_, []) => {}
            ([time], [value]) => svg.circle(axes.at(*time, *value), 1.1, look),
            (times, values) => svg.polyline(&axes.curve(times, values), look),
        }
    }
}

/// The unit of a time axis.
struct TimeUnit {
    name: &'static str,
    /// Its length \[s\].
    seconds: f64,
}

impl TimeUnit {
    /// For an axis of this length \[s\].
    fn of(duration: f64) -> TimeUnit {
        match duration {
            d if d > 3.0 * 3600.0 => TimeUnit { name: "h", seconds: 3600.0 },
            d if d > 300.0 => TimeUnit { name: "min", seconds: 60.0 },
            d if d < 0.5 => TimeUnit { name: "ms", seconds: 1e-3 },
            _ => TimeUnit { name: "s", seconds: 1.0 },
        }
    }
}
