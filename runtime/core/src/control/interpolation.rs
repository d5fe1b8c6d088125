//! From a demand per step to a joint position per servo period, for all robots of a cell with one delay.
//!
//! In: accepted joint positions, one per step, and the time that a servo period ends at. Out: the position for that end.
//! Where every robot of a cell has one servo period in a step, the demand itself is it. Otherwise it is the uniform
//! quadratic B-spline over the demands at a time that lies one [`delay`] back, the same for all robots of the cell,
//! whatever their periods: cooperating arms stay together. The spline's velocity runs linearly from one step's mean
//! velocity to the next one's, so its acceleration is the demands' own second difference, which the limits have been
//! checked for, and never more. It passes a demand at a distance of `a T² / 8`.
//!
//! ```text
//! q(u) = q1 + (q2 - q0) u / 2 + (q2 - 2 q1 + q0) (u² / 2 + 1/8),   -1/2 < u <= 1/2
//! ```
//!
//! Between poses it is the same curve about `X1`, of the flange's position and of its rotation vector.

use core::time::Duration;

use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::model::joints::JointVector;
use crate::model::pace::{Pace, ServoPeriod};
use crate::model::pose::Pose;
use crate::model::time::Nanos;

/// The time by which drives of robots with these servo periods, in steps of `period`, lie behind their demands: the least at which the demands
/// that each of them needs have come when its servo period begins. `None` where each takes every demand as it is.
///
/// A demand of step `k` stands for the time `k T`. Ticks begin half a servo period after the steps; by then the demands
/// of the steps whose half is over, or half a servo period, if that is shorter, are known. Those of a robot that paces itself
/// begin at any time: at worst just before a step's demand is known.
pub(crate) fn delay(
    period: Duration,
    servos: impl Iterator<Item: Into<ServoPeriod>> + Clone,
) -> Option<Duration> {
    let servos = servos.map(Into::into);
    if servos.clone().all(|servo| servo == ServoPeriod::from(period)) {
        return None;
    }
    let needs = |ServoPeriod { length: servo, pace }: ServoPeriod| {
        if pace != Pace::Cell {
            servo + (period * 3 + servo.min(period)) / 2
        } else if servo <= period {
            // The step's last tick ends half a period into the next step; the spline ends half a step before the demand.
            (period * 3 + servo) / 2
        } else {
            let known = (servo.as_nanos() / 2).div_ceil(period.as_nanos().max(1)) as u32 - 1;
            (servo * 3 + period) / 2 - period * known
        }
    };
    servos.map(needs).max()
}

/// The demands that the ticks follow.
pub(crate) struct Interpolation<J> {
    /// Demands of past steps, that of step `k` at `k` modulo the length, which is a power of 2.
    demands: Box<[J]>,
    /// How many of them are kept for the ticks.
    kept: i64,
    /// The step that the newest demand is for; before the first one -1.
    newest: i64,
    /// Length of a step \[ns\].
    period: Nanos,
    /// The cell's delay \[ns\]; `None`: the newest demand is the position.
    delay: Option<Nanos>,
}

impl<J: JointVector> Interpolation<J> {
    /// At rest before the step `first`.
    pub fn new(position: J, first: u64, period: Duration, delay: Option<Duration>) -> Self {
        let delay = delay.map(|delay| delay.as_nanos() as Nanos);
        let period = (period.as_nanos() as Nanos).max(1);
        let kept = 4 + delay.unwrap_or(0) / period;
        let demands = (0..kept.next_power_of_two()).map(|_| position).collect();
        Interpolation { demands, kept: kept as i64, newest: first as i64 - 1, period, delay }
    }

    /// The demand of the step that follows the newest.
    pub fn push(&mut self, demand: J) {
        self.newest += 1;
        let place = self.place(self.newest);
        self.demands[place] = demand;
    }

    /// The demand that the ticks are on their way to.
    pub fn goal(&self) -> &J {
        self.demand(0)
    }

    /// Whether all demands that are kept are one: nothing moves.
    pub fn stands(&self) -> bool {
        (1..self.kept).all(|age| self.demand(age) == self.goal())
    }

    /// Whether the drives take each demand as it is.
    pub const fn is_direct(&self) -> bool {
        self.delay.is_none()
    }

