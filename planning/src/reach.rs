//! How far joints get in a fault stop.
//!
//! In: the range of velocities that each joint of a robot may have, and its limits. Out: for each joint a [`Reach`], within which it is at each
//! share of the stop, 0 to 1. All joints of a robot are at the same share, whatever the path speed was: the operator may have lowered it.
//!
//! A robot has the joint velocities `k r`, with `k` between 0 and 1. It goes on for a time of at most `T_r`, the reaction time, in which `k` may change, and then
//! brakes within the limits of acceleration `a_i` and jerk `j_i`. `T = max |r_i| / a_i` is the longest time that a joint brakes at full speed, and `G = T_r + T / 2`.
//!
//! **Without limits of jerk** all joints of a robot stand at the same time, on a straight line in joint space: at `lambda r_i G`, with the share `lambda`.
//!
//! **With them** each joint brakes by itself. Compare it with a joint of velocity `k` that goes on for as long, and then brakes for `k T`: it goes at most `G`,
//! and the share `lambda` is the part of `G` that it has gone. For `r_i > 0`, and without what jerk adds:
//!
//! - upper bound: `lambda r_i G`, because no joint brakes for longer than the one beside it;
//! - lower bound: `lambda r_i G T_i / T`, with `T_i = r_i / a_i`. Until the robot brakes both have gone in the ratio `r_i`. After that the velocity of the joint
//!   falls to a smaller share than that of the other, so the ratio falls until both stand, and then it is at least `r_i T_i / T`;
//! - in all no more than [`braking_distance`] after the reaction time.
//!
//! What jerk adds, with `c = a_i^2 / 2 j_i`, the most velocity that a joint gains while an acceleration fades:
//!
//! - above: braking begins up to `1.5 a_i / j_i` later, and from a velocity that is up to `c` larger;
//! - below: an acceleration may be against the motion when braking begins. The joint then goes no less far than by even braking from that instant. One that is slower
//!   than `c` is carried back, by no more than one goes that begins with `c`.
//!
//! Demands are made in steps: a joint is up to half a step sooner than in continuous time, which [`LATE`] has room for.

use core::ops::Range;

use mrroc_robots::clearance::braking_distance;

use crate::limits::Limits;

/// By how much later or sooner than in continuous time a joint may be, for it moves in steps: a least time \[s\], and a share of the reaction time,
/// which is longer for longer steps.
const LATE: f64 = 2e-3;
const LATE_SHARE: f64 = 1.0 / 15.0;

/// One end of where a joint may be, over the share of the stop: a line, cut at both ends, and moved by `more` [rad or m].
#[derive(Clone, Copy, Debug, Default)]
struct End {
    slope: f64,
    first: f64,
    least: f64,
    most: f64,
    more: f64,
}

impl End {
    /// A line that is not cut.
    const fn straight(slope: f64) -> Self {
        End { slope, first: 0.0, least: f64::NEG_INFINITY, most: f64::INFINITY, more: 0.0 }
    }

    fn at(&self, share: f64) -> f64 {
        (self.slope * share + self.first).clamp(self.least, self.most) + self.more
    }

    /// The same the other way.
    fn mirrored(self) -> Self {
        let End { slope, first, least, most, more } = self;
        End { slope: -slope, first: -first, least: -most, most: -least, more: -more }
    }
}

/// Where a joint may be in a fault stop, as seen from where it was [rad or m].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reach {
    lower: End,
    upper: End,
    /// How far it may be off both when it stands, which grows with the square of the share [rad or m].
    bend: f64,
}

impl Reach {
    /// The least and the greatest between two shares.
    pub(crate) fn between(&self, from: f64, to: f64) -> [f64; 2] {
        // Both only rise, or only fall.
        let bend = self.bend * from.max(to).powi(2);
        [self.lower.at(from).min(self.lower.at(to)) - bend, self.upper.at(from).max(self.upper.at(to)) + bend]
    }

    /// That of a joint without a limit of jerk that goes on for the reaction time and then brakes for `time`, on a line from which it may be off by
    /// `bend` when it stands.
    pub(crate) fn bent(rates: [f64; 2], reaction: f64, time: f64, bend: f64) -> Self {
        let [lower, upper] = rates.map(|rate| End::straight(rate * (reaction + 0.5 * time)));
        Reach { lower, upper, bend }
    }

    /// How far it goes until it stands, in the middle of where it may be.
    pub(crate) fn travel(&self) -> f64 {
        0.5 * (self.lower.at(1.0) + self.upper.at(1.0))
    }
}

/// Those of the joints of a robot, from velocities in the range that `rates` has for each [rad/s or m/s].
pub(crate) fn reaches(
    limits: &Limits,
    joints: Range<usize>,
    reaction: f64,
    rates: impl Fn(usize) -> [f64; 2],
    mut visit: impl FnMut(usize, Reach),
) {
    let all = || joints.clone().map(|j| (j, rates(j)));
    let fastest = |[lower, upper]: [f64; 2]| lower.abs().max(upper.abs());
    let time = all().map(|(j, rates)| fastest(rates) / limits.acceleration[j]).fold(0.0, f64::max);
    let late = LATE.max(LATE_SHARE * reaction);
    for (j, rates) in all() {
        let Some(jerk) = limits.jerk[j] else {
            visit(j, Reach::bent(rates, reaction, time, 0.0));
            continue;
        };
        if rates == [0.0; 2] {
            visit(j, Reach::default());
            continue;
        }
        let alone = Alone { acceleration: limits.acceleration[j], jerk, time, reaction, late };
        let [lower, upper] = rates;
        let (lower, upper) = (alone.farthest(-lower).mirrored(), alone.farthest(upper));
        visit(j, Reach { lower, upper, bend: 0.0 });
    }
}

