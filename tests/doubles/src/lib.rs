//! What the whole-system tests and the benchmarks of `mrroc` share: two small robots, drives that follow their demands
//! exactly (they are about the runtime; real dynamics are in `mrroc-robots`), a motion by orders, and a recorder of demands.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::fault::Excess;
use mrroc::observe::ServoRecord;
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, JointKind, JointVector, Limits, Measured, NoInverse};
use nalgebra::{SVector, Translation3};

/// The step that most tests use.
pub const MS: Duration = Duration::from_millis(1);

/// One vector per joint.
pub type Q<const N: usize> = SVector<f64, N>;

/// Three perpendicular slides: joint positions are the flange's position \[m\].
#[derive(Clone, Debug)]
pub struct Gantry {
    limits: Limits<Q<3>>,
}

impl Default for Gantry {
    /// A gantry with limits of -1 m and 1 m, 1 m/s, 10 m/s², and no jerk limit.
    fn default() -> Self {
        Gantry {
            limits: Limits {
                lower: Q::repeat(-1.0),
                upper: Q::repeat(1.0),
                velocity: Q::repeat(1.0),
                acceleration: Q::repeat(10.0),
                jerk: None,
            },
        }
    }
}

impl Gantry {
    /// The same gantry with this velocity limit [m/s].
    #[must_use]
    pub fn with_velocity(velocity: f64) -> Self {
        let mut gantry = Gantry::default();
        gantry.limits.velocity = Q::repeat(velocity);
        gantry
    }

    /// A gantry with these limits.
    #[must_use]
    pub fn with_limits(limits: Limits<Q<3>>) -> Self {
        Gantry { limits }
    }

    /// The same gantry with this jerk limit [m/s³].
    #[must_use]
    pub fn with_jerk(jerk: f64) -> Self {
        let mut gantry = Gantry::default();
        gantry.limits.jerk = Some(Q::repeat(jerk));
        gantry
    }
}

impl Robot for Gantry {
    const KIND: &'static str = "gantry";
    type Joints = Q<3>;

    fn joint(&self, _: usize) -> JointKind {
        JointKind::Prismatic
    }

    fn limits(&self) -> &Limits<Q<3>> {
        &self.limits
    }

    fn forward(&self, q: &Q<3>) -> Pose {
        Pose::translation(q[0], q[1], q[2])
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _: &Q<3>) -> Result<Q<3>, NoInverse> {
        if X_WF.rotation.angle() > 1e-9 {
            return Err(NoInverse::Singular { name: "the gantry cannot turn" });
        }
        let Translation3 { vector } = X_WF.translation;
        if vector.norm() > 5.0 {
            return Err(NoInverse::OutOfReach { distance: vector.norm(), min: 0.0, max: 5.0 });
        }
        Ok(vector)
    }
}

/// One rotary joint, whose end stops are far away.
#[derive(Clone, Debug)]
pub struct Turntable {
    limits: Limits<Q<1>>,
}

impl Default for Turntable {
    fn default() -> Self {
        Turntable {
            limits: Limits {
                lower: Q::repeat(-100.0),
                upper: Q::repeat(100.0),
                velocity: Q::repeat(2.0),
                acceleration: Q::repeat(20.0),
                jerk: None,
            },
        }
    }
}

impl Robot for Turntable {
    const KIND: &'static str = "turntable";
    type Joints = Q<1>;

    fn limits(&self) -> &Limits<Q<1>> {
        &self.limits
    }

    fn forward(&self, q: &Q<1>) -> Pose {
        Pose::rotation(nalgebra::Vector3::z() * q[0])
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Q<1>) -> Result<Q<1>, NoInverse> {
        let (_, _, yaw) = X_WF.rotation.euler_angles();
        let turns = ((near[0] - yaw) / std::f64::consts::TAU).round();
        Ok(Q::<1>::new(yaw + turns * std::f64::consts::TAU))
    }
}

/// Drives that reach their demand at the end of every servo period: a test double, not a simulation.
#[derive(Clone, Debug)]
pub struct ExactDrive<const N: usize> {
    measured: Measured<Q<N>>,
    period: Duration,
    /// The tick in which the drives trip.
    pub trips_at: Option<u64>,
    /// The tick from which the drives no longer follow their demands.
    pub sticks_at: Option<u64>,
    ticks: u64,
}

