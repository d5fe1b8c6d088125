//! The file that a calibration is written to: what `cell.toml` reads ([`ArmCalibration`]), and what else is known.

use core::fmt::Write;
use std::time::{SystemTime, UNIX_EPOCH};

use mrroc::pose::Pose;
use mrroc_robots::{ArmCalibration, ChainCalibration, LocalCorrection};

use crate::chain::ChainArm;
use crate::fit::Fit;
use crate::known::is_unknown;
use crate::pose_text::pose_text;
use crate::problem::ArmId;
use crate::trials::Errors;

/// What a calibration file says besides the arm's dimensions.
#[derive(Clone, Debug)]
pub struct Account {
    /// The arm's name.
    pub robot: String,
    /// Where the measurements are, if in a file.
    pub data: Option<String>,
    /// The day, as [`today`] writes it.
    pub made: String,
    /// Errors of measurements at the postures that it was made from.
    pub within: Errors,
    /// Errors at postures that were left out.
    pub foretold: Errors,
    /// Frames by name, such as the arm's base in the world.
    pub frames: Vec<(String, Pose)>,
}

/// The calibration of a chain, with its local correction.
#[must_use]
pub fn of_chain(model: &ChainArm, values: &[f64], local: Option<LocalCorrection>) -> ArmCalibration {
    let chain = model.chain();
    let encoders = model.encoders(values);
    let any = encoders.iter().flatten().any(|number| *number != 0.0);
    ArmCalibration::Chain(ChainCalibration {
        design: chain.joints.iter().map(|joint| joint.X_before).collect(),
        tip: chain.X_tip,
        displacements: model.displacements(values),
        encoders: if any { encoders } else { Vec::new() },
        local,
    })
}

/// The text of the whole file.
#[must_use]
pub fn text(calibration: &ArmCalibration, fit: &Fit, arm: ArmId, account: &Account) -> String {
    let mut text = calibration.text();
    let Account { robot, data, made, within, foretold, frames } = account;
    // Writing into a text does not fail.
    let _ = writeln!(text, "robot = {}\nmade = {made:?}", quoted(robot));
    if let Some(data) = data {
        let _ = writeln!(text, "data = {}", quoted(data));
    }
    let _ = writeln!(
        text,
        "\n# Errors of measurements [m, or rad of angles alone]: at the postures used, and foretold at ones left out."
    );
    for (name, errors) in [("within", within), ("foretold", foretold)] {
        let Errors { count, mean, rms, max } = errors;
        let _ = writeln!(text, "[{name}]\ncount = {count}\nmean = {mean:?}\nrms = {rms:?}\nmax = {max:?}\n");
    }
    let _ = writeln!(text, "# Frames, as poses in cell.toml [m].");
    for (name, frame) in frames {
        let _ = writeln!(text, "[frames.{}]\n{}", quoted(name), pose_text(frame));
    }
    let columns: Vec<usize> = fit.columns_of(arm).into_iter().flatten().collect();
    let found: Vec<_> = fit.found().collect();
    let _ = writeln!(
        text,
        "# The parameters of the arm that were found, their values and covariance; the rest of it cannot be told apart."
    );
    let _ = writeln!(text, "[parameters]\nnames = [");
    for i in &columns {
        let parameter = &found[*i].parameter;
        let _ = writeln!(text, "    {}, # {}", quoted(&parameter.name), parameter.unit);
    }
    let values: Vec<f64> = columns.iter().map(|i| found[*i].value).collect();
    let sigmas: Vec<f64> = columns.iter().map(|i| found[*i].sigma).collect();
    let unknown = columns.iter().filter(|i| is_unknown(&found[**i]));
    let unknown: Vec<String> = unknown.map(|i| quoted(&found[*i].parameter.name)).collect();
    let _ = writeln!(text, "]\n# Of these the measurements tell hardly more than was believed before.");
    let _ = writeln!(text, "unknown = [{}]", unknown.join(", "));
    let _ = writeln!(text, "values = {values:?}\nsigmas = {sigmas:?}\ncovariance = [");
    for i in &columns {
        let row: Vec<f64> = columns.iter().map(|j| fit.covariance()[(*i, *j)]).collect();
        let _ = writeln!(text, "    {row:?},");
    }
    text.push_str("]\n");
    text
}

/// A text as TOML quotes it. Rust's own quotes escape characters in forms that TOML does not know.
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            // All of them are below U+00A0.
            _ if letter.is_control() => quoted.push_str(&format!("\\u{:04X}", u32::from(letter))),
            _ => quoted.push(letter),
        }
    }
    quoted.push('"');
    quoted
}

/// Today's date in UTC, `2026-11-24`.
#[must_use]
pub fn today() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let (year, month, day) = date(since.as_secs() / 86_400);
    format!("{year:04}-{month:02}-{day:02}")
}

/// Year, month and day of a number of days since 1970-01-01 (Hinnant, *chrono-compatible low-level date algorithms*).
fn date(days: u64) -> (u64, u64, u64) {
    let shifted = days + 719_468;
    let (era, of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let from_march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * from_march + 2) / 5 + 1;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    (year_of_era + 400 * era + u64::from(month <= 2), month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_dates() {
        for (days, expected) in [(0, (1970, 1, 1)), (11_016, (2000, 2, 29)), (20_781, (2026, 11, 24))] {
            assert_eq!(date(days), expected);
        }
    }
}
