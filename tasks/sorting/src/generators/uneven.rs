//! Runs a belt as a worn drive does: not at its nominal speed, and not evenly.

use mrroc::prelude::*;
use mrroc::random::Noise;
use mrroc_robots::{Conveyor, One};

/// Speeds a belt up to a speed within 20 % of the nominal one, which wanders from then on: by a rate of at most 0.5 % a second that is drawn
/// anew every second, and back where it is farther off than that. No program is told of it.
pub struct Uneven {
    random: Noise,
    nominal: f64,
    /// What it wanders about, and by what share it is off that now.
    speed: f64,
    share: f64,
    /// Per second, and for how long still \[s\].
    rate: f64,
    left: f64,
    /// How fast it is, and how far \[m/s, m\].
    now: f64,
    x: f64,
    /// From when on \[s\] it goes at which share of its speed.
    profile: &'static [(f64, f64)],
    age: f64,
}

impl Uneven {
    /// How far off the nominal speed it may be, as a share.
    pub const OFF: f64 = 0.2;
    /// Farther off the nominal speed it only wanders back, as a share: within a tenth of [`OFF`](Self::OFF) beyond it, which programs allow for.
    const BACK: f64 = 1.05 * Self::OFF;
    /// How much of its speed it may lose or win in a second.
    pub const WANDERING: f64 = 0.005;
    /// \[m/s²\]: within the conveyor's limit.
    pub const ACCELERATION: f64 = 0.045;

    /// About a nominal speed [m/s], >= 0.
    #[must_use]
    pub fn about(nominal: f64, seed: u64) -> Self {
        let mut random = Noise::seeded(seed);
        let speed = nominal * (1.0 + random.between(-Self::OFF, Self::OFF));
        Self {
            random,
            nominal,
            speed,
            share: 0.0,
            rate: 0.0,
            left: 0.0,
            now: 0.0,
            x: 0.0,
            profile: &[],
            age: 0.0,
        }
    }

    /// The same that goes at these shares of its speed, each from a time on \[s\]: 0 stops it, -1 turns it back.
    #[must_use]
    pub const fn changing(self, profile: &'static [(f64, f64)]) -> Self {
        Self { profile, ..self }
    }

    /// The highest speed that one about this nominal speed may have [m/s], when it goes at these shares of it.
    #[must_use]
    pub fn fastest(nominal: f64, profile: &[(f64, f64)]) -> f64 {
        let share = profile.iter().map(|(_, share)| *share).fold(1.0, f64::max);
        nominal * share * (1.0 + 1.1 * Self::OFF)
    }

    /// The speed about which it wanders [m/s].
    #[must_use]
    pub const fn speed(&self) -> f64 {
        self.speed
    }
}

#[generator(ecp)]
impl Uneven {
    fn first_step(&mut self, e: &State<Conveyor>, t: Tick) -> Step<Conveyor> {
        self.x = e.demanded().joints[0];
        self.next_step(t)
    }

    fn next_step(&mut self, t: Tick) -> Step<Conveyor> {
        Step::Next(Demand::joints(One::new(self.after(t.dt))))
    }
}

impl Uneven {
    /// How far it is after a step of `dt` \[s\].
    fn after(&mut self, dt: f64) -> f64 {
        self.age += dt;
        self.left -= dt;
        if self.left <= 0.0 {
            self.left += 1.0;
            self.rate = self.random.between(-Self::WANDERING, Self::WANDERING);
            let off = self.speed * (1.0 + self.share) / self.nominal - 1.0;
            if off.abs() > Self::BACK {
                self.rate = -self.rate.abs().copysign(off);
            }
        }
        self.share += self.rate * dt;
        let mut begun = self.profile.iter().rev().filter(|(time, _)| self.age > *time);
        let share = begun.next().map_or(1.0, |(_, share)| *share);
        let wanted = self.speed * (1.0 + self.share) * share;
        let change = Self::ACCELERATION * dt;
        self.now += (wanted - self.now).clamp(-change, change);
        self.x += self.now * dt;
        self.x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sum of random rates grows with the root of time: by 20 % in 5,000 s.
    #[test]
    fn a_belt_wanders_for_hours_and_stays_within_22_percent_of_its_nominal_speed() {
        for seed in 0..20 {
            let (mut belt, mut farthest) = (Uneven::about(0.15, seed), 0.0_f64);
            for step in 0..200_000 {
                belt.after(0.1);
                // It has speeded up.
                if step > 100 {
                    farthest = farthest.max((belt.now / 0.15 - 1.0).abs());
                }
            }
            assert!(farthest > Uneven::OFF && farthest <= 1.1 * Uneven::OFF, "seed {seed}: {farthest}");
        }
        assert!((Uneven::fastest(0.15, &[]) - 0.15 * 1.22).abs() < 1e-12);
        assert!((Uneven::fastest(0.15, &[(3.0, 1.2), (9.0, 0.5)]) - 0.18 * 1.22).abs() < 1e-12);
    }
}
