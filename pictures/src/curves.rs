//! Curves over time, one chart above the other: measured thick, demanded thin, their names and figures at the right end.
//!
//! In: charts. Out: lines with round ticks on a common time axis; where animations are shown, a line that moves along
//! with the robots.

use nalgebra::Vector2;

use crate::chart::{Chart, Curve, Ends, HEADING, LABEL};
use crate::labels;
use crate::palette::{GREY, GRID, INK, RULE};
use crate::playback::Playback;
use crate::projection::Area;
use crate::svg::{Anchor, Points, Px, Svg, Weight, Words};
use crate::thinning;
use crate::ticks::{Axis, Ticks};

/// Room for ticks at the left end of a chart, and usually for labels at its right end \[px\].
const TICKS: f64 = 54.0;
pub(crate) const LABELS: f64 = 108.0;

/// A time axis and what is drawn over it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Timeline<'a> {
    /// When the run began and ended \[s\].
    pub run: (f64, f64),
    pub playback: Option<&'a Playback>,
    /// The most points of a line.
    pub most: usize,
    /// Room for labels \[px\].
    pub labels: f64,
}

impl Timeline<'_> {
    /// Draws charts.
    pub fn draw(&self, svg: &mut Svg, area: Area, charts: &[Chart]) {
        let left = area.x + TICKS;
        let right = area.x + area.width - self.labels;
        let (unit, seconds) = time_unit(self.run.1 - self.run.0);
        let time = Axis::new((self.run.0 / seconds, self.run.1 / seconds), (left, right));
        let ticks = Ticks::inside(self.run.0 / seconds, self.run.1 / seconds, 8);
        let mut top = area.y;
        for chart in charts {
            let frame = Area { x: left, y: top + HEADING, width: right - left, height: chart.height };
            for value in ticks.values() {
                let x = time.at(value);
                let (a, b) = (Vector2::new(x, frame.y), Vector2::new(x, frame.y + frame.height));
                svg.line(a, b, format_args!("stroke=\"{GRID}\""));
            }
            let xs: Vec<f64> = chart.times.iter().map(|t| time.at(t / seconds)).collect();
            chart.draw(svg, frame, &xs, self);
            top += HEADING + chart.height;
        }
        let words = Words { size: 11.0, colour: GREY, anchor: Anchor::Middle, weight: Weight::Normal };
        for value in ticks.values() {
            svg.words(Vector2::new(time.at(value), top + 16.0), words, &ticks.label(value));
        }
        let words = Words { colour: INK, anchor: Anchor::Start, ..words };
        svg.words(Vector2::new(right + 32.0, top + 16.0), words, &format!("time [{unit}]"));
        if let Some(playback) = self.playback {
            let from = area.y + HEADING;
            svg.group("g", format_args!("class=\"moving\" display=\"none\""), |svg| {
                Playback::set(svg, "display", "inline");
                svg.group(
                    "path",
                    format_args!(
                        "stroke=\"{INK}\" stroke-opacity=\".55\" d=\"M{},{}V{}\"",
                        Px(left),
                        Px(from),
                        Px(top)
                    ),
                    |svg| {
                        let places = [self.run.0, self.run.1]
                            .map(|t| format!("M{},{}V{}", Px(time.at(t / seconds)), Px(from), Px(top)));
                        playback.animate(svg, "d", places.into_iter());
                    },
                );
            });
        }
    }
}

