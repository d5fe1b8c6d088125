//! Every robot of the crate keeps what a robot must keep.

mod support;

use mrroc::Pose;
use mrroc_robots::{Irp6, SimulatedIrp6, driver_conformance, kinematics_conformance};
use nalgebra::Vector3;
use support::engraving;

/// A base that is neither at the origin nor upright.
fn base() -> Pose {
    Pose::new(Vector3::new(0.3, -2.1, 0.95), Vector3::new(0.1, -0.4, 2.0))
}

kinematics_conformance!(irp6, Irp6::nominal(), engraving());
kinematics_conformance!(irp6_calibrated, Irp6::calibrated().with_base(base()), engraving());
driver_conformance!(
    irp6_drives,
    Irp6::nominal(),
    SimulatedIrp6::new(Irp6::nominal(), &engraving()),
    engraving()
);
