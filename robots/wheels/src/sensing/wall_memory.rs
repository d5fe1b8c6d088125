//! Which walls the base has seen, and what they say about where it stands.
//!
//! ```text
//! hits of one sensor one after the other, or of neighbours at once, on a level or an upright line:  a seen piece of a wall
//! a piece near a known wall of the same direction: that wall; the base stands beside where it thinks by the difference
//! a piece that leans: the heading is off by so much;          any other piece: a new wall
//! ```
//!
//! What is known beforehand: walls are level or upright, so thick, and leave passages of some width. No grid is known: whether walls stand at
//! multiples of one spacing, and which, is learned from those that were seen ([`mrroc_map::spacing`]). Then a face is where the multiple
//! next to it says, however the base had drifted when it was seen first: without that, errors of its place add up from wall to wall.

use mrroc_map::{Contact, Knowledge, spacing};
use nalgebra::Vector2;

use super::planar::Planar;

/// Two pieces of one direction are of one wall if their lines are nearer than this \[m\].
pub const SAME: f64 = 0.045;
/// A piece is at least so long \[m\] ..
const SHORTEST: f64 = 0.028;
/// .. and no place of it is farther from its line \[m\].
const SCATTER: f64 = 0.006;
/// Places of a piece are no farther apart along it \[m\].
const GAP: f64 = 0.03;
/// From wall to piece along the wall \[m\].
const JOINED: f64 = 0.04;
/// Places that are kept of a sensor.
const KEPT: usize = 16;
/// Share of a difference by which the base's place is corrected at once.
const GAIN: f64 = 0.25;
/// The same of its heading.
const TURNING: f64 = 0.06;
/// A wall that was seen so many times is known as well as can be.
const SURE: u32 = 1000;
/// How many walls are told at a time.
pub const TOLD: usize = 10;

/// A face of a wall, as it was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, mrroc::payload::Payload)]
pub struct Face {
    /// In which direction one looks at it: 0 along +x, 1 along +y, 2 along -x, 3 along -y.
    pub into: u8,
    /// Where it is along that axis \[m\].
    pub line: f64,
    /// Where it begins and ends along the other axis, `from` <= `to` \[m\].
    pub from: f64,
    /// See `from`.
    pub to: f64,
}

impl Face {
    /// The direction into it.
    #[must_use]
    pub fn direction(&self) -> Vector2<f64> {
        [Vector2::x(), Vector2::y(), -Vector2::x(), -Vector2::y()][usize::from(self.into % 4)]
    }

    /// Both its ends \[m\].
    #[must_use]
    pub fn ends(&self) -> [Vector2<f64>; 2] {
        let upright = self.into.is_multiple_of(2);
        [self.from, self.to]
            .map(|s| if upright { Vector2::new(self.line, s) } else { Vector2::new(s, self.line) })
    }
}

/// A face with how many pieces were seen of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Known {
    face: Face,
    seen: u32,
}

/// The walls that are known.
#[derive(Clone, Debug)]
pub struct WallMemory {
    known: Vec<Known>,
    /// Of each sensor, the places that it met last, the newest last.
    traces: Vec<Vec<Vector2<f64>>>,
    /// Numbers of those that changed last, the newest last.
    changed: Vec<usize>,
    told: Knowledge,
    /// At whose multiples walls stand \[m\], once that is learned.
    spacing: Option<f64>,
}

/// What is seen of a wall at a time.
struct Piece {
    face: Face,
    /// How much it leans, counterclockwise from its axis \[rad\], if it is long enough to tell.
    lean: Option<f64>,
}

impl WallMemory {
    /// Of a maze of which so much is known beforehand, by so many sensors.
    #[must_use]
    pub fn of_frame(told: Knowledge, sensors: usize) -> Self {
        let ([width, height], half) = (told.size, 0.5 * told.thickness);
        let side = |into: u8, line: f64, length: f64| Known {
            face: Face { into, line, from: 0.0, to: length },
            seen: SURE,
        };
        let known = vec![
            side(0, width - half, height),
            side(1, height - half, width),
            side(2, half, height),
            side(3, half, width),
        ];
        Self {
            known,
            traces: vec![Vec::with_capacity(KEPT); sensors],
            changed: Vec::with_capacity(TOLD),
            told,
            spacing: None,
        }
    }

