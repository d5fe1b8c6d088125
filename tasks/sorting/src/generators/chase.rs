//! What the behaviours of the arm share: the motion of the tool, and the part that it is after.

use core::cell::Cell;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_sensors::physics::Triangulation;
use mrroc_sensors::virtual_sensors::{AcrossReading, GateReading};
use nalgebra::Vector3;

use crate::places::{PART, RANGE_AT, RANGE_FROM, SPACING, tool};

/// The tool's motion and the part, as all behaviours see them. They are copied, not borrowed, in each step.
#[derive(Clone, Debug, Default)]
pub struct Chase {
    /// Where the tool is demanded to be.
    pub tool: Rc<Cell<Pursuit>>,
    /// The part that it is after.
    pub part: Rc<Cell<Option<Part>>>,
    /// Why the last part was let pass.
    pub missed: Rc<Cell<Option<Missed>>>,
    /// Whether sensors are used after the first edge, or not.
    pub open: Option<Open>,
}

/// Open loop: the first edge tells when a part comes; its speed and length are believed, not measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Open {
    /// Nominal speed of the belt [m/s].
    pub speed: f64,
    /// Length that parts are believed to have \[m\].
    pub length: f64,
}

/// Why a part was let pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missed {
    /// It would have come between the fingers beyond the arm's reach.
    TooFar,
    /// It did not come between the fingers where it was expected.
    NotThere,
    /// Something came between the fingers where it was not expected.
    Elsewhere,
    /// It was lost while the hand closed.
    Lost,
}

/// A part on the belt, extrapolated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its middle along the belt \[m\], when the demand of this step is attained.
    pub s: f64,
    /// [m/s].
    pub speed: f64,
    /// \[m\].
    pub length: f64,
    /// Across the belt, from its middle \[m\].
    pub across: f64,
}

impl Part {
    /// From the step of a demand to the step's end at which the tool is there \[s\]: the cell's delay.
    pub const DELAY: f64 = 0.009;

    /// The last value of a part is finished within so long of when its trailing edge has left the range finder, some values of 38 ms that
    /// are no number among them \[s\].
    const LAST: f64 = 0.15;
    /// Such a share of a part must have been seen: the second half of a disc has a median 3.4 mm beside its near side.
    const SEEN: f64 = 0.5;

    /// Whether gate and range finder tell of one part, of which the range finder has seen enough: if it was not read for a while it tells of
    /// the part before, or of the end of this one, which its only value may have seen for a share of its time.
    #[must_use]
    pub fn is_one(gate: &GateReading, range: &AcrossReading) -> bool {
        // Its trailing edge left the range finder before the second barrier.
        let left = gate.since - RANGE_AT / gate.speed;
        let values = gate.length / gate.speed / Triangulation::UPDATE;
        (range.since - left).abs() < Self::LAST && f64::from(range.values) >= Self::SEEN * values
    }

    /// The part that gate and range finder tell; their readings are so many seconds old.
    #[must_use]
    pub fn seen(gate: &GateReading, range: &AcrossReading, age: f64, open: Option<Open>) -> Self {
        let later = age + Self::DELAY;
        let across = range.distance + 0.5 * PART[0] - RANGE_FROM;
        match open {
            None => Self { s: gate.place(later), speed: gate.speed, length: gate.length, across },
            Some(Open { speed, length }) => {
                let s = speed * (gate.came + later) - SPACING - 0.5 * length;
                Self { s, speed, length, across }
            }
        }
    }

    /// The same part `dt` \[s\] later.
    #[must_use]
    pub fn after(self, dt: f64) -> Self {
        Self { s: self.s + self.speed * dt, ..self }
    }
}

/// A motion of the tool that pursues a place within limits, from any motion: so behaviours take it over from each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pursuit {
    /// Along the belt, across it, over it \[m\].
    pub at: Vector3<f64>,
    /// [m/s].
    pub velocity: Vector3<f64>,
}

impl Pursuit {
    /// The largest acceleration \[m/s²\] ..
    const ACCELERATION: f64 = 1.2;
    /// .. and the largest speed relative to the place [m/s].
    const SPEED: f64 = 0.35;
    /// How fast a small distance decays [1/s].
    const RATE: f64 = 9.0;
    /// How fast a difference of velocities decays [1/s].
    const DAMPING: f64 = 40.0;

