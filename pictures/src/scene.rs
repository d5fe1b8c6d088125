//! The robots in space: one large view with a floor, one from the front, one from above, all moving.
//!
//! In: the actors, robots with their motions and paths; the clock of the animation. Out: three panels. Poses: the first
//! pale, the last dark, ghosts between; over them, where animations are shown, the robot on its way.

use nalgebra::{Vector2, Vector3};

use crate::block::Block;
use crate::body::{self, Pen};
use crate::ghosts::ghosts;
use crate::marks::{arrow, dot, ends, ring};
use crate::palette::{self, GREY, GRID, INK, LEVELS, PANEL, RULE};
use crate::panel;
use crate::playback::Playback;
use crate::projection::{Area, Extent, Projection, View};
use crate::stick::{Motion, Stick};
use crate::svg::{Anchor, Points, Px, Svg, Weight, Words};
use crate::ticks::{Ticks, step};
use crate::tool_path::ToolPath;
use crate::wording::{metres, shortened};

/// A robot as it is drawn.
#[derive(Clone, Debug)]
pub(crate) struct Actor<'a> {
    pub name: &'a str,
    pub colour: &'static str,
    pub motion: Motion,
    pub path: ToolPath,
}

/// What all views share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene<'a> {
    pub actors: &'a [Actor<'a>],
    pub blocks: &'a [Block],
    pub playback: Option<&'a Playback>,
    /// The speed of the last colour [m/s], > 0.
    pub fastest: f64,
}

const LARGE: Pen = Pen { link: 7.0, joint: 4.6, way: 2.6, arrow: 5.5, arrows: 10, most: 2200 };
const SMALL: Pen = Pen { link: 4.0, joint: 2.8, way: 1.8, arrow: 4.0, arrows: 5, most: 900 };

/// The share of the width that the view in space takes, and the room that it leaves left, above, right, below \[px\].
const LARGE_SHARE: f64 = 0.625;
const ROOM: [f64; 4] = [38.0, 40.0, 30.0, 66.0];

/// Bounds of the scene's height \[px\].
const LOWEST: f64 = 440.0;
const HIGHEST: f64 = 600.0;

/// Least extent of a view \[m\].
const LEAST: f64 = 0.05;

