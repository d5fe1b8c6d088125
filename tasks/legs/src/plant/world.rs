//! The world of the cell: a trunk on four legs on the ground, and its clock.
//!
//! In: where each leg's joints are at the end of each of its servo periods. Out: the force of the ground on its foot, mean over the last
//! period that the world went through.
//!
//! **Time.** All legs have the same servo period. The world goes through a period when all legs have come to its end. A leg that begins the
//! next period while others have not come to the end of this one goes on without them: they have stopped, and stand as they are. So
//! the result does not depend on the order of the legs. Within a period joints move evenly, in [`SUBSTEPS`] steps.

use mrroc::pose::Pose;
use nalgebra::Vector3;

use super::foot::{Foot, RADIUS};
use super::trunk::{Sums, Trunk};
use crate::ground::Ground;
use crate::leg::{GRAVITY, Leg, Three};
use crate::seen::{RunMeasurements, Standing};

/// Servo period of the legs \[s\].
pub const PERIOD: f64 = 0.002;
/// Steps of a servo period: of 0.25 ms. The stiffest motion, a trunk on four feet, has 0.04 rad a step.
pub const SUBSTEPS: u32 = 8;

/// Trunk, legs, ground.
#[derive(Debug)]
pub struct World {
    legs: [Leg; 4],
    ground: Ground,
    friction: f64,
    trunk: Trunk,
    q: [Three; 4],
    qd: [Three; 4],
    next: [Option<Three>; 4],
    feet: [Foot; 4],
    /// Mean force on each foot in the last period [N, T].
    loads: [Vector3<f64>; 4],
    periods: u64,
    /// What there was to see.
    pub seen: RunMeasurements,
}

impl World {
    /// A machine at rest, on ground of this friction.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn new(legs: [Leg; 4], ground: Ground, friction: f64, X_WT: Pose, q: [Three; 4]) -> Self {
        Self {
            legs,
            ground,
            friction,
            trunk: Trunk::at(X_WT),
            q,
            qd: [Three::zeros(); 4],
            next: [None; 4],
            feet: Default::default(),
            loads: [Vector3::zeros(); 4],
            periods: 0,
            seen: RunMeasurements::default(),
        }
    }

    /// Begins a servo period of a leg: the mean force on its foot in the last one [N, T].
    pub fn begin(&mut self, leg: usize) -> Vector3<f64> {
        if self.next[leg].is_some() {
            self.go_on();
        }
        self.loads[leg]
    }

    /// Ends it, with the joints there.
    pub fn end(&mut self, leg: usize, q: Three) {
        self.next[leg] = Some(q);
        if self.next.iter().all(Option::is_some) {
            self.go_on();
        }
    }

    /// Goes through a period in which no leg moves.
    pub fn stand(&mut self) {
        self.next = [None; 4];
        self.go_on();
    }

    /// Goes through a period.
    fn go_on(&mut self) {
        let from = self.q;
        for ((next, qd), from) in self.next.iter_mut().zip(&mut self.qd).zip(&from) {
            let to = next.take().unwrap_or(*from);
            *qd = (to - from) / PERIOD;
        }
        let h = PERIOD / f64::from(SUBSTEPS);
        let mut impulses = [Vector3::zeros(); 4];
        self.drift(&from, 0.0, 0.5 * h);
        for step in 0..SUBSTEPS {
            self.kick(h, &mut impulses);
            let now = (f64::from(step) + 0.5) * h;
            self.drift(&from, now, if step + 1 == SUBSTEPS { 0.5 * h } else { h });
        }
        self.loads = impulses.map(|impulse| impulse / PERIOD);
        self.periods += 1;
        let standing = self.standing();
        self.seen.look(&standing);
    }

    /// Moves on with constant momenta for `h` \[s\], from the time `now` of a period that began with the joints at `from`.
    fn drift(&mut self, from: &[Three; 4], now: f64, h: f64) {
        for ((q, qd), from) in self.q.iter_mut().zip(&self.qd).zip(from) {
            *q = from + qd * (now + 0.5 * h);
        }
        let sums = Sums::of(&self.legs, &self.q, &self.qd);
        self.trunk.drift(&sums, h);
        for ((q, qd), from) in self.q.iter_mut().zip(&self.qd).zip(from) {
            *q = from + qd * (now + h);
        }
    }

    /// The forces of a step.
    fn kick(&mut self, h: f64, impulses: &mut [Vector3<f64>; 4]) {
        let sums = Sums::of(&self.legs, &self.q, &self.qd);
        let (v, omega) = self.trunk.twist(&sums);
        let (position, rotation) = (self.trunk.position, self.trunk.rotation);
        let mut pushes = [(Vector3::zeros(), Vector3::zeros()); 4];
        for i in 0..4 {
            let arm = rotation * self.legs[i].foot(&self.q[i]);
            let at = position + arm;
            let Some(contact) = self.ground.touch(&at, RADIUS) else {
                self.feet[i].lift();
                continue;
            };
            let moving = rotation * (self.legs[i].slope(&self.q[i]) * self.qd[i]);
            let velocity = v + omega.cross(&arm) + moving;
            let force = self.feet[i].press(&contact, self.friction, &velocity, h);
            impulses[i] += rotation.inverse() * force * h;
            pushes[i] = (force, at);
        }
        for (force, at) in pushes {
            self.trunk.kick(&force, &at, h);
        }
        let weight = Vector3::z() * (-GRAVITY * sums.M);
        self.trunk.kick(&weight, &(position + rotation * sums.centre()), h);
    }

    /// How it stands now.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn standing(&self) -> Standing {
        let X_WT = self.trunk.pose();
        let sums = Sums::of(&self.legs, &self.q, &self.qd);
        let feet =
            core::array::from_fn(|i| X_WT.transform_point(&self.legs[i].foot(&self.q[i]).into()).coords);
        Standing {
            time: self.periods as f64 * PERIOD,
            X_WT,
            velocity: self.trunk.twist(&sums).0,
            centre: X_WT.transform_point(&sums.centre().into()).coords,
            feet,
            forces: core::array::from_fn(|i| self.feet[i].force),
            slid: core::array::from_fn(|i| self.feet[i].slid),
            q: self.q,
        }
    }

    /// Mean force on each foot in the last period [N, T].
    #[must_use]
    pub const fn loads(&self) -> &[Vector3<f64>; 4] {
        &self.loads
    }

    /// The ground as it truly is.
    #[must_use]
    pub const fn ground(&self) -> &Ground {
        &self.ground
    }

    /// The legs.
    #[must_use]
    pub const fn legs(&self) -> &[Leg; 4] {
        &self.legs
    }
}
