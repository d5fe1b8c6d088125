//! The page: a heading, the scene, for each robot its tool's path, its figures and its curves; then the rate of path time
//! and each sensor.
//!
//! In: what is kept of each robot, and what was seen of the rest. Out: the SVG document.

use mrroc::observe::solid::ObstacleLayout;
use mrroc::robot::JointKind;
use nalgebra::{Vector2, Vector3};

use crate::bands::{self, Row};
use crate::block::Block;
use crate::body::Actor;
use crate::chart::{self, Chart};
use crate::curves::{LABELS, Timeline};
use crate::history::History;
use crate::instructions::Log;
use crate::playback::Playback;
use crate::sample::Sample;
use crate::scene::Scene;
use crate::seen::Sights;
use crate::stick::Motion;
use crate::svg::palette::{self, GREY, INK, PAGE, WHITE};
use crate::svg::{Area, Look, Page, Range, Svg, TextStyle, Ticks, shortened};
use crate::tool_path::ToolPath;
use crate::wording::{duration, figure};
use crate::{closeup, figures, instruments, panel};

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

/// Points of all enlarged paths together.
const MOST_PATH: usize = 6000;

const STYLE: &str = "text{font-variant-numeric:tabular-nums}\
    @media (prefers-reduced-motion:reduce){.moving{display:none!important}.end{opacity:1!important}.start{opacity:.42!important}}";

/// A robot that was observed, and what is drawn of it.
struct Robot<'a> {
    history: &'a History,
    samples: Vec<&'a Sample>,
    charts: Vec<Chart>,
    /// Below the time axis of the charts.
    rows: Vec<Row>,
}

