//! Pictures: the arm at the belt, moving; where grasps were off the middle; what became of each part, over time.

use std::io;
use std::path::Path;

use mrroc::cell::RunPicture;
use mrroc::prelude::*;
use mrroc_pictures::Film;
use mrroc_pictures::svg::palette::{GREY, HIGHLIGHT, INK, REGION, WHITE, joint};
use mrroc_pictures::svg::{Area, Axes, Look, Page, Range, Svg, TextStyle};
use mrroc_robots::grasp::World;
use nalgebra::Vector2;

use crate::monitor::Fate;
use crate::parts::{Arrival, FEED};
use crate::places::{BELT, PART, SURFACE, TRAY, TRAYS};
use crate::run::{Outcome, Ready};
use crate::summary::Summary;

const WIDTH: f64 = 1200.0;
pub(crate) const MARGIN: f64 = 70.0;

/// A film of the belt, which is so much longer \[m\] where a second arm stands at it.
pub(crate) fn of_belt(longer: f64) -> Film {
    let [from, to, width] = SURFACE;
    let to = to + longer;
    let belt = Pose::translation(BELT[0], BELT[1] + 0.5 * (from + to), -0.01);
    // Hands are on their arms, and the belt's mark runs away: both are drawn as bodies.
    Film::new().without(&["hand", "hand-2", "belt"]).with_block([width, to - from, 0.02], move || belt)
}

/// Where what is at `X_PQ` of a part is. Before the part comes and after it has gone it is where it was seen last, or out of the way below
/// the belt, at `feed` along it \[m\].
#[allow(non_snake_case)]
pub(crate) fn seen(world: &World, number: usize, X_PQ: Pose, feed: f64) -> impl FnMut() -> Pose + 'static {
    let (world, mut seen) = (world.clone(), Pose::translation(BELT[0], BELT[1] + feed, -0.05));
    move || {
        seen = world.body_of(number).map_or(seen, |state| state.pose * X_PQ);
        seen
    }
}

/// Runs a cell and films it, from above, from the side and in space.
///
/// # Errors
/// The film cannot be written.
pub fn filmed(mut ready: Ready, file: &Path) -> io::Result<Outcome> {
    let mut film = of_belt(0.0);
    for [x, y, z] in TRAYS {
        film = film.with_block(TRAY, move || Pose::translation(x, y, z));
    }
    for (number, part) in ready.parts.iter().enumerate() {
        let seen = seen(&ready.plant.world, number, Pose::identity(), FEED);
        film = film.with_block([part.shape.length(), PART[0], PART[1]], seen);
    }
    ready.cell = film.watch(ready.cell);
    let outcome = ready.run();
    film.save(file)?;
    Ok(outcome)
}

/// Off-centre distances of grasps by the belt's speed, closed loop beside open loop.
#[must_use]
pub fn scatter(reactive: &Summary, first_edge: &Summary) -> String {
    let height = 520.0;
    Page::new("Grasps off the middle", WIDTH, height).draw(|svg| {
        heading(svg, "Where the hand gets hold of parts", "distance of the part's middle from that of the fingers along the belt, one point for each grasp, by the belt's nominal speed");
        let halves = [(reactive, "all sensors", 0), (first_edge, "the first edge alone", 1)];
        for (half, (summary, name, colour)) in halves.into_iter().enumerate() {
            let wide = 0.5 * WIDTH - 1.4 * MARGIN;
            let x = MARGIN + half as f64 * (wide + 1.2 * MARGIN);
            let frame = Area { x, y: 110.0, width: wide, height: height - 180.0 };
            let all = summary.all();
            let most = all.off.iter().fold(3.5, |most: f64, off| most.max(off * 1e3));
            let up = Range { low: 0.0, high: most };
            let axes = Axes::new(frame, Range { low: 0.01, high: 0.16 }, up);
            axes.draw_grid(svg);
            axes.draw_labels_below(svg);
            let spread = |index: usize| 0.006 * ((index as f64 * 0.618).fract() - 0.5);
            for row in &summary.0 {
                for (index, off) in row.off.iter().enumerate() {
                    let at = axes.at(row.speed + spread(index), off * 1e3);
                    svg.circle(at, 2.2, Look::filled(joint(colour)).fill_opacity(0.55));
                }
            }
            let bound = [axes.at(0.01, 3.0), axes.at(0.16, 3.0)];
            svg.line(bound[0], bound[1], Look::line(HIGHLIGHT, 1.2).dashed(5.0, 4.0));
            let label = format!("{name}: {} of {} parts acquired", all.sorted + all.wrong, all.parts);
            svg.text(Vector2::new(x, 100.0), TextStyle::new(14.0, INK).bold(), &label);
            svg.text(Vector2::new(x + wide, frame.bottom() + 34.0), TextStyle::new(12.0, GREY).end(), "speed of the belt [m/s]");
            svg.text(Vector2::new(bound[1].x, bound[1].y - 6.0), TextStyle::new(12.0, HIGHLIGHT).end(), "3 mm");
            svg.text(Vector2::new(x - 44.0, 100.0), TextStyle::new(12.0, GREY), "mm");
        }
    })
}

