//! Bright bars that stand on a dark floor, level or upright in a frame of their own, as a camera above sees them: the walls of a maze.
//!
//! ```text
//! image -> the plane of the bars' tops, straight on, where the frame is said to be -> the frame, by its four sides
//!       -> the same where the frame is -> bright squares by a threshold that follows the light
//!       -> runs of bright squares longer than bars are thick -> bars; what is left, of a bar's thickness -> posts
//!       -> edges between squares, at half of the step of brightness
//! ```
//!
//! A bar that stands up shows its sides, less bright than its top, towards the place below the camera. Edges that look away from there are
//! steps from the top to the floor: those tell where a bar is, and its known thickness tells the other edge. Where an end looks
//! towards the camera, its side is as wide as the height and the camera's place say.

use mrroc::pose::Pose;
use nalgebra::{Matrix6, Point3, Translation3, UnitQuaternion, Vector2, Vector3, Vector6};
use thiserror::Error;

use super::rectified::Rectified;
use crate::camera::Plane;

/// What is known of bars beforehand, in \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarsKnown {
    /// The frame's sides, from the middle of its bars.
    pub sides: [f64; 2],
    /// How thick bars are.
    pub thickness: f64,
    /// How high they stand.
    pub height: f64,
    /// By how much the frame may be beside where it is said to be.
    pub loose: f64,
    /// Side of a square in which the plane is looked at: about what a pixel sees.
    pub cell: f64,
}

/// What was seen.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Bars {
    /// Where the frame M is, from the middle of its lower left corner, in F.
    pub X_FM: Pose,
    /// Lower left and upper right corners \[m, M\].
    pub boxes: Vec<[Vector2<f64>; 2]>,
}

/// Why there are no bars.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum NoBars {
    /// Nothing is bright.
    #[error(
        "the image is dark, grey {bright:.0} at its brightest, at least {least:.0}: lens covered or lamp off?"
    )]
    Dark {
        /// Of the brightest parts.
        bright: f64,
        /// What it has to be.
        least: f64,
    },
    /// A side of the frame is not where it may be.
    #[error(
        "the {side} side of the frame is not seen: was the maze moved, or is something before the camera?"
    )]
    NoFrame {
        /// Which.
        side: &'static str,
    },
}

/// The least grey value of a bar.
const LIGHT: f64 = 40.0;
/// Brighter than this share of a top is a top; sides have 0.46 of it at most, under diffuse light and a lamp above.
const TOP: f64 = 0.68;
/// A side of the frame is straight in so much of its length: what is before it hides it.
const WHOLE: f64 = 0.95;
/// What a side has of a top's brightness where it is too narrow to be looked at.
const SIDE: f64 = 0.4;

impl Bars {
    /// The bars in an image; `said` is where the frame is said to be, `X_FM`.
    ///
    /// # Errors
    /// [`NoBars`].
    ///
    /// # Panics
    /// If the image has not the camera's size.
    pub fn find(plane: &Plane, image: &[u8], said: &Pose, known: &BarsKnown) -> Result<Self, NoBars> {
        // A turn of the frame moves its corners as well.
        let pad = 2.0 * known.loose + 10.0 * known.cell + known.thickness;
        let look = |at: &Pose| Rectified::of(plane, image, at, known.height, known.sides, pad, known.cell);
        let first = look(said);
        let light = Light::of(&first)?;
        let found = said * frame(&first, &light, known, pad)?;
        let straight = look(&found);
        let light = Light::of(&straight)?;
        let eye = found.inverse_transform_point(&Point3::from(plane.X_FC.translation.vector));
        let sight = Sight { squares: &straight, eye: eye.coords, known };
        Ok(Self { X_FM: found, boxes: sight.boxes(&light) })
    }
}

/// How bright a top is, over the plane: a quadratic function of the place.
struct Light {
    coefficients: Vector6<f64>,
    size: [usize; 2],
}

