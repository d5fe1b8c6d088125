//! Pictures of runs with the camera: the cell, moving; which kinds were taken for which; where grasps were off; parts over time.

use std::io;
use std::path::Path;

use mrroc::cell::RunPicture;
use mrroc::prelude::*;
use mrroc_pictures::svg::palette::{GREY, HIGHLIGHT, INK, REGION, WHITE, joint};
use mrroc_pictures::svg::{Area, Axes, Look, Page, Range, TextStyle};
use nalgebra::{Point3, Vector2};

use super::kinds::{KINDS, kinds};
use super::layout::{BINS, FEED, STATIONS, bin};
use super::run::{Outcome, Ready};
use super::summary::{Confusion, Table};
use crate::monitor::Fate;
use crate::pictures::{MARGIN, heading, of_belt, seen};
use crate::places::{TRAY, TRAYS};

const WIDTH: f64 = 1000.0;

/// Runs a cell and films it, from above, from the side and in space. Parts are drawn as the boxes that hold them.
///
/// # Errors
/// The film cannot be written.
pub fn filmed(mut ready: Ready, file: &Path) -> io::Result<Outcome> {
    let stations = &STATIONS[..ready.arms];
    let mut film = of_belt(stations[stations.len() - 1].along);
    for (station, number) in stations.iter().flat_map(|station| (0..BINS).map(move |bin| (station, bin))) {
        let ([x, y], [dx, dy]) = bin(number);
        let (y, z) = (y + station.along, TRAYS[number / 4][2]);
        film = film.with_block([2.0 * dx, 2.0 * dy, TRAY[2]], move || Pose::translation(x, y, z));
    }
    for (number, part) in ready.parts.iter().enumerate() {
        let corners: Vec<_> = part.form.corners().collect();
        let (least, most) = corners.iter().fold((corners[0], corners[0]), |(a, b), c| (a.inf(c), b.sup(c)));
        let (edges, middle) = (most - least, 0.5 * (least + most));
        let at = part.X_BP * Point3::from(middle);
        let seen = seen(&ready.plant.world, number, Pose::translation(at.x, at.y, at.z), FEED);
        film = film.with_block(edges.into(), seen);
    }
    ready.cell = film.watch(ready.cell);
    let outcome = ready.run();
    film.save(file)?;
    Ok(outcome)
}

/// Which kinds were taken for which.
#[must_use]
pub fn confusion(of: &Confusion) -> String {
    let side = 74.0;
    let (left, top) = (190.0, 150.0);
    let names: Vec<_> = kinds().iter().map(|kind| kind.class.name).chain(["none of them"]).collect();
    let [right, misnamed, rejected] = of.counts();
    let height = top + side * (KINDS + 1) as f64 + 40.0;
    Page::new("Kinds and what they were taken for", WIDTH, height).draw(|svg| {
        let text = format!("rows: what it was; columns: what it was taken for. {right} right, {misnamed} misnamed, {rejected} rejected");
        heading(svg, "Kinds and what they were taken for", &text);
        for (row, (counts, name)) in of.0.iter().zip(&names).enumerate() {
            let all: u32 = counts.iter().sum();
            let y = top + side * row as f64;
            svg.text(Vector2::new(left - 12.0, y + 0.55 * side), TextStyle::new(13.0, INK).end(), name);
            let x = left + side * (row as f64 + 0.5);
            svg.text(Vector2::new(x, top - 12.0), TextStyle::new(11.0, INK).middle(), names[row]);
            for (column, count) in counts.iter().enumerate() {
                let area = Area { x: left + side * column as f64, y, width: side - 2.0, height: side - 2.0 };
                let share = f64::from(*count) / f64::from(all.max(1));
                let colour = if row == column { joint(0) } else { HIGHLIGHT };
                // What is rare is to be seen too.
                let shade = if *count == 0 { WHITE } else { WHITE.towards(colour, 0.15 + 0.75 * share) };
                svg.rectangle(area, 2.0, Look::filled(shade).stroke(REGION));
                if *count > 0 {
                    let style = TextStyle::new(14.0, INK).middle();
                    svg.text(Vector2::new(area.x + 0.5 * side, y + 0.57 * side), style, &count.to_string());
                }
            }
        }
    })
}

