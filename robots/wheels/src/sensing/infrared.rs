//! Infrared distance sensors around the base, by triangulation: what codes they give.
//!
//! ```text
//! d >= 4 cm   code = 11 + 2076 / (d / cm), times 1 +- 1 % by the unit, noise of 2 codes
//! nearer      it falls back to 0: a nearer wall seems farther away. So the sensors look across the base, from its other side
//! beyond      of 30 cm the code is not believed
//! ```
//!
//! A sensor takes a new sample every 16.5 ms, and says it until the next one; sensors are not in step with each other. Each sees along a line.
//! Seven look ahead side by side, 11 mm apart, and four more at each side a little outwards: walls are 12 mm thick, so that no end of a wall in
//! the body's path stays unseen.

use mrroc::random::Random;
use mrroc_map::{Place, Wall, Walls};
use nalgebra::Vector2;

use super::gyro::normal;
use crate::simulation::Floor;

/// How many look ahead; they are the first ones.
pub const FRONT: usize = 15;
/// How many there are.
pub const SENSORS: usize = 21;

/// Where a sensor is on the base, and in which direction it looks \[rad\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounted {
    /// [m, base].
    pub at: Vector2<f64>,
    /// From ahead, counterclockwise \[rad\].
    pub looks: f64,
}

/// Where they all are, all within the round body: fifteen ahead from right to left, two to each side, and one to each side ahead.
#[must_use]
pub fn mounted(sensor: usize) -> Mounted {
    use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    let there = |x: f64, y: f64, looks: f64| Mounted { at: Vector2::new(x, y), looks };
    match sensor {
        0..FRONT => {
            // Where it looks through just ahead of the body, and where it is.
            let number = sensor as f64 - 7.0;
            let outwards = (number.abs() - 3.0).max(0.0).copysign(number);
            let through = 0.011 * (number - outwards) + 0.0055 * outwards;
            let beside = through.clamp(-0.033, 0.033);
            there(-0.030, beside, ((through - beside) / 0.065).atan())
        }
        15 => there(0.025, -0.030, FRAC_PI_2),
        16 => there(-0.025, -0.030, FRAC_PI_2),
        17 => there(0.025, 0.030, -FRAC_PI_2),
        18 => there(-0.025, 0.030, -FRAC_PI_2),
        19 => there(-0.020, -0.020, FRAC_PI_4),
        _ => there(-0.020, 0.020, -FRAC_PI_4),
    }
}

/// What a code is at a distance \[m\], without errors.
#[must_use]
pub fn code(distance: f64) -> f64 {
    const NEAREST: f64 = 0.04;
    let far = |distance: f64| 11.0 + 20.76 / distance;
    if distance < NEAREST { far(NEAREST) * distance / NEAREST } else { far(distance) }
}

/// The distance of a code \[m\], from 4 to 30 cm; `None` of one that tells of nothing there.
///
/// ```
/// use mrroc_wheels::sensing::infrared::{code, distance};
/// assert!((distance(code(0.10)).unwrap_or(0.0) - 0.10).abs() < 1e-12);
/// assert_eq!(distance(code(0.35)), None);
/// ```
#[must_use]
pub fn distance(code: f64) -> Option<f64> {
    (code > 11.0).then(|| 20.76 / (code - 11.0)).filter(|distance| *distance < 0.30)
}

/// The sensors of a base.
#[derive(Debug)]
pub struct Infrared {
    floor: Floor,
    chance: Random,
    gains: [f64; SENSORS],
    next: [f64; SENSORS],
    blind: [bool; SENSORS],
}

impl Infrared {
    /// Time from sample to sample \[s\].
    pub const SAMPLE: f64 = 0.0165;
    /// Noise, in codes.
    const NOISE: f64 = 2.0;
    /// They see no farther \[m\].
    const FARTHEST: f64 = 0.40;

    /// On the base of this floor.
    #[must_use]
    pub fn new(floor: Floor, seed: u64) -> Self {
        let mut chance = Random::seeded(seed ^ 0x6972);
        let gains = core::array::from_fn(|_| 1.0 + chance.within(0.01));
        let next = core::array::from_fn(|_| Self::SAMPLE * chance.unit());
        Self { floor, chance, gains, next, blind: [false; SENSORS] }
    }

