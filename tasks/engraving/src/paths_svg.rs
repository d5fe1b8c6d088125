//! `paths.svg`: the drawing's curves under the executed path, with a magnified view of the worst place.

use crate::deviation::DeviationReport;
use crate::drawing::{Drawing, Vec2};
use crate::placement::Plate;
use crate::trace::{Contact, TracePart};
use mrroc_pictures::svg::palette::{GREY, HIGHLIGHT, INK, PALE, RULE, joint};
use mrroc_pictures::svg::{Area, Colour, Look, Page, Svg, TextStyle, shortened};
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

/// A stroke that is smaller than this, seen from above, is a hole and drawn as a ring \[mm\].
const HOLE: f64 = 0.05;

/// Colours of the three kinds of line.
const DRAWN: Colour = RULE;
const EXECUTED: Colour = HIGHLIGHT;

fn travel() -> Colour {
    joint(2)
}

/// Text beside lines.
fn small() -> TextStyle {
    TextStyle::new(3.2, INK)
}

impl PathsSvg<'_> {
    /// The SVG document.
    #[must_use]
    pub fn document(&self) -> String {
        let Plate { width, height, .. } = *self.plate;
        let page_width = width + PANEL + 3.0 * EDGE;
        let page_height = (height + HEADING + 2.0 * EDGE + 10.0).max(HEADING + EDGE + PANEL_HEIGHT);
        let room = ((page_width - 2.0 * EDGE) / HEADING_CHARACTER) as usize;
        let title = shortened(self.title, room);
        let subtitle = format!("drawn curves and executed tool path, {width:.0} x {height:.0} mm plate");
        Page::new(&title, page_width, page_height).in_millimetres().draw(|svg| {
            svg.text(Vec2::new(EDGE, 11.0), TextStyle::new(5.0, INK).bold(), &title);
            svg.text(Vec2::new(EDGE, 16.5), small().colour(GREY), &subtitle);
            svg.moved(Vec2::new(EDGE, HEADING + EDGE), |svg| self.draw_plate(svg));
            svg.moved(Vec2::new(width + 2.0 * EDGE, HEADING + EDGE), |svg| {
                draw_legend(svg);
                self.draw_worst_place(svg);
            });
        })
    }

    /// Writes the document.
    ///
    /// # Errors
    /// What the file system reports.
    pub fn write(&self, path: &Path) -> std::io::Result<()> {
        std::fs::write(path, self.document())
    }

    fn draw_plate(&self, svg: &mut Svg) {
        let Plate { width, height, margin, .. } = *self.plate;
        let page = |p: &Vec2| Vec2::new(p.x, height - p.y);
        let plate = Area { x: 0.0, y: 0.0, width, height };
        svg.rectangle(plate, 2.0, Look::filled(PALE).stroke(RULE).width(0.25));
        let look = Look::line(RULE, 0.15).dashed(1.0, 1.0);
        svg.rectangle(plate.inset(margin, margin, margin, margin), 0.0, look);
        let strokes = &self.drawing.strokes;
        let drawn = thinned(|tolerance| strokes.iter().map(|s| s.flattened(tolerance)).collect(), 2e-3);
        svg.path(&placed(&drawn, page), Look::line(DRAWN, 0.55).round());
        for hole in strokes.iter().filter(|stroke| stroke.bounds().size().amax() < HOLE) {
            svg.circle(page(&hole.start()), 0.9, Look::line(DRAWN, 0.55));
        }
        for (contact, look) in [
            (Contact::Travelling, Look::line(travel(), 0.1).dashed(0.8, 0.8)),
            (Contact::Cutting, Look::line(EXECUTED, 0.12)),
        ] {
            let lines: Vec<&[Vec2]> =
                self.executed.iter().filter(|p| p.contact == contact).map(|p| p.points.as_slice()).collect();
            let lines =
                thinned(|tolerance| lines.iter().map(|line| skipping(line, tolerance)).collect(), 0.0);
            svg.path(&placed(&lines, page), look.round());
        }
        let bar = if width >= 100.0 { 50.0 } else { 10.0 };
        draw_scale(svg, Vec2::new(0.0, height + 5.0), bar, &format!("{bar:.0} mm"));
        if let Some(worst) = self.deviation.worst {
            svg.circle(page(&worst.position.xy()), 1.8, Look::line(INK, 0.3));
        }
    }

    /// The worst place, so large that its deviation is seen.
    fn draw_worst_place(&self, svg: &mut Svg) {
        const SIDE: f64 = 62.0;
        const TOP: f64 = 34.0;
        let Some(worst) = self.deviation.worst else { return };
        // The deviation takes an eighth of the window, which shows from 0.05 to 20 mm.
        let window = (worst.distance * 8.0).clamp(0.05, 20.0);
        let zoom = SIDE / window;
        let corner = worst.position.xy() - Vec2::new(window, window) * 0.5;
        let page = |p: &Vec2| Vec2::new((p.x - corner.x) * zoom, SIDE - (p.y - corner.y) * zoom);
        let near = |line: &[Vec2]| within(line, worst.position.xy(), window);
        let heading = format!("worst place, {zoom:.0} x magnified");
        svg.text(Vec2::new(0.0, TOP - 2.5), TextStyle::new(3.4, INK).bold(), &heading);
        let area = Area { x: 0.0, y: TOP, width: SIDE, height: SIDE };
        svg.rectangle(area, 0.0, Look::filled(PALE));
        let fine = (window / 2000.0).max(1e-5);
        let drawn: Vec<Vec<Vec2>> =
            self.drawing.strokes.iter().flat_map(|s| near(&s.flattened(fine))).collect();
        let cut = self.executed.iter().filter(|part| part.contact == Contact::Cutting);
        let executed: Vec<Vec<Vec2>> = cut.flat_map(|part| near(&part.points)).collect();
        svg.window(area, |svg| {
            svg.path(&placed(&drawn, page), Look::line(DRAWN, 1.6).round());
            svg.path(&placed(&executed, page), Look::line(EXECUTED, 0.5).round());
            svg.circle(Vec2::new(0.5 * SIDE, 0.5 * SIDE), 1.3, Look::line(INK, 0.35));
        });
        svg.rectangle(area, 0.0, Look::line(INK, 0.3));
        let below = Vec2::new(0.0, TOP + SIDE + 4.5);
        draw_scale(svg, below, SIDE / 8.0, &format!("{:.1} µm", window / 8.0 * 1e3));
        let figures = [
            format!("largest deviation {:.2} µm", worst.distance * 1e3),
            format!("{} points measured", self.deviation.points),
            format!("root mean square {:.2} µm", self.deviation.rms * 1e3),
            format!("at x {:.2}, y {:.2} mm", worst.position.x, worst.position.y),
        ];
        for (line, text) in figures.iter().enumerate() {
            svg.text(below + Vec2::new(0.0, 7.0 + line as f64 * 4.6), small(), text);
        }
    }
}

