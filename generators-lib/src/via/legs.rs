//! How fast each leg is passed.

use core::ops::Range;

use mrroc::robot::MAX_JOINTS;

use super::times::{Knot, Times};
use super::{Blend, ViaError};
use crate::profile::JerkLimits;

/// Coordinates of a leg.
pub(super) type LegVector = [f64; MAX_JOINTS];

/// Coordinates that are limited together, by their norm.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub axes: Range<usize>,
    pub limits: JerkLimits,
    pub deviation: f64,
    /// A rotation vector: its second derivative is not quite the angular acceleration.
    pub turns: bool,
}

/// Share of the limit of angular acceleration that the rotation vector's second derivative may take.
const TURNING: f64 = 0.9;
/// Share of its largest speed below which a corner is slowed down no more, by 0.8 each time.
const SLOWEST: f64 = 1e-190;
/// Steps of a bisection: to the last digit.
const STEPS: usize = 60;

/// A leg: the rates [1/s] out of its first corner, between, into its last, and the blends between them.
struct Leg {
    rates: [f64; 3],
    blends: [Option<Blend>; 2],
    times: [f64; 3],
}

struct Problem<'a> {
    displacements: &'a [LegVector],
    groups: &'a [Group],
    /// Largest rate of each leg by the velocity limits [1/s].
    most: Vec<f64>,
    /// Share of that with which each corner is passed.
    shares: Vec<f64>,
}

/// The rates of `displacements` that are not zero.
pub(super) fn plan(displacements: &[LegVector], groups: &[Group]) -> Result<Times, ViaError> {
    let mut problem = Problem::new(displacements, groups)?;
    problem.slow_down()?;
    let legs: Vec<_> = (0..displacements.len()).map_while(|k| problem.leg(k)).collect();
    if legs.len() < displacements.len() {
        return Err(ViaError::Precision);
    }
    problem.times(legs.into_iter())
}

/// Refuses limits and deviations that are out of range.
fn check(groups: &[Group]) -> Result<(), ViaError> {
    for Group { limits: JerkLimits { velocity, acceleration, jerk }, deviation, .. } in groups {
        let all = [
            ("velocity", velocity),
            ("acceleration", acceleration),
            ("jerk", jerk),
            ("deviation", deviation),
        ];
        for (name, &value) in all {
            if !(value > 0.0 && (value.is_finite() || name == "jerk")) {
                return Err(ViaError::Limit { name, value });
            }
        }
    }
    Ok(())
}

/// The largest number in `0..=most` that is `good`, where all below it are.
fn largest(most: f64, good: impl Fn(f64) -> bool) -> f64 {
    if good(most) {
        return most;
    }
    let mut low = 0.0;
    let mut high = most;
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if good(middle) { low = middle } else { high = middle }
    }
    low
}

impl Group {
    fn norm(&self, displacement: &LegVector) -> f64 {
        displacement[self.axes.clone()].iter().fold(0.0_f64, |norm, x| norm.hypot(*x))
    }

    fn acceleration(&self) -> f64 {
        if self.turns { TURNING * self.limits.acceleration } else { self.limits.acceleration }
    }
}

