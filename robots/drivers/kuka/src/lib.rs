//! KUKA arms for mrroc, by the Robot Sensor Interface (RSI): the controller sends where its axes are every 4 or 12 ms, and takes
//! corrections in the answer.
//!
//! **Never run on a real robot.** It was run against RSIPI's emulator of a controller, which rejects answers with another
//! clock and breaks off after too many late ones (`tests/peers/drives`).
//!
//! On the controller runs a program of its own with `RSI_ON(#ABSOLUTE)` or `RSI_ON(#RELATIVE)`, as [`RsiSettings::corrections`] has
//! it, a signal flow of an ETHERNET object whose `AKorr` goes to an AXISCORR object, and limits of the corrections that let the
//! task's range through. Its configuration of the network names this machine, the port of [`RsiSettings::listen`], and
//! [`RsiSettings::sensor`] as its `SENTYPE`; it sends `DEF_AIPos` and `DEF_Delay`. `HOLDON` of its `AKorr` is 1 for absolute corrections,
//! else a late answer sends the arm back to its start, and 0 for relative ones, else the last correction is added again.
//!
//! Its digital inputs and outputs have names in a cell where the configuration has their words `DiL`, `DoutW` and `DiO` as well (the page of the
//! book on real robots shows it whole).
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

mod corrections;
mod drives;
mod message;
mod network;
mod opening;
mod session;
mod settings;
mod words;

use core::time::Duration;

use mrroc::cell::{CellError, RobotSetup};
use mrroc_launch::cell_file::{AnySetup, EntryKey, Kinds, RobotEntry};
use mrroc_robots::{Simulated, urdf_arm};

pub use corrections::Corrections;
pub use drives::Rsi;
pub use message::{AXES, FromController, ToController};
pub use mrroc_driver_kit::Arrived;
pub use network::{Network, Sockets};
pub use settings::RsiSettings;

/// Adds the kind `kuka-rsi`: an arm of six axes, read from the URDF `file` as the kind `urdf` is, and moved by a controller
/// at `address`, which sends to this machine's `listen`. `period_ms` is 4 or 12, and `corrections` are "absolute" or "relative", as
/// on the controller; the first of each by default. Simulated drives, from `start` on, stand in where nothing real may move.
#[must_use]
pub fn with_rsi(kinds: Kinds) -> Kinds {
    kinds.with_any("kuka-rsi", |entry| {
        let arm = urdf_arm::<AXES>(entry)?;
        let settings = RsiSettings {
            period: period(entry)?,
            corrections: corrections(entry)?,
            ..RsiSettings::new(entry.listen()?, entry.address()?)
        };
        let start = entry.start(&arm)?;
        let setup = RobotSetup::new(entry.name(), arm.clone(), Rsi::new(settings));
        Ok(AnySetup::from(setup.stand_in(Simulated::new(arm, &start))))
    })
}

/// The periods that a controller has.
const PERIODS: [Duration; 2] = [Duration::from_millis(4), Duration::from_millis(12)];

fn period(entry: &RobotEntry) -> Result<Duration, CellError> {
    let period = entry.period().unwrap_or(PERIODS[0]);
    if PERIODS.contains(&period) {
        return Ok(period);
    }
    let what = format!("a controller with RSI has no period of {} ms", period.as_secs_f64() * 1e3);
    let help = "write period_ms = 4 for IPO_FAST, or 12 for IPO, as its ETHERNET object has it".to_owned();
    Err(entry.refuse(EntryKey::Period, what, help))
}

fn corrections(entry: &RobotEntry) -> Result<Corrections, CellError> {
    match entry.corrections() {
        None | Some("absolute") => Ok(Corrections::Absolute),
        Some("relative") => Ok(Corrections::Relative),
        Some(other) => {
            let what = format!("`{other}` says nothing that corrections could be counted from");
            let help =
                "write corrections = \"absolute\" or \"relative\", as in RSI_ON of its program".to_owned();
            Err(entry.refuse(EntryKey::Corrections, what, help))
        }
    }
}

#[cfg(test)]
mod tests {
    use mrroc_launch::cell_file::CellFile;

    use super::*;

    /// The refusal of a KUKA arm with these lines in its table, in the cell of the example; or none.
    fn refusal(lines: &str) -> Option<String> {
        let example = include_str!("../examples/cell.toml").replace("stop_ms = 1000", "stop_ms = 2000");
        let example = example.replace("file = \"kr6", &format!("{lines}\nfile = \"kr6"));
        let name = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/cell.toml");
        let file = CellFile::parse(name, &example).expect("well-formed");
        file.cell(&with_rsi(mrroc_robots::simulated())).err().map(|why| why.to_string())
    }

    #[test]
    fn the_period_and_what_corrections_count_from_are_read_from_the_cell_file() {
        assert_eq!(refusal(""), None);
        assert_eq!(refusal("period_ms = 4\ncorrections = \"absolute\""), None);
        assert_eq!(refusal("corrections = \"relative\""), None);
        for (lines, told) in [
            ("period_ms = 8", "a controller with RSI has no period of 8 ms"),
            ("corrections = \"both\"", "`both` says nothing that corrections could be counted from"),
            ("calibration = \"kr6.toml\"", "kr6.toml cannot be read"),
        ] {
            let why = refusal(lines).expect("a refusal");
            assert!(why.contains(told), "{why}");
        }
    }

    #[test]
    fn other_kinds_refuse_them() {
        for line in ["period_ms = 4", "corrections = \"relative\""] {
            let text = format!(
                "step_ms = 2\n[robots.arm]\nkind = \"irp6\"\nstart = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]\n{line}\n"
            );
            let file = CellFile::parse("cell.toml", &text).expect("well-formed");
            let Err(why) = file.cell(&with_rsi(mrroc_robots::simulated())) else { panic!("{line} is taken") };
            let key = line.split(' ').next().unwrap_or_default();
            assert!(why.to_string().contains(&format!("the kind `irp6` does not read `{key}`")), "{why}");
        }
    }
}