    /// The spacing at whose multiples walls stand \[m\], once those that were seen bear one out.
    #[must_use]
    pub const fn spacing(&self) -> Option<f64> {
        self.spacing
    }

    /// The walls that changed last, the newest first.
    pub fn changed(&self) -> impl Iterator<Item = Face> {
        self.changed.iter().rev().map(|number| self.known[*number].face)
    }

    /// All walls that are known.
    pub fn faces(&self) -> impl Iterator<Item = Face> {
        self.known.iter().map(|known| known.face)
    }

    /// A sensor has met something at `hit`, or nothing. Where the base stands then, corrected.
    pub fn trace(&mut self, sensor: usize, hit: Option<Vector2<f64>>, pose: Planar) -> Planar {
        let Some(trace) = self.traces.get_mut(sensor) else { return pose };
        let Some(hit) = hit else {
            trace.clear();
            return pose;
        };
        if trace.last().is_some_and(|last| (hit - last).norm() > GAP) {
            trace.clear();
        }
        if trace.last().is_some_and(|last| (hit - last).norm() < 0.004) {
            return pose;
        }
        if trace.len() == KEPT {
            trace.remove(0);
        }
        trace.push(hit);
        let places = core::mem::take(trace);
        let corrected = self.learn(&places, pose);
        self.traces[sensor] = places;
        self.shift(&(corrected.at() - pose.at()));
        corrected
    }

    /// Sensors side by side have met these places at once. Where the base stands then, corrected.
    pub fn side_by_side(&mut self, hits: &[Option<Vector2<f64>>], pose: Planar) -> Planar {
        let mut places = Vec::with_capacity(hits.len());
        let mut corrected = pose;
        for hit in hits.iter().copied().chain([None]) {
            match hit {
                Some(hit) => places.push(hit),
                None => {
                    corrected = self.learn(&places, corrected);
                    places.clear();
                }
            }
        }
        self.shift(&(corrected.at() - pose.at()));
        corrected
    }

    fn shift(&mut self, by: &Vector2<f64>) {
        for hit in self.traces.iter_mut().flatten() {
            *hit += by;
        }
    }

    /// Learns from the longest end of these places that is a piece of a wall, as it is seen from the base.
    fn learn(&mut self, places: &[Vector2<f64>], pose: Planar) -> Planar {
        let pieces = [0, 1].map(|axis| piece(places, axis, &pose));
        // Of a corner, the piece that is longer.
        let length = |piece: &Piece| piece.face.to - piece.face.from;
        let longest = pieces.into_iter().flatten().max_by(|a, b| length(a).total_cmp(&length(b)));
        match longest {
            Some(piece) => self.take(&piece, pose),
            None => pose,
        }
    }

    fn take(&mut self, piece: &Piece, pose: Planar) -> Planar {
        let seen = piece.face;
        let same = |known: &Known| {
            let face = &known.face;
            face.into == seen.into
                && (face.line - seen.line).abs() < SAME
                && seen.from < face.to + JOINED
                && seen.to > face.from - JOINED
        };
        let off = |known: &Known| (known.face.line - seen.line).abs();
        let found = (0..self.known.len())
            .filter(|i| same(&self.known[*i]))
            .min_by(|a, b| off(&self.known[*a]).total_cmp(&off(&self.known[*b])));
        let mut corrected = pose;
        if let Some(lean) = piece.lean {
            corrected.heading -= TURNING * lean;
        }
        let Some(number) = found else {
            // It may be the other face of a wall that is known, or at a multiple of the spacing.
            let line = self.multiple(&seen).or_else(|| self.through(&seen)).unwrap_or(seen.line);
            let beside = line - seen.line;
            if seen.into.is_multiple_of(2) {
                corrected.x += GAIN * beside;
            } else {
                corrected.y += GAIN * beside;
            }
            self.known.push(Known { face: Face { line, ..seen }, seen: if beside == 0.0 { 1 } else { 8 } });
            self.tell(self.known.len() - 1);
            self.learn_spacing();
            return corrected;
        };
        let known = &mut self.known[number];
        let beside = known.face.line - seen.line;
        // A wall that was seen a few times only is not known better than the base's place.
        let share = f64::from(known.seen) / (f64::from(known.seen) + 4.0);
        if seen.into.is_multiple_of(2) {
            corrected.x += GAIN * share * beside;
        } else {
            corrected.y += GAIN * share * beside;
        }
        known.face.line -= (1.0 - share) * beside / 4.0;
        known.seen = (known.seen + 1).min(SURE);
        known.face.from = known.face.from.min(seen.from);
        known.face.to = known.face.to.max(seen.to);
        self.tell(number);
        corrected
    }

