//! `paths.svg`: the drawing's curves under the executed path, with a magnified view of the worst place.

use crate::deviation::DeviationReport;
use crate::drawing::{Drawing, Vec2};
use crate::placement::Plate;
use crate::trace::{Contact, TracePart};
use std::fmt::Write as _;
use std::path::Path;

/// What the picture shows.
#[derive(Clone, Copy, Debug)]
pub struct PathsSvg<'a> {
    /// The plate.
    pub plate: &'a Plate,
    /// The drawing in plate coordinates.
    pub drawing: &'a Drawing,
    /// The executed path in plate coordinates.
    pub executed: &'a [TracePart],
    /// The measured deviation, whose worst place is magnified.
    pub deviation: &'a DeviationReport,
    /// What was engraved, for the heading.
    pub title: &'a str,
}

/// The most points drawn; the path is thinned until it has fewer: 5 MB at 14 bytes a point, both layers together.
const MOST_POINTS: usize = 150_000;

/// The margin around the plate, the heading, and the panel at its right \[mm\].
const EDGE: f64 = 8.0;
const HEADING: f64 = 14.0;
const PANEL: f64 = 66.0;
/// The panel's height: legend, magnified view, scale and figures \[mm\].
const PANEL_HEIGHT: f64 = 124.0;
/// Width of a character of the heading, on the safe side \[mm\].
const HEADING_CHARACTER: f64 = 3.6;

const DRAWN: &str = "#b9c4d0";
const EXECUTED: &str = "#c8102e";
const TRAVEL: &str = "#2b7a78";

