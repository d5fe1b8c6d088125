//! The robots in space: one large view with a floor, one from the front, one from above, all moving.
//!
//! In: the actors, robots with their motions and paths; the clock of the animation. Out: three panels. Poses: the first
//! pale, the last dark, ghosts between; over them, where animations are shown, the robot in motion.

use mrroc::observe::solid::ObstacleLayout;
use nalgebra::{Vector2, Vector3};

use crate::block::Block;
use crate::body::{self, Actor, Pen};
use crate::floor::{self, Floor};
use crate::ghosts::ghosts;
use crate::marks::{dot, ends, ring};
use crate::panel;
use crate::playback::{self, Playback};
use crate::projection::{Extent, Projection, View};
use crate::standing;
use crate::stick::Stick;
use crate::svg::palette::{FLOOR, GREY, GRID, INK, RULE, WHITE};
use crate::svg::{Area, Look, Range, Svg, TextStyle, Ticks, shortened, step, thinned};
use crate::tool_path::{LEVELS, level_colour};

/// What all views share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene<'a> {
    pub actors: &'a [Actor<'a>],
    pub blocks: &'a [Block],
    pub obstacles: &'a [ObstacleLayout],
    pub playback: Option<&'a Playback>,
    /// The speed of the last colour [m/s], > 0.
    pub fastest: f64,
}