/// A joint that brakes by itself, of a robot whose joints brake for at most `time` \[s\].
struct Alone {
    /// Its limits.
    acceleration: f64,
    jerk: f64,
    time: f64,
    reaction: f64,
    /// What steps shift \[s\].
    late: f64,
}

impl Alone {
    /// The greatest position from velocities of at most `rate`.
    fn farthest(&self, rate: f64) -> End {
        let Alone { acceleration, jerk, time, reaction, late } = *self;
        let whole = reaction + 0.5 * time;
        let (fading, gain) = (acceleration / jerk, 0.5 * acceleration * acceleration / jerk);
        let speed = rate.abs();
        if rate >= 0.0 {
            let delay = late + 1.5 * fading;
            let gained = gain * (reaction + delay + (speed + 0.5 * gain) / acceleration);
            let most = speed * reaction + braking_distance(speed, acceleration, jerk);
            let (slope, first) = (speed * whole, speed * delay + gained);
            return End { slope, first, least: f64::NEG_INFINITY, most, more: 0.0 };
        }
        let share = if time > 0.0 { speed / (acceleration * time) } else { 0.0 };
        let back = gain * (late + 1.5 * fading + 0.5 * gain / acceleration);
        let (slope, first) = (-share * speed * whole, speed * late);
        End { slope, first, least: f64::NEG_INFINITY, most: 0.0, more: back }
    }
}

#[cfg(test)]
mod tests {
    use mrroc::random::Random;
    use mrroc::robot::JointKind;

    use super::*;
    use crate::braking::Braking;

    /// Into how many parts the shares of a stop are cut.
    const PARTS: u32 = 400;

    fn limits(random: &mut Random, joints: usize) -> Limits {
        let mut draw = |lower: f64, upper: f64| -> Vec<f64> {
            (0..joints).map(|_| lower * (upper / lower).powf(random.unit())).collect()
        };
        let (acceleration, jerk) = (draw(2.0, 20.0), draw(100.0, 5000.0));
        Limits {
            lower: vec![-9.0; joints],
            upper: vec![9.0; joints],
            velocity: vec![3.0; joints],
            acceleration,
            jerk: jerk.into_iter().map(Some).collect(),
            robots: core::iter::once(0..joints).collect(),
            kinds: vec![JointKind::Revolute; joints],
        }
    }

    #[test]
    fn joints_that_brake_by_themselves_are_within_their_reach_at_one_share_at_any_time() {
        let (n, reaction) = (4, 0.03);
        let mut random = Random::seeded(5);
        let mut halves = [0.0; 2];
        for _ in 0..300 {
            let limits = limits(&mut random, n);
            let rates: Vec<[f64; 2]> = (0..n)
                .map(|_| {
                    let (middle, half) = (random.within(2.0), 0.1 * random.unit());
                    [middle - half, middle + half]
                })
                .collect();
            let mut reach = vec![Reach::default(); n];
            reaches(&limits, 0..n, reaction, |j| rates[j], |j, of| reach[j] = of);
            for _ in 0..10 {
                // Speed and time until the robot brakes, velocities and accelerations then.
                let (speed, wait) = (random.unit(), reaction * random.unit());
                let v: Vec<f64> = rates
                    .iter()
                    .map(|[lower, upper]| speed * (lower + (upper - lower) * random.unit()))
                    .collect();
                let braking: Vec<Braking> = (0..n)
                    .map(|j| {
                        let (a, jerk) = (limits.acceleration[j], limits.jerk[j].expect("a limit"));
                        Braking::with_jerk(v[j], random.within(a), a, jerk)
                    })
                    .collect();
                let longest = braking.iter().map(Braking::duration).fold(0.0, f64::max);
                for k in 0..=40 {
                    let time = (wait + longest) * f64::from(k) / 40.0;
                    let travel: Vec<f64> = (0..n)
                        .map(|j| v[j] * time.min(wait) + braking[j].at((time - wait).max(0.0)))
                        .collect();
                    let holds = |part: &u32| {
                        let shares = [0, 1].map(|end| f64::from(part + end) / f64::from(PARTS));
                        (0..n).all(|j| {
                            let [lower, upper] = reach[j].between(shares[0], shares[1]);
                            (lower - 1e-9..=upper + 1e-9).contains(&travel[j])
                        })
                    };
                    assert!(
                        (0..PARTS).any(|part| holds(&part)),
                        "{limits:?}, {rates:?} at {speed}: {travel:?} after {time}"
                    );
                }
            }
            // Where it may be is less than all that it sweeps.
            for of in &reach {
                let width = |from, to| of.between(from, to)[1] - of.between(from, to)[0];
                halves[0] += width(0.5, 0.5);
                halves[1] += width(0.0, 1.0);
            }
        }
        assert!(halves[0] < 0.6 * halves[1], "{halves:?}");
    }
}
