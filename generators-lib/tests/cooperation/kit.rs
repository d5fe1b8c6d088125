//! Arms that record where their tools were demanded and measured, and what a transfer must keep.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::observe::ServoRecord;
use mrroc::prelude::*;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Driven, Irp6, Shaft, Simulated, Six};
use nalgebra::{SVector, Vector3};

/// One step, and one servo period of the simulated drives.
pub const STEP: Duration = Duration::from_millis(2);

/// Where a tool was, servo period by servo period.
#[derive(Clone, Default)]
pub struct Trace {
    pub demanded: Rc<RefCell<Vec<Pose>>>,
    pub measured: Rc<RefCell<Vec<Pose>>>,
    /// The demanded joints.
    pub joints: Rc<RefCell<Vec<Vec<f64>>>>,
}

/// A simulated robot at `q` that records.
pub fn arm<R: Driven<N>, const N: usize>(
    name: &str,
    robot: &R,
    q: &SVector<f64, N>,
) -> (RobotSetup<R>, Trace, Shaft<N>) {
    let (trace, simulated) = (Trace::default(), Simulated::new(robot.clone(), q));
    let (records, shaft, robot) = (trace.clone(), simulated.shaft(), robot.clone());
    let setup = RobotSetup::new(name, robot.clone(), simulated).observe(move |record: &ServoRecord<R>| {
        records.demanded.borrow_mut().push(robot.forward(&record.demanded));
        records.joints.borrow_mut().push(record.demanded.as_slice().to_vec());
        records.measured.borrow_mut().push(robot.forward(&record.measured.position));
    });
    (setup, trace, shaft)
}

/// Where the IRp-6 arms of these tests begin.
pub fn irp6_start() -> Six {
    Irp6::READY
}

/// An IRp-6 whose base stands `distance` \[m\] from the world's axis in the direction `angle` \[rad\], and faces the axis.
pub fn irp6_facing(distance: f64, angle: f64) -> Irp6 {
    let base = Pose::rotation(Vector3::z() * angle) * Pose::translation(distance, 0.0, 0.0);
    Irp6::nominal().with_base(base * Pose::rotation(Vector3::z() * std::f64::consts::PI))
}

pub fn limits() -> ToolLimits {
    ToolLimits {
        translation: ProfileLimits { velocity: 0.1, acceleration: 0.2 },
        rotation: ProfileLimits { velocity: 0.2, acceleration: 0.4 },
    }
}

/// Distance \[m\] and angle \[rad\] between two poses.
pub fn apart(a: &Pose, b: &Pose) -> (f64, f64) {
    let by = a.inv_mul(b);
    // Exact where the angle's cosine is not.
    (by.translation.vector.norm(), 2.0 * by.rotation.imag().norm().min(1.0).asin())
}

/// The largest of both errors of a relation between the poses of two traces that is to be `X_AB` throughout.
pub fn relative_error(a: &[Pose], b: &[Pose], X_AB: &Pose) -> (f64, f64) {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| apart(&a.inv_mul(b), X_AB))
        .fold((0.0, 0.0), |most: (f64, f64), error| (most.0.max(error.0), most.1.max(error.1)))
}
