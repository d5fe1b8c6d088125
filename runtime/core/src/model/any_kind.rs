//! A robot of any kind with so many joints, and its drives: what its processes know of it.
//!
//! In: a model and drives of one kind. Out: the same behind tables of functions, so that an EDP, which needs no more, is compiled
//! once for each number of joints and not for each kind of robots.

use core::marker::PhantomData;
use core::time::Duration;
use std::sync::Arc;

use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Channels, Driver, Measured, Recovery, Regulators, SimulatedDrives, Stepped};
use crate::model::joints::JointVector;
use crate::model::load::Load;
use crate::model::pace::{Pace, Pulse};
use crate::model::pose::Pose;
use crate::model::robot::{CoupledLimit, JointKind, Limits, NoInverse, Robot};
use crate::model::signals::{Outputs, Signals};
use crate::model::wrench::Wrench;

/// The model of a robot of any kind. It has what moves a robot; what observers see of one, such as meshes, it does not have.
#[derive(Clone)]
pub(crate) struct AnyKind<J>(Arc<dyn Model<J>>);

impl<J: JointVector> AnyKind<J> {
    pub fn new(model: impl Robot<Joints = J>) -> Self {
        AnyKind(Arc::new(model))
    }
}

/// What [`AnyKind`] asks of a model.
#[allow(non_snake_case)]
trait Model<J>: Send + Sync {
    fn joint(&self, i: usize) -> JointKind;
    fn limits(&self) -> &Limits<J>;
    fn check_coupled(&self, from: &J, to: &J, duration: f64) -> Result<(), CoupledLimit>;
    fn check_coupled_to_stop(&self, from: &J, to: (&J, f64), stop: (&J, f64)) -> Result<(), CoupledLimit>;
    fn near_singularity(&self, q: &J) -> Option<&'static str>;
    fn forward(&self, q: &J) -> Pose;
    fn inverse(&self, X_WF: &Pose, near: &J) -> Result<J, NoInverse>;
    fn inverse_at(&self, X_WF: &Pose, redundancy: f64, near: &J) -> Result<J, NoInverse>;
}

#[allow(non_snake_case)]
impl<R: Robot> Model<R::Joints> for R {
    fn joint(&self, i: usize) -> JointKind {
        Robot::joint(self, i)
    }

    fn limits(&self) -> &Limits<R::Joints> {
        Robot::limits(self)
    }

    fn check_coupled(&self, from: &R::Joints, to: &R::Joints, duration: f64) -> Result<(), CoupledLimit> {
        Robot::check_coupled(self, from, to, duration)
    }

    fn check_coupled_to_stop(
        &self,
        from: &R::Joints,
        to: (&R::Joints, f64),
        stop: (&R::Joints, f64),
    ) -> Result<(), CoupledLimit> {
        Robot::check_coupled_to_stop(self, from, to, stop)
    }

    fn near_singularity(&self, q: &R::Joints) -> Option<&'static str> {
        Robot::near_singularity(self, q)
    }

    fn forward(&self, q: &R::Joints) -> Pose {
        Robot::forward(self, q)
    }

    fn inverse(&self, X_WF: &Pose, near: &R::Joints) -> Result<R::Joints, NoInverse> {
        Robot::inverse(self, X_WF, near)
    }

    fn inverse_at(&self, X_WF: &Pose, redundancy: f64, near: &R::Joints) -> Result<R::Joints, NoInverse> {
        Robot::inverse_at(self, X_WF, redundancy, near)
    }
}

#[allow(non_snake_case)]
impl<J: JointVector> Robot for AnyKind<J> {
    // In no message: what names a robot by its kind knows the kind.
    const KIND: &'static str = "any";

    type Joints = J;

    fn joint(&self, i: usize) -> JointKind {
        self.0.joint(i)
    }

    fn limits(&self) -> &Limits<J> {
        self.0.limits()
    }

    fn check_coupled(&self, from: &J, to: &J, duration: f64) -> Result<(), CoupledLimit> {
        self.0.check_coupled(from, to, duration)
    }

    fn check_coupled_to_stop(&self, from: &J, to: (&J, f64), stop: (&J, f64)) -> Result<(), CoupledLimit> {
        self.0.check_coupled_to_stop(from, to, stop)
    }

    fn near_singularity(&self, q: &J) -> Option<&'static str> {
        self.0.near_singularity(q)
    }

    fn forward(&self, q: &J) -> Pose {
        self.0.forward(q)
    }

    fn inverse(&self, X_WF: &Pose, near: &J) -> Result<J, NoInverse> {
        self.0.inverse(X_WF, near)
    }

    fn inverse_at(&self, X_WF: &Pose, redundancy: f64, near: &J) -> Result<J, NoInverse> {
        self.0.inverse_at(X_WF, redundancy, near)
    }
}

/// Drives of one kind of robots as those of any kind.
pub(crate) struct DrivesOf<R, D>(D, PhantomData<fn() -> R>);

impl<R: Robot, D: Driver<R>> DrivesOf<R, D> {
    pub const fn new(drives: D) -> Self {
        DrivesOf(drives, PhantomData)
    }
}

// What drives do not say would be the default of the trait, and not what they do.
#[deny(clippy::missing_trait_methods)]
impl<R: Robot, D: Driver<R>> Driver<AnyKind<R::Joints>> for DrivesOf<R, D> {
    fn period(&self) -> Duration {
        self.0.period()
    }

    fn pace(&self) -> Pace {
        self.0.pace()
    }

    fn pulse(&mut self, now: Duration) -> Result<Option<Pulse>, DriveFault> {
        self.0.pulse(now)
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        self.0.open()
    }

    fn close(&mut self) {
        self.0.close();
    }

    fn held(&self) -> Option<R::Joints> {
        self.0.held()
    }

    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault> {
        self.0.measured()
    }

    fn tick(&mut self, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault> {
        self.0.tick(demanded)
    }

    fn channels(&self) -> Channels {
        self.0.channels()
    }

    fn signals(&self) -> Signals {
        self.0.signals()
    }

    fn switch_outputs(&mut self, outputs: &Outputs) {
        self.0.switch_outputs(outputs);
    }

    fn declare_outputs(&mut self, named: &Outputs, when_lost: &Outputs) {
        self.0.declare_outputs(named, when_lost);
    }

    fn carry(&mut self, load: &Load) {
        self.0.carry(load);
    }

    fn load_time(&self) -> Duration {
        self.0.load_time()
    }

    fn motor_currents(&self) -> Option<R::Joints> {
        self.0.motor_currents()
    }

    fn wrench(&self) -> Option<Wrench> {
        self.0.wrench()
    }

    fn speed_scaling(&self) -> f64 {
        self.0.speed_scaling()
    }

    fn hardware(&self) -> Option<String> {
        self.0.hardware()
    }

    fn calibration(&mut self) -> Result<Option<String>, DriveFault> {
        self.0.calibration()
    }

    fn has_brakes(&self) -> bool {
        self.0.has_brakes()
    }

    fn switch_off(&mut self) {
        self.0.switch_off();
    }

    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        self.0.recover()
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.0.switch_on()
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        self.0.has_regulator(joint, set)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.0.choose_regulators(sets);
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R::Joints>> {
        self.0.simulation()
    }

    fn stepped(&mut self) -> Option<&mut dyn Stepped<R::Joints>> {
        self.0.stepped()
    }

    fn python(&self) -> Option<String> {
        self.0.python()
    }
}
