//! The page: a heading, the scene, and for each robot its tool's path, its figures and its curves.
//!
//! In: takes. Out: the SVG document.

use mrroc::JointKind;
use nalgebra::Vector2;

use crate::block::Block;
use crate::chart::{self, Chart};
use crate::curves::{LABELS, Timeline};
use crate::palette::{self, GREY, INK, PAGE};
use crate::playback::Playback;
use crate::projection::Area;
use crate::scene::{Actor, Scene};
use crate::stick::Motion;
use crate::svg::{Anchor, Px, Svg, Weight, Words};
use crate::take::{Sample, Take};
use crate::ticks::Ticks;
use crate::tool_path::ToolPath;
use crate::wording::{duration, figure, shortened};
use crate::{closeup, figures, panel};

/// Width of the page \[px\], its margin, and the room for its heading.
pub(crate) const WIDTH: f64 = 1200.0;
pub(crate) const MARGIN: f64 = 24.0;
pub(crate) const HEADING: f64 = 84.0;
/// A robot's panel \[px\]: its heading, and the column with the tool's path.
const ROBOT_HEADING: f64 = 62.0;
const COLUMN: f64 = 292.0;
const GAP: f64 = 16.0;

/// Points of all curves together: about 10 bytes each.
const MOST_POINTS: usize = 24_000;

/// Points of all enlarged ways together.
const MOST_WAY: usize = 6000;

const STYLE: &str = "text{font-variant-numeric:tabular-nums}\
    @media (prefers-reduced-motion:reduce){.moving{display:none!important}.end{opacity:1!important}.start{opacity:.42!important}}";

/// The picture of some takes, with the blocks that the robots handled.
pub(crate) fn svg(takes: &[Take], blocks: &[Block]) -> String {
    let takes: Vec<(&Take, Vec<&Sample>)> =
        takes.iter().map(|take| (take, take.samples())).filter(|(_, samples)| !samples.is_empty()).collect();
    if takes.is_empty() {
        let title = "Nothing was seen";
        return document(title, HEADING + MARGIN, |svg| {
            heading(svg, title, "No robot had a servo period while the film was running.");
        });
    }
    let ends = takes.iter().filter_map(|(_, samples)| Some((samples.first()?.time, samples.last()?.time)));
    let run =
        ends.fold((f64::INFINITY, f64::NEG_INFINITY), |run, ends| (run.0.min(ends.0), run.1.max(ends.1)));
    // A cell starts at 0; its first servo period ends a little later.
    let run = if run.0 < 0.02 * run.1 { (0.0, run.1) } else { run };
    let playback =
        takes.iter().any(|(take, _)| take.moved()).then(|| Playback::of(run.0, run.1, takes.len())).flatten();

    let (actors, fastest) = actors(&takes);
    let charts: Vec<Vec<Chart>> = takes.iter().map(|(take, samples)| chart::charts(take, samples)).collect();
    let lines: usize = charts.iter().map(|charts| chart::lines(charts)).sum();
    let most = (MOST_POINTS / lines.max(1)).clamp(120, 600);
    let timeline = Timeline { run, playback: playback.as_ref(), most, labels: LABELS };
    let heights: Vec<f64> =
        takes.iter().zip(&charts).map(|((take, _), charts)| robot_height(take, charts)).collect();

    let scene = Scene { actors: &actors, blocks, playback: playback.as_ref(), fastest };
    let area = Area { x: MARGIN, y: HEADING, width: WIDTH - 2.0 * MARGIN, height: 0.0 };
    let area = Area { height: scene.height(area.width), ..area };
    let height = HEADING + area.height + heights.iter().map(|height| height + GAP).sum::<f64>() + MARGIN;
    let (title, subtitle) = titles(&takes, run, playback.as_ref());
    document(&title, height, |svg| {
        heading(svg, &title, &subtitle);
        scene.draw(svg, area);
        let mut y = HEADING + area.height + GAP;
        for ((take, samples), ((actor, charts), height)) in
            takes.iter().zip(actors.iter().zip(&charts).zip(&heights))
        {
            let area = Area { x: MARGIN, y, width: WIDTH - 2.0 * MARGIN, height: *height };
            robot(svg, area, take, samples, actor, (MOST_WAY / takes.len()).min(2500));
            let area = area.inset(COLUMN + 40.0, ROBOT_HEADING - 20.0, 8.0, 0.0);
            timeline.draw(svg, area, charts);
            y += height + GAP;
        }
    })
}

