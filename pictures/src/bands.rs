//! Bands below a time axis: the Moves and Waits of programs, each with its generator or condition, and suspensions.
//!
//! In: spans of time. Out: a row of bands for each program. What is too narrow for its words goes without them, or together
//! with its neighbours; in a browser every band tells itself when it is pointed at.

use mrroc::operator::state::InstructionKind;
use nalgebra::Vector2;

use crate::instructions::{Log, Span};
use crate::states::Spell;
use crate::svg::palette::{GREY, GRID, INK, REGION, RULE};
use crate::svg::{Area, Axis, Colour, Look, Range, Svg, TextStyle, shortened};

/// Height of a row, and of its bands \[px\].
const ROW: f64 = 16.0;
const BAND: f64 = 12.5;

/// Room above the first row \[px\].
const GAP: f64 = 24.0;

/// Width below which a band goes together with neighbours that are as narrow, and the gap that is then left out \[px\].
const NARROW: f64 = 12.0;
const CLOSE: f64 = 1.5;

/// Height of the words, and the width of one letter with some room \[px\].
const WORDS: f64 = 10.0;
const LETTER: f64 = 5.9;

/// What is on, and what was on and off too often to be told apart.
const ON: Colour = Colour::hex(0x4c9a77);
const SEVERAL: Colour = Colour::hex(0xa9cfbd);

/// Letters of a name at the right end of a row.
const NAME: usize = 16;

/// The ground of Waits.
const WAITING: Colour = Colour::hex(0xf5e3bd);

/// A row of bands.
#[derive(Clone, Debug)]
pub(crate) enum Row {
    /// When the operator had suspended the cell \[s\].
    Suspensions(Vec<Range>),
    /// What a program did, and who it is.
    Program(&'static str, Vec<Span>),
    /// A state over time: where it comes from, its name, the names of what it may be unless it is on or off.
    States { side: &'static str, name: String, names: Option<Vec<&'static str>>, spells: Vec<Spell> },
}

struct Band {
    time: Range,
    colour: Colour,
    /// What may be written in it, the longest first.
    words: Vec<String>,
}

/// The rows below the time axis of a robot: suspensions, what the MP did, what the robot's own program did; of those only
/// what there was.
pub(crate) fn rows(mp: &Log, ecp: &Log) -> Vec<Row> {
    let mut rows = Vec::new();
    if !mp.suspensions().is_empty() {
        rows.push(Row::Suspensions(mp.suspensions().to_vec()));
    }
    for (label, log) in [("MP", mp), ("ECP", ecp)] {
        if !log.spans().is_empty() {
            rows.push(Row::Program(label, log.spans().to_vec()));
        }
    }
    rows
}

impl Row {
    fn label(&self) -> &'static str {
        match self {
            Row::Suspensions(_) => "operator",
            Row::Program(label, _) => label,
            Row::States { side, .. } => side,
        }
    }

    fn bands(&self, time: &Axis) -> Vec<Band> {
        match self {
            Row::Suspensions(times) => {
                let suspended =
                    |time: &Range| Band { time: *time, colour: RULE, words: vec!["suspended".to_owned()] };
                times.iter().map(suspended).collect()
            }
            Row::Program(_, spans) => joined(time, spans).iter().map(band).collect(),
            Row::States { name, names, spells, .. } => {
                spells.iter().filter_map(|spell| state(spell, name, names.as_deref())).collect()
            }
        }
    }
}

/// How high rows are \[px\].
pub(crate) fn height(rows: usize) -> f64 {
    if rows == 0 { 0.0 } else { ROW * rows as f64 + 4.0 }
}

fn band(span: &Span) -> Band {
    let (word, colour) = match span.doing {
        Some(InstructionKind::Wait) => ("Wait", WAITING),
        Some(InstructionKind::Move) => ("Move", REGION),
        Some(InstructionKind::Nothing | InstructionKind::Homing) | None => ("instructions", GRID),
    };
    let words = match (&span.by, span.count) {
        (Some(by), 1) => vec![format!("{word} {by}"), by.clone()],
        (Some(by), n) => vec![format!("{n} × {word} {by}"), format!("{n} × {by}"), format!("{n} ×")],
        (None, n) if span.doing.is_some() => vec![format!("{n} {word}s"), format!("{n} ×")],
        (None, n) => vec![format!("{n} {word}"), format!("{n} ×")],
    };
    Band { time: span.time, colour, words }
}