    /// Where this face is if walls stand at multiples of the spacing that was learned.
    fn multiple(&self, seen: &Face) -> Option<f64> {
        let s = self.spacing?;
        let half = if seen.into < 2 { -0.5 } else { 0.5 } * self.told.thickness;
        let line = ((seen.line - half) / s).round() * s + half;
        ((line - seen.line).abs() < SAME).then_some(line)
    }

    /// Whether walls stand at multiples of one spacing, by all faces that are known; if so, they are put there.
    fn learn_spacing(&mut self) {
        let met = |known: &Known| {
            let (into, [from, to]) = (known.face.direction(), known.face.ends());
            let at = 0.5 * (from + to);
            Contact { at, into, moving: into, ball: at - into * self.told.radius }
        };
        let contacts: Vec<_> = self.known.iter().map(met).collect();
        self.spacing = spacing(&contacts, &self.told, self.spacing);
        for number in 0..self.known.len() {
            if let Some(line) = self.multiple(&self.known[number].face) {
                self.known[number] = Known { face: Face { line, ..self.known[number].face }, seen: SURE };
            }
        }
    }

    /// Where this face is if it is the other one of a wall that was seen a few times before.
    fn through(&self, seen: &Face) -> Option<f64> {
        let thick = if seen.into < 2 { -self.told.thickness } else { self.told.thickness };
        let other = self.known.iter().find(|known| {
            let face = &known.face;
            face.into % 4 == (seen.into + 2) % 4
                && known.seen > 4
                && (face.line + thick - seen.line).abs() < SAME
                && seen.from < face.to
                && seen.to > face.from
        })?;
        Some(other.face.line + thick)
    }

    fn tell(&mut self, number: usize) {
        // The frame need not be told.
        if number < 4 || self.changed.last() == Some(&number) {
            return;
        }
        self.changed.retain(|other| *other != number);
        if self.changed.len() == TOLD {
            self.changed.remove(0);
        }
        self.changed.push(number);
    }
}

