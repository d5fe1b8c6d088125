//! The charts of a robot: which quantities are drawn over time.
//!
//! In: a history. Out: curves by unit: positions as changes since the start, so that a small motion of one joint is seen
//! beside the large angle of another; velocities; following errors; the speed of the tool.

use mrroc::robot::JointKind;

use crate::history::History;
use crate::sample::{Rates, Sample};
use crate::svg::palette::{self, INK};
use crate::svg::{Colour, Range};

/// Room above a chart for its heading, and below the last one for times \[px\].
pub(crate) const HEADING: f64 = 31.0;
const TIMES: f64 = 34.0;

/// Room for a label \[px\].
pub(crate) const LABEL: f64 = 13.5;

/// What an axis spans at least when nothing moved [rad, m, rad/s, m/s]: what is less is an encoder's play.
const PLAY: f64 = 0.02;

/// A quantity over time.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub colour: Colour,
    /// Thin; none of what nobody demands.
    pub demanded: Option<Vec<f64>>,
    /// Thick.
    pub measured: Vec<f64>,
    pub label: String,
    /// Largest absolute value in all servo periods, when it is known better than from the samples.
    pub peak: Option<f64>,
}

/// What stands at the right end of a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ends {
    /// Each curve's last value, beside it.
    Last,
    /// Each curve's largest absolute value, in order.
    Largest,
}

/// What the left axis of a chart spans, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Span {
    /// All values and 0, and at least so much.
    WithZero(f64),
    /// All values; 0, too, unless they are far away from it.
    Values,
    /// This.
    Fixed(Range),
}

/// Curves of one unit.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    pub heading: String,
    /// Empty where nobody tells it.
    pub unit: &'static str,
    /// Of its lines in the SVG.
    pub class: &'static str,
    /// Of the curves \[px\].
    pub height: f64,
    pub span: Span,
    pub ends: Ends,
    /// When the curves have their values \[s\], increasing.
    pub times: Vec<f64>,
    pub curves: Vec<Curve>,
}

impl Chart {
    /// A chart without curves.
    pub fn empty(heading: &str) -> Chart {
        Chart {
            heading: heading.to_owned(),
            unit: "",
            class: "measured",
            height: 20.0,
            span: Span::Fixed(Range { low: 0.0, high: 1.0 }),
            ends: Ends::Largest,
            times: Vec::new(),
            curves: Vec::new(),
        }
    }
}

/// The charts of a robot.
pub(crate) fn charts(history: &History, samples: &[&Sample]) -> Vec<Chart> {
    let mut charts = Vec::new();
    for kind in [JointKind::Revolute, JointKind::Prismatic] {
        let joints: Vec<usize> = (0..history.joints.len()).filter(|i| history.joints[*i] == kind).collect();
        if !joints.is_empty() {
            charts.extend(of_kind(history, samples, kind, &joints));
        }
    }
    let tool = Curve {
        colour: INK,
        demanded: None,
        measured: rates(samples).map(|rates| rates.tool).collect(),
        label: "tool".to_owned(),
        peak: Some(history.tool_speed),
    };
    charts.push(Chart {
        heading: "Tool speed".to_owned(),
        unit: "m/s",
        class: "measured",
        height: 60.0,
        span: Span::WithZero(if history.moved() { 0.0 } else { PLAY }),
        ends: Ends::Largest,
        times: rates(samples).map(|rates| rates.time).collect(),
        curves: vec![tool],
    });
    charts
}

/// Positions, velocities and following errors of the joints of one kind.
fn of_kind(history: &History, samples: &[&Sample], kind: JointKind, joints: &[usize]) -> [Chart; 3] {
    let curve = |joint: usize, demanded: Option<Vec<f64>>, measured: Vec<f64>, peak: Option<f64>| Curve {
        colour: palette::joint(joint),
        demanded,
        measured,
        label: format!("q{}", joint + 1),
        peak,
    };
    let mut positions = Vec::new();
    let mut velocities = Vec::new();
    let mut errors = Vec::new();
    for joint in joints.iter().copied() {
        let demanded: Vec<f64> =
            samples.iter().filter_map(|sample| sample.demanded.get(joint)).copied().collect();
        let measured: Vec<f64> =
            samples.iter().filter_map(|sample| sample.measured.get(joint)).copied().collect();
        let start = demanded.first().copied().unwrap_or(0.0);
        let since_start = |values: &[f64]| values.iter().map(|value| value - start).collect();
        positions.push(curve(joint, Some(since_start(&demanded)), since_start(&measured), None));
        let rate = |of: fn(&Rates) -> &[f64]| {
            rates(samples).filter_map(|rates| of(rates).get(joint)).copied().collect()
        };
        let range = history.ranges.get(joint);
        let fastest = range.map(|range| range.speed);
        velocities.push(curve(
            joint,
            Some(rate(|rates| &rates.demanded)),
            rate(|rates| &rates.measured),
            fastest,
        ));
        let following =
            demanded.iter().zip(&measured).map(|(demanded, measured)| demanded - measured).collect();
        let peak = range.map(|range| range.following_error);
        errors.push(curve(joint, None, following, peak));
    }
    let headings = match kind {
        JointKind::Revolute => ["Joint angles since the start", "Joint velocities", "Following errors"],
        JointKind::Prismatic => {
            ["Slides since the start", "Velocities of slides", "Following errors of slides"]
        }
    };
    let least = if joints.iter().any(|i| history.ranges[*i].moved()) { 0.0 } else { PLAY };
    let room = LABEL * joints.len() as f64;
    let chart = |heading: &str, order, height: f64, least, ends, curves| {
        let unit = kind.unit(order);
        let times = match order {
            0 => samples.iter().map(|sample| sample.time).collect(),
            _ => rates(samples).map(|rates| rates.time).collect(),
        };
        Chart {
            heading: heading.to_owned(),
            unit,
            class: "measured",
            height: height.max(room),
            span: Span::WithZero(least),
            ends,
            times,
            curves,
        }
    };
    [
        chart(headings[0], 0, 150.0, least, Ends::Last, positions),
        chart(headings[1], 1, 84.0, least, Ends::Largest, velocities),
        // An error is worth seeing however small it is.
        chart(headings[2], 0, 66.0, 2e-5, Ends::Largest, errors),
    ]
}

/// The speeds of the samples that have some.
fn rates<'a>(samples: &'a [&Sample]) -> impl Iterator<Item = &'a Rates> {
    samples.iter().filter_map(|sample| sample.rates.as_ref())
}

/// How high charts are, one above the other \[px\].
pub(crate) fn height(charts: &[Chart]) -> f64 {
    charts.iter().map(|chart| chart.height + HEADING).sum::<f64>() + TIMES
}

/// How many lines the charts draw.
pub(crate) fn lines(charts: &[Chart]) -> usize {
    charts.iter().flat_map(|chart| &chart.curves).map(|curve| 1 + usize::from(curve.demanded.is_some())).sum()
}
