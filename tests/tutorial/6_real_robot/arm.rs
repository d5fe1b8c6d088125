//! The kind of robot, and what drives it: a Franka Research 3 by its control interface.

use std::time::Duration;

use mrroc::cell_file::Kinds;
use mrroc_franka::{FciSettings, with_franka_as};

pub use mrroc_franka::Fr3 as Arm;

/// How long a simulator may say nothing; a robot has stopped by itself after 20 ms.
const SILENCE: Duration = Duration::from_millis(100);

/// The kind "fr3" in cell.toml, beside the simulated robots.
pub fn kinds() -> Kinds {
    with_franka_as(mrroc_robots::simulated(), |robot| FciSettings {
        silence: SILENCE,
        ..FciSettings::new(robot)
    })
}
