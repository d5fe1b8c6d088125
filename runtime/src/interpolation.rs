//! From a demand per step to a joint position per servo period.
//!
//! In: accepted joint positions, one per step. Out: positions for the ends of the servo periods of a step. With one
//! period in a step the demand itself is it. With `n > 1` it is the uniform quadratic B-spline over the demands, half
//! a step behind them: its velocity runs linearly from one step's mean velocity to the next one's, so its
//! acceleration is the demands' own second difference, which the limits have been checked for, and never more. It
//! passes a demand at a distance of `a T² / 8`; at rest it is at the demand half a step later.
//!
//! ```text
//! q(u) = q1 + (q2 - q0) u / 2 + (q2 - 2 q1 + q0) (u² / 2 + 1/8),   u = tick / n - 1/2
//! ```

use crate::joints::JointVector;

/// The last three demands, and how far the ticks are in the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interpolation<J> {
    demands: [J; 3],
    tick: u32,
    ticks_per_step: u32,
}

impl<J: JointVector> Interpolation<J> {
    /// At rest, with so many servo periods in a step, at least 1.
    pub fn new(position: J, ticks_per_step: u32) -> Self {
        Interpolation { demands: [position; 3], tick: 0, ticks_per_step: ticks_per_step.max(1) }
    }

    /// Whether the next tick begins a step: then a demand is due.
    pub const fn begins_step(&self) -> bool {
        self.tick == 0
    }

    /// The demand of the step that begins.
    pub const fn push(&mut self, demand: J) {
        self.demands = [self.demands[1], self.demands[2], demand];
    }

    /// The demand that the ticks are on their way to.
    pub const fn goal(&self) -> &J {
        &self.demands[2]
    }

    /// Servo periods in a step.
    pub const fn ticks_per_step(&self) -> u32 {
        self.ticks_per_step
    }

    /// The position for the end of the next servo period.
    pub fn tick(&mut self) -> J {
        let [q0, q1, q2] = self.demands;
        if self.ticks_per_step == 1 {
            return q2;
        }
        self.tick = (self.tick + 1) % self.ticks_per_step;
        let passed = if self.tick == 0 { self.ticks_per_step } else { self.tick };
        let u = f64::from(passed) / f64::from(self.ticks_per_step) - 0.5;
        q1 + (q2 - q0) * (0.5 * u) + (q2 - q1 * 2.0 + q0) * (0.5 * u * u + 0.125)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

    /// A trapezoid of velocity over steps of 1: up to 5, held, down.
    fn demands() -> Vec<f64> {
        let speeds = [1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0, 4.0, 3.0, 2.0, 1.0, 0.0, 0.0];
        speeds
            .iter()
            .scan(0.0, |x, v| {
                *x += v;
                Some(*x)
            })
            .collect()
    }

    #[test]
    fn servo_positions_never_ask_for_more_acceleration_than_the_demands() {
        for n in [2, 4, 10] {
            let mut interpolation = Interpolation::new(Vector1::new(0.0), n);
            let mut positions = vec![0.0, 0.0];
            for demand in demands() {
                interpolation.push(Vector1::new(demand));
                positions.extend((0..n).map(|_| interpolation.tick()[0]));
            }
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
        let mut interpolation = Interpolation::new(Vector1::new(0.0), 1);
        for demand in demands() {
            assert!(interpolation.begins_step());
            interpolation.push(Vector1::new(demand));
            assert_eq!(interpolation.tick()[0], demand);
        }
    }
}