/// The longest end of `places` that lies on one line on which this coordinate, 0 or 1, is constant.
fn piece(places: &[Vector2<f64>], axis: usize, pose: &Planar) -> Option<Piece> {
    let other = 1 - axis;
    let last = places.last()?;
    let (mut sum, mut count) = (0.0, 0.0);
    let (mut from, mut to) = (last[other], last[other]);
    let mut before = *last;
    let mut taken = 0;
    for at in places.iter().rev() {
        let mean = if count > 0.0 { sum / count } else { at[axis] };
        if (at[axis] - mean).abs() > SCATTER || (at[other] - before[other]).abs() > GAP {
            break;
        }
        sum += at[axis];
        count += 1.0;
        taken += 1;
        (from, to) = (from.min(at[other]), to.max(at[other]));
        before = *at;
    }
    if taken < 3 || to - from < SHORTEST {
        return None;
    }
    let (line, middle) = (sum / count, 0.5 * (from + to));
    // A line through them by least squares: what it leans.
    let (mut cross, mut square, mut mean) = (0.0, 0.0, 0.0);
    for at in &places[places.len() - taken..] {
        mean += at[other] / count;
    }
    for at in &places[places.len() - taken..] {
        cross += (at[axis] - line) * (at[other] - mean);
        square += (at[other] - mean) * (at[other] - mean);
    }
    let slope = cross / square;
    if slope.abs() > 0.2 {
        return None;
    }
    // Along y, x falls as it leans counterclockwise.
    let lean = if axis == 0 { -slope } else { slope };
    let seen_from = pose.at()[axis];
    let into = match (axis, line > seen_from) {
        (0, true) => 0,
        (_, true) => 1,
        (0, false) => 2,
        (_, false) => 3,
    };
    // What is seen at a grazing angle is not believed.
    let away = ((line - seen_from).abs(), (middle - pose.at()[other]).abs());
    if away.1 > 2.5 * away.0 {
        return None;
    }
    Some(Piece { face: Face { into, line, from, to }, lean: (to - from > 0.05).then_some(lean) })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALL: Knowledge =
        Knowledge { size: [1.8, 1.8], radius: 0.045, thickness: 0.012, passage: 0.15, wall: 0.18 };

    #[test]
    fn a_base_that_is_wrong_about_its_place_is_put_right_by_a_wall_that_it_knows() {
        let mut memory = WallMemory::of_frame(HALL, 1);
        // It drives upwards, 84 mm beside the left side of the frame, and thinks that it is 10 mm farther to the right and turned by 2 degrees.
        let mut error = Planar { x: 0.010, y: 0.0, heading: 0.035 };
        for k in 0..300 {
            let (x, y) = (0.09, 0.2 + 0.004 * f64::from(k));
            let pose = Planar {
                x: x + error.x,
                y: y + error.y,
                heading: core::f64::consts::FRAC_PI_2 + error.heading,
            };
            // What it sees to its left: the wall's face at x = 6 mm.
            let hit = pose.place(&Vector2::new(0.0, x - 0.006));
            let better = memory.trace(0, Some(hit), pose);
            error = Planar {
                x: better.x - x,
                y: better.y - y,
                heading: better.heading - core::f64::consts::FRAC_PI_2,
            };
            // A wrong heading leads it aside in its own mind.
            error.x -= 0.004 * error.heading;
        }
        assert!(error.x.abs() < 1e-3 && error.heading.abs() < 5e-3, "{error:?}");
        assert_eq!(memory.changed().count(), 0);
    }

    #[test]
    fn a_wall_with_an_opening_is_seen_as_two() {
        let mut memory = WallMemory::of_frame(HALL, 1);
        for k in 0..140 {
            let pose =
                Planar { x: 0.9, y: 0.2 + 0.004 * f64::from(k), heading: core::f64::consts::FRAC_PI_2 };
            let open = (0.36..0.52).contains(&pose.y);
            memory.trace(0, (!open).then(|| pose.place(&Vector2::new(0.0, 0.084))), pose);
        }
        let faces: Vec<Face> = memory.changed().collect();
        assert_eq!(faces.len(), 2, "{faces:?}");
        assert!(faces.iter().all(|face| face.into == 2 && (face.line - 0.816).abs() < 1e-9));
        assert!((faces[1].to - 0.356).abs() < 5e-3 && (faces[0].from - 0.52).abs() < 5e-3, "{faces:?}");
    }

    #[test]
    fn a_base_that_has_drifted_is_put_right_by_a_wall_that_it_never_saw_once_the_spacing_is_learned() {
        let mut memory = WallMemory::of_frame(HALL, 1);
        // Eight upright walls, seen from the left as it passes them, each at a multiple of 0.18 m.
        let mut pass = |line: f64, error: f64| {
            let mut error = error;
            for k in 0..40 {
                let (x, y) = (line - 0.09, 0.3 + 0.004 * f64::from(k));
                let pose = Planar { x: x + error, y, heading: core::f64::consts::FRAC_PI_2 };
                let hit = pose.place(&Vector2::new(0.0, -(line - 0.006 - x)));
                error = memory.trace(0, Some(hit), pose).x - x;
            }
            error
        };
        for line in [2, 3, 5, 6, 7, 8] {
            pass(0.18 * f64::from(line), 0.002);
        }
        // By now it is off by 20 mm, and comes to another one.
        let error = pass(0.18 * 4.0, 0.020);
        assert!(error.abs() < 1e-3, "{error}");
        assert_eq!(memory.spacing(), Some(0.18));
    }

    #[test]
    fn where_walls_stand_anywhere_a_base_that_has_drifted_takes_a_new_one_to_be_where_it_sees_it() {
        let mut memory = WallMemory::of_frame(HALL, 1);
        let mut pass = |line: f64| {
            for k in 0..40 {
                let pose = Planar {
                    x: line - 0.09,
                    y: 0.3 + 0.004 * f64::from(k),
                    heading: core::f64::consts::FRAC_PI_2,
                };
                let better = memory.trace(0, Some(pose.place(&Vector2::new(0.0, -0.084))), pose);
                assert!((better.x - pose.x).abs() < 1e-12);
            }
        };
        // Their distances have no common measure.
        [0.31, 0.507, 0.711, 0.99, 1.207, 1.43].into_iter().for_each(&mut pass);
        assert_eq!(memory.spacing(), None);
    }
}