    /// Steps of standing demands after which the ticks have come to them.
    pub fn settling_steps(&self) -> u64 {
        // The spline is at the demand of step `k` half a step after it, and all ticks that begin in the delay after that
        // are on their way there.
        self.delay.map_or(0, |delay| (2 * delay).saturating_sub(self.period).div_ceil(2 * self.period))
    }

    /// The position for the end of a servo period.
    pub fn at(&self, end: Nanos) -> J {
        match self.delay {
            None => *self.goal(),
            Some(delay) => {
                let ([q0, q1, q2], u) = self.span(end, delay);
                q1 + (q2 - q0) * (0.5 * u) + (q2 - q1 * 2.0 + q0) * (0.5 * u * u + 0.125)
            }
        }
    }

    /// The pose for the end of a servo period, where `pose` is that of a demand.
    pub fn pose_at(&self, end: Nanos, pose: impl Fn(&J) -> Pose) -> Pose {
        let Some(delay) = self.delay else { return pose(self.goal()) };
        let ([q0, q1, q2], u) = self.span(end, delay);
        let [before, middle, after] = [pose(&q0), pose(&q1), pose(&q2)];
        let blend = |before: Vector3<f64>, after: Vector3<f64>| {
            (after - before) * (0.5 * u) + (after + before) * (0.5 * u * u + 0.125)
        };
        let offset = |to: &Pose| to.translation.vector - middle.translation.vector;
        let turn = |to: &Pose| (middle.rotation.inverse() * to.rotation).scaled_axis();
        Pose::from_parts(
            Translation3::from(middle.translation.vector + blend(offset(&before), offset(&after))),
            middle.rotation * UnitQuaternion::from_scaled_axis(blend(turn(&before), turn(&after))),
        )
    }

    /// The three demands about the time `delay` before `end`, and how far from the middle one it lies \[steps\].
    fn span(&self, end: Nanos, delay: Nanos) -> ([J; 3], f64) {
        let period = self.period as i64;
        let back = self.newest * period - end as i64 + delay as i64;
        let middle = (period + 2 * back).max(0) / (2 * period);
        let u = (middle * period - back) as f64 / period as f64;
        ([*self.demand(middle + 1), *self.demand(middle), *self.demand(middle - 1)], u)
    }

    /// The demand of so many steps ago.
    fn demand(&self, age: i64) -> &J {
        &self.demands[self.place(self.newest - age)]
    }

