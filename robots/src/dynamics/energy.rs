//! Energies of a tree's bodies.

use nalgebra::SVector;

use super::posture::{MOST, Posture, Spatial};
use super::tree::Tree;

impl<const N: usize> Tree<N> {
    /// Kinetic energy at `q` [rad or m] and `velocity` [rad/s or m/s] \[J\]: `qdot^T M qdot / 2`, summed over the bodies.
    #[must_use]
    pub fn kinetic_energy(&self, q: &SVector<f64, N>, velocity: &SVector<f64, N>) -> f64 {
        let posture = Posture::at(self, q);
        let mut speeds = [Spatial::ZERO; MOST];
        let mut energy = 0.0;
        for (i, stage) in self.stages.iter().enumerate().take(MOST) {
            let before = if stage.is_root { Spatial::ZERO } else { speeds[stage.parent] };
            speeds[i] = before.plus(&posture.axes[i].times(stage.multiplier * velocity[stage.coordinate]));
            energy += 0.5 * speeds[i].dot(&posture.body(i, stage).times(&speeds[i]));
        }
        energy
    }

    /// Potential energy of the weight at `q` [rad or m] \[J\]: 0 with all mass at the origin of the world.
    #[must_use]
    pub fn potential_energy(&self, q: &SVector<f64, N>) -> f64 {
        let posture = Posture::at(self, q);
        let base = self.X_WB.translation.vector;
        let raised = self.stages.iter().enumerate().take(MOST).map(|(i, stage)| {
            let centre = base + posture.origins[i] + posture.turned[i] * stage.centre;
            -stage.mass * self.gravity.dot(&centre)
        });
        raised.sum()
    }
}
