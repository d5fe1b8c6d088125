//! KUKA arms for mrroc, by the Robot Sensor Interface (RSI): the controller sends where its axes are every 4 or 12 ms, and takes
//! corrections in the answer.
//!
//! **Never run on a real robot.** It was run against RSIPI's emulator of a controller, which rejects answers with another
//! clock and breaks off after too many late ones (`tests/peers/drives`).
//!
//! On the controller runs a program of its own with `RSI_ON(#ABSOLUTE)`, a signal flow of an ETHERNET object whose `AKorr`
//! goes to an AXISCORR object, and limits of the corrections that let the task's range through. Its configuration of the
//! network names this machine, the port of [`RsiSettings::listen`], and [`RsiSettings::sensor`] as its `SENTYPE`; it sends
//! `DEF_AIPos`, and `DEF_Delay` if it can.
//!
//! What the robot does by itself: it stops when the answers to more packets are late than its ETHERNET object's `Timeout`
//! allows, and when a correction is beyond its own limits. Then it says nothing more, which is a fault of its drives
//! here; a person starts its program at the pendant again, and then a reset goes on from where the robot stands.
//!
//! ```no_run
//! use mrroc_kuka::with_rsi;
//!
//! // kind = "kuka-rsi" in cell.toml: an arm of six axes that a URDF describes.
//! let kinds = with_rsi(mrroc_robots::simulated());
//! ```

mod drives;
mod message;

use mrroc::cell::RobotSetup;
use mrroc_launch::cell_file::{AnySetup, Kinds};
use mrroc_robots::{Simulated, urdf_arm};

pub use drives::{Rsi, RsiSettings};
pub use message::{AXES, FromController, ToController};

/// Adds the kind `kuka-rsi`: an arm of six axes, read from the URDF `file` as the kind `urdf` is, and moved by a controller
/// at `address`, which sends to this machine's `listen`. Its period is 4 ms. Simulated drives, from `start` on, stand in
/// where nothing real may move.
#[must_use]
pub fn with_rsi(kinds: Kinds) -> Kinds {
    kinds.with_any("kuka-rsi", |entry| {
        let arm = urdf_arm::<AXES>(entry)?;
        let settings = RsiSettings::new(entry.listen()?, entry.address()?);
        let start = entry.start(&arm)?;
        let setup = RobotSetup::new(entry.name(), arm.clone(), Rsi::new(settings));
        Ok(AnySetup::from(setup.stand_in(Simulated::new(arm, &start))))
    })
}