impl<'a> Robot<'a> {
    fn of(history: &'a History, mp: &Log, sights: &Sights) -> Robot<'a> {
        let samples = history.samples();
        let mut charts = chart::charts(history, &samples);
        let mut rows = bands::rows(mp, &history.program);
        if let Some(signals) = sights.robot(&history.name) {
            charts.extend(instruments::analog(signals));
            rows.extend(instruments::digital(signals));
        }
        Robot { history, samples, charts, rows }
    }

    /// How high its panel is \[px\].
    fn height(&self) -> f64 {
        let column = 260.0 + figures::height(self.history.joints.len());
        let charts = chart::height(&self.charts) + bands::height(self.rows.len());
        ROBOT_HEADING - 20.0 + charts.max(column)
    }

    /// When it was observed first and last \[s\].
    fn run(&self) -> Range {
        Range::of(self.samples.iter().map(|sample| &sample.time))
    }
}

/// The picture of what some robots did, with the blocks that they handled and what stood around them, and of what the MP's program did.
pub(crate) fn svg(
    histories: &[History],
    blocks: &[Block],
    obstacles: &[ObstacleLayout],
    mp: &Log,
    sights: &Sights,
) -> String {
    let observed = histories.iter().filter(|history| !history.samples().is_empty());
    let robots: Vec<Robot<'_>> = observed.map(|history| Robot::of(history, mp, sights)).collect();
    let instruments = instruments::instruments(sights, mp);
    if robots.is_empty() {
        let title = "Nothing was seen";
        return document(title, HEADING + MARGIN, |svg| {
            heading(svg, title, "No robot had a servo period while the film was running.");
        });
    }
    let runs: Vec<f64> = robots.iter().map(Robot::run).flat_map(|run| [run.low, run.high]).collect();
    let mut run = Range::of(&runs);
    // A cell starts at 0; its first servo period ends a little later.
    if run.low < 0.02 * run.high {
        run.low = 0.0;
    }
    let moved = robots.iter().any(|robot| robot.history.moved());
    let playback = moved.then(|| Playback::of(run.low, run.high, robots.len())).flatten();

    let fastest = fastest(&robots);
    let actors = actors(&robots, fastest);
    let all_charts =
        robots.iter().map(|robot| &robot.charts).chain(instruments.iter().map(|panel| &panel.charts));
    let lines: usize = all_charts.map(|charts| chart::lines(charts)).sum();
    let most = (MOST_POINTS / lines.max(1)).clamp(120, 600);
    let timeline =
        Timeline { run, playback: playback.as_ref(), most, labels: LABELS, suspensions: mp.suspensions() };

    let scene = Scene { actors: &actors, blocks, obstacles, playback: playback.as_ref(), fastest };
    let area = Area { x: MARGIN, y: HEADING, width: WIDTH - 2.0 * MARGIN, height: 0.0 };
    let area = Area { height: scene.height(area.width), ..area };
    let panels: f64 = robots.iter().map(|robot| robot.height() + GAP).sum();
    let panels = panels + instruments.iter().map(|panel| panel.height() + GAP).sum::<f64>();
    let height = HEADING + area.height + panels + MARGIN;
    let title = title(&robots, run);
    let subtitle = subtitle(playback.as_ref());
    document(&title, height, |svg| {
        heading(svg, &title, &subtitle);
        scene.draw(svg, area);
        let mut y = HEADING + area.height + GAP;
        for (robot, actor) in robots.iter().zip(&actors) {
            let area = Area { x: MARGIN, y, width: WIDTH - 2.0 * MARGIN, height: robot.height() };
            draw_robot(svg, area, robot, actor, (MOST_PATH / robots.len()).min(2500));
            timeline.draw(
                svg,
                area.inset(COLUMN + 40.0, ROBOT_HEADING - 20.0, 8.0, 0.0),
                &robot.charts,
                &robot.rows,
            );
            y += area.height + GAP;
        }
        for instrument in &instruments {
            let area = Area { x: MARGIN, y, width: WIDTH - 2.0 * MARGIN, height: instrument.height() };
            instrument.draw(svg, area, COLUMN);
            let over_time = area.inset(COLUMN + 40.0, ROBOT_HEADING - 20.0, 8.0, 0.0);
            timeline.draw(svg, over_time, &instrument.charts, &instrument.rows);
            y += area.height + GAP;
        }
    })
}

/// The speed of the last colour of tool paths [m/s].
fn fastest(robots: &[Robot<'_>]) -> f64 {
    let fastest = robots.iter().fold(0.0_f64, |most, robot| most.max(robot.history.tool_speed));
    // Slower than 1 mm/s is an encoder's play.
    Ticks::around(Range { low: 0.0, high: fastest.max(1e-3) }, 5).range().high
}

/// The robots as they are drawn in space.
fn actors<'a>(robots: &[Robot<'a>], fastest: f64) -> Vec<Actor<'a>> {
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = Vector3::repeat(f64::NEG_INFINITY);
    for point in robots.iter().flat_map(|robot| &robot.samples).flat_map(|sample| &sample.links) {
        low = low.inf(point);
        high = high.sup(point);
    }
    // A gripper is seen, but does not hide what it is near to.
    let size = (high - low).amax();
    let gripper = if size.is_finite() { (0.05 * size).max(0.01) } else { 0.05 };
    let actor = |i: usize, robot: &Robot<'a>| Actor {
        name: &robot.history.name,
        colour: palette::robot(i),
        motion: Motion::of(robot.history, gripper),
        path: ToolPath::of(robot.history, &robot.samples).coloured(fastest),
    };
    robots.iter().enumerate().map(|(i, robot)| actor(i, robot)).collect()
}

/// A robot's panel without its curves.
fn draw_robot(svg: &mut Svg, area: Area, robot: &Robot<'_>, actor: &Actor<'_>, most: usize) {
    panel::ground(svg, area);
    let bar = Area { x: area.x + 16.0, y: area.y + 14.0, width: 4.0, height: 18.0 };
    svg.rectangle(bar, 2.0, Look::filled(actor.colour));
    let name = shortened(&robot.history.name, 32);
    svg.text(Vector2::new(area.x + 28.0, area.y + 28.0), TextStyle::new(15.0, actor.colour).bold(), &name);
    let at = Vector2::new(area.x + COLUMN + 86.0, area.y + 28.0);
    svg.text(at, TextStyle::new(12.5, GREY), &caption(robot.history, &robot.samples));
    let column = Area { x: area.x + 20.0, y: area.y + ROBOT_HEADING, width: COLUMN, height: 250.0 };
    closeup::draw(svg, column, actor, most);
    let table = Area { y: column.y + column.height + 8.0, ..column };
    figures::draw(svg, table, robot.history, &robot.samples);
}