/// The robots as they are drawn, and the speed of the last colour [m/s].
fn actors<'a>(takes: &[(&'a Take, Vec<&Sample>)]) -> (Vec<Actor<'a>>, f64) {
    let points = || takes.iter().flat_map(|(_, samples)| samples).flat_map(|sample| &sample.links);
    let (low, high) = points().fold(
        (nalgebra::Vector3::repeat(f64::INFINITY), nalgebra::Vector3::repeat(f64::NEG_INFINITY)),
        |(low, high), point| (low.inf(point), high.sup(point)),
    );
    // A gripper is seen, but does not hide what it is near to.
    let size = (high - low).amax();
    let gripper = if size.is_finite() { (0.05 * size).max(0.01) } else { 0.05 };
    let mut actors: Vec<Actor<'a>> = takes
        .iter()
        .enumerate()
        .map(|(i, (take, samples))| {
            let motion = Motion::of(take, gripper);
            let path = ToolPath::of(take, samples);
            Actor { name: &take.name, colour: palette::robot(i), motion, path }
        })
        .collect();
    let fastest = takes.iter().fold(0.0_f64, |most, (take, _)| most.max(take.tool_speed));
    // Slower than 1 mm/s is an encoder's play.
    let fastest = Ticks::around(0.0, fastest.max(1e-3), 5).high();
    for actor in &mut actors {
        actor.path = actor.path.clone().coloured(fastest);
    }
    (actors, fastest)
}

fn robot_height(take: &Take, charts: &[Chart]) -> f64 {
    let left = 260.0 + figures::height(take.joints.len());
    ROBOT_HEADING - 20.0 + chart::height(charts).max(left)
}

/// A robot's panel without its curves.
fn robot(svg: &mut Svg, area: Area, take: &Take, samples: &[&Sample], actor: &Actor<'_>, most: usize) {
    panel::ground(svg, area);
    svg.element(
        "rect",
        format_args!(
            "x=\"{}\" y=\"{}\" width=\"4\" height=\"18\" rx=\"2\" fill=\"{}\"",
            Px(area.x + 16.0),
            Px(area.y + 14.0),
            actor.colour
        ),
    );
    let words = Words { size: 15.0, colour: actor.colour, anchor: Anchor::Start, weight: Weight::Bold };
    let name = shortened(&take.name, 32);
    svg.words(Vector2::new(area.x + 28.0, area.y + 28.0), words, &name);
    let words = Words { size: 12.5, colour: GREY, anchor: Anchor::Start, weight: Weight::Normal };
    svg.words(Vector2::new(area.x + COLUMN + 86.0, area.y + 28.0), words, &caption(take, samples));
    let column = Area { x: area.x + 20.0, y: area.y + ROBOT_HEADING, width: COLUMN, height: 250.0 };
    closeup::draw(svg, column, actor, most);
    let table = Area { y: column.y + column.height + 8.0, ..column };
    figures::draw(svg, table, take, samples);
}

/// Kind, duration and largest following errors, in words.
fn caption(take: &Take, samples: &[&Sample]) -> String {
    let lasted = samples.last().zip(samples.first()).map_or(0.0, |(last, first)| last.time - first.time);
    let mut parts = vec![take.kind.to_owned(), duration(lasted)];
    if !take.moved() {
        parts.push("did not move".to_owned());
    }
    let errors: Vec<(JointKind, usize, f64)> = [JointKind::Revolute, JointKind::Prismatic]
        .into_iter()
        .filter_map(|kind| take.worst_following(kind).map(|(joint, error)| (kind, joint, error)))
        .collect();
    if errors.iter().all(|(_, _, error)| *error < 1e-6) {
        parts.push("no following error".to_owned());
    } else {
        let told = |(kind, joint, error): &(JointKind, usize, f64)| {
            format!("{} {} (q{})", figure(*error), kind.unit(0), joint + 1)
        };
        let errors: Vec<String> = errors.iter().map(told).collect();
        parts.push(format!("largest following error {}", errors.join(" and ")));
    }
    if take.not_finite > 0 {
        parts.push(format!("{} servo periods without finite numbers left out", take.not_finite));
    }
    parts.join(" · ")
}