/// Distances of grasps from the middle, by the belt's speed; and what 95 % of them may be \[mm\], where something is asked.
#[must_use]
pub fn scatter(table: &Table, asked: Option<f64>) -> String {
    Page::new("Grasps off the middle", WIDTH, 480.0).draw(|svg| {
        let text = "distance of the part's frame from the middle of the pads along them, one point for each grasp, by the belt's nominal speed";
        heading(svg, "Where the hand gets hold of parts", text);
        let frame = Area { x: MARGIN, y: 100.0, width: WIDTH - 2.0 * MARGIN, height: 310.0 };
        let offs = table.0.iter().flat_map(|line| &line.off);
        let most = offs.fold(1.3, |most: f64, off| most.max(off * 1e3));
        let axes = Axes::new(frame, Range { low: 0.0, high: 0.17 }, Range { low: 0.0, high: most });
        axes.draw_grid(svg);
        axes.draw_labels_below(svg);
        let spread = |index: usize| 0.012 * ((index as f64 * 0.618).fract() - 0.5);
        for line in &table.0 {
            for (index, off) in line.off.iter().enumerate() {
                let at = axes.at(line.speed + spread(index), off * 1e3);
                svg.circle(at, 2.0, Look::filled(joint(0)).fill_opacity(0.5));
            }
        }
        if let Some(asked) = asked {
            let bound = [axes.at(0.0, asked), axes.at(0.17, asked)];
            svg.line(bound[0], bound[1], Look::line(HIGHLIGHT, 1.2).dashed(5.0, 4.0));
            let style = TextStyle::new(12.0, HIGHLIGHT).end();
            svg.text(Vector2::new(bound[1].x, bound[1].y - 6.0), style, &format!("{asked} mm: bound of 95 %"));
        }
        svg.text(Vector2::new(frame.right(), frame.bottom() + 34.0), TextStyle::new(12.0, GREY).end(), "speed of the belt [m/s]");
        svg.text(Vector2::new(MARGIN - 44.0, 96.0), TextStyle::new(12.0, GREY), "mm");
    })
}

/// The queue: from when each part came until it was grasped; of the first so many.
#[must_use]
pub fn time_line(outcome: &Outcome, ready: &[(f64, usize)]) -> String {
    const MOST: usize = 60;
    const ROW: f64 = 9.0;
    let shown = ready.len().min(MOST);
    let height = 190.0 + ROW * shown as f64;
    let held = |number: usize| outcome.grips.iter().find(|grip| grip.part == number);
    let grip = |number: usize| held(number).map(|grip| grip.time);
    let arms = outcome.grips.iter().map(|grip| grip.arm + 1).max().unwrap_or(1);
    let last = |number: usize| grip(number).unwrap_or(ready[number].0);
    let end = (0..shown).map(last).fold(0.0, f64::max) + 10.0;
    Page::new("Parts over time", WIDTH, height).draw(|svg| {
        let sorted = outcome.count(Fate::Sorted);
        let strangers = ready.iter().filter(|(_, kind)| *kind == KINDS).count();
        let besides = if strangers > 0 { format!(", and {strangers} strangers came") } else { String::new() };
        let text = format!(
            "{sorted} of {} parts sorted{besides}; a bar begins where its part comes and ends where it is grasped",
            ready.len() - strangers
        );
        heading(svg, "The queue of parts", &text);
        let frame = Area { x: MARGIN, y: 100.0, width: WIDTH - 2.0 * MARGIN, height: ROW * shown as f64 };
        let axes = Axes::new(frame, Range { low: 0.0, high: end }, Range { low: 0.0, high: 1.0 });
        svg.rectangle(frame, 0.0, Look::filled(WHITE).stroke(REGION));
        axes.draw_labels_below(svg);
        for (number, (came, kind)) in ready.iter().take(shown).enumerate() {
            let until = grip(number).unwrap_or(came + 1.0);
            let (x, to) = (axes.at(*came, 0.0).x, axes.at(until, 0.0).x);
            let bar = Area { x, y: 101.0 + ROW * number as f64, width: (to - x).max(2.0), height: ROW - 2.0 };
            let colour = match outcome.fates[number] {
                Fate::Sorted => joint(*kind),
                Fate::Wrong => HIGHLIGHT,
                Fate::Missed => GREY,
                Fate::Passed | Fate::Gripped => REGION,
            };
            svg.rectangle(bar, 1.0, Look::filled(colour));
            if let Some(grip) = held(number).filter(|_| arms > 1) {
                // Whose hand it was: by its number, and by a tick that is full or empty.
                let tick = Area { x: to + 3.0, y: bar.y, width: bar.height, height: bar.height };
                let fill = if grip.arm == 0 { INK } else { WHITE };
                svg.rectangle(tick, 1.0, Look::filled(fill).stroke(INK));
                let at = Vector2::new(tick.x + 11.0, bar.y + bar.height);
                svg.text(at, TextStyle::new(8.0, INK), &format!("{}", grip.arm + 1));
            }
        }
        let y = frame.bottom() + 40.0;
        let names = kinds();
        for (i, kind) in names.iter().enumerate() {
            let x = MARGIN + 104.0 * i as f64;
            svg.rectangle(Area { x, y: y - 9.0, width: 12.0, height: 9.0 }, 1.0, Look::filled(joint(i)));
            svg.text(Vector2::new(x + 17.0, y), TextStyle::new(12.0, INK), kind.class.name);
        }
        svg.text(
            Vector2::new(MARGIN, y + 22.0),
            TextStyle::new(12.0, GREY),
            if arms > 1 {
                "grey: missed; pale: a stranger that passed; red: in a wrong bin. Where a bar ends: which arm took the part, the first (full square) or the second (empty)"
            } else {
                "grey: missed; pale: a stranger that passed; red: in a wrong bin"
            },
        );
        svg.text(Vector2::new(frame.right(), y + 22.0), TextStyle::new(12.0, GREY).end(), "time [s]");
    })
}