    /// A sensor that never sees anything from now on.
    pub fn blind(&mut self, sensor: usize) {
        if let Some(blind) = self.blind.get_mut(sensor) {
            *blind = true;
        }
    }

    /// The codes of the sensors that have taken a new sample since this was asked last.
    pub fn ask(&mut self) -> [Option<f64>; SENSORS] {
        let (pose, now) = (self.floor.motion().pose, self.floor.time());
        core::array::from_fn(|i| {
            if now < self.next[i] {
                return None;
            }
            self.next[i] +=
                Self::SAMPLE * ((now - self.next[i]) / Self::SAMPLE).floor().max(0.0) + Self::SAMPLE;
            let Mounted { at, looks } = mounted(i);
            let (sine, cosine) = (pose.heading + looks).sin_cos();
            let seen = self
                .floor
                .walls(|walls| ray(walls, &pose.place(&at), &Vector2::new(cosine, sine), Self::FARTHEST));
            let clean = match seen.flatten().filter(|_| !self.blind[i]) {
                Some(distance) => self.gains[i] * code(distance),
                None => 11.0,
            };
            Some((clean + Self::NOISE * normal(&mut self.chance)).round().max(0.0))
        })
    }
}

/// How far a wall is along a ray \[m\], within `most`.
#[must_use]
pub fn ray(walls: &Walls, from: &Place, along: &Vector2<f64>, most: f64) -> Option<f64> {
    // Walls within half a pitch of places on the ray are all that it can meet; boxes farther on are met by later places.
    let step = 0.5 * walls.pitch();
    let mut nearest = most;
    let mut at = 0.0;
    while at < nearest + step {
        for wall in walls.near(&(from + along * at.min(most))) {
            if let Some(distance) = meets(wall, from, along) {
                nearest = nearest.min(distance);
            }
        }
        at += step;
    }
    (nearest < most).then_some(nearest)
}

/// Where a ray enters a box (the slab method).
fn meets(wall: &Wall, from: &Place, along: &Vector2<f64>) -> Option<f64> {
    let (mut first, mut last) = (0.0_f64, f64::INFINITY);
    for axis in 0..2 {
        let (low, high) = (wall.lower[axis] - from[axis], wall.upper[axis] - from[axis]);
        if along[axis].abs() < 1e-12 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
        } else {
            let (a, b) = (low / along[axis], high / along[axis]);
            first = first.max(a.min(b));
            last = last.min(a.max(b));
        }
    }
    (first <= last).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DiffDrive;
    use mrroc_map::Layout;

    #[test]
    fn a_ray_meets_the_same_wall_as_when_every_wall_is_tried() {
        let maze = Layout::random(16, 5);
        let walls = Walls::of(&maze, 0.18, 0.012);
        let mut chance = Random::seeded(2);
        for _ in 0..3000 {
            let from = Place::new(1.44 + chance.within(1.4), 1.44 + chance.within(1.4));
            let (sine, cosine) = chance.within(4.0).sin_cos();
            let along = Vector2::new(cosine, sine);
            let all = walls.boxes().iter().filter_map(|wall| meets(wall, &from, &along));
            let all = all.fold(f64::INFINITY, f64::min);
            let found = ray(&walls, &from, &along, 0.4);
            assert_eq!(found, Some(all).filter(|all| *all < 0.4), "{from} {along}");
        }
    }

    #[test]
    fn ahead_of_the_body_no_end_of_a_wall_lies_between_two_sensors() {
        // Their lines, so far ahead of the axle.
        let line = |i: usize, x: f64| {
            let Mounted { at, looks } = mounted(i);
            at.y + (x - at.x) * looks.tan()
        };
        for i in 1..FRONT {
            for beyond in [0.0, 0.03] {
                // Where the body would touch what is at this line after going on by so much.
                let y: f64 = line(i, 0.035).abs().min(line(i - 1, 0.035).abs());
                let rim = (DiffDrive::BODY * DiffDrive::BODY - y * y).max(0.0).sqrt();
                let x = rim + beyond;
                assert!(line(i, x) - line(i - 1, x) < 0.012, "{i} {x}");
            }
        }
        assert!(line(FRONT - 1, 0.02) > DiffDrive::BODY);
        assert!((0..SENSORS).all(|i| mounted(i).at.norm() <= DiffDrive::BODY));
    }
}