    fn place(&self, step: i64) -> usize {
        // The bits of a negative number count on downwards.
        step.cast_unsigned() as usize & (self.demands.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

    const STEP: Duration = Duration::from_millis(1);

    /// A trapezoid of velocity over steps of 1: up to 5, held, down.
    fn demands() -> Vec<f64> {
        let speeds = [1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0, 4.0, 3.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        speeds
            .iter()
            .scan(0.0, |x, v| {
                *x += v;
                Some(*x)
            })
            .collect()
    }

    /// Ends of the servo periods \[ns\] and the positions for them, as an EDP comes by them.
    fn ticks(servo: Duration, delay: Option<Duration>) -> Vec<(Nanos, f64)> {
        let (step, servo) = (STEP.as_nanos() as Nanos, servo.as_nanos() as Nanos);
        let mut interpolation = Interpolation::new(Vector1::new(0.0), 0, STEP, delay);
        let (mut positions, mut tick) = (Vec::new(), servo / 2);
        for (k, demand) in demands().into_iter().enumerate() {
            let pushed = k as u64 * step + servo.min(step) / 2;
            while tick < pushed {
                positions.push((tick + servo, interpolation.at(tick + servo)[0]));
                tick += servo;
            }
            interpolation.push(Vector1::new(demand));
        }
        positions
    }

    #[test]
    fn servo_positions_never_ask_for_more_acceleration_than_the_demands() {
        for n in [2, 4, 10] {
            let servo = STEP / n;
            let mut positions = vec![0.0, 0.0];
            positions.extend(ticks(servo, delay(STEP, [servo].into_iter())).iter().map(|(_, q)| q));
            let dt = 1.0 / f64::from(n);
            for w in positions.windows(3) {
                let acceleration = (w[2] - 2.0 * w[1] + w[0]) / (dt * dt);
                assert!(acceleration.abs() <= 1.0 + 1e-9, "{acceleration} with {n} periods");
            }
            let last = demands()[demands().len() - 1];
            assert!((positions[positions.len() - 1] - last).abs() < 1e-12, "not at the last demand");
        }
    }

    #[test]
    fn one_servo_period_in_a_step_gets_the_demand_itself() {
        assert_eq!(delay(STEP, [STEP, STEP].into_iter()), None);
        let positions: Vec<_> = ticks(STEP, None).iter().map(|(_, q)| *q).collect();
        assert_eq!(positions, demands()[..positions.len()]);
    }

    #[test]
    fn robots_of_all_rates_are_at_one_place_at_one_time() {
        // The curve in closed form, for the time `delay` before the end of a period.
        let d = demands();
        let curve = |time: f64| {
            let middle = (time + 0.5).ceil() - 1.0;
            let (u, k) = (time - middle, middle as i64);
            let q = |k: i64| if k < 0 { 0.0 } else { d[k as usize] };
            q(k) + (q(k + 1) - q(k - 1)) * 0.5 * u
                + (q(k + 1) - 2.0 * q(k) + q(k - 1)) * (0.5 * u * u + 0.125)
        };
        let servos = [STEP / 4, STEP / 2, STEP, STEP * 2, STEP * 3, STEP * 4];
        let common = delay(STEP, servos.into_iter()).expect("more than one period");
        // The slowest begins its period at 2.0, with the demand of step 1, and ends it at 6.0: 1 - 0.5 = 6.0 - 5.5.
        assert_eq!(common, Duration::from_micros(5500));
        for servo in servos {
            for (end, position) in ticks(servo, Some(common)) {
                let expected = curve((end as f64 - 5.5e6) * 1e-6);
                assert!((position - expected).abs() < 1e-12, "{servo:?}, {end}: {position} and {expected}");
            }
        }
    }

    #[test]
    fn a_delay_is_the_least_at_which_all_demands_are_known() {
        for servo in [STEP / 4, STEP / 2, STEP * 2, STEP * 3, STEP * 4, STEP * 5] {
            let delay = delay(STEP, [servo, STEP].into_iter()).expect("two periods");
            let (servo, delay) = (servo.as_nanos() as i64, delay.as_nanos() as i64);
            // Half a step before a demand ends what it is needed for.
            let spare = |servo: i64| {
                let tick = |j: i64| j * servo + servo / 2;
                let pushed = |k: i64| k * 1_000_000 + servo.min(1_000_000) / 2;
                let known = |t: i64| (-1..100).take_while(|&k| pushed(k) <= t).last().expect("the first");
                (0..20).map(|j| known(tick(j)) * 1_000_000 - 500_000 - (tick(j) + servo - delay)).min()
            };
            let least = spare(servo).min(spare(1_000_000)).expect("ticks");
            assert_eq!(least, 0, "servo {servo}");
        }
    }

    #[test]
    fn poses_between_demands_lie_on_the_line_and_the_arc_that_the_demands_lie_on() {
        // Constant speed along x and about z: the curve is the motion itself, half a step and more behind.
        let pose = |q: &Vector1<f64>| {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * (0.1 * q[0]));
            Pose::from_parts(Translation3::new(0.02 * q[0], 0.3, 0.0), turn)
        };
        let delay = delay(STEP, [STEP / 10].into_iter());
        let mut interpolation = Interpolation::new(Vector1::new(0.0), 0, STEP, delay);
        (0..5).for_each(|k| interpolation.push(Vector1::new(f64::from(k))));
        // The last demand is of step 4; delay 1.55.
        for (end, time) in [(5_050_000, 3.5), (4_800_000, 3.25), (4_100_000, 2.55)] {
            let (x, expected) = (interpolation.pose_at(end, pose), pose(&Vector1::new(time)));
            assert!((x.translation.vector - expected.translation.vector).norm() < 1e-15, "{x} {expected}");
            assert!(x.rotation.angle_to(&expected.rotation) < 1e-12, "{x} {expected}");
        }
    }
}