/// The heading and the line below it.
fn titles(takes: &[(&Take, Vec<&Sample>)], run: (f64, f64), playback: Option<&Playback>) -> (String, String) {
    let moved: Vec<&str> =
        takes.iter().filter(|(take, _)| take.moved()).map(|(take, _)| take.name.as_str()).collect();
    let lasted = duration(run.1 - run.0);
    let title = match (moved.as_slice(), takes.len()) {
        ([], _) => format!("Nothing moved in {lasted}"),
        ([one], _) => format!("{} moved in {lasted}", shortened(one, 40)),
        ([one, other], 2) => {
            format!("{} and {} moved in {lasted}", shortened(one, 24), shortened(other, 24))
        }
        (some, all) if some.len() == all => format!("All {all} robots moved in {lasted}"),
        (some, all) => format!("{} of {all} robots moved in {lasted}", some.len()),
    };
    let mut subtitle = vec!["Joints: measured thick, demanded thin".to_owned()];
    match playback.map(Playback::faster) {
        Some(faster) if faster > 1.01 => {
            subtitle.push(format!("animation {} times as fast as the motion", figure(faster)))
        }
        Some(_) => subtitle.push("animation in real time".to_owned()),
        None => {}
    }
    (title, subtitle.join(" · "))
}

pub(crate) fn heading(svg: &mut Svg, title: &str, subtitle: &str) {
    let words = Words { size: 24.0, colour: INK, anchor: Anchor::Start, weight: Weight::Bold };
    svg.words(Vector2::new(MARGIN, 40.0), words, title);
    let words = Words { size: 13.0, colour: GREY, anchor: Anchor::Start, weight: Weight::Normal };
    svg.words(Vector2::new(MARGIN, 63.0), words, subtitle);
}

/// An SVG document of this title and height \[px\].
pub(crate) fn document(title: &str, height: f64, content: impl FnOnce(&mut Svg)) -> String {
    let mut svg = Svg::default();
    let height = height.round();
    svg.group(
        "svg",
        format_args!(
            "xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" font-family=\"Inter, 'Segoe UI', 'Helvetica Neue', Arial, 'DejaVu Sans', sans-serif\""
        ),
        |svg| {
            svg.title(title);
            svg.style(STYLE);
            svg.group("defs", format_args!(""), |svg| {
                svg.group(
                    "marker",
                    format_args!("id=\"joint\" viewBox=\"-1 -1 2 2\" markerWidth=\"1\" markerHeight=\"1\""),
                    |svg| svg.element("circle", format_args!("r=\".85\" fill=\"#fff\"")),
                );
            });
            svg.element("rect", format_args!("width=\"100%\" height=\"100%\" fill=\"{PAGE}\""));
            content(svg);
        },
    );
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::take::tests::slide;

    fn take(name: &str, periods: u32) -> Take {
        let mut take = Take::new(name, "<slide>", &[JointKind::Prismatic]);
        for i in 0..periods {
            let time = f64::from(i) * 2e-3;
            take.keep(slide(time, time, time));
        }
        take
    }

    #[test]
    fn names_of_any_text_come_back_from_a_parser() {
        let name = "<a href='x'>&amp; \"ż\"</a>";
        let svg = svg(&[take(name, 500)], &[]);
        let document = roxmltree::Document::parse(&svg).unwrap();
        let texts: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
        assert!(texts.contains(&name));
        assert!(texts.iter().any(|text| text.starts_with("<slide>")));
    }

    #[test]
    fn a_robot_that_never_ticked_is_left_out() {
        let svg = svg(&[take("first", 0), take("second", 500)], &[]);
        assert!(!svg.contains(">first<") && svg.contains("second moved in 1.00 s"));
    }

    #[test]
    fn one_servo_period_is_a_picture_without_motion() {
        let svg = svg(&[take("one", 1)], &[]);
        roxmltree::Document::parse(&svg).unwrap();
        assert!(svg.contains("Nothing moved") && !svg.contains("<animate ") && !svg.contains("NaN"));
    }
}