impl Light {
    /// Squares of a block, along a side.
    const BLOCK: usize = 32;

    fn terms(&self, column: f64, row: f64) -> Vector6<f64> {
        let (x, y) = (column / self.size[0] as f64 - 0.5, row / self.size[1] as f64 - 0.5);
        Vector6::new(1.0, x, y, x * x, x * y, y * y)
    }

    fn of(squares: &Rectified) -> Result<Self, NoBars> {
        let mut light = Self { coefficients: Vector6::zeros(), size: squares.size };
        let [columns, rows] = squares.size;
        let mut blocks = Vec::new();
        for j in (0..rows).step_by(Self::BLOCK) {
            for i in (0..columns).step_by(Self::BLOCK) {
                let mut most = (0.0_f32, 0, 0);
                for row in j..(j + Self::BLOCK).min(rows) {
                    for column in i..(i + Self::BLOCK).min(columns) {
                        let grey = squares.at(column, row);
                        if grey > most.0 {
                            most = (grey, column, row);
                        }
                    }
                }
                blocks.push((f64::from(most.0), light.terms(most.1 as f64, most.2 as f64)));
            }
        }
        let mut all: Vec<f64> = blocks.iter().map(|block| block.0).collect();
        all.sort_by(f64::total_cmp);
        let bright = all.get(all.len() * 9 / 10).copied().unwrap_or(0.0);
        if bright < LIGHT {
            return Err(NoBars::Dark { bright, least: LIGHT });
        }
        // Blocks without a top are left out, as far as they tell.
        blocks.retain(|block| block.0 > 0.5 * bright);
        for _ in 0..3 {
            let (mut square, mut right) = (Matrix6::zeros(), Vector6::zeros());
            for (grey, terms) in &blocks {
                square += terms * terms.transpose();
                right += terms * *grey;
            }
            for i in 0..6 {
                square[(i, i)] += 1e-9 * blocks.len() as f64;
            }
            light.coefficients =
                square.cholesky().map_or(light.coefficients, |inverse| inverse.solve(&right));
            blocks.retain(|(grey, terms)| *grey > 0.85 * light.coefficients.dot(terms));
        }
        Ok(light)
    }

    fn at(&self, column: usize, row: usize) -> f64 {
        self.coefficients.dot(&self.terms(column as f64, row as f64))
    }
}

/// Where the frame is beside where it was looked for, by its outer edges: `X_SM`.
fn frame(squares: &Rectified, light: &Light, known: &BarsKnown, pad: f64) -> Result<Pose, NoBars> {
    let reach = (2.0 * pad / squares.cell) as usize;
    // Of each side a line: how far in it begins, and how much more per square along it.
    let line = |axis: usize, backwards: bool, side: &'static str| {
        let [depth, length] = [squares.size[axis], squares.size[1 - axis]];
        let value = |d: usize, l: usize| {
            let d = if backwards { depth - 1 - d } else { d };
            if axis == 0 { (squares.at(d, l), light.at(d, l)) } else { (squares.at(l, d), light.at(l, d)) }
        };
        let mut hits = Vec::new();
        let looked = (reach..length.saturating_sub(reach)).step_by(2);
        let all = looked.len();
        for l in looked {
            let is_top = |d: usize| {
                let (grey, top) = value(d, l);
                f64::from(grey) > TOP * top
            };
            let Some(d) = (0..reach.min(depth / 2)).find(|d| is_top(*d) && is_top(d + 1)) else { continue };
            let profile = |k: i64| f64::from(value((d as i64 - k).max(0) as usize, l).0);
            hits.push((l as f64, d as f64 - crossing(profile, None)));
        }
        straight(&mut hits).filter(|_| hits.len() as f64 > WHOLE * all as f64).ok_or(NoBars::NoFrame { side })
    };
    let (left, right) = (line(0, false, "left")?, line(0, true, "right")?);
    let (low, high) = (line(1, false, "lower")?, line(1, true, "upper")?);
    // Turned to the left by a little, the left side is x = a - turn y, the lower one y = c + turn x.
    let turn = 0.25 * (low.1 - high.1 - left.1 + right.1);
    let middle = |axis: usize, near: (f64, f64), far: (f64, f64)| {
        let half = 0.5 * squares.size[1 - axis] as f64;
        let (near, far) = (near.0 + near.1 * half, squares.size[axis] as f64 - 1.0 - (far.0 + far.1 * half));
        squares.metres(axis, 0.5 * (near + far))
    };
    let centre = Vector3::new(middle(0, left, right), middle(1, low, high), 0.0);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
    let corner = centre - turn * Vector3::new(0.5 * known.sides[0], 0.5 * known.sides[1], 0.0);
    Ok(Pose::from_parts(Translation3::from(corner), turn))
}

