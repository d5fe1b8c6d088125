//! Mass matrix and forward dynamics: composite rigid bodies (Featherstone 2008, table 6.2), then Cholesky's factors.

use mrroc::pose::Wrench;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::posture::{MOST, Posture, Spatial};
use super::tree::{Tree, steiner};

/// The terms of the equation of motion `M qddot + h = tau` at one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equation<const N: usize> {
    /// The mass matrix M [kg m², kg m, kg].
    pub mass: SMatrix<f64, N, N>,
    /// Coriolis, centrifugal and gravity terms h [N m or N].
    pub bias: SVector<f64, N>,
}

/// What links do to the joints that move them: a tree, or a tree whose loops are closed.
pub trait Dynamics<const N: usize>: core::fmt::Debug {
    /// The equation of motion at joint positions `q` [rad or m] and speeds [rad/s or m/s]; allocates nothing.
    fn equation(&self, q: &SVector<f64, N>, velocity: &SVector<f64, N>) -> Equation<N>;
}

impl<const N: usize> Dynamics<N> for Tree<N> {
    fn equation(&self, q: &SVector<f64, N>, velocity: &SVector<f64, N>) -> Equation<N> {
        let posture = Posture::at(self, q);
        Equation { mass: self.composite(&posture), bias: self.torques(&posture, velocity, None, None) }
    }
}

/// Bodies as one: mass, first moment and inertia about the base's origin.
#[derive(Clone, Copy)]
struct Composite {
    mass: f64,
    moment: Vector3<f64>,
    inertia: Matrix3<f64>,
}

impl Composite {
    fn times(&self, motion: &Spatial) -> Spatial {
        Spatial {
            angular: self.inertia * motion.angular + self.moment.cross(&motion.linear),
            linear: motion.linear * self.mass + motion.angular.cross(&self.moment),
        }
    }
}

impl<const N: usize> Tree<N> {
    /// The mass matrix at `q` [rad or m]: symmetric; [kg m²] between turns, [kg m] between a turn and a slide, \[kg\] between
    /// slides.
    #[must_use]
    pub fn mass_matrix(&self, q: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        self.composite(&Posture::at(self, q))
    }

    fn composite(&self, posture: &Posture) -> SMatrix<f64, N, N> {
        let none = Composite { mass: 0.0, moment: Vector3::zeros(), inertia: Matrix3::zeros() };
        let mut composites = [none; MOST];
        for (i, stage) in self.stages.iter().enumerate().take(MOST) {
            let body = posture.body(i, stage);
            composites[i] = Composite {
                mass: body.mass,
                moment: body.centre * body.mass,
                inertia: body.inertia + steiner(body.mass, &body.centre),
            };
        }
        let mut matrix = SMatrix::zeros();
        for (i, stage) in self.stages.iter().enumerate().take(MOST).rev() {
            let force = composites[i].times(&posture.axes[i]).times(stage.multiplier);
            matrix[(stage.coordinate, stage.coordinate)] += stage.multiplier * posture.axes[i].dot(&force);
            let mut at = stage;
            while !at.is_root {
                let before = at.parent;
                at = &self.stages[before];
                let share = at.multiplier * posture.axes[before].dot(&force);
                matrix[(stage.coordinate, at.coordinate)] += share;
                matrix[(at.coordinate, stage.coordinate)] += share;
            }
            if !stage.is_root {
                let carried = composites[i];
                let carrier = &mut composites[stage.parent];
                carrier.mass += carried.mass;
                carrier.moment += carried.moment;
                carrier.inertia += carried.inertia;
            }
        }
        matrix
    }

    /// The accelerations [rad/s² or m/s²] that `torques` [N m or N] make at `q` [rad or m] and `velocity` [rad/s or m/s], while
    /// the surroundings act on the tip with `wrench`: at the tip's origin, along the axes of the world [N, N m]. `None` where
    /// a coordinate moves no mass.
    #[must_use]
    pub fn forward_dynamics(
        &self,
        q: &SVector<f64, N>,
        velocity: &SVector<f64, N>,
        torques: &SVector<f64, N>,
        wrench: Option<&Wrench>,
    ) -> Option<SVector<f64, N>> {
        let posture = Posture::at(self, q);
        let bias = self.torques(&posture, velocity, None, wrench);
        self.composite(&posture).cholesky().map(|factors| factors.solve(&(torques - bias)))
    }
}