/// Kind, duration and largest following errors, in words.
fn caption(history: &History, samples: &[&Sample]) -> String {
    let lasted = samples.last().zip(samples.first()).map_or(0.0, |(last, first)| last.time - first.time);
    let mut parts = vec![history.kind.to_owned(), duration(lasted)];
    if !history.moved() {
        parts.push("did not move".to_owned());
    }
    let errors: Vec<(JointKind, usize, f64)> = [JointKind::Revolute, JointKind::Prismatic]
        .into_iter()
        .filter_map(|kind| history.largest_following_error(kind).map(|(joint, error)| (kind, joint, error)))
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
    if history.not_finite > 0 {
        parts.push(format!("{} servo periods without finite numbers left out", history.not_finite));
    }
    parts.join(" · ")
}

/// The heading: what moved, and how long.
fn title(robots: &[Robot<'_>], run: Range) -> String {
    let moved: Vec<&str> = robots
        .iter()
        .filter(|robot| robot.history.moved())
        .map(|robot| robot.history.name.as_str())
        .collect();
    let lasted = duration(run.width());
    match (moved.as_slice(), robots.len()) {
        ([], _) => format!("Nothing moved in {lasted}"),
        ([one], _) => format!("{} moved in {lasted}", shortened(one, 40)),
        ([one, other], 2) => {
            format!("{} and {} moved in {lasted}", shortened(one, 24), shortened(other, 24))
        }
        (some, all) if some.len() == all => format!("All {all} robots moved in {lasted}"),
        (some, all) => format!("{} of {all} robots moved in {lasted}", some.len()),
    }
}

/// The line below the heading: how to read the picture.
fn subtitle(playback: Option<&Playback>) -> String {
    let joints = "Joints: measured thick, demanded thin";
    match playback.map(Playback::faster) {
        Some(faster) if faster > 1.01 => {
            format!("{joints} · animation {} times as fast as the motion", figure(faster))
        }
        Some(_) => format!("{joints} · animation in real time"),
        None => joints.to_owned(),
    }
}

/// A page's heading and the line below it.
pub(crate) fn heading(svg: &mut Svg, title: &str, subtitle: &str) {
    svg.text(Vector2::new(MARGIN, 40.0), TextStyle::new(24.0, INK).bold(), title);
    svg.text(Vector2::new(MARGIN, 63.0), TextStyle::new(13.0, GREY), subtitle);
}

/// An SVG document of this title and height \[px\].
pub(crate) fn document(title: &str, height: f64, content: impl FnOnce(&mut Svg)) -> String {
    let page = Page::new(title, WIDTH, height.round()).ground(PAGE).style(STYLE);
    page.draw(|svg| {
        // Joints of moving robots are markers of their lines.
        svg.containing("defs", format_args!(""), |svg| {
            let size = "viewBox=\"-1 -1 2 2\" markerWidth=\"1\" markerHeight=\"1\"";
            svg.containing("marker", format_args!(" id=\"joint\" {size}"), |svg| {
                svg.element("circle", format_args!(" r=\".85\" fill=\"{WHITE}\""));
            });
        });
        content(svg);
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::history::tests::slide;

    fn history(name: &str, periods: u32) -> History {
        let mut history = History::new(name, "<slide>", &[JointKind::Prismatic]);
        for i in 0..periods {
            let time = f64::from(i) * 2e-3;
            history.add(slide(time, time, time));
        }
        history
    }

    #[test]
    fn names_of_any_text_come_back_from_a_parser() {
        let name = "<a href='x'>&amp; \"ż\"</a>";
        let svg = svg(&[history(name, 500)], &[], &[], &Log::default(), &Sights::default());
        let document = roxmltree::Document::parse(&svg).unwrap();
        let texts: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
        assert!(texts.contains(&name));
        assert!(texts.iter().any(|text| text.starts_with("<slide>")));
    }

    #[test]
    fn a_robot_that_never_ticked_is_left_out() {
        let svg = svg(
            &[history("first", 0), history("second", 500)],
            &[],
            &[],
            &Log::default(),
            &Sights::default(),
        );
        assert!(!svg.contains(">first<") && svg.contains("second moved in 1.00 s"));
    }

    #[test]
    fn one_servo_period_is_a_picture_without_motion() {
        let svg = svg(&[history("one", 1)], &[], &[], &Log::default(), &Sights::default());
        roxmltree::Document::parse(&svg).unwrap();
        assert!(svg.contains("Nothing moved") && !svg.contains("<animate ") && !svg.contains("NaN"));
    }
}
