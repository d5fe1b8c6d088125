//! A film of the map growing: walls as they are, pale; start, exit and a scale; what was touched, as it was; the ball and its path.

use std::fmt::Write as _;

use mrroc_map::{Contact, Place, Walls};

use crate::mp::MazeSettings;
use crate::run::Outcome;

/// How long the film takes \[s\].
const FILM: f64 = 24.0;

/// The length that the scale shows \[m\].
const SCALE: f64 = 0.1;

/// An SVG of a run in the maze of which this was told. It is drawn in millimetres where cells are 25 mm, others as
/// if they were, and repeats itself; without its animation it shows the whole run.
#[must_use]
pub fn film(outcome: &Outcome, walls: &Walls, told: &MazeSettings) -> String {
    let mm = 25.0 / outcome.sizes.pitch;
    let [width, height] = told.known.size.map(|side| mm * side);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-6 -6 {:.0} {:.0}\" font-family=\"sans-serif\" font-size=\"7\">\n\
         <title>the map of a maze grows by touches</title>\n\
         <rect x=\"-6\" y=\"-6\" width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <g transform=\"translate(0 {height:.1}) scale(1 -1)\">\n",
        width + 12.0,
        height + 34.0
    );
    for wall in walls.boxes() {
        let (at, size) = (wall.lower * mm, (wall.upper - wall.lower) * mm);
        let _ = writeln!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#d8d8d8\"/>",
            at.x, at.y, size.x, size.y
        );
    }
    let (start, exit) = (told.start * mm, [told.goal.lower * mm, (told.goal.upper - told.goal.lower) * mm]);
    let _ = writeln!(
        svg,
        "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#cfe8cf\"/>\n\
         <circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"none\" stroke=\"#3a8a3a\" stroke-width=\"1\"/>",
        exit[0].x, exit[0].y, exit[1].x, exit[1].y, start.x, start.y
    );
    // How far along the path each touch is, as a share.
    let mut lengths = vec![0.0];
    for leg in outcome.trace.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + (leg[1] - leg[0]).norm());
    }
    let whole = lengths[lengths.len() - 1].max(1e-9);
    let points: Vec<String> =
        outcome.trace.iter().map(|at| format!("{:.1},{:.1}", mm * at.x, mm * at.y)).collect();
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#2a6fb0\" stroke-width=\"0.8\" stroke-linejoin=\"round\" pathLength=\"1\" \
         stroke-dasharray=\"1 1\" stroke-dashoffset=\"0\"><animate attributeName=\"stroke-dashoffset\" values=\"1;0;0\" keyTimes=\"0;0.9;1\" \
         dur=\"{FILM}s\" repeatCount=\"indefinite\"/></polyline>",
        points.join(" ")
    );
    let mut from = 0;
    for contact in &outcome.contacts {
        let (next, share) = when(outcome, &lengths, whole, from, contact);
        from = next;
        let side = Place::new(-contact.into.y, contact.into.x) * (2.5 / mm);
        let (a, b) = ((contact.at - side) * mm, (contact.at + side) * mm);
        let share = (0.9 * share).clamp(1e-3, 0.899);
        let _ = writeln!(
            svg,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"#c03a2b\" stroke-width=\"1.6\"><animate attributeName=\"opacity\" \
             values=\"0;0;1;1\" keyTimes=\"0;{share:.4};{:.4};1\" dur=\"{FILM}s\" repeatCount=\"indefinite\"/></line>",
            a.x,
            a.y,
            b.x,
            b.y,
            share + 0.01
        );
    }
    let _ = writeln!(
        svg,
        "</g>\n<text x=\"0\" y=\"{:.1}\">{} {} (red), from the ring to the green exit</text>\n\
         <path d=\"M0 {:.1}v3h{:.1}v-3\" fill=\"none\" stroke=\"black\" stroke-width=\"0.6\"/>\n\
         <text x=\"{:.1}\" y=\"{:.1}\">{:.0} mm; distance {:.2} x the shortest</text>\n</svg>",
        height + 12.0,
        outcome.touches,
        if outcome.travel == 0.0 { "places of walls that were seen" } else { "touches" },
        height + 18.0,
        mm * SCALE,
        mm * SCALE + 3.0,
        height + 22.0,
        1e3 * SCALE,
        outcome.ratio()
    );
    svg
}

/// Where on the trace the ball touched, not before `from`: the index, and the share of the path.
fn when(outcome: &Outcome, lengths: &[f64], whole: f64, from: usize, contact: &Contact) -> (usize, f64) {
    let ball = contact.at - contact.into * outcome.sizes.radius;
    let near = |i: &usize| (outcome.trace[*i] - ball).norm() < 0.7 * outcome.sizes.back;
    let found = (from..outcome.trace.len()).find(near).unwrap_or(from);
    (found, lengths.get(found).copied().unwrap_or(0.0) / whole)
}