impl<const N: usize> ExactDrive<N> {
    /// Drives at `position`, with this servo period.
    #[must_use]
    pub fn new(position: Q<N>, period: Duration) -> Self {
        let measured = Measured { position, velocity: Q::zeros() };
        ExactDrive { measured, period, trips_at: None, sticks_at: None, ticks: 0 }
    }

    /// Drives at the origin, with a servo period of 1 ms.
    #[must_use]
    pub fn at_origin() -> Self {
        Self::new(Q::zeros(), MS)
    }
}

impl<R: Robot<Joints = Q<N>>, const N: usize> Driver<R> for ExactDrive<N> {
    fn period(&self) -> Duration {
        self.period
    }

    fn measured(&self) -> Result<Measured<Q<N>>, DriveFault> {
        Ok(self.measured)
    }

    fn tick(&mut self, demanded: &Q<N>) -> Result<Measured<Q<N>>, DriveFault> {
        self.ticks += 1;
        if self.trips_at == Some(self.ticks) {
            return Err(DriveFault::exceeded(0, "motor current", Excess::new(30.0, 25.0, "A")));
        }
        if self.sticks_at.is_none_or(|tick| self.ticks < tick) {
            let velocity = (demanded - self.measured.position) / self.period.as_secs_f64();
            self.measured = Measured { position: *demanded, velocity };
        }
        Ok(self.measured)
    }
}

/// An order for [`Follow`]: by how much the first joint is off where the Move began \[rad or m\].
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Turned {
    /// The offset \[rad or m\].
    pub by: f64,
}

/// A motion of an ECP that goes where the MP's order turns the first joint to, and ends with the MP's Move.
#[derive(Clone, Debug)]
pub struct Follow<R: Robot> {
    /// Where it began \[rad or m\].
    from: R::Joints,
}

impl<R: Robot> Follow<R> {
    /// Takes the offset from the joint positions that are demanded when it begins.
    #[must_use]
    pub fn from_here() -> Self {
        Follow { from: R::Joints::zeros() }
    }
}

#[generator(ecp)]
impl<R: Robot> Follow<R> {
    fn first_step(&mut self, order: &Order<Turned>, e: &State<R>) -> Step<R> {
        self.from = e.demanded().joints;
        self.next_step(order)
    }

    fn next_step(&mut self, order: &Order<Turned>) -> Step<R> {
        let mut q = self.from;
        q[0] += order.value().by;
        Step::Next(Demand::joints(q))
    }
}

/// The demands that a robot's drives got, one for each servo period.
pub type Trace<const N: usize> = Rc<RefCell<Vec<Q<N>>>>;

/// A gantry at the origin that records its drives' demands.
#[must_use]
pub fn gantry(name: &str) -> (RobotSetup<Gantry>, Trace<3>) {
    traced(RobotSetup::new(name, Gantry::default(), ExactDrive::at_origin()))
}

/// A turntable at the origin that records its drives' demands.
#[must_use]
pub fn turntable(name: &str) -> (RobotSetup<Turntable>, Trace<1>) {
    traced(RobotSetup::new(name, Turntable::default(), ExactDrive::at_origin()))
}

/// The same robot with a recorder.
#[must_use]
pub fn traced<R: Robot<Joints = Q<N>>, const N: usize>(setup: RobotSetup<R>) -> (RobotSetup<R>, Trace<N>) {
    let trace = Trace::default();
    let recorder = Rc::clone(&trace);
    (setup.observe(move |record: &ServoRecord<R>| recorder.borrow_mut().push(record.demanded)), trace)
}

/// The largest velocity and acceleration of a trace with period `dt` \[s\], by differences.
#[must_use]
pub fn peaks<const N: usize>(trace: &[Q<N>], dt: f64) -> (f64, f64) {
    let mut peak = (0.0_f64, 0.0_f64);
    for window in trace.windows(3) {
        let (v0, v1) = ((window[1] - window[0]) / dt, (window[2] - window[1]) / dt);
        peak = (peak.0.max(v0.amax()).max(v1.amax()), peak.1.max(((v1 - v0) / dt).amax()));
    }
    peak
}

/// The fault of a run that must have ended with one.
///
/// # Panics
/// If the run did not end with a fault.
#[must_use]
pub fn fault(result: Result<mrroc::cell::RunReport, mrroc::cell::CellError>) -> Fault {
    match result {
        Err(mrroc::cell::CellError::Fault(fault)) => fault,
        other => panic!("expected a fault, got {other:?}"),
    }
}