impl PathsSvg<'_> {
    /// The SVG document.
    #[must_use]
    pub fn document(&self) -> String {
        let (w, h) = (self.plate.width, self.plate.height);
        let width = w + PANEL + 3.0 * EDGE;
        let height = (h + HEADING + 2.0 * EDGE + 10.0).max(HEADING + EDGE + PANEL_HEIGHT);
        let room = ((width - 2.0 * EDGE) / HEADING_CHARACTER) as usize;
        let mut out = String::new();
        let _ = write!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}mm\" height=\"{height:.0}mm\" viewBox=\"0 0 {width:.2} {height:.2}\" font-family=\"Helvetica, Arial, sans-serif\">\n\
             <title>{title}</title>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
             <text x=\"{EDGE}\" y=\"11\" font-size=\"5\" font-weight=\"bold\" fill=\"#1b2733\">{title}</text>\n\
             <text x=\"{EDGE}\" y=\"16.5\" font-size=\"3.2\" fill=\"#51606f\">drawn curves and executed tool path, {w:.0} x {h:.0} mm plate</text>\n",
            title = escaped(&shortened(self.title, room))
        );
        let _ = writeln!(out, "<g transform=\"translate({EDGE} {top})\">", top = HEADING + EDGE);
        self.plate_view(&mut out);
        out.push_str("</g>\n");
        let _ = writeln!(out, "<g transform=\"translate({x} {y})\">", x = w + 2.0 * EDGE, y = HEADING + EDGE);
        legend(&mut out);
        self.magnified(&mut out);
        out.push_str("</g>\n</svg>\n");
        out
    }

    /// Writes the document.
    ///
    /// # Errors
    /// What the file system reports.
    pub fn write(&self, path: &Path) -> std::io::Result<()> {
        std::fs::write(path, self.document())
    }

    fn plate_view(&self, out: &mut String) {
        let (w, h, m) = (self.plate.width, self.plate.height, self.plate.margin);
        let page = |p: Vec2| Vec2::new(p.x, h - p.y);
        let _ = writeln!(
            out,
            "<rect width=\"{w}\" height=\"{h}\" rx=\"2\" fill=\"#fbfaf7\" stroke=\"#8a94a0\" stroke-width=\"0.25\"/>"
        );
        let _ = writeln!(
            out,
            "<rect x=\"{m}\" y=\"{m}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#d5d2c8\" stroke-width=\"0.15\" stroke-dasharray=\"1 1\"/>",
            w - 2.0 * m,
            h - 2.0 * m
        );
        let drawn =
            thinned(|tolerance| self.drawing.strokes.iter().map(|s| s.flattened(tolerance)).collect(), 2e-3);
        path(out, &drawn, DRAWN, 0.55, "", page);
        for (contact, colour, width, dash) in [
            (Contact::Travelling, TRAVEL, 0.10, " stroke-dasharray=\"0.8 0.8\""),
            (Contact::Cutting, EXECUTED, 0.12, ""),
        ] {
            let lines: Vec<&[Vec2]> =
                self.executed.iter().filter(|p| p.contact == contact).map(|p| p.points.as_slice()).collect();
            let lines =
                thinned(|tolerance| lines.iter().map(|line| skipping(line, tolerance)).collect(), 0.0);
            path(out, &lines, colour, width, dash, page);
        }
        let bar = if w >= 100.0 { 50.0 } else { 10.0 };
        let y = h + 5.0;
        let _ = writeln!(
            out,
            "<path d=\"M0 {a}V{b}M0 {y}H{bar}M{bar} {a}V{b}\" stroke=\"#1b2733\" stroke-width=\"0.3\" fill=\"none\"/>\
             <text x=\"{x}\" y=\"{t}\" font-size=\"3.2\" fill=\"#1b2733\">{bar:.0} mm</text>",
            a = y - 1.0,
            b = y + 1.0,
            x = bar + 2.0,
            t = y + 1.1
        );
        if let Some(worst) = self.deviation.worst {
            let p = page(worst.position);
            let _ = writeln!(
                out,
                "<circle cx=\"{:.3}\" cy=\"{:.3}\" r=\"1.8\" fill=\"none\" stroke=\"#1b2733\" stroke-width=\"0.3\"/>",
                p.x, p.y
            );
        }
    }

    /// The worst place, so large that its deviation is seen.
    fn magnified(&self, out: &mut String) {
        const SIDE: f64 = 62.0;
        const TOP: f64 = 34.0;
        let Some(worst) = self.deviation.worst else { return };
        // The deviation takes an eighth of the window, which shows from 0.05 to 20 mm.
        let window = (worst.distance * 8.0).clamp(0.05, 20.0);
        let zoom = SIDE / window;
        let corner = worst.position - Vec2::new(window, window) * 0.5;
        let page = |p: Vec2| Vec2::new((p.x - corner.x) * zoom, SIDE - (p.y - corner.y) * zoom);
        let near = |line: &[Vec2]| within(line, worst.position, window);
        let _ = writeln!(
            out,
            "<text y=\"{}\" font-size=\"3.4\" font-weight=\"bold\" fill=\"#1b2733\">worst place, {zoom:.0} x magnified</text>",
            TOP - 2.5
        );
        let _ = writeln!(
            out,
            "<svg y=\"{TOP}\" width=\"{SIDE}\" height=\"{SIDE}\" viewBox=\"0 0 {SIDE} {SIDE}\"><rect width=\"{SIDE}\" height=\"{SIDE}\" fill=\"#fbfaf7\"/>"
        );
        let fine = (window / 2000.0).max(1e-5);
        let drawn: Vec<Vec<Vec2>> =
            self.drawing.strokes.iter().flat_map(|s| near(&s.flattened(fine))).collect();
        path(out, &drawn, DRAWN, 1.6, "", page);
        let executed: Vec<Vec<Vec2>> = self
            .executed
            .iter()
            .filter(|part| part.contact == Contact::Cutting)
            .flat_map(|part| near(&part.points))
            .collect();
        path(out, &executed, EXECUTED, 0.5, "", page);
        let _ = writeln!(
            out,
            "<circle cx=\"{c}\" cy=\"{c}\" r=\"1.3\" fill=\"none\" stroke=\"#1b2733\" stroke-width=\"0.35\"/></svg>",
            c = SIDE / 2.0
        );
        let _ = writeln!(
            out,
            "<rect y=\"{TOP}\" width=\"{SIDE}\" height=\"{SIDE}\" fill=\"none\" stroke=\"#1b2733\" stroke-width=\"0.3\"/>"
        );
        let bar = SIDE / 8.0;
        let y = TOP + SIDE + 4.5;
        let _ = writeln!(
            out,
            "<path d=\"M0 {y}h{bar}m0 -1v2M0 {a}v2\" stroke=\"#1b2733\" stroke-width=\"0.3\" fill=\"none\"/>\
             <text x=\"{x}\" y=\"{t}\" font-size=\"3.2\" fill=\"#1b2733\">{:.1} µm</text>",
            window / 8.0 * 1e3,
            a = y - 1.0,
            x = bar + 2.0,
            t = y + 1.1
        );
        for (line, text) in [
            format!("largest deviation {:.2} µm", worst.distance * 1e3),
            format!("{} points measured", self.deviation.points),
            format!("root mean square {:.2} µm", self.deviation.rms * 1e3),
            format!("at x {:.2}, y {:.2} mm", worst.position.x, worst.position.y),
        ]
        .iter()
        .enumerate()
        {
            let y = y + 7.0 + line as f64 * 4.6;
            let _ = writeln!(out, "<text y=\"{y:.1}\" font-size=\"3.2\" fill=\"#1b2733\">{text}</text>");
        }
    }
}

fn legend(out: &mut String) {
    for (row, (colour, width, dash, text)) in [
        (DRAWN, 1.2, "", "drawn: exact curves of the file"),
        (EXECUTED, 0.4, "", "executed: tool tip in the material"),
        (TRAVEL, 0.3, " stroke-dasharray=\"1.6 1.2\"", "travel: tool lifted"),
    ]
    .iter()
    .enumerate()
    {
        let y = 2.0 + row as f64 * 6.0;
        let _ = writeln!(
            out,
            "<path d=\"M0 {y}H12\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>\
             <text x=\"15\" y=\"{t}\" font-size=\"3.2\" fill=\"#1b2733\">{text}</text>",
            t = y + 1.1
        );
    }
}