    /// At rest where the tool is.
    #[must_use]
    pub fn at_rest(pose: &Pose) -> Self {
        let origin = tool(0.0, 0.0, 0.0).translation.vector;
        let at = pose.translation.vector - origin;
        Self { at: Vector3::new(at.y, at.x, at.z), velocity: Vector3::zeros() }
    }

    /// A step of `dt` \[s\] after `place`, which moves at `moving`, both along, across and over the belt.
    ///
    /// The distance is to be closed at a speed from which the tool can brake with half of the acceleration, and the difference to
    /// that velocity decays, both within the limit. Once it goes with the place it is where that will be a step later.
    #[must_use]
    pub fn after(self, place: &Vector3<f64>, moving: &Vector3<f64>, dt: f64) -> Self {
        let offset = place - self.at;
        let distance = offset.norm();
        let speed = (Self::RATE * distance).min(Self::SPEED).min((Self::ACCELERATION * distance).sqrt());
        let wanted = if distance > 0.0 { moving + offset * (speed / distance) } else { *moving };
        let pull = (wanted - self.velocity) * Self::DAMPING;
        let excess = (pull.norm() / Self::ACCELERATION).max(1.0);
        let velocity = self.velocity + pull / excess * dt;
        Self { at: self.at + velocity * dt, velocity }
    }

    /// The tool there.
    #[must_use]
    pub fn pose(&self) -> Pose {
        tool(self.at.x, self.at.y, self.at.z)
    }
}

impl Chase {
    /// Pursues a place for a step, and demands where that brings the tool.
    pub fn pursue<R: Robot>(&self, place: Vector3<f64>, moving: f64, dt: f64) -> Step<R> {
        let next = self.tool.get().after(&place, &Vector3::new(moving, 0.0, 0.0), dt);
        self.tool.set(next);
        Step::Next(Demand::pose(next.pose()))
    }

    /// Takes the tool up from a part that was lost: the hand may have it all the same.
    pub fn lose<R: Robot>(&self) -> Step<R> {
        self.missed.set(Some(Missed::Lost));
        Step::Done
    }

    /// Lets the part pass.
    pub fn miss<R: Robot>(&self, why: Missed) -> Step<R> {
        self.missed.set(Some(why));
        self.part.set(None);
        Step::Done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_passed_the_range_finder_while_that_was_not_read_is_not_taken_for_the_one_before() {
        for speed in [0.016, 0.05, 0.18] {
            // Half a second ago it left the second barrier, and the range finder 30 mm before that.
            let length = 0.06;
            let gate = GateReading { parts: 2, since: 0.5, speed, length, ..GateReading::default() };
            let told = |since: f64, values: u32| {
                let range = AcrossReading { parts: 2, since, values, ..AcrossReading::default() };
                Part::is_one(&gate, &range)
            };
            let left = 0.5 + 0.03 / speed;
            // A value takes 38 ms.
            let whole = (length / speed / 0.038) as u32;
            assert!(
                told(left, whole) && told(left - 0.038, whole) && told(left + 2.0 * 0.038, whole),
                "{speed}"
            );
            // Its end alone.
            assert!(!told(left, whole / 3), "{speed}");
            // The one before came 10 s earlier; the next one is there.
            assert!(!told(left + 10.0, whole) && !told(0.0, whole), "{speed}");
        }
    }

    #[test]
    fn a_pursuit_gets_onto_a_place_that_moves_within_its_limits_and_stays_on_it() {
        let dt = 4e-3;
        for speed in [0.0, 0.016, 0.1, 0.18] {
            let mut pursuit = Pursuit { at: Vector3::new(0.13, 0.0, 0.14), velocity: Vector3::zeros() };
            let mut place = Vector3::new(0.1, 0.02, 0.14);
            for step in 0..600 {
                place.x += speed * dt;
                let next = pursuit.after(&place, &(Vector3::x() * speed), dt);
                assert!((next.velocity - pursuit.velocity).norm() <= Pursuit::ACCELERATION * dt + 1e-12);
                pursuit = next;
                if step > 350 {
                    let later = place + Vector3::x() * (speed * dt);
                    assert!((pursuit.at - later).norm() < 5e-4, "{} at {step}", (pursuit.at - later).norm());
                }
            }
            assert!((pursuit.velocity.x - speed).abs() < 1e-3);
        }
    }
}