/// The line through most of these points, which there must be many of: value at 0, and slope.
fn straight(points: &mut Vec<(f64, f64)>) -> Option<(f64, f64)> {
    let median = |part: &[(f64, f64)]| {
        let mut values: Vec<f64> = part.iter().map(|point| point.1).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    let (first, second) = points.split_at(points.len() / 2);
    let apart = second.first()?.0 - first.first()?.0;
    let slope = (median(second)? - median(first)?) / apart;
    let mut line = (median(first)? - slope * first.get(first.len() / 2)?.0, slope);
    for within in [6.0, 1.0, 0.5] {
        points.retain(|(x, y)| (y - line.0 - line.1 * x).abs() < within);
        let n = points.len() as f64;
        let (x, y) = points.iter().fold((0.0, 0.0), |sum, at| (sum.0 + at.0 / n, sum.1 + at.1 / n));
        let (xx, xy) = points
            .iter()
            .fold((0.0, 0.0), |sum, at| (sum.0 + (at.0 - x).powi(2), sum.1 + (at.0 - x) * (at.1 - y)));
        line = (y - xy / xx * x, xy / xx);
    }
    line.0.is_finite().then_some(line)
}

/// How far outwards from square 0, the last of a top, its edge is \[squares\]: where the brightness crosses the middle between inside
/// and outside. `side` is how wide a side is seen there, none where the edge looks away from the camera.
fn crossing(profile: impl Fn(i64) -> f64, side: Option<f64>) -> f64 {
    let inside = (-3..=0).map(&profile).fold(0.0, f64::max);
    let floor = (2..=4).map(&profile).fold(f64::INFINITY, f64::min);
    let outside = match side {
        None => floor,
        Some(width) if width >= 2.5 => profile((0.5 * width).round().max(2.0) as i64),
        Some(width) => {
            let floor = profile((width + 2.0).round() as i64).min(floor);
            floor + (SIDE * inside - floor).max(0.0) * (width / 2.0).min(1.0)
        }
    };
    let middle = 0.5 * (inside + outside);
    (-2..=3)
        .find_map(|k| {
            let (a, b) = (profile(k), profile(k + 1));
            (a >= middle && b < middle).then(|| k as f64 + (a - middle) / (a - b))
        })
        .unwrap_or(0.5)
}

/// In which direction bars lie: along an axis of M, 0 or 1.
type Axis = usize;

/// Squares straight on, and from where they are seen.
struct Sight<'s> {
    squares: &'s Rectified,
    /// The camera \[m, M\].
    eye: Vector3<f64>,
    known: &'s BarsKnown,
}

/// Runs of bright squares beside each other; each from the first square to the one behind the last.
#[derive(Clone, Copy, Debug)]
struct Strip {
    /// Of all runs together ..
    extent: [usize; 2],
    /// .. and of the longest one.
    longest: [usize; 2],
    /// The first and the last line.
    lines: [usize; 2],
}

impl Strip {
    const fn meets(&self, start: usize, end: usize) -> bool {
        self.extent[0] < end && start < self.extent[1]
    }