/// One path element over many lines.
fn path(
    out: &mut String,
    lines: &[Vec<Vec2>],
    colour: &str,
    width: f64,
    dash: &str,
    page: impl Fn(Vec2) -> Vec2,
) {
    if lines.is_empty() {
        return;
    }
    let _ = write!(
        out,
        "<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linecap=\"round\" stroke-linejoin=\"round\"{dash} d=\""
    );
    for line in lines {
        for (i, p) in line.iter().enumerate() {
            let p = page(*p);
            let letter = if i == 0 { 'M' } else { 'L' };
            let _ = write!(out, "{letter}{:.3} {:.3}", p.x, p.y);
        }
    }
    out.push_str("\"/>\n");
}

/// Lines at the finest tolerance, doubled from `first`, at which they have few enough points.
fn thinned(at: impl Fn(f64) -> Vec<Vec<Vec2>>, first: f64) -> Vec<Vec<Vec2>> {
    let mut tolerance = first;
    for _ in 0..16 {
        let lines = at(tolerance);
        if lines.iter().map(Vec::len).sum::<usize>() <= MOST_POINTS {
            return lines;
        }
        tolerance = (tolerance * 2.0).max(0.02);
    }
    at(tolerance)
}

/// A line without the points that are nearer than `distance` to the one before; its ends stay.
fn skipping(line: &[Vec2], distance: f64) -> Vec<Vec2> {
    let mut kept: Vec<Vec2> = Vec::new();
    for (i, p) in line.iter().enumerate() {
        if i + 1 == line.len() || kept.last().is_none_or(|last| (p - last).norm() > distance) {
            kept.push(*p);
        }
    }
    kept
}

/// The parts of a line whose segments come near a square window.
fn within(line: &[Vec2], centre: Vec2, window: f64) -> Vec<Vec<Vec2>> {
    let mut parts: Vec<Vec<Vec2>> = Vec::new();
    let mut open = false;
    for w in line.windows(2) {
        let (low, high) = (w[0].inf(&w[1]) - centre, w[0].sup(&w[1]) - centre);
        let inside = low.x < window && low.y < window && high.x > -window && high.y > -window;
        match (inside, open, parts.last_mut()) {
            (true, true, Some(part)) => part.push(w[1]),
            (true, _, _) => parts.push(vec![w[0], w[1]]),
            (false, _, _) => {}
        }
        open = inside;
    }
    parts
}

/// A text of at most `room` characters; what does not fit becomes an ellipsis.
fn shortened(text: &str, room: usize) -> String {
    if text.chars().count() <= room {
        return text.to_owned();
    }
    text.chars().take(room.saturating_sub(1)).chain(['…']).collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace(|c: char| c.is_control(), " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deviation::{Corners, Deviation};
    use crate::drawing::{EllipticalArc, Piece, Stroke};
    use crate::plate::Tip;
    use crate::sampling::Sampling;
    use crate::trace::Trace;

    #[test]
    fn the_document_is_well_formed_and_says_the_worst_deviation() {
        let arc = EllipticalArc::circular(Vec2::new(50.0, 50.0), 20.0, 0.0, 6.0);
        let drawing = Drawing { strokes: vec![Stroke::new(vec![Piece::Arc(arc)]).unwrap()] };
        let mut deviation = Deviation::new(&drawing, &Sampling::default(), Corners::Counted);
        let mut trace = Trace::new(5e-4);
        trace.move_to(Tip::new(0.0, 0.0, 5.0));
        trace.move_to(Tip::new(70.0, 50.0, 5.0));
        deviation.begin_stroke(0);
        for k in 0..=3000 {
            let t = f64::from(k) / 3000.0;
            let p = arc.point(t) * (1.0 + 1e-4 * (t * 40.0).sin());
            deviation.observe(p, 0.0);
            trace.move_to(Tip::new(p.x, p.y, -0.3));
        }
        let report = deviation.report();
        let parts = trace.parts();
        let svg = PathsSvg {
            plate: &Plate::default(),
            drawing: &drawing,
            executed: &parts,
            deviation: &report,
            title: "a <b> & c",
        };
        let text = svg.document();
        let document = roxmltree::Document::parse(&text).unwrap();
        assert_eq!(document.root_element().tag_name().name(), "svg");
        assert!(text.contains("a &lt;b&gt; &amp; c"));
        assert!(text.contains(&format!("largest deviation {:.2} µm", report.max * 1e3)));
        assert!(text.len() < 500_000);
    }
}
