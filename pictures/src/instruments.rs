//! Panels of what is no robot's own motion: the rate of path time, and the readings of each sensor.
//!
//! In: what was seen. Out: for each panel its charts and rows over time, and a table of its numbers.

use nalgebra::Vector2;

use crate::bands::{self, Row};
use crate::chart::{self, Chart, Curve, Ends, LABEL, Span};
use crate::instructions::Log;
use crate::panel;
use crate::seen::{Reader, RobotSight, SensorSight, Sights};
use crate::svg::palette::{self, GREY, GRID, INK};
use crate::svg::{Area, Look, Range, Svg, TextStyle, shortened};
use crate::track::Track;
use crate::wording::{duration, figure};

/// Height of a row of the table, and of what is above it \[px\].
const ROW: f64 = 17.0;
const TABLE: f64 = 62.0;

/// Height of a chart of readings, and of the rate's \[px\].
const READINGS: f64 = 84.0;
const RATE: f64 = 56.0;

/// The most rows of a table.
const MOST_ROWS: usize = 40;

/// A panel.
pub(crate) struct Instrument {
    name: String,
    caption: String,
    pub charts: Vec<Chart>,
    pub rows: Vec<Row>,
    table: Vec<TableRow>,
}

/// The least, the greatest and the last value of a number.
struct TableRow {
    label: String,
    range: Option<Range>,
    last: Option<f64>,
}

/// All panels of a run: the rate, and the sensors in the order of the cell; none of a run without a step.
pub(crate) fn instruments(sights: &Sights, mp: &Log) -> Vec<Instrument> {
    if sights.rate.is_empty() {
        return Vec::new();
    }
    let sensors = sights.sensors.iter().map(|sensor| of_sensor(sensor, mp));
    [of_rate(sights, mp)].into_iter().chain(sensors).collect()
}

fn of_rate(sights: &Sights, mp: &Log) -> Instrument {
    let lines = sights.rate.lines(&[0, 1]);
    let mut values = lines.values.into_iter();
    let (rate, speed) = (values.next().unwrap_or_default(), values.next());
    let curve = Curve { colour: INK, demanded: speed, measured: rate, label: "rate".to_owned(), peak: None };
    let chart = Chart {
        heading: "Rate of path time".to_owned(),
        unit: "1",
        class: "rate",
        height: RATE,
        span: Span::Fixed(Range { low: 0.0, high: 1.0 }),
        ends: Ends::Last,
        times: lines.times,
        curves: vec![curve],
    };
    Instrument {
        name: "path".to_owned(),
        caption: format!(
            "steps of {} · thick: in force, 1 is as planned · thin: as the operator wants it",
            duration(sights.step)
        ),
        charts: vec![chart],
        rows: bands::rows(mp, &Log::default()),
        table: vec![row("rate", &sights.rate, 0), row("wanted", &sights.rate, 1)],
    }
}

fn of_sensor(sensor: &SensorSight, mp: &Log) -> Instrument {
    let mut charts = Vec::new();
    let mut table = Vec::new();
    let mut first = 0;
    for group in &sensor.quantities.groups {
        let places: Vec<usize> = (first..first + group.numbers.len()).collect();
        first += group.numbers.len();
        let lines = sensor.readings.lines(&places);
        let peak =
            |place: usize| sensor.readings.range(place).map(|range| range.low.abs().max(range.high.abs()));
        let curve = |(i, (values, place)): (usize, (Vec<f64>, &usize))| Curve {
            colour: palette::joint(i),
            demanded: None,
            measured: values,
            label: group.numbers[i].label.clone(),
            peak: peak(*place),
        };
        let curves: Vec<Curve> = lines.values.into_iter().zip(&places).enumerate().map(curve).collect();
        let room = LABEL * curves.len() as f64;
        for (number, place) in group.numbers.iter().zip(&places) {
            let label = match number.label.as_str() {
                "value" => group.heading.clone(),
                label => format!("{} {label}", group.heading),
            };
            table.push(row(&label, &sensor.readings, *place));
        }
        charts.push(Chart {
            heading: group.heading.clone(),
            unit: group.unit,
            class: "reading",
            height: READINGS.max(room),
            span: Span::Values,
            ends: Ends::Largest,
            times: lines.times,
            curves,
        });
    }
    let states = sensor.quantities.choices.iter().zip(sensor.states());
    let mut rows: Vec<Row> = states
        .map(|(choice, states)| Row::States {
            side: "state",
            name: choice.label.clone(),
            names: choice.names.clone(),
            spells: states.spells().to_vec(),
        })
        .collect();
    rows.extend(bands::rows(mp, &Log::default()));
    if charts.is_empty() {
        // Its rows need a time axis.
        charts.push(Chart::empty("No numbers that can be drawn"));
    }
    table.truncate(MOST_ROWS);
    Instrument { name: sensor.name.clone(), caption: caption(sensor), charts, rows, table }
}

