//! Closes the fingers as long as something is between them.

use mrroc::prelude::*;
use mrroc_robots::{One, TwoFingers};
use mrroc_sensors::virtual_sensors::Between;

use crate::places::{CLOSED, FINGERS, OPEN};

/// Closes the fingers while the barrier between them is covered, and opens them again from where it no longer is; done where they are
/// closed, or open again.
#[derive(Default)]
pub struct Grasp {
    /// Opening \[m\], and its rate [m/s].
    x: f64,
    rate: f64,
    lost: bool,
}

impl Grasp {
    /// Closed or open within this it is done \[m\].
    const NEAR: f64 = 1e-4;

    /// Whether it was lost.
    #[must_use]
    pub const fn is_lost(&self) -> bool {
        self.lost
    }
}

#[generator(ecp)]
impl Grasp {
    fn first_step(&mut self, e: &State<TwoFingers>, v: &Reading<(Between,)>, t: Tick) -> Step<TwoFingers> {
        *self = Self { x: e.demanded().joints[0], ..Self::default() };
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(Between,)>, t: Tick) -> Step<TwoFingers> {
        self.lost |= !v.0.reading().is_some_and(|fingers| fingers.covered);
        let remaining = if self.lost { OPEN } else { CLOSED } - self.x;
        if remaining.abs() < Self::NEAR {
            return Step::Done;
        }
        // Where the fingers can still brake, with a reserve.
        let [speed, acceleration] = FINGERS;
        let wanted = speed.min((1.4 * acceleration * remaining.abs()).sqrt()).copysign(remaining);
        let change = acceleration * t.dt;
        self.rate += (wanted - self.rate).clamp(-change, change);
        self.x += self.rate * t.dt;
        Step::Next(Demand::joints(One::new(self.x)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::sensor::SensorImage;
    use mrroc_generators::rehearsal::rehearse_with;
    use mrroc_sensors::virtual_sensors::Fingers;

    /// The openings that are demanded while the barrier is covered for so many steps of 4 ms.
    fn openings(covered: u32) -> Vec<f64> {
        let mut steps = 0;
        let readings = |_: &_| {
            steps += 1;
            let fingers = Fingers { covered: steps <= covered, edges: 1, since: 0.0 };
            (Order::new(()), Reading::new((SensorImage::new(fingers, 0),)))
        };
        let demands = rehearse_with(Grasp::default(), &TwoFingers::new(), One::new(OPEN), 4e-3, readings);
        demands.expect("within the limits").iter().filter_map(Demand::as_joints).map(|q| q[0]).collect()
    }

    #[test]
    fn fingers_close_within_their_acceleration_and_open_again_where_nothing_is_between_them_any_more() {
        for (covered, end) in [(u32::MAX, CLOSED), (60, OPEN), (100, OPEN)] {
            let x = openings(covered);
            assert!((x[x.len() - 1] - end).abs() < 2.0 * Grasp::NEAR, "{covered}");
            let accelerations = x.windows(3).map(|x| (x[2] - 2.0 * x[1] + x[0]) / (4e-3 * 4e-3));
            assert!(accelerations.clone().all(|a| a.abs() < FINGERS[1] * 1.0001), "{covered}");
            let least = x.iter().copied().fold(f64::INFINITY, f64::min);
            assert!(least >= CLOSED - Grasp::NEAR && x.iter().all(|x| *x <= OPEN + Grasp::NEAR));
        }
    }
}