/// What became of each part: from when it came to when it was grasped, and by its fate; of the first so many.
#[must_use]
pub fn time_line(outcome: &Outcome, parts: &[Arrival]) -> String {
    const MOST: usize = 60;
    let shown = parts.len().min(MOST);
    let row = 9.0;
    let height = 150.0 + row * shown as f64;
    let end = parts.iter().take(shown).map(|part| part.time).fold(0.0, f64::max) + 15.0;
    Page::new("Parts over time", WIDTH, height).draw(|svg| {
        let sorted = outcome.count(Fate::Sorted);
        let text = format!(
            "{sorted} of {} parts sorted; a bar begins where its part comes and ends where it is grasped",
            parts.len()
        );
        heading(svg, "What became of the parts", &text);
        let frame = Area { x: MARGIN, y: 100.0, width: WIDTH - 2.0 * MARGIN, height: row * shown as f64 };
        let across = Range { low: 0.0, high: end };
        let axes = Axes::new(frame, across, Range { low: 0.0, high: 1.0 });
        svg.rectangle(frame, 0.0, Look::filled(WHITE).stroke(REGION));
        axes.draw_labels_below(svg);
        for (number, part) in parts.iter().take(shown).enumerate() {
            let grip = outcome.grips.iter().find(|grip| grip.part == number);
            let until = grip.map_or(part.time + 1.0, |grip| grip.time);
            let (x, to) = (axes.at(part.time, 0.0).x, axes.at(until, 0.0).x);
            let bar = Area { x, y: 101.0 + row * number as f64, width: (to - x).max(2.0), height: row - 2.0 };
            let colour = match outcome.fates[number] {
                Fate::Sorted if part.shape.tray() == 0 => joint(0),
                Fate::Sorted => joint(2),
                Fate::Wrong => HIGHLIGHT,
                Fate::Missed | Fate::Passed | Fate::Gripped => GREY,
            };
            svg.rectangle(bar, 1.0, Look::filled(colour));
        }
        let y = frame.bottom() + 34.0;
        let names = [
            ("short, sorted", joint(0)),
            ("long, sorted", joint(2)),
            ("wrong tray", HIGHLIGHT),
            ("missed", GREY),
        ];
        for (i, (name, colour)) in names.into_iter().enumerate() {
            let x = MARGIN + 130.0 * i as f64;
            svg.rectangle(Area { x, y: y - 9.0, width: 12.0, height: 9.0 }, 1.0, Look::filled(colour));
            svg.text(Vector2::new(x + 18.0, y), TextStyle::new(12.0, INK), name);
        }
        svg.text(Vector2::new(frame.right(), y), TextStyle::new(12.0, GREY).end(), "time [s]");
    })
}

/// A title, and a line below it.
pub(crate) fn heading(svg: &mut Svg, title: &str, below: &str) {
    svg.text(Vector2::new(MARGIN, 42.0), TextStyle::new(22.0, INK).bold(), title);
    svg.text(Vector2::new(MARGIN, 66.0), TextStyle::new(13.0, GREY), below);
}
