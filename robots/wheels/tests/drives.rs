//! The simulated drives keep what every driver must.

use mrroc_wheels::simulation::{Floor, Ground};
use mrroc_wheels::{DiffDrive, Planar, Rolling, Two};

fn rolling() -> Rolling {
    Rolling::new(DiffDrive::new(), Floor::new(Ground::default(), Planar::default()))
}

mrroc_robots::driver_conformance!(base, DiffDrive::new(), rolling(), Two::zeros());
