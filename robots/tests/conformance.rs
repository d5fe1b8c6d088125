//! Every robot of the crate keeps what a robot must keep.

use std::time::Duration;

use mrroc::pose::Pose;
use mrroc::robot::IdealDrives;
use mrroc_robots::{
    Conveyor, Five, Gripper, Irp6, Irp6FiveDof, Irp6Track, One, Polycrank, Rnt, Seven, Simulated,
    SimulatedIrp6, Six, TwoFingers, driver_conformance, kinematics_conformance,
};
use nalgebra::Vector3;

use crate::support::engraving;

/// A base that is neither at the origin nor upright.
fn base() -> Pose {
    Pose::new(Vector3::new(0.3, -2.1, 0.95), Vector3::new(0.1, -0.4, 2.0))
}

/// A Polycrank with both arms bent and the tool level.
fn bent() -> Seven {
    Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2])
}

/// The RNT with its tool straight down.
fn drawn() -> Six {
    Six::new(0.1, 0.5, 0.55, 0.2, 1.3, 0.3)
}

/// The middle of the track, the arm as for engraving.
fn on_track() -> Seven {
    let arm = engraving();
    Seven::from_fn(|i, _| if i == 0 { 0.5 } else { arm[i - 1] })
}

kinematics_conformance!(irp6, Irp6::nominal(), engraving());
kinematics_conformance!(irp6_calibrated, Irp6::calibrated().with_base(base()), engraving());
driver_conformance!(
    irp6_drives,
    Irp6::nominal(),
    SimulatedIrp6::new(Irp6::nominal(), &engraving()),
    engraving()
);
driver_conformance!(
    ideal_drives,
    Irp6::nominal(),
    IdealDrives::new(&Irp6::nominal(), engraving(), Duration::from_millis(2)),
    engraving()
);
kinematics_conformance!(
    irp6_5dof,
    Irp6FiveDof::nominal().with_base(base()),
    Five::new(0.3, -1.6, 0.1, 0.2, 1.0)
);
kinematics_conformance!(irp6_track, Irp6Track::nominal(), on_track());
kinematics_conformance!(irp6_track_calibrated, Irp6Track::calibrated().with_base(base()), on_track());
kinematics_conformance!(polycrank, Polycrank::new().with_base(base()), bent());
kinematics_conformance!(rnt, Rnt::new().with_base(base()), drawn());

driver_conformance!(
    irp6_5dof_drives,
    Irp6FiveDof::nominal(),
    Simulated::new(Irp6FiveDof::nominal(), &Five::new(0.3, -1.6, 0.1, 0.2, 1.0)),
    Five::new(0.3, -1.6, 0.1, 0.2, 1.0)
);
driver_conformance!(
    irp6_track_drives,
    Irp6Track::nominal(),
    Simulated::new(Irp6Track::nominal(), &on_track()),
    on_track()
);
driver_conformance!(polycrank_drives, Polycrank::new(), Simulated::new(Polycrank::new(), &bent()), bent());
driver_conformance!(rnt_drives, Rnt::new(), Simulated::new(Rnt::new(), &drawn()), drawn());

kinematics_conformance!(gripper, Gripper::new().with_base(base()), One::new(0.07));
kinematics_conformance!(two_fingers, TwoFingers::new().with_base(base()), One::new(0.05));
kinematics_conformance!(conveyor, Conveyor::new().with_base(base()), One::new(0.5));
driver_conformance!(
    gripper_drive,
    Gripper::new(),
    Simulated::new(Gripper::new(), &One::new(0.07)),
    One::new(0.07)
);
driver_conformance!(
    two_fingers_drive,
    TwoFingers::new(),
    Simulated::new(TwoFingers::new(), &One::new(0.05)),
    One::new(0.05)
);
driver_conformance!(
    conveyor_drive,
    Conveyor::new(),
    Simulated::new(Conveyor::new(), &One::new(0.5)),
    One::new(0.5)
);