/// Kind, robot, and in how many steps it was read, in words.
fn caption(sensor: &SensorSight) -> String {
    let mut parts = vec![sensor.kind.to_owned()];
    parts.extend(sensor.of.as_ref().map(|robot| format!("of {robot}")));
    let readers: Vec<&Reader> =
        sensor.readers.iter().filter(|reader| reader.read + reader.missed > 0).collect();
    parts.extend(readers.iter().map(|reader| {
        let by = if readers.len() > 1 { format!(" by {}", reader.process) } else { String::new() };
        let read = match reader.read {
            0 => "never read".to_owned(),
            n => format!("read in {}", counted(n, "step", "steps")),
        };
        let missed = match reader.missed {
            0 => String::new(),
            n => format!(", no reading in {}", counted(n, "step that asked", "steps that asked")),
        };
        format!("{read}{by}{missed}")
    }));
    if readers.is_empty() {
        parts.push("never read".to_owned());
    }
    if sensor.quantities.undrawn > 0 {
        parts.push(format!("{} not drawn", counted(sensor.quantities.undrawn as u64, "word", "words")));
    }
    parts.join(" · ")
}

fn counted(n: u64, one: &str, more: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { more })
}

fn row(label: &str, track: &Track, place: usize) -> TableRow {
    TableRow { label: label.to_owned(), range: track.range(place), last: track.last(place) }
}

/// The charts of a robot's analog inputs and outputs: one for each, because their drivers state their units.
pub(crate) fn analog(robot: &RobotSight) -> impl Iterator<Item = Chart> + '_ {
    robot.analog.iter().enumerate().map(|(i, signal)| {
        let lines = robot.levels.lines(&[i]);
        let curve = |values| Curve {
            colour: palette::joint(i),
            demanded: None,
            measured: values,
            label: if signal.is_output { "output" } else { "input" }.to_owned(),
            peak: robot.levels.range(i).map(|range| range.low.abs().max(range.high.abs())),
        };
        Chart {
            heading: signal.name.clone(),
            unit: "",
            class: "signal",
            height: RATE,
            span: Span::Values,
            ends: Ends::Largest,
            times: lines.times,
            curves: lines.values.into_iter().map(curve).collect(),
        }
    })
}

/// The rows of a robot's digital inputs and outputs.
pub(crate) fn digital(robot: &RobotSight) -> impl Iterator<Item = Row> + '_ {
    robot.digital.iter().map(|(signal, states)| Row::States {
        side: if signal.is_output { "output" } else { "input" },
        name: signal.name.clone(),
        names: None,
        spells: states.spells().to_vec(),
    })
}

impl Instrument {
    /// How high its panel is \[px\].
    pub fn height(&self) -> f64 {
        let charts = chart::height(&self.charts) + bands::height(self.rows.len());
        42.0 + charts.max(TABLE - 42.0 + ROW * (self.table.len() as f64 + 1.0) + 10.0)
    }

    /// Draws its panel without what is over time; its table is so wide \[px\].
    pub fn draw(&self, svg: &mut Svg, area: Area, width: f64) {
        panel::ground(svg, area);
        let bar = Area { x: area.x + 16.0, y: area.y + 14.0, width: 4.0, height: 18.0 };
        svg.rectangle(bar, 2.0, Look::filled(GREY));
        let name = shortened(&self.name, 32);
        svg.text(Vector2::new(area.x + 28.0, area.y + 28.0), TextStyle::new(15.0, INK).bold(), &name);
        let at = Vector2::new(area.x + width + 86.0, area.y + 28.0);
        svg.text(at, TextStyle::new(12.5, GREY), &shortened(&self.caption, 118));
        if !self.table.is_empty() {
            self.draw_table(svg, Area { x: area.x + 20.0, y: area.y + TABLE, width, height: 0.0 });
        }
    }

    fn draw_table(&self, svg: &mut Svg, area: Area) {
        let left = TextStyle::new(11.0, GREY);
        let columns = [0.60, 0.80, 1.0].map(|share| area.x + share * area.width);
        for (x, text) in columns.iter().zip(["least", "greatest", "end"]) {
            svg.text(Vector2::new(*x, area.y), left.end(), text);
        }
        let rule = Vector2::new(area.x, area.y + 5.0);
        svg.line(rule, rule + Vector2::new(area.width, 0.0), Look::new().stroke(GRID));
        for (i, row) in self.table.iter().enumerate() {
            let y = area.y + ROW * (i as f64 + 1.0);
            svg.text(Vector2::new(area.x, y), left.colour(INK), &shortened(&row.label, 18));
            let values = [row.range.map(|range| range.low), row.range.map(|range| range.high), row.last];
            for (x, value) in columns.iter().zip(values) {
                let text = value.map_or_else(|| "–".to_owned(), figure);
                svg.text(Vector2::new(*x, y), left.end().colour(INK), &text);
            }
        }
    }
}