impl<'a> Problem<'a> {
    /// Each corner as fast as it may be passed by itself.
    fn new(displacements: &'a [LegVector], groups: &'a [Group]) -> Result<Problem<'a>, ViaError> {
        check(groups)?;
        let rate = |displacement: &LegVector| {
            groups
                .iter()
                .map(|group| group.limits.velocity / group.norm(displacement))
                .fold(f64::INFINITY, f64::min)
        };
        let most: Vec<f64> = displacements.iter().map(rate).collect();
        if !most.iter().all(|rate| *rate > 0.0 && rate.is_finite()) {
            return Err(ViaError::Precision);
        }
        let mut problem = Problem { displacements, groups, most, shares: vec![1.0; displacements.len() + 1] };
        for corner in 1..displacements.len() {
            problem.shares[corner] = largest(1.0, |share| problem.passes(corner, share));
        }
        Ok(problem)
    }

    fn rate(&self, corner: usize, leg: usize) -> f64 {
        self.shares[corner] * self.most[leg]
    }

    fn blend(&self, change: &LegVector) -> Blend {
        let groups = self.groups.iter();
        Blend::of(groups.map(|group| (group.norm(change), group.acceleration(), group.limits.jerk)))
    }

    /// The change of velocity round a corner that is passed with a share of the largest rates.
    fn change(&self, corner: usize, share: f64) -> LegVector {
        let before = &self.displacements[corner - 1];
        let after = &self.displacements[corner];
        let rates = (share * self.most[corner - 1], share * self.most[corner]);
        core::array::from_fn(|i| after[i] * rates.1 - before[i] * rates.0)
    }

    /// Whether a corner passed so fast stays within its deviation and, of a turn, within the angular acceleration.
    fn passes(&self, corner: usize, share: f64) -> bool {
        let change = self.change(corner, share);
        let blend = self.blend(&change);
        self.groups.iter().all(|group| {
            let near = group.norm(&change) * blend.deviation() <= group.deviation;
            // Angular acceleration less the rotation vector's second derivative, at an angle `x` from the corner: at most
            // `w^2 (x / 6 + x^2 / 12 + x^3 / 60)`, from the derivative of the left Jacobian of SO(3).
            let [v, w] =
                [corner - 1, corner].map(|leg| share * self.most[leg] * group.norm(&self.displacements[leg]));
            let w = v.max(w);
            let x = 0.5 * w * blend.duration();
            let excess = w * w * x * (1.0 / 6.0 + x * (1.0 / 12.0 + x / 60.0));
            near && (!group.turns || excess <= (1.0 - TURNING) * group.limits.acceleration)
        })
    }

    /// The blend at a corner; at the ends, from and to rest.
    fn corner(&self, corner: usize, rate: f64) -> Blend {
        if corner == 0 || corner == self.displacements.len() {
            self.blend(&self.displacements[corner.min(self.displacements.len() - 1)].map(|x| x * rate))
        } else {
            self.blend(&self.change(corner, self.shares[corner]))
        }
    }

    /// Slows down the corners of each leg until it has room for their blends.
    fn slow_down(&mut self) -> Result<(), ViaError> {
        let mut k = 0;
        while k < self.displacements.len() {
            let least = self.least(k);
            if least == 0.0 || self.leg_at(k, least).is_some() {
                k += 1;
                continue;
            }
            for corner in [k, k + 1] {
                self.shares[corner] *= 0.8;
            }
            if self.shares[k] < SLOWEST || self.shares[k + 1] < SLOWEST {
                return Err(ViaError::Precision);
            }
            // Of the legs that had room, only the one before knows of these corners.
            k = k.saturating_sub(1);
        }
        Ok(())
    }

    /// The rate of leg `k` below which it is not to fall between its corners \[1/s\].
    fn least(&self, k: usize) -> f64 {
        let last = self.displacements.len() - 1;
        let low = |corner| if corner == 0 || corner > last { 0.0 } else { self.rate(corner, k) };
        low(k).max(low(k + 1))
    }

    /// Leg `k` at the largest rate that leaves room for its blends, if there is any not below those of its corners.
    fn leg(&self, k: usize) -> Option<Leg> {
        let least = self.least(k);
        let fits = |rate: f64| self.leg_at(k, rate);
        if least > 0.0 {
            fits(least)?;
        }
        fits(least + largest(self.most[k] - least, |more| fits(least + more).is_some()))
    }

    fn leg_at(&self, k: usize, rate: f64) -> Option<Leg> {
        let last = self.displacements.len() - 1;
        let entry = if k == 0 { rate } else { self.rate(k, k) };
        let exit = if k == last { rate } else { self.rate(k + 1, k) };
        let faster =
            |from: f64| (rate > from).then(|| self.blend(&self.displacements[k].map(|x| x * (rate - from))));
        let blends = [faster(entry), faster(exit)];
        let corners = [self.corner(k, rate), self.corner(k + 1, rate)];
        // From the middle of the corner's blend to the middle of the other one.
        let slow = [0, 1].map(|i| blends[i].map_or(0.0, |b| 0.5 * (corners[i].duration() + b.duration())));
        let between = [0, 1].map(|i| blends[i].unwrap_or(corners[i]).duration());
        let time = (1.0 - entry * slow[0] - exit * slow[1]) / rate;
        let fits = time >= 0.5 * (between[0] + between[1]);
        fits.then_some(Leg { rates: [entry, rate, exit], blends, times: [slow[0], time, slow[1]] })
    }

    fn times(&self, legs: impl Iterator<Item = Leg>) -> Result<Times, ViaError> {
        let mut knots = Vec::with_capacity(3 * self.displacements.len() + 1);
        let mut time = 0.0;
        let mut before = (0, 0.0);
        for (k, Leg { rates, blends, times }) in legs.enumerate() {
            let blend = self.corner(k, rates[0]);
            if k == 0 {
                time = 0.5 * blend.duration();
            }
            knots.push(Knot { time, place: (k, 0.0), before, after: (k, rates[0]), blend });
            let mut share = 0.0;
            for i in 0..2 {
                share += rates[i] * times[i];
                time += times[i];
                if let Some(blend) = blends[i] {
                    let before = (k, rates[i]);
                    let after = (k, rates[i + 1]);
                    knots.push(Knot { time, place: (k, share), before, after, blend });
                }
            }
            time += times[2];
            before = (k, rates[2]);
        }
        let blend = self.corner(self.displacements.len(), before.1);
        knots.push(Knot {
            time,
            place: (self.displacements.len(), 0.0),
            before,
            after: (before.0, 0.0),
            blend,
        });
        let times = Times { knots };
        if times.duration().is_finite() { Ok(times) } else { Err(ViaError::Precision) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from 0 to 1: a linear congruential generator, Knuth's MMIX.
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Legs whose lengths are three orders of magnitude apart, so that many have no room for their corners' blends.
    fn zigzag(count: usize, seed: u64) -> Vec<LegVector> {
        let mut state = seed;
        let mut leg = || {
            let length = 10_f64.powf(-3.0 * random(&mut state));
            core::array::from_fn(
                |axis| if axis < 3 { length * (2.0 * random(&mut state) - 1.0) } else { 0.0 },
            )
        };
        (0..count).map(|_| leg()).collect()
    }

    fn groups(jerk: f64) -> Vec<Group> {
        let limits = JerkLimits { velocity: 1.0, acceleration: 2.0, jerk };
        let group = |axis| Group { axes: axis..axis + 1, limits, deviation: 0.02, turns: axis == 2 };
        (0..3).map(group).collect()
    }

    /// All legs anew whenever corners are slowed down, from the first leg that has no room; and how often that was.
    fn dense(displacements: &[LegVector], groups: &[Group]) -> Result<(Times, usize), ViaError> {
        let mut problem = Problem::new(displacements, groups)?;
        for tries in 0..2000 {
            let legs: Vec<_> = (0..displacements.len()).map(|k| problem.leg(k)).collect();
            let Some(tight) = legs.iter().position(Option::is_none) else {
                return Ok((problem.times(legs.into_iter().flatten())?, tries));
            };
            for corner in [tight, tight + 1] {
                problem.shares[corner] *= 0.8;
            }
        }
        Err(ViaError::Precision)
    }

    #[test]
    fn a_plan_is_the_one_of_all_legs_anew_to_the_bit() {
        let mut slowed = 0;
        for seed in 0..40 {
            let displacements = zigzag(2 + seed as usize, seed);
            for jerk in [10.0, f64::INFINITY] {
                let (times, tries) = dense(&displacements, &groups(jerk)).expect("a motion");
                assert_eq!(plan(&displacements, &groups(jerk)), Ok(times), "seed {seed}, jerk {jerk}");
                slowed += tries;
            }
        }
        assert!(slowed > 200, "corners were slowed down {slowed} times only");
    }

    #[test]
    fn fault_75_twenty_thousand_legs_take_time_that_grows_with_their_number() {
        // By all legs anew these were billions of legs, and were refused after some thousand corners.
        let displacements = zigzag(20_000, 1);
        let times = plan(&displacements, &groups(10.0)).expect("a motion");
        assert!(times.knots.len() > displacements.len() && times.duration().is_finite());
    }
}
