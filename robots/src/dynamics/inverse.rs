//! Inverse dynamics: recursive Newton-Euler (Featherstone 2008, table 5.1), outwards with motions and inwards with forces.

use mrroc::pose::Wrench;
use nalgebra::SVector;

use super::posture::{MOST, Posture, Spatial};
use super::tree::Tree;

impl<const N: usize> Tree<N> {
    /// Torques [N m, or N on a slide] that give the accelerations `acceleration` [rad/s² or m/s²] at `q` [rad or m] and
    /// `velocity` [rad/s or m/s], while the surroundings act on the tip with `wrench`: at the tip's origin, along the axes of
    /// the world [N, N m].
    #[must_use]
    pub fn inverse_dynamics(
        &self,
        q: &SVector<f64, N>,
        velocity: &SVector<f64, N>,
        acceleration: &SVector<f64, N>,
        wrench: Option<&Wrench>,
    ) -> SVector<f64, N> {
        self.torques(&Posture::at(self, q), velocity, Some(acceleration), wrench)
    }

    /// `h(q, qdot)`: the torques that keep all accelerations 0 [N m or N].
    #[must_use]
    pub fn bias(&self, q: &SVector<f64, N>, velocity: &SVector<f64, N>) -> SVector<f64, N> {
        self.torques(&Posture::at(self, q), velocity, None, None)
    }

    /// The torques that hold the tree at rest at `q` against its weight [N m or N].
    #[must_use]
    pub fn gravity_torques(&self, q: &SVector<f64, N>) -> SVector<f64, N> {
        self.bias(q, &SVector::zeros())
    }

    pub(super) fn torques(
        &self,
        posture: &Posture,
        velocity: &SVector<f64, N>,
        acceleration: Option<&SVector<f64, N>>,
        wrench: Option<&Wrench>,
    ) -> SVector<f64, N> {
        let mut motions = [(Spatial::ZERO, Spatial::ZERO); MOST];
        let mut forces = [Spatial::ZERO; MOST];
        // A base that is accelerated upwards has the same effect as gravity.
        let ground = (Spatial::ZERO, Spatial { linear: -self.gravity, ..Spatial::ZERO });
        for (i, stage) in self.stages.iter().enumerate().take(MOST) {
            let (before, pushed) = if stage.is_root { ground } else { motions[stage.parent] };
            let own = posture.axes[i].times(stage.multiplier * velocity[stage.coordinate]);
            let speed = before.plus(&own);
            let mut change = pushed.plus(&before.cross(&own));
            if let Some(acceleration) = acceleration {
                change =
                    change.plus(&posture.axes[i].times(stage.multiplier * acceleration[stage.coordinate]));
            }
            motions[i] = (speed, change);
            let body = posture.body(i, stage);
            forces[i] = body.times(&change).plus(&speed.cross_force(&body.times(&speed)));
        }
        if let Some(wrench) = wrench {
            let last = self.stages.len() - 1;
            let tip = posture.origins[last] + posture.turned[last] * self.X_tip.translation.vector;
            let angular = wrench.torque + tip.cross(&wrench.force);
            forces[last] = forces[last].plus(&Spatial { angular: -angular, linear: -wrench.force });
        }
        let mut torques = SVector::zeros();
        for (i, stage) in self.stages.iter().enumerate().take(MOST).rev() {
            torques[stage.coordinate] += stage.multiplier * posture.axes[i].dot(&forces[i]);
            if !stage.is_root {
                forces[stage.parent] = forces[stage.parent].plus(&forces[i]);
            }
        }
        torques
    }
}
