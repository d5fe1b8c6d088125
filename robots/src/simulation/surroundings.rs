//! Simulated drives among things that load their motors and are moved by them.
//!
//! In: what a robot does to its surroundings and they do to it, before and after a servo period. Out: the drives of that robot.

use core::fmt::Debug;
use core::time::Duration;

use mrroc::robot::{DriveFault, Driver, Measured, Regulators, SimulatedDrives};
use nalgebra::SVector;

use super::simulated::{Shaft, Simulated};
use crate::models::Driven;

/// What is around a robot: its world, or what it holds.
pub trait Surroundings<R: Driven<N>, const N: usize>: Debug {
    /// A demand is about to be carried out.
    fn demanded(&mut self, _drives: &mut Simulated<R, N>, _demand: &SVector<f64, N>) {}

    /// A servo period begins, with a demand or in braking: loads the motors, blocks joints.
    fn begin(&mut self, _drives: &mut Simulated<R, N>) {}

    /// It is over: the joints are where [`Simulated::state`] says.
    fn end(&mut self, _drives: &Simulated<R, N>) {}
}

/// A [`Simulated`] robot in its surroundings.
///
/// ```
/// use mrroc::robot::Driver;
/// use mrroc_robots::{Conveyor, One, Simulated, Surrounded, Surroundings};
///
/// /// A box that lies at 0.2 mm on the path, and is pushed along from there.
/// #[derive(Debug)]
/// struct Box(f64);
///
/// impl Surroundings<Conveyor, 1> for Box {
///     fn end(&mut self, drives: &Simulated<Conveyor, 1>) {
///         self.0 = self.0.max(drives.state().position[0]);
///     }
/// }
///
/// let drives = Simulated::new(Conveyor::new(), &One::zeros());
/// let mut belt = Surrounded::by(drives, Box(2e-4));
/// for k in 1..=200 {
///     belt.tick(&One::new(2e-6 * f64::from(k)))?;
/// }
/// assert!((belt.around().0 - 4e-4).abs() < 1e-4);
/// # Ok::<(), mrroc::robot::DriveFault>(())
/// ```
#[derive(Debug)]
pub struct Surrounded<R, const N: usize, S> {
    drives: Simulated<R, N>,
    /// While there is a view of it, the drives keep their true joint state.
    shaft: Shaft<N>,
    around: S,
}

impl<R: Driven<N>, const N: usize, S: Surroundings<R, N>> Surrounded<R, N, S> {
    /// These drives there.
    #[must_use]
    pub fn by(drives: Simulated<R, N>, around: S) -> Self {
        Self { shaft: drives.shaft(), drives, around }
    }

    /// A view of the true joint state.
    #[must_use]
    pub fn shaft(&self) -> Shaft<N> {
        self.shaft.clone()
    }

    /// The drives.
    #[must_use]
    pub const fn drives(&self) -> &Simulated<R, N> {
        &self.drives
    }

    /// What is around them.
    #[must_use]
    pub const fn around(&self) -> &S {
        &self.around
    }

    /// The drives, to jam one or to reset a trip.
    #[must_use]
    pub const fn drives_mut(&mut self) -> &mut Simulated<R, N> {
        &mut self.drives
    }

    /// One servo period.
    fn period_of<T>(&mut self, period: impl FnOnce(&mut Simulated<R, N>) -> T) -> T {
        self.around.begin(&mut self.drives);
        let outcome = period(&mut self.drives);
        self.around.end(&self.drives);
        outcome
    }
}

impl<R: Driven<N>, const N: usize, S: Surroundings<R, N>> Driver<R> for Surrounded<R, N, S> {
    fn period(&self) -> Duration {
        self.drives.period()
    }

    fn measured(&self) -> Result<Measured<SVector<f64, N>>, DriveFault> {
        self.drives.measured()
    }

    fn tick(&mut self, demanded: &SVector<f64, N>) -> Result<Measured<SVector<f64, N>>, DriveFault> {
        self.around.demanded(&mut self.drives, demanded);
        self.period_of(|drives| drives.tick(demanded))
    }

    fn motor_currents(&self) -> Option<SVector<f64, N>> {
        self.drives.motor_currents()
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R::Joints>> {
        Some(self)
    }

    fn has_brakes(&self) -> bool {
        self.drives.has_brakes()
    }

    fn switch_off(&mut self) {
        self.drives.switch_off();
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.drives.switch_on()
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        self.drives.has_regulator(joint, set)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.drives.choose_regulators(sets);
    }
}

impl<R: Driven<N>, const N: usize, S: Surroundings<R, N>> SimulatedDrives<R::Joints> for Surrounded<R, N, S> {
    fn brake(&mut self) -> Measured<SVector<f64, N>> {
        self.period_of(Simulated::brake)
    }
}