const LARGE: Pen = Pen { link: 7.0, joint: 4.6, path: 2.6, arrow: 5.5, arrows: 10, most: 2200 };
const SMALL: Pen = Pen { link: 4.0, joint: 2.8, path: 1.8, arrow: 4.0, arrows: 5, most: 900 };

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
        let sticks = self.actors.iter().flat_map(|actor| &actor.motion.sticks).flat_map(Stick::points);
        let standing = self.obstacles.iter().flat_map(standing::points);
        sticks.chain(self.blocks.iter().flat_map(Block::points)).chain(standing)
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
        let extent = self.extent_in_space(&self.floor());
        let room = Area { x: 0.0, y: 0.0, width: LARGE_SHARE * width, height: HIGHEST }
            .inset(ROOM[0], ROOM[1], ROOM[2], ROOM[3]);
        (extent.size().y * room.width / extent.size().x + ROOM[1] + ROOM[3]).clamp(LOWEST, HIGHEST).round()
    }

    /// The floor under all that moves.
    fn floor(&self) -> Floor {
        let ground = self.extent(View::above()).at_least(4.0 * LEAST);
        let heights = self.extent(View::front());
        let tile = step(self.size(), 6);
        // Whole tiles.
        let tiled = |low: f64, high: f64| Range {
            low: (low / tile - 1e-9).floor() * tile,
            high: (high / tile + 1e-9).ceil() * tile,
        };
        Floor {
            x: tiled(ground.low.x, ground.high.x),
            y: tiled(ground.low.y, ground.high.y),
            height: heights.low.y.min(0.0),
            tile,
        }
    }

    /// What all of it spans in the view in space, with its floor.
    fn extent_in_space(&self, floor: &Floor) -> Extent {
        let top = floor.corners()[0] + Vector3::z() * floor.tile;
        let points = self.points().chain(floor.corners()).chain([top]);
        Extent::of(points.map(|point| View::space().plane(point)))
    }

    /// The view in space.
    fn space(&self, svg: &mut Svg, area: Area) {
        panel::headed(svg, area, "In space");
        let floor = self.floor();
        let Floor { x, y, height, tile } = floor;
        let corners = floor.corners();
        let extent = self.extent_in_space(&floor);
        let room = area.inset(ROOM[0], ROOM[1], ROOM[2], ROOM[3]);
        let on = Projection::new(View::space(), &extent, room, extent.scale(room));

        let floor_corners = corners.map(|corner| on.at(corner));
        svg.polygon(&floor_corners, Look::filled(FLOOR));
        svg.group(Look::new().stroke(GRID).width(1.0), |svg| {
            let lines = |range: Range| {
                let count = (range.width() / tile).round() as i64;
                (0..=count).map(move |i| range.low + i as f64 * tile)
            };
            let at = |x, y| on.at(Vector3::new(x, y, height));
            lines(x).for_each(|x| svg.line(at(x, y.low), at(x, y.high), Look::new()));
            lines(y).for_each(|y| svg.line(at(x.low, y), at(x.high, y), Look::new()));
        });
        floor::axes(svg, &on, corners[0], tile);
        self.shadows(svg, &on, height);
        self.feet(svg, &on, height);
        self.poses(svg, &on, LARGE.fitting(self.reach() * on.scale, 160.0));
        self.names(svg, &on, height, area);
        self.legend(svg, area);
    }

    /// A view along an axis of the world, with coordinates at its sides.
    fn flat(&self, svg: &mut Svg, frame: Area, on: &Projection, names: [&str; 2]) {
        let shown = on.shown(frame);
        let right = Ticks::inside(Range { low: shown.low.x, high: shown.high.x }, 6);
        let up = Ticks::inside(Range { low: shown.low.y, high: shown.high.y }, 4);
        let below = TextStyle::new(11.0, GREY).middle();
        let beside = below.end();
        let left = frame.x;
        let bottom = frame.bottom();
        let grid = |svg: &mut Svg, from, to| svg.line(from, to, Look::new().stroke(GRID));
        for value in right.values() {
            let x = on.on_page(Vector2::new(value, 0.0)).x;
            grid(svg, Vector2::new(x, frame.y), Vector2::new(x, bottom));
            if x < left + frame.width - 46.0 {
                svg.text(Vector2::new(x, bottom + 15.0), below, &right.label(value));
            }
        }
        for value in up.values() {
            let y = on.on_page(Vector2::new(0.0, value)).y;
            grid(svg, Vector2::new(left, y), Vector2::new(left + frame.width, y));
            if y > frame.y + 16.0 {
                svg.text(Vector2::new(left - 6.0, y + 4.0), beside, &up.label(value));
            }
        }
        let name = beside.colour(INK);
        svg.text(Vector2::new(left + frame.width, bottom + 15.0), name, &format!("{} [m]", names[0]));
        svg.text(Vector2::new(left - 6.0, frame.y + 8.0), name, &format!("{} [m]", names[1]));
        self.poses(svg, on, SMALL.fitting(self.reach() * on.scale, 80.0));
    }

    /// The last pose and the path, straight below on the floor.
    fn shadows(&self, svg: &mut Svg, on: &Projection, floor: f64) {
        let below = |point: &Vector3<f64>| on.at(Vector3::new(point.x, point.y, floor));
        svg.group(Look::new().no_fill().stroke(INK).stroke_opacity(0.09).round(), |svg| {
            for actor in self.actors {
                if let Some(last) = actor.motion.sticks.last() {
                    let line: Vec<_> = last.links.iter().map(below).collect();
                    svg.polyline(&line, Look::new().width(8.0));
                }
                let path: Vec<_> = actor.motion.tool.iter().map(below).collect();
                svg.polyline(&thinned(&path, 0.5), Look::new().width(1.5));
            }
        });
    }

    /// Where the robots stand that are not mounted on others: a plate on the floor, and a post when the first frame is above it. A robot that shows its
    /// flange alone stands nowhere; a plumb line tells how high it is.
    fn feet(&self, svg: &mut Svg, on: &Projection, floor: f64) {
        for actor in self.actors.iter().filter(|actor| !actor.motion.is_mounted) {
            let (Some(first), Some(tool)) = (actor.motion.sticks.first(), actor.motion.tool.last()) else {
                continue;
            };
            let Some(base) = first.links.first().filter(|_| first.links.len() > 2) else {
                let below = on.at(Vector3::new(tool.x, tool.y, floor));
                svg.line(below, on.at(*tool), Look::new().stroke(RULE).width(1.2).dashed(4.0, 4.0));
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
                svg.line(on.at(foot), on.at(*base), Look::new().stroke(RULE).width(9.0).round());
            }
            svg.polygon(&ring, Look::filled(colour).fill_opacity(0.18).stroke(colour).stroke_opacity(0.6));
        }
    }

    /// What stands there; ghosts, the first and the last pose, the paths; and the robots in motion.
    fn poses(&self, svg: &mut Svg, on: &Projection, pen: Pen) {
        self.obstacles.iter().for_each(|obstacle| standing::draw(svg, on, obstacle));
        for actor in self.actors {
            let found = ghosts(&actor.motion, on.scale, self.actors.len());
            let thin = Pen { link: 0.45 * pen.link, joint: 0.0, ..pen };
            for stick in found.into_iter().filter_map(|i| actor.motion.sticks.get(i)) {
                svg.group(Look::new().class("ghost").opacity(0.2), |svg| {
                    body::still(svg, on, stick, actor.colour, thin);
                });
            }
        }
        for actor in self.actors {
            let sticks = &actor.motion.sticks;
            let (Some(first), Some(last)) = (sticks.first(), sticks.last()) else { continue };
            for (class, stick, opacity) in [("start", first, 0.42), ("end", last, 1.0)] {
                svg.group(Look::new().class(class).opacity(opacity), |svg| {
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
            for (class, time, opacity) in [("start", first, 0.42), ("end", last, 1.0)] {
                svg.group(Look::new().class(class).opacity(opacity), |svg| {
                    if self.playback.is_some() {
                        Playback::set(svg, "opacity", ".25");
                    }
                    block.draw(svg, on, time, None);
                });
            }
        }
        for actor in self.actors {
            actor.path.draw(svg, &actor.motion, on, pen.path, pen.most / self.actors.len().max(1));
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
            playback::moving(svg, |svg| {
                for block in self.blocks.iter().filter(|block| block.moved()) {
                    block.draw(svg, on, f64::NEG_INFINITY, Some(playback));
                }
                for actor in self.actors {
                    body::moving(svg, on, actor, playback, pen);
                }
            });
        }
    }

    /// The robots' names below their feet, or beside what they are mounted on.
    fn names(&self, svg: &mut Svg, on: &Projection, floor: f64, area: Area) {
        let mut taken: Vec<(Vector2<f64>, f64)> = Vec::new();
        for actor in self.actors {
            let stick = actor.motion.sticks.first();
            let Some(base) = stick.and_then(|stick| stick.links.first()) else { continue };
            let name = shortened(actor.name, 28);
            let half = 4.2 * name.chars().count() as f64;
            let mut at = if actor.motion.is_mounted {
                on.at(*base) + Vector2::new(half + 14.0, 4.0)
            } else {
                on.at(Vector3::new(base.x, base.y, floor)) + Vector2::new(0.0, 30.0)
            };
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
            svg.text_on_lines(at, TextStyle::new(13.0, actor.colour).middle().bold(), WHITE, &name);
        }
    }

    fn legend(&self, svg: &mut Svg, area: Area) {
        if self.playback.is_none() {
            return;
        }
        let y = area.y + area.height - 20.0;
        let style = TextStyle::new(11.5, GREY);
        let colour = self.actors.first().map_or(INK, |actor| actor.colour);
        let mut x = area.x + 16.0;
        for (text, opacity, width, room) in
            [("start", 0.42, 6.0, 78.0), ("between", 0.3, 3.0, 92.0), ("end", 1.0, 6.0, 76.0)]
        {
            let left = Vector2::new(x, y - 4.0);
            let right = Vector2::new(x + 22.0, y - 4.0);
            svg.line(left, right, Look::new().stroke(colour).stroke_opacity(opacity).width(width).round());
            match text {
                "start" => ring(svg, right, 3.6),
                "end" => dot(svg, right, 3.6),
                _ => {}
            }
            svg.text(Vector2::new(x + 31.0, y), style, text);
            x += room;
        }
        let width = 150.0;
        let left = area.x + area.width - width - 86.0;
        let bar = width / LEVELS as f64;
        svg.text(Vector2::new(left - 8.0, y), style.end(), "tool path: speed 0");
        for level in 0..LEVELS {
            let area = Area { x: left + level as f64 * bar, y: y - 8.0, width: bar + 0.5, height: 8.0 };
            svg.rectangle(area, 0.0, Look::filled(level_colour(level)));
        }
        let ticks = Ticks::around(Range { low: 0.0, high: self.fastest }, 1);
        svg.text(Vector2::new(left + width + 8.0, y), style, &format!("{} m/s", ticks.label(self.fastest)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::pose::Pose;

    #[test]
    fn the_corners_of_blocks_count_in_what_is_shown() {
        // From x = 2 m to x = 3 m, 1 m above the floor; a second one whose place is no number has none.
        let mut x = 1.0;
        let moving = move || {
            x += 1.0;
            Pose::translation(x, -0.5, 1.0)
        };
        let nowhere = || Pose::translation(f64::NAN, 0.0, 0.0);
        let mut blocks =
            [Block::new([0.4, 0.2, 0.1], Box::new(moving)), Block::new([1.0, 1.0, 1.0], Box::new(nowhere))];
        for block in &mut blocks {
            block.observe(0.0);
            block.observe(1.0);
        }
        let scene = Scene { actors: &[], blocks: &blocks, obstacles: &[], playback: None, fastest: 1.0 };
        let above = scene.extent(View::above());
        let front = scene.extent(View::front());
        assert!((above.low - Vector2::new(1.8, -0.6)).norm() < 1e-12, "{above:?}");
        assert!((above.high - Vector2::new(3.2, -0.4)).norm() < 1e-12, "{above:?}");
        assert!((front.low - Vector2::new(1.8, 0.95)).norm() < 1e-12, "{front:?}");
        assert!((front.high - Vector2::new(3.2, 1.05)).norm() < 1e-12, "{front:?}");
        assert!((scene.size() - 1.4).abs() < 1e-12);
        // The floor lies under all of it.
        let floor = scene.floor().corners();
        let shown = scene.extent_in_space(&scene.floor());
        assert!(floor[0].x <= 1.8 && floor[2].x >= 3.2 && floor[0].y <= -0.6 && floor[2].y >= -0.4);
        let corner = View::space().plane(Vector3::new(3.2, -0.4, 1.05));
        assert!(corner.x <= shown.high.x && corner.y <= shown.high.y, "{corner} {shown:?}");
    }
}