/// A bar of a length \[mm\] on the page, and what length it stands for.
fn draw_scale(svg: &mut Svg, left: Vec2, length: f64, text: &str) {
    let right = left + Vec2::new(length, 0.0);
    let tick = Vec2::new(0.0, 1.0);
    let bar = [[left - tick, left + tick], [left, right], [right - tick, right + tick]];
    svg.path(&bar, Look::line(INK, 0.3));
    svg.text(right + Vec2::new(2.0, 1.1), small(), text);
}

fn draw_legend(svg: &mut Svg) {
    let rows = [
        (Look::line(DRAWN, 1.2), "drawn: exact curves of the file"),
        (Look::line(EXECUTED, 0.4), "executed: tool tip in the material"),
        (Look::line(travel(), 0.3).dashed(1.6, 1.2), "travel: tool lifted"),
    ];
    for (row, (look, text)) in rows.into_iter().enumerate() {
        let left = Vec2::new(0.0, 2.0 + row as f64 * 6.0);
        svg.line(left, left + Vec2::new(12.0, 0.0), look);
        svg.text(left + Vec2::new(15.0, 1.1), small(), text);
    }
}

/// Lines where they are on the page.
fn placed(lines: &[Vec<Vec2>], page: impl Fn(&Vec2) -> Vec2) -> Vec<Vec<Vec2>> {
    lines.iter().map(|line| line.iter().map(&page).collect()).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deviation::{Corners, Deviation};
    use crate::drawing::{EllipticalArc, Piece, Stroke, Vec3};
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
        deviation.begin_stroke(0, 0.0);
        for k in 0..=3000 {
            let t = f64::from(k) / 3000.0;
            let p = arc.point(t) * (1.0 + 1e-4 * (t * 40.0).sin());
            deviation.observe(Vec3::new(p.x, p.y, 0.0));
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
