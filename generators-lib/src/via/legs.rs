//! How fast each leg is passed.

use core::ops::Range;

use mrroc::robot::MAX_JOINTS;

use super::times::{Knot, Times};
use super::{Blend, ViaError};
use crate::profile::JerkLimits;

/// Coordinates of a leg.
pub(super) type Way = [f64; MAX_JOINTS];

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
/// How often a corner is slowed down; by 0.8 each time, 1e-190 of its speed remains.
const TRIES: usize = 2000;
/// Steps of a bisection: to the last digit.
const STEPS: usize = 60;

/// A leg: the rates [1/s] out of its first corner, between, into its last, and the blends between them.
struct Leg {
    rates: [f64; 3],
    blends: [Option<Blend>; 2],
    times: [f64; 3],
}

struct Problem<'a> {
    ways: &'a [Way],
    groups: &'a [Group],
    /// Largest rate of each leg by the velocity limits [1/s].
    most: Vec<f64>,
    /// Share of that with which each corner is passed.
    shares: Vec<f64>,
}

/// The rates of `ways` that are not zero.
pub(super) fn plan(ways: &[Way], groups: &[Group]) -> Result<Times, ViaError> {
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
    if ways.is_empty() {
        return Err(ViaError::Coincident);
    }
    let rate = |way: &Way| {
        groups.iter().map(|group| group.limits.velocity / group.norm(way)).fold(f64::INFINITY, f64::min)
    };
    let most: Vec<f64> = ways.iter().map(rate).collect();
    if !most.iter().all(|rate| *rate > 0.0 && rate.is_finite()) {
        return Err(ViaError::Precision);
    }
    let mut problem = Problem { ways, groups, most, shares: vec![1.0; ways.len() + 1] };
    for corner in 1..ways.len() {
        problem.shares[corner] = largest(1.0, |share| problem.passes(corner, share));
    }
    for _ in 0..TRIES {
        let legs: Vec<_> = (0..ways.len()).map(|k| problem.leg(k)).collect();
        let Some(tight) = legs.iter().position(Option::is_none) else {
            return problem.times(legs.into_iter().flatten());
        };
        for corner in [tight, tight + 1] {
            problem.shares[corner] *= 0.8;
        }
    }
    Err(ViaError::Precision)
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
    fn norm(&self, way: &Way) -> f64 {
        way[self.axes.clone()].iter().fold(0.0_f64, |norm, x| norm.hypot(*x))
    }

    fn acceleration(&self) -> f64 {
        if self.turns { TURNING * self.limits.acceleration } else { self.limits.acceleration }
    }
}

impl Problem<'_> {
    fn rate(&self, corner: usize, leg: usize) -> f64 {
        self.shares[corner] * self.most[leg]
    }

    fn blend(&self, change: &Way) -> Blend {
        let groups = self.groups.iter();
        Blend::of(groups.map(|group| (group.norm(change), group.acceleration(), group.limits.jerk)))
    }

    /// The change of velocity round a corner that is passed with a share of the largest rates.
    fn change(&self, corner: usize, share: f64) -> Way {
        let before = &self.ways[corner - 1];
        let after = &self.ways[corner];
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
            let [v, w] = [corner - 1, corner].map(|leg| share * self.most[leg] * group.norm(&self.ways[leg]));
            let w = v.max(w);
            let x = 0.5 * w * blend.duration();
            let excess = w * w * x * (1.0 / 6.0 + x * (1.0 / 12.0 + x / 60.0));
            near && (!group.turns || excess <= (1.0 - TURNING) * group.limits.acceleration)
        })
    }

    /// The blend at a corner; at the ends, from and to rest.
    fn corner(&self, corner: usize, rate: f64) -> Blend {
        if corner == 0 || corner == self.ways.len() {
            self.blend(&self.ways[corner.min(self.ways.len() - 1)].map(|x| x * rate))
        } else {
            self.blend(&self.change(corner, self.shares[corner]))
        }
    }

    /// Leg `k` at the largest rate that leaves room for its blends, if there is any not below those of its corners.
    fn leg(&self, k: usize) -> Option<Leg> {
        let last = self.ways.len() - 1;
        let low = |corner| if corner == 0 || corner > last { 0.0 } else { self.rate(corner, k) };
        let least = low(k).max(low(k + 1));
        let fits = |rate: f64| self.leg_at(k, rate);
        if least > 0.0 {
            fits(least)?;
        }
        fits(least + largest(self.most[k] - least, |more| fits(least + more).is_some()))
    }

    fn leg_at(&self, k: usize, rate: f64) -> Option<Leg> {
        let last = self.ways.len() - 1;
        let entry = if k == 0 { rate } else { self.rate(k, k) };
        let exit = if k == last { rate } else { self.rate(k + 1, k) };
        let faster = |from: f64| (rate > from).then(|| self.blend(&self.ways[k].map(|x| x * (rate - from))));
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
        let mut knots = Vec::with_capacity(3 * self.ways.len() + 1);
        let mut time = 0.0;
        let mut before = (0, 0.0);
        for (k, Leg { rates, blends, times }) in legs.enumerate() {
            let blend = self.corner(k, rates[0]);
            if k == 0 {
                time = 0.5 * blend.duration();
            }
            knots.push(Knot { time, place: (k, 0.0), before, after: (k, rates[0]), blend });
            let mut way = 0.0;
            for i in 0..2 {
                way += rates[i] * times[i];
                time += times[i];
                if let Some(blend) = blends[i] {
                    let before = (k, rates[i]);
                    let after = (k, rates[i + 1]);
                    knots.push(Knot { time, place: (k, way), before, after, blend });
                }
            }
            time += times[2];
            before = (k, rates[2]);
        }
        let blend = self.corner(self.ways.len(), before.1);
        knots.push(Knot { time, place: (self.ways.len(), 0.0), before, after: (before.0, 0.0), blend });
        let times = Times { knots };
        if times.duration().is_finite() { Ok(times) } else { Err(ViaError::Precision) }
    }
}