/// A state that is not off.
fn state(spell: &Spell, name: &str, names: Option<&[&'static str]>) -> Option<Band> {
    let band = |colour, words: String| Some(Band { time: spell.time, colour, words: vec![words] });
    match (spell.state, names) {
        (Some(0), None) => None,
        (Some(_), None) => band(ON, format!("{name} on")),
        (Some(place), Some(names)) => {
            let named = usize::try_from(place).ok().and_then(|place| names.get(place));
            band(REGION, (*named.unwrap_or(&"unknown")).to_owned())
        }
        (None, _) => band(SEVERAL, format!("{} changes", spell.count)),
    }
}

/// Spans with narrow neighbours that touch as one: none of them could be told from the next.
fn joined(time: &Axis, spans: &[Span]) -> Vec<Span> {
    let width = |span: &Span| time.at(span.time.high) - time.at(span.time.low);
    let mut joined: Vec<Span> = Vec::new();
    let mut last_is_narrow = false;
    for span in spans {
        let is_narrow = width(span) < NARROW;
        match joined.last_mut() {
            Some(last)
                if is_narrow
                    && last_is_narrow
                    && time.at(span.time.low) - time.at(last.time.high) < CLOSE =>
            {
                *last = last.with(span);
            }
            _ => joined.push(span.clone()),
        }
        last_is_narrow = is_narrow;
    }
    joined
}

fn when(time: Range) -> String {
    format!("{:.3} s to {:.3} s", time.low, time.high)
}

/// Shades what was suspended, over the height of some charts.
pub(crate) fn shade(svg: &mut Svg, time: &Axis, suspensions: &[Range], area: Area) {
    for suspension in suspensions {
        let (from, to) = (time.at(suspension.low).max(area.x), time.at(suspension.high).min(area.right()));
        let shaded = Area { x: from, width: (to - from).max(1.0), ..area };
        svg.rectangle(shaded, 0.0, Look::filled(GRID).fill_opacity(0.6).class("suspended"));
    }
}

/// Draws the rows below a time axis whose frames end at `bottom` \[px\]; their labels end at the left end of the axis.
pub(crate) fn draw(svg: &mut Svg, time: &Axis, across: Range, bottom: f64, rows: &[Row]) {
    for (i, row) in rows.iter().enumerate() {
        let y = bottom + GAP + ROW * i as f64;
        let left = Vector2::new(across.low - 6.0, y + 9.5);
        svg.text(left, TextStyle::new(WORDS, GREY).end(), row.label());
        if let Row::States { name, spells, .. } = row {
            let right = Vector2::new(across.high + 6.0, y + 9.5);
            svg.text(right, TextStyle::new(WORDS, INK), &shortened(name, NAME));
            known(svg, time, across, y + BAND, spells);
        }
        let class = if matches!(row, Row::States { .. }) { "state" } else { "band" };
        for band in row.bands(time) {
            let (from, to) =
                (time.at(band.time.low).max(across.low), time.at(band.time.high).min(across.high));
            let area = Area { x: from, y, width: (to - from).max(0.75), height: BAND };
            let look = Look::filled(band.colour).stroke(RULE).width(0.5).class(class);
            svg.explained(&format!("{}, {}", band.words[0], when(band.time)), |svg| {
                svg.rectangle(area, 1.5, look);
            });
            if band.colour != ON
                && let Some(words) = fitting(&band.words, area.width)
            {
                let at = Vector2::new(area.x + 0.5 * area.width, y + 9.5);
                svg.text(at, TextStyle::new(WORDS, INK).middle().class("words"), &words);
            }
        }
    }
}

/// A line where a state is known, at the height of `y` \[px\]: where there is no bar on it, it is off.
fn known(svg: &mut Svg, time: &Axis, across: Range, y: f64, spells: &[Spell]) {
    let mut lines: Vec<Range> = Vec::new();
    for spell in spells {
        match lines.last_mut() {
            Some(last) if spell.time.low <= last.high => last.high = spell.time.high,
            _ => lines.push(spell.time),
        }
    }
    for line in lines {
        let at = |value: f64| Vector2::new(time.at(value).clamp(across.low, across.high), y);
        svg.line(at(line.low), at(line.high), Look::new().stroke(RULE).width(1.0).class("known"));
    }
}

/// The first of some words that has room, or the last one as far as some letters of it have.
fn fitting(words: &[String], width: f64) -> Option<String> {
    let room = (width / LETTER) as usize;
    let whole = words.iter().find(|words| words.chars().count() <= room).cloned();
    whole.or_else(|| {
        let name = words.last().filter(|name| room >= 4 && !name.ends_with('×'))?;
        Some(shortened(name, room))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(low: f64, high: f64, doing: InstructionKind, by: &str) -> Span {
        Span { time: Range { low, high }, count: 1, doing: Some(doing), by: Some(by.to_owned()) }
    }

    #[test]
    fn narrow_neighbours_are_one_band_and_wide_ones_stay_their_own() {
        // 10 px a second.
        let time = Axis::new(Range { low: 0.0, high: 100.0 }, 50.0, 1050.0);
        let mut spans = vec![span(0.0, 10.0, InstructionKind::Move, "Line")];
        spans.extend((0..20).map(|i| {
            span(10.0 + 0.5 * f64::from(i), 10.5 + 0.5 * f64::from(i), InstructionKind::Move, "Arc")
        }));
        spans.push(span(20.0, 60.0, InstructionKind::Wait, "Dwell"));
        // Narrow ones with a gap between them.
        spans.push(span(70.0, 70.5, InstructionKind::Move, "Line"));
        spans.push(span(75.0, 75.5, InstructionKind::Wait, "Dwell"));
        spans.push(span(75.5, 76.0, InstructionKind::Move, "Line"));
        let joined = joined(&time, &spans);
        let counts: Vec<_> = joined.iter().map(|span| span.count).collect();
        assert_eq!(counts, [1, 20, 1, 1, 2]);
        assert_eq!(
            (joined[1].by.as_deref(), joined[4].by.as_deref(), joined[4].doing),
            (Some("Arc"), None, None)
        );
        let words: Vec<_> = joined.iter().map(|span| band(span).words[0].clone()).collect();
        assert_eq!(words, ["Move Line", "20 × Move Arc", "Wait Dwell", "Move Line", "2 instructions"]);
    }

    #[test]
    fn words_are_as_long_as_their_band_or_left_out() {
        let words = ["Wait ForceAbove".to_owned(), "ForceAbove".to_owned()];
        let fit = |letters: f64| fitting(&words, letters * LETTER + 0.1);
        assert_eq!(fit(15.0).as_deref(), Some("Wait ForceAbove"));
        assert_eq!(fit(14.0).as_deref(), Some("ForceAbove"));
        assert_eq!(fit(6.0).as_deref(), Some("Force…"));
        assert_eq!(fit(3.0), None);
        // A number says nothing when it is cut.
        assert_eq!(fitting(&["1234 ×".to_owned()], 5.0 * LETTER), None);
    }
}
