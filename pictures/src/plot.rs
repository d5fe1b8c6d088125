//! A plot: quantities over time that are no robot's own, such as a force.
//!
//! In: values and when they were had. Out: a self-contained SVG, in the look of the film's charts.

use std::io;
use std::path::Path;

use nalgebra::Vector2;

use crate::chart::{self, Chart, Curve, Ends, Span};
use crate::curves::Timeline;
use crate::page::{self, MARGIN, WIDTH};
use crate::panel;
use crate::svg::palette::{self, GREY};
use crate::svg::{Area, Range, TextStyle};

/// Height of a chart's curves \[px\].
const HEIGHT: f64 = 150.0;

/// Room for labels, of some words, and largest values \[px\].
const LABELS: f64 = 190.0;

/// The most points of a line.
const MOST: usize = 1200;

/// A quantity over time: its label and its values.
pub type Line = (String, Vec<f64>);

/// Charts over time, one above the other, on one page of 1200 px width.
///
/// ```
/// use mrroc_pictures::Plot;
///
/// let times: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.01).collect();
/// let force = times.iter().map(|t| (6.0 * t).sin()).collect();
/// let plot = Plot::new("A force over time", "simulated").chart("Force", "N", times, [("left".to_owned(), force)]);
/// assert!(plot.svg().contains("Force [N]"));
/// ```
#[derive(Clone, Debug)]
pub struct Plot {
    title: String,
    subtitle: String,
    charts: Vec<Chart>,
}

impl Plot {
    /// A plot with a heading and a line below it.
    #[must_use]
    pub fn new(title: &str, subtitle: &str) -> Plot {
        Plot { title: title.to_owned(), subtitle: subtitle.to_owned(), charts: Vec::new() }
    }

    /// The same plot with one more chart: lines of one `unit`, each with a value for each of `times` \[s\], increasing, or
    /// for the first of them.
    #[must_use]
    pub fn chart(
        mut self,
        heading: &'static str,
        unit: &'static str,
        times: Vec<f64>,
        lines: impl IntoIterator<Item = Line>,
    ) -> Plot {
        let curve = |i: usize, line: Line| Curve {
            colour: palette::joint(i),
            demanded: None,
            label: line.0,
            measured: line.1,
            peak: None,
        };
        let curves = lines.into_iter().enumerate().map(|(i, line)| curve(i, line)).collect();
        self.charts.push(Chart {
            heading: heading.to_owned(),
            unit,
            class: "measured",
            height: HEIGHT,
            span: Span::WithZero(0.0),
            ends: Ends::Largest,
            times,
            curves,
        });
        self
    }

    /// The plot as an SVG document.
    #[must_use]
    pub fn svg(&self) -> String {
        let run = Range::of(self.charts.iter().flat_map(|chart| &chart.times));
        let area = Area {
            x: MARGIN,
            y: page::HEADING,
            width: WIDTH - 2.0 * MARGIN,
            height: chart::height(&self.charts) + 10.0,
        };
        page::document(&self.title, area.y + area.height + MARGIN, |svg| {
            page::heading(svg, &self.title, &self.subtitle);
            panel::ground(svg, area);
            if run.width() > 0.0 {
                let timeline = Timeline { run, playback: None, most: MOST, labels: LABELS, suspensions: &[] };
                timeline.draw(svg, area.inset(12.0, 10.0, 12.0, 0.0), &self.charts, &[]);
            } else {
                let at = Vector2::new(area.x + MARGIN, area.y + MARGIN + 10.0);
                svg.text(at, TextStyle::new(13.0, GREY), "No time has passed.");
            }
        })
    }

    /// Writes the plot.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, file: &Path) -> io::Result<()> {
        std::fs::write(file, self.svg())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_drawn_with_its_label_and_its_largest_value() {
        let times: Vec<f64> = (0..=100).map(|i| f64::from(i) * 0.1).collect();
        let lines = [("up", 3.0), ("<down>", -7.0)]
            .map(|(label, end)| (label.to_owned(), times.iter().map(|t| end * t / 10.0).collect()));
        let svg = Plot::new("Two lines", "").chart("Force", "N", times, lines).svg();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let lines = document.descendants().filter(|node| node.attribute("class") == Some("measured"));
        assert_eq!(lines.count(), 2);
        let texts: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
        assert!(texts.contains(&"<down>") && texts.contains(&"up"));
        assert!(
            texts.iter().any(|text| text.starts_with("3")) && texts.iter().any(|text| text.contains("7.0"))
        );
    }

    #[test]
    fn a_plot_of_nothing_is_a_document() {
        roxmltree::Document::parse(&Plot::new("Nothing", "").svg()).unwrap();
        let plot = Plot::new("Nothing", "").chart("Force", "N", vec![1.0], [("one".to_owned(), vec![1.0])]);
        assert!(!plot.svg().contains("NaN"));
    }
}