impl Chart {
    fn draw(&self, svg: &mut Svg, frame: Area, xs: &[f64], on: &Timeline<'_>) {
        let words = Words { size: 11.0, colour: GREY, anchor: Anchor::End, weight: Weight::Normal };
        let heading = Words { size: 12.0, colour: INK, anchor: Anchor::Start, weight: Weight::Bold };
        svg.words(
            Vector2::new(frame.x, frame.y - 9.0),
            heading,
            &format!("{} [{}]", self.heading, self.unit),
        );
        let values = || {
            let lines = self.curves.iter().flat_map(|curve| [Some(&curve.measured), curve.demanded.as_ref()]);
            lines.flatten().flatten().copied()
        };
        let (mut low, mut high) =
            values().fold((0.0_f64, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        if high - low < self.least {
            let middle = 0.5 * (low + high);
            (low, high) = (middle - 0.5 * self.least, middle + 0.5 * self.least);
        }
        // A bit of play beyond 0 is not worth a step of the axis.
        low = if low > -0.02 * high { 0.0 } else { low };
        high = if high < -0.02 * low { 0.0 } else { high };
        let ticks = Ticks::around(low, high, if self.height > 100.0 { 5 } else { 3 });
        let axis = Axis::new((ticks.low(), ticks.high()), (frame.y + frame.height, frame.y));
        let right = frame.x + frame.width;
        for value in ticks.values() {
            let y = axis.at(value);
            let colour = if value == 0.0 { RULE } else { GRID };
            svg.line(Vector2::new(frame.x, y), Vector2::new(right, y), format_args!("stroke=\"{colour}\""));
            svg.words(Vector2::new(frame.x - 6.0, y + 3.8), words, &ticks.label(value));
        }
        let line = |values: &[f64]| {
            let points: Vec<_> =
                xs.iter().zip(values).map(|(x, value)| Vector2::new(*x, axis.at(*value))).collect();
            thinning::curve(&points, on.most)
        };
        svg.group(
            "g",
            format_args!("fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\""),
            |svg| {
                for curve in &self.curves {
                    let (width, opacity) = if curve.demanded.is_some() { (3.2, ".5") } else { (1.4, "1") };
                    svg.element(
                        "polyline",
                        format_args!(
                            "class=\"measured\" stroke=\"{}\" stroke-width=\"{width}\" stroke-opacity=\"{opacity}\" points=\"{}\"",
                            curve.colour,
                            Points(&line(&curve.measured))
                        ),
                    );
                }
                for curve in &self.curves {
                    if let Some(demanded) = &curve.demanded {
                        svg.element(
                            "polyline",
                            format_args!(
                                "class=\"demanded\" stroke=\"{}\" stroke-width=\"1\" points=\"{}\"",
                                curve.colour,
                                Points(&line(demanded))
                            ),
                        );
                    }
                }
            },
        );
        self.labels(svg, (frame, on.labels), &axis, &ticks, xs);
    }

    /// At the right end: which curve is which, and its last or largest value.
    fn labels(&self, svg: &mut Svg, (frame, room): (Area, f64), axis: &Axis, ticks: &Ticks, xs: &[f64]) {
        let right = frame.x + frame.width;
        let words = Words { size: 11.5, colour: GREY, anchor: Anchor::Start, weight: Weight::Normal };
        let caption = match self.ends {
            Ends::Last => "at the end",
            Ends::Largest => "largest",
        };
        svg.words(Vector2::new(right + 20.0, frame.y - 9.0), Words { size: 11.0, ..words }, caption);
        let last = |curve: &Curve| curve.measured.last().copied().unwrap_or(0.0);
        // Those that came back stand in their order, whatever their play.
        let play = 0.01 * (ticks.high() - ticks.low());
        let wish = |value: f64| axis.at(if value.abs() < play { 0.0 } else { value });
        let wishes: Vec<f64> = match self.ends {
            Ends::Last => self.curves.iter().map(|curve| wish(last(curve))).collect(),
            Ends::Largest => (0..self.curves.len()).map(|i| frame.y + 6.0 + LABEL * i as f64).collect(),
        };
        let heights = labels::spread(&wishes, LABEL, (frame.y + 4.0, frame.y + frame.height));
        for (curve, (wish, y)) in self.curves.iter().zip(wishes.iter().zip(heights)) {
            let value = match self.ends {
                Ends::Last => last(curve),
                Ends::Largest => {
                    let seen = curve.measured.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                    curve.peak.unwrap_or(seen)
                }
            };
            if self.ends == Ends::Last {
                let end = xs.last().copied().unwrap_or(right);
                let leader = [
                    Vector2::new(end, *wish),
                    Vector2::new(right + 8.0, *wish),
                    Vector2::new(right + 16.0, y),
                ];
                svg.element(
                    "polyline",
                    format_args!(
                        "fill=\"none\" stroke=\"{}\" stroke-opacity=\".5\" points=\"{}\"",
                        curve.colour,
                        Points(&leader)
                    ),
                );
            }
            let at = Vector2::new(right + 20.0, y + 4.0);
            svg.words(at, Words { colour: curve.colour, weight: Weight::Bold, ..words }, &curve.label);
            let at = Vector2::new(right + room - 6.0, y + 4.0);
            svg.words(at, Words { anchor: Anchor::End, colour: INK, ..words }, &ticks.figure(value));
        }
    }
}

/// The unit of a time axis over a duration \[s\], and its length \[s\].
fn time_unit(duration: f64) -> (&'static str, f64) {
    match duration {
        d if d > 3.0 * 3600.0 => ("h", 3600.0),
        d if d > 300.0 => ("min", 60.0),
        d if d < 0.5 => ("ms", 1e-3),
        _ => ("s", 1.0),
    }
}