impl Scene<'_> {
    /// Draws the three views.
    pub fn draw(&self, svg: &mut Svg, area: Area) {
        let gap = 16.0;
        let large = Area { width: (LARGE_SHARE * area.width).round(), ..area };
        self.space(svg, large);
        let width = area.width - large.width - gap;
        let height = 0.5 * (area.height - gap);
        let front = Area { x: large.x + large.width + gap, y: area.y, width, height };
        let above = Area { y: area.y + height + gap, ..front };
        let extents = [View::front(), View::above()].map(|view| self.extent(view).at_least(LEAST));
        let frames = [front, above].map(|area| area.inset(48.0, 34.0, 14.0, 26.0));
        // One scale for both: what is beside each other in one is so in the other.
        let room = frames.map(|frame| frame.inset(12.0, 8.0, 12.0, 8.0));
        let scale = extents[0].scale(room[0]).min(extents[1].scale(room[1]));
        panel::headed(svg, front, "From the front");
        self.flat(svg, frames[0], &Projection::new(View::front(), &extents[0], frames[0], scale), ["x", "z"]);
        panel::headed(svg, above, "From above");
        self.flat(svg, frames[1], &Projection::new(View::above(), &extents[1], frames[1], scale), ["x", "y"]);
    }

    fn points(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        self.actors.iter().flat_map(|actor| &actor.motion.sticks).flat_map(Stick::points)
    }

    fn extent(&self, view: View) -> Extent {
        Extent::of(self.points().map(|point| view.plane(point)))
    }

    /// The largest extent of all that moves along an axis of the world \[m\].
    fn size(&self) -> f64 {
        let [above, front] =
            [View::above(), View::front()].map(|view| self.extent(view).at_least(LEAST).size().max());
        above.max(front)
    }

    /// The length of the longest robot along its links at the start \[m\].
    fn reach(&self) -> f64 {
        let first = self.actors.iter().filter_map(|actor| actor.motion.sticks.first());
        let length = |stick: &Stick| stick.links.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>();
        first.map(length).fold(0.0, f64::max)
    }

    /// How high the scene would like to be at this width \[px\].
    pub fn height(&self, width: f64) -> f64 {
        let (_, _, extent) = self.floor();
        let room = Area { x: 0.0, y: 0.0, width: LARGE_SHARE * width, height: HIGHEST }
            .inset(ROOM[0], ROOM[1], ROOM[2], ROOM[3]);
        (extent.size().y * room.width / extent.size().x + ROOM[1] + ROOM[3]).clamp(LOWEST, HIGHEST).round()
    }

    /// The corners of the floor, the length of a tile \[m\], and what it all spans in the view in space.
    fn floor(&self) -> ([Vector3<f64>; 4], f64, Extent) {
        let ground = self.extent(View::above()).at_least(4.0 * LEAST);
        let heights = self.extent(View::front());
        let floor = heights.low.y.min(0.0);
        let size = self.size();
        let tile = step(size, 6);
        let [x, y] = [(ground.low.x, ground.high.x), (ground.low.y, ground.high.y)].map(|(low, high)| {
            // Tiles that lie under all that moves.
            let (first, last) = ((low / tile - 1e-9).floor(), (high / tile + 1e-9).ceil());
            (first * tile, last * tile)
        });
        let corners =
            [(x.0, y.0), (x.1, y.0), (x.1, y.1), (x.0, y.1)].map(|(x, y)| Vector3::new(x, y, floor));
        let view = View::space();
        let top = Vector3::new(x.0, y.0, floor + tile);
        let extent = Extent::of(self.points().chain(corners).chain([top]).map(|point| view.plane(point)));
        (corners, tile, extent)
    }

    /// The view in space.
    fn space(&self, svg: &mut Svg, area: Area) {
        panel::headed(svg, area, "In space");
        let (corners, tile, extent) = self.floor();
        let floor = corners[0].z;
        let [x, y] = [(corners[0].x, corners[2].x), (corners[0].y, corners[2].y)];
        let room = area.inset(ROOM[0], ROOM[1], ROOM[2], ROOM[3]);
        let on = Projection::new(View::space(), &extent, room, extent.scale(room));

        let floor_corners = corners.map(|corner| on.at(corner));
        svg.element("polygon", format_args!("fill=\"#f6f8f9\" points=\"{}\"", Points(&floor_corners)));
        svg.group("g", format_args!("stroke=\"{GRID}\" stroke-width=\"1\""), |svg| {
            let lines = |(low, high): (f64, f64)| {
                let count = ((high - low) / tile).round() as i64;
                (0..=count).map(move |i| low + i as f64 * tile)
            };
            let at = |x, y| on.at(Vector3::new(x, y, floor));
            lines(x).for_each(|x| svg.line(at(x, y.0), at(x, y.1), format_args!("")));
            lines(y).for_each(|y| svg.line(at(x.0, y), at(x.1, y), format_args!("")));
        });
        axes(svg, &on, corners[0], tile);
        self.shadows(svg, &on, floor);
        self.feet(svg, &on, floor);
        self.poses(svg, &on, LARGE.fitting(self.reach() * on.scale, 160.0));
        self.names(svg, &on, floor, area);
        self.legend(svg, area);
    }

    /// A view along an axis of the world, with coordinates at its sides.
    fn flat(&self, svg: &mut Svg, frame: Area, on: &Projection, names: [&str; 2]) {
        let shown = on.shown(frame);
        let right = Ticks::inside(shown.low.x, shown.high.x, 6);
        let up = Ticks::inside(shown.low.y, shown.high.y, 4);
        let words = Words { size: 11.0, colour: GREY, anchor: Anchor::Middle, weight: Weight::Normal };
        let (left, bottom) = (frame.x, frame.y + frame.height);
        let grid = |svg: &mut Svg, a, b| svg.line(a, b, format_args!("stroke=\"{GRID}\""));
        for value in right.values() {
            let x = on.on_page(Vector2::new(value, 0.0)).x;
            grid(svg, Vector2::new(x, frame.y), Vector2::new(x, bottom));
            if x < left + frame.width - 46.0 {
                svg.words(Vector2::new(x, bottom + 15.0), words, &right.label(value));
            }
        }
        for value in up.values() {
            let y = on.on_page(Vector2::new(0.0, value)).y;
            grid(svg, Vector2::new(left, y), Vector2::new(left + frame.width, y));
            if y > frame.y + 16.0 {
                let words = Words { anchor: Anchor::End, ..words };
                svg.words(Vector2::new(left - 6.0, y + 4.0), words, &up.label(value));
            }
        }
        let words = Words { colour: INK, anchor: Anchor::End, ..words };
        svg.words(Vector2::new(left + frame.width, bottom + 15.0), words, &format!("{} [m]", names[0]));
        svg.words(Vector2::new(left - 6.0, frame.y + 8.0), words, &format!("{} [m]", names[1]));
        self.poses(svg, on, SMALL.fitting(self.reach() * on.scale, 80.0));
    }

    /// The last pose and the way, straight below on the floor.
    fn shadows(&self, svg: &mut Svg, on: &Projection, floor: f64) {
        let below = |point: &Vector3<f64>| on.at(Vector3::new(point.x, point.y, floor));
        svg.group(
            "g",
            format_args!(
                "fill=\"none\" stroke=\"{INK}\" stroke-opacity=\".09\" stroke-linecap=\"round\" stroke-linejoin=\"round\""
            ),
            |svg| {
                for actor in self.actors {
                    if let Some(last) = actor.motion.sticks.last() {
                        let line: Vec<_> = last.links.iter().map(below).collect();
                        svg.element("polyline", format_args!("stroke-width=\"8\" points=\"{}\"", Points(&line)));
                    }
                    let way: Vec<_> = actor.motion.tool.iter().map(below).collect();
                    let way = crate::thinning::within(&way, 0.5);
                    svg.element("polyline", format_args!("stroke-width=\"1.5\" points=\"{}\"", Points(&way)));
                }
            },
        );
    }

    /// Where the robots stand: a plate on the floor, and a post when the first frame is above it. A robot that shows its
    /// flange alone stands nowhere; a plumb line tells how high it is.
    fn feet(&self, svg: &mut Svg, on: &Projection, floor: f64) {
        for actor in self.actors {
            let (Some(first), Some(tool)) = (actor.motion.sticks.first(), actor.motion.tool.last()) else {
                continue;
            };
            let Some(base) = first.links.first().filter(|_| first.links.len() > 2) else {
                let below = on.at(Vector3::new(tool.x, tool.y, floor));
                svg.line(
                    below,
                    on.at(*tool),
                    format_args!("stroke=\"{RULE}\" stroke-width=\"1.2\" stroke-dasharray=\"4 4\""),
                );
                continue;
            };
            let foot = Vector3::new(base.x, base.y, floor);
            let half = 0.035 * self.size();
            let ring: Vec<_> = (0..32)
                .map(|i| std::f64::consts::TAU * f64::from(i) / 32.0)
                .map(|angle| on.at(foot + Vector3::new(angle.cos(), angle.sin(), 0.0) * half))
                .collect();
            let colour = actor.colour;
            if base.z - floor > 1e-3 {
                svg.line(
                    on.at(foot),
                    on.at(*base),
                    format_args!("stroke=\"{RULE}\" stroke-width=\"9\" stroke-linecap=\"round\""),
                );
            }
            svg.element(
                "polygon",
                format_args!(
                    "fill=\"{colour}\" fill-opacity=\".18\" stroke=\"{colour}\" stroke-opacity=\".6\" points=\"{}\"",
                    Points(&ring)
                ),
            );
        }
    }

    /// Ghosts, the first and the last pose, the ways; and the robots on their way.
    fn poses(&self, svg: &mut Svg, on: &Projection, pen: Pen) {
        for actor in self.actors {
            let found = ghosts(&actor.motion, on.scale, self.actors.len());
            let thin = Pen { link: 0.45 * pen.link, joint: 0.0, ..pen };
            for stick in found.into_iter().filter_map(|i| actor.motion.sticks.get(i)) {
                svg.group("g", format_args!("class=\"ghost\" opacity=\".2\""), |svg| {
                    body::still(svg, on, stick, actor.colour, thin);
                });
            }
        }
        for actor in self.actors {
            let sticks = &actor.motion.sticks;
            let (Some(first), Some(last)) = (sticks.first(), sticks.last()) else { continue };
            for (class, stick, opacity) in [("start", first, ".42"), ("end", last, "1")] {
                svg.group("g", format_args!("class=\"{class}\" opacity=\"{opacity}\""), |svg| {
                    if self.playback.is_some() {
                        Playback::set(svg, "opacity", ".25");
                    }
                    body::still(svg, on, stick, actor.colour, pen);
                });
            }
        }
        for block in self.blocks {
            let Some((first, last)) = block.run() else { continue };
            if !block.moved() {
                block.draw(svg, on, first, None);
                continue;
            }
            for (class, time, opacity) in [("start", first, ".42"), ("end", last, "1")] {
                svg.group("g", format_args!("class=\"{class}\" opacity=\"{opacity}\""), |svg| {
                    if self.playback.is_some() {
                        Playback::set(svg, "opacity", ".25");
                    }
                    block.draw(svg, on, time, None);
                });
            }
        }
        for actor in self.actors {
            actor.path.draw(svg, &actor.motion, on, pen.way, pen.most / self.actors.len().max(1));
        }
        for actor in self.actors {
            actor.path.arrows(
                svg,
                &actor.motion,
                on,
                pen.arrow,
                (2 * pen.arrows / self.actors.len().max(1) as u32).clamp(2, pen.arrows),
            );
            if let (Some(first), Some(last)) = (actor.motion.tool.first(), actor.motion.tool.last()) {
                ends(svg, on.at(*first), on.at(*last), 0.8 * pen.joint);
            }
        }
        if let Some(playback) = self.playback {
            svg.group("g", format_args!("class=\"moving\" display=\"none\""), |svg| {
                Playback::set(svg, "display", "inline");
                for block in self.blocks.iter().filter(|block| block.moved()) {
                    block.draw(svg, on, f64::NEG_INFINITY, Some(playback));
                }
                for actor in self.actors {
                    body::moving(svg, on, actor, playback, pen);
                }
            });
        }
    }

    /// The robots' names below their feet.
    fn names(&self, svg: &mut Svg, on: &Projection, floor: f64, area: Area) {
        let mut taken: Vec<(Vector2<f64>, f64)> = Vec::new();
        for actor in self.actors {
            let stick = actor.motion.sticks.first();
            let Some(base) = stick.and_then(|stick| stick.links.first()) else { continue };
            let name = shortened(actor.name, 28);
            let half = 4.2 * name.chars().count() as f64;
            let mut at = on.at(Vector3::new(base.x, base.y, floor)) + Vector2::new(0.0, 30.0);
            at.x =
                at.x.clamp(area.x + half + 6.0, (area.x + area.width - half - 6.0).max(area.x + half + 6.0));
            let hits = |at: Vector2<f64>, taken: &[(Vector2<f64>, f64)]| {
                taken.iter().any(|(other, width)| {
                    (at.x - other.x).abs() < half + width && (at.y - other.y).abs() < 15.0
                })
            };
            while hits(at, &taken) {
                at.y += 4.0;
            }
            taken.push((at, half));
            let words =
                Words { size: 13.0, colour: actor.colour, anchor: Anchor::Middle, weight: Weight::Bold };
            svg.words_on_lines(at, words, PANEL, &name);
        }
    }

    fn legend(&self, svg: &mut Svg, area: Area) {
        if self.playback.is_none() {
            return;
        }
        let y = area.y + area.height - 20.0;
        let words = Words { size: 11.5, colour: GREY, anchor: Anchor::Start, weight: Weight::Normal };
        let colour = self.actors.first().map_or(INK, |actor| actor.colour);
        let mut x = area.x + 16.0;
        for (text, opacity, width, room) in
            [("start", ".42", 6.0, 78.0), ("between", ".3", 3.0, 92.0), ("end", "1", 6.0, 76.0)]
        {
            let (a, b) = (Vector2::new(x, y - 4.0), Vector2::new(x + 22.0, y - 4.0));
            svg.line(
                a,
                b,
                format_args!(
                    "stroke=\"{colour}\" stroke-opacity=\"{opacity}\" stroke-width=\"{width}\" stroke-linecap=\"round\""
                ),
            );
            match text {
                "start" => ring(svg, b, 3.6),
                "end" => dot(svg, b, 3.6),
                _ => {}
            }
            svg.words(Vector2::new(x + 31.0, y), words, text);
            x += room;
        }
        let width = 150.0;
        let left = area.x + area.width - width - 86.0;
        let bar = width / LEVELS as f64;
        svg.words(Vector2::new(left - 8.0, y), Words { anchor: Anchor::End, ..words }, "tool path: speed 0");
        for level in 0..LEVELS {
            svg.element(
                "rect",
                format_args!(
                    "x=\"{}\" y=\"{}\" width=\"{}\" height=\"8\" fill=\"{}\"",
                    Px(left + level as f64 * bar),
                    Px(y - 8.0),
                    Px(bar + 0.5),
                    palette::level(level)
                ),
            );
        }
        let ticks = Ticks::around(0.0, self.fastest, 1);
        svg.words(Vector2::new(left + width + 8.0, y), words, &format!("{} m/s", ticks.label(self.fastest)));
    }
}

/// Arrows along the world's axes from the floor's corner, of a known length \[m\].
fn axes(svg: &mut Svg, on: &Projection, corner: Vector3<f64>, length: f64) {
    let words = Words { size: 12.0, colour: INK, anchor: Anchor::Middle, weight: Weight::Bold };
    let from = on.at(corner);
    for (axis, name) in [(Vector3::x(), "x"), (Vector3::y(), "y"), (Vector3::z(), "z")] {
        let to = on.at(corner + axis * length);
        arrow(svg, from, to);
        let direction = (to - from).try_normalize(1e-9).unwrap_or_else(Vector2::zeros);
        svg.words_on_lines(to + direction * 11.0 + Vector2::new(0.0, 4.0), words, PANEL, name);
    }
    let middle = 0.5 * (from + on.at(corner + Vector3::x() * length));
    let words = Words { size: 11.5, weight: Weight::Normal, ..words };
    svg.words_on_lines(middle + Vector2::new(-4.0, 18.0), words, PANEL, &metres(length));
}
