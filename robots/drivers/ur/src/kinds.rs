//! The kinds of `cell.toml`.

use core::time::Duration;
use std::io::Read;
use std::path::Path;

use mrroc::cell::{CellError, RobotSetup};
use mrroc_launch::cell_file::{AnySetup, EntryKey, Kinds, RobotEntry};
use mrroc_launch::files;
use mrroc_robots::Simulated;

use crate::calibration::Calibration;
use crate::drives::{Ur, UrSettings};
use crate::models::UrModel;

/// The longest stop of a robot that says nothing else, as in `cell.toml`.
const STOP: Duration = Duration::from_millis(600);

/// How far an arm may be behind what it is told, as time at its largest velocity \[s\]: the lookahead of `servoj`, and some
/// periods of the network.
const BEHIND: f64 = 0.06;

/// Adds the kinds `ur3e`, `ur5e`, `ur10e`, `ur16e`, `ur20` and `ur30`: arms with the nominal dimensions of their [`UrModel`],
/// or those of their `calibration`, whose controller is at `address` and calls this machine's `listen`. Simulated drives, from `start` on, stand in where
/// nothing real may move.
#[must_use]
pub fn with_ur(kinds: Kinds) -> Kinds {
    with_ur_as(kinds, |settings| settings)
}

/// The same with other settings than the defaults.
#[must_use]
pub fn with_ur_as(kinds: Kinds, settings: fn(UrSettings) -> UrSettings) -> Kinds {
    UrModel::ALL
        .into_iter()
        .fold(kinds, |kinds, model| kinds.with_any(model.kind(), move |entry| set_up(entry, model, settings)))
}

/// The most bytes of a file with a calibration.
const MOST: u64 = 16 * 1024;

/// Reads the calibration of an arm of this model.
fn calibration(entry: &RobotEntry, model: UrModel, path: &Path) -> Result<Calibration, CellError> {
    let print =
        || format!("print it by `-- calibration {}` into this file, while the key is left out", entry.name());
    let refuse = |what: String, help| entry.refuse(EntryKey::Calibration, what, help);
    let mut text = String::new();
    let read = files::open(path).and_then(|file| file.take(MOST).read_to_string(&mut text));
    read.map_err(|why| refuse(format!("{} cannot be read: {why}", path.display()), print()))?;
    let parsed = Calibration::parse(&text);
    let (of, calibration) = parsed.map_err(|why| refuse(format!("{}: {why}", path.display()), print()))?;
    if of != model {
        let what =
            format!("{} is the calibration of a {}, not of a {}", path.display(), of.kind(), model.kind());
        return Err(refuse(what, format!("write kind = \"{}\", or another file", of.kind())));
    }
    Ok(calibration)
}

fn set_up(
    entry: &RobotEntry,
    model: UrModel,
    settings: fn(UrSettings) -> UrSettings,
) -> Result<AnySetup, CellError> {
    let settings = settings(UrSettings::new(model, entry.address()?, entry.listen()?));
    let mut settings = settings;
    let arm = match entry.calibration() {
        None => model.arm(entry.base()).map_err(|why| {
            entry.refuse(EntryKey::Address, why.to_string(), "this is a mistake of mrroc-ur".to_owned())
        })?,
        Some(path) => {
            let calibration = calibration(entry, model, &path)?;
            settings.calibration = Some(calibration);
            model.calibrated(entry.base(), &calibration).map_err(|why| {
                let help = format!("print that of this robot by `-- calibration {}`", entry.name());
                entry.refuse(EntryKey::Calibration, format!("{}: {why}", path.display()), help)
            })?
        }
    };
    let (longest, allowed) = (settings.longest_stop(model), entry.stop_time().unwrap_or(STOP));
    if longest > allowed {
        let what = format!(
            "robot `{}` may go on for {} ms when the network fails: {} ms until its script notices, then braking at {:.1} rad/s²; limit {} ms",
            entry.name(),
            longest.as_millis(),
            settings.read_timeout.as_millis(),
            settings.deceleration,
            allowed.as_millis()
        );
        let help = format!("write stop_ms = {} in its table", longest.as_millis().next_multiple_of(50));
        return Err(entry.refuse(EntryKey::Address, what, help));
    }
    let start = entry.start(&arm)?;
    let setup = RobotSetup::new(entry.name(), arm.clone(), Ur::new(settings));
    let setup = setup.following_error(model.velocities() * BEHIND);
    Ok(AnySetup::from(setup.stand_in(Simulated::new(arm, &start))))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use mrroc_launch::cell_file::CellFile;

    use super::*;

    /// A folder with the calibration of a UR5e, `arm.toml`, and with others that are none.
    fn folder() -> PathBuf {
        let folder = std::env::temp_dir().join(format!("mrroc-ur-kinds-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let of = |model: UrModel| Calibration::nominal(model).text(model);
        for (name, text) in [
            ("arm.toml", of(UrModel::Ur5e)),
            ("ur10e.toml", of(UrModel::Ur10e)),
            ("wrong.toml", of(UrModel::Ur10e).replace("ur10e", "ur5e")),
            ("cell.toml", "step_ms = 2".to_owned()),
        ] {
            std::fs::write(folder.join(name), text).expect("written");
        }
        folder
    }

    fn refusal(folder: &Path, lines: &str) -> Option<String> {
        let text = format!(
            "step_ms = 2\nstop_ms = 800\n[robots.arm]\nkind = \"ur5e\"\naddress = \"127.0.0.1\"\nlisten = \"127.0.0.1:50001\"\n\
             start = [0.0, -1.5, 1.5, -1.5, -1.5, 0.0]\n{lines}\n"
        );
        let name = folder.join("cell.toml").display().to_string();
        let file = CellFile::parse(&name, &text).expect("well-formed");
        file.cell(&with_ur(mrroc_robots::simulated())).err().map(|why| why.to_string())
    }

    #[test]
    fn a_calibration_is_read_from_its_file_and_refused_where_it_is_of_another_robot() {
        let folder = folder();
        assert_eq!(refusal(&folder, ""), None);
        assert_eq!(refusal(&folder, "calibration = \"arm.toml\""), None);
        for (file, told) in [
            ("ur10e.toml", "is the calibration of a ur10e, not of a ur5e"),
            ("wrong.toml", "it is another model"),
            ("cell.toml", "a calibration has no `step_ms`"),
            ("nothing.toml", "nothing.toml cannot be read"),
        ] {
            let why = refusal(&folder, &format!("calibration = \"{file}\"")).expect(file);
            assert!(why.contains(told) && why.contains("cell.toml:8:15"), "{why}");
        }
        std::fs::remove_dir_all(folder).expect("removed");
    }
}