    fn join(&mut self, other: &Self) {
        let length = |run: [usize; 2]| run[1] - run[0];
        if length(other.longest) > length(self.longest) {
            self.longest = other.longest;
        }
        let both = |a: [usize; 2], b: [usize; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        self.extent = both(self.extent, other.extent);
        self.lines = both(self.lines, other.lines);
    }
}

impl Sight<'_> {
    fn boxes(&self, light: &Light) -> Vec<[Vector2<f64>; 2]> {
        let [columns, rows] = self.squares.size;
        let mut bright = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                bright.push(f64::from(self.squares.at(column, row)) > TOP * light.at(column, row));
            }
        }
        let mut boxes = Vec::new();
        for axis in [0, 1] {
            for strip in self.strips(&bright, axis) {
                boxes.push(self.bar(&strip, axis));
            }
        }
        for [lower, upper] in &boxes {
            self.clear(&mut bright, lower, upper);
        }
        self.posts(&mut bright, &mut boxes);
        boxes
    }

    fn grey(&self, axis: Axis, along: i64, across: i64) -> f64 {
        let (Ok(along), Ok(across)) = (usize::try_from(along), usize::try_from(across)) else { return 0.0 };
        let [column, row] = if axis == 0 { [along, across] } else { [across, along] };
        self.squares.at(column, row).into()
    }

    /// Runs longer than three times a bar's thickness, joined with those beside them.
    fn strips(&self, bright: &[bool], axis: Axis) -> Vec<Strip> {
        let [length, lines] = [self.squares.size[axis], self.squares.size[1 - axis]];
        let least = (3.0 * self.known.thickness / self.squares.cell).ceil() as usize;
        let index = |along: usize, line: usize| {
            if axis == 0 { line * self.squares.size[0] + along } else { along * self.squares.size[0] + line }
        };
        let (mut done, mut open): (Vec<Strip>, Vec<Strip>) = (Vec::new(), Vec::new());
        for line in 0..lines {
            let mut from = None;
            for along in 0..=length {
                let is_bright = along < length && bright[index(along, line)];
                match (is_bright, from) {
                    (true, None) => from = Some(along),
                    (false, Some(start)) => {
                        from = None;
                        if along - start < least {
                            continue;
                        }
                        // Where the light is at the threshold, a line has several runs on one bar.
                        let mut strip =
                            Strip { extent: [start, along], longest: [start, along], lines: [line; 2] };
                        for other in open.extract_if(.., |other| other.meets(start, along)) {
                            strip.join(&other);
                        }
                        open.push(strip);
                    }
                    (true, Some(_)) | (false, None) => {}
                }
            }
            done.extend(open.extract_if(.., |strip| strip.lines[1] < line));
        }
        done.extend(open);
        done
    }

    /// How wide a side is seen at a place along an axis \[squares\], and whether an edge there that looks up the axis shows it.
    fn side(&self, axis: Axis, at: f64) -> (f64, bool) {
        let off = self.eye[axis] - self.squares.metres(axis, at);
        (off.abs() * self.known.height / self.eye.z / self.squares.cell, off > 0.0)
    }

    /// Where a thing is across an axis, by its edge that looks away from the camera \[m\]; `lines` are those of its bright squares.
    fn across(&self, axis: Axis, lines: [usize; 2], along: [usize; 2]) -> f64 {
        let middle = 0.5 * (lines[0] + lines[1]) as f64;
        let (_, up_shows) = self.side(1 - axis, middle);
        let half = 0.5 * self.known.thickness;
        let edge = |up: bool| {
            let (last, sign) = if up { (lines[1] as i64, 1) } else { (lines[0] as i64, -1) };
            let (mut sum, mut count) = (0.0, 0.0);
            for i in along[0]..=along[1] {
                let profile = |k: i64| self.grey(axis, i as i64, last + sign * k);
                // Not where another bar is joined.
                let inside = (-3..=0).map(profile).fold(0.0, f64::max);
                if (2..=4).map(profile).fold(f64::INFINITY, f64::min) < 0.3 * inside {
                    let (width, _) = self.side(1 - axis, middle);
                    sum += crossing(profile, (up == up_shows).then_some(width));
                    count += 1.0;
                }
            }
            (last as f64 + f64::from(sign as i32) * sum / count, count)
        };
        let (away, clean) = edge(!up_shows);
        let (place, up) = if clean >= 3.0 { (away, !up_shows) } else { (edge(up_shows).0, up_shows) };
        if place.is_finite() {
            self.squares.metres(1 - axis, place) + if up { -half } else { half }
        } else {
            self.squares.metres(1 - axis, middle)
        }
    }

    fn bar(&self, strip: &Strip, axis: Axis) -> [Vector2<f64>; 2] {
        let (start, end) = (strip.longest[0], strip.longest[1] - 1);
        let centre = self.across(axis, strip.lines, [start + 3, end.saturating_sub(3).max(start + 3)]);
        let line = (centre - self.squares.origin[1 - axis]) / self.squares.cell;
        let row = line.round() as i64;
        let end_at = |last: usize, sign: i64| {
            let profile = |k: i64| {
                (-1..=1).map(|off| self.grey(axis, last as i64 + sign * k, row + off)).sum::<f64>() / 3.0
            };
            let (width, up_shows) = self.side(axis, last as f64);
            let crossed = crossing(profile, (up_shows == (sign > 0)).then_some(width));
            self.squares.metres(axis, last as f64 + sign as f64 * crossed)
        };
        let (lower, upper) = (end_at(start, -1), end_at(end, 1));
        let half = 0.5 * self.known.thickness;
        let point = |along: f64, across: f64| {
            if axis == 0 { Vector2::new(along, across) } else { Vector2::new(across, along) }
        };
        [point(lower, centre - half), point(upper, centre + half)]
    }

    /// Squares that a box explains.
    fn clear(&self, bright: &mut [bool], lower: &Vector2<f64>, upper: &Vector2<f64>) {
        let to = |axis: usize, at: f64, off: f64| {
            let last = self.squares.size[axis] as f64 - 1.0;
            (((at - self.squares.origin[axis]) / self.squares.cell + off).round().clamp(0.0, last)) as usize
        };
        for row in to(1, lower.y, -1.5)..=to(1, upper.y, 1.5) {
            for column in to(0, lower.x, -1.5)..=to(0, upper.x, 1.5) {
                bright[row * self.squares.size[0] + column] = false;
            }
        }
    }

    /// What is left and large enough stands alone.
    fn posts(&self, bright: &mut [bool], boxes: &mut Vec<[Vector2<f64>; 2]>) {
        let columns = self.squares.size[0];
        let least = (0.4 * (self.known.thickness / self.squares.cell).powi(2)).max(2.0);
        let half = Vector2::repeat(0.5 * self.known.thickness);
        for first in 0..bright.len() {
            if !bright[first] {
                continue;
            }
            let (mut stack, mut area) = (vec![first], 0.0);
            let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
            bright[first] = false;
            while let Some(index) = stack.pop() {
                area += 1.0;
                for (axis, at) in [index % columns, index / columns].into_iter().enumerate() {
                    low[axis] = low[axis].min(at);
                    high[axis] = high[axis].max(at);
                }
                for next in [index.wrapping_sub(1), index + 1, index.wrapping_sub(columns), index + columns] {
                    if bright.get(next) == Some(&true) {
                        bright[next] = false;
                        stack.push(next);
                    }
                }
            }
            if area >= least {
                let middle = |axis: usize| {
                    let at = usize::midpoint(low[axis], high[axis]);
                    [at.saturating_sub(1), at + 1]
                };
                let y = self.across(0, [low[1], high[1]], middle(0));
                let x = self.across(1, [low[0], high[0]], middle(1));
                boxes.push([Vector2::new(x, y) - half, Vector2::new(x, y) + half]);
            }
        }
    }
}
