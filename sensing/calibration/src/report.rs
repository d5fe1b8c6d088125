//! What `calibrate` prints.

use core::fmt::Write;

use mrroc::robot::JointKind;

use crate::data::Data;
use crate::fit::Fit;
use crate::known::is_unknown;
use crate::local::LocalTrial;
use crate::trials::{Errors, Scale, Trial, lengths};

/// A measurement is suspect that is off by this many times the root mean square of all.
const SUSPECT: f64 = 4.0;

/// Postures left out are foretold so many times worse than those that were used: as much was found from too little.
const FITTED: f64 = 5.0;

/// What tells a scale that the data do not.
const TELLS: &str = "a known distance of two points tells, as [[distances]] in the header";

/// An error of a scale that large should show [%].
const BLIND: f64 = 0.2;

/// Most parameters in a row of the list of what cannot be told apart.
const UNSEEN: usize = 40;

/// All that was learned from data.
pub struct Report<'r> {
    /// The data.
    pub data: &'r Data,
    /// The name of their file.
    pub file: &'r str,
    /// All fits.
    pub trials: &'r [Trial],
    /// The one that is taken.
    pub chosen: usize,
    /// Scales of instruments, by their place.
    pub scales: &'r [(usize, Scale)],
    /// Whether a local correction helps, if that was looked at.
    pub local: Option<&'r LocalTrial>,
    /// Errors at measurements of another file, for the first trial and the one that is taken, with its name.
    pub test: Option<(String, Errors, Errors)>,
}

impl Report<'_> {
    /// The text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing into a text does not fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) -> core::fmt::Result {
        let (data, fit) = (self.data, self.fit());
        let instruments: Vec<&str> = data.instruments().collect();
        let points: Vec<&str> = data.points().collect();
        writeln!(out, "{}: {} postures, {} measurements", self.file, data.postures(), data.measurements())?;
        writeln!(out, "arm: {}, {} joints", data.arm().name, data.arm().chain.joints.len())?;
        writeln!(out, "instruments: {}; points: {}\n", instruments.join(", "), points.join(", "))?;
        self.table(out)?;
        let information = fit.information();
        let (rank, all) = (information.rank, information.parameters());
        writeln!(
            out,
            "\nrank {rank} of {all} unknowns; smallest singular value seen {:.1e} of the largest",
            smallest(fit)
        )?;
        if !fit.unseen().is_empty() {
            writeln!(out, "what cannot be told apart (the first of each stays as it was designed):")?;
            for unseen in fit.unseen().iter().take(UNSEEN) {
                writeln!(out, "  {unseen}")?;
            }
        }
        writeln!(out, "\nfound:")?;
        for found in fit.found() {
            let (unit, factor) = found.parameter.unit.shown();
            let (value, sigma) = (factor * found.value, factor * found.sigma);
            let mark = if is_unknown(&found) { "   unknown: hardly better than before" } else { "" };
            writeln!(out, "  {:28} {value:10.4} +- {sigma:.4} {unit}{mark}", found.parameter.name)?;
        }
        self.noise(out)?;
        self.scales(out)?;
        self.local(out)?;
        self.suspects(out)?;
        if let Some((file, before, after)) = &self.test {
            let [before, after] = [before, after].map(|errors| self.errors(errors));
            writeln!(
                out,
                "\n{file}, measurements not used here:\n  frames alone  {before}\n  calibrated    {after}"
            )?;
        }
        Ok(())
    }

    /// The fit that is taken.
    fn fit(&self) -> &Fit {
        let taken = self.local.and_then(|local| local.taken.as_ref());
        taken.map_or(&self.trials[self.chosen].fit, |(_, fit)| fit)
    }

    /// Errors in mm, or mrad.
    fn errors(&self, errors: &Errors) -> String {
        let Errors { count, mean, rms, max } = errors;
        let unit = self.unit();
        format!(
            "mean {:.4}, rms {:.4}, max {:.4} {unit} ({count} measurements)",
            1e3 * mean,
            1e3 * rms,
            1e3 * max
        )
    }

    fn unit(&self) -> &'static str {
        let problem = &self.trials[self.chosen].stated.problem;
        let has_lengths =
            (0..problem.measurements()).any(|i| problem.device_of(i).unit(0) == crate::Unit::Metre);
        if has_lengths { "mm" } else { "mrad" }
    }

    fn table(&self, out: &mut String) -> core::fmt::Result {
        let unit = self.unit();
        writeln!(out, "calibrated          tolerances   at these postures   at postures left out [{unit}]")?;
        writeln!(out, "                                   mean     max       mean     rms      max")?;
        for (i, trial) in self.trials.iter().enumerate() {
            let Trial { detail, factor, within, foretold, .. } = trial;
            let mark = if i == self.chosen { "<- taken" } else { "" };
            let name = match detail {
                crate::Detail::Frames => "frames alone",
                crate::Detail::Zeros => "zeros",
                crate::Detail::Geometry => "geometry",
                crate::Detail::Encoders => "encoders, too",
            };
            let [a, b, c, d, e] =
                [within.mean, within.max, foretold.mean, foretold.rms, foretold.max].map(|error| 1e3 * error);
            writeln!(out, "{name:20} x {factor:<8} {a:8.4} {b:8.4}   {c:8.4} {d:8.4} {e:8.4}  {mark}")?;
        }
        let Trial { within, foretold, .. } = &self.trials[self.chosen];
        if foretold.mean > FITTED * within.mean {
            let times = foretold.mean / within.mean;
            writeln!(
                out,
                "warning: errors at postures left out are {times:.0} times those at the postures used: these are too few, and the arm will be off by the former; measure more postures"
            )?;
        }
        Ok(())
    }

    fn noise(&self, out: &mut String) -> core::fmt::Result {
        let trial = &self.trials[self.chosen];
        for (name, id) in self.data.instruments().zip(&trial.stated.instruments) {
            let noise = self.fit().noise(*id);
            let told: Vec<String> = noise.iter().map(|sigma| format!("{:.4}", 1e3 * sigma)).collect();
            writeln!(out, "noise of {name}: {} [mm or mrad]", told.join(" "))?;
        }
        Ok(())
    }

    fn scales(&self, out: &mut String) -> core::fmt::Result {
        let names: Vec<&str> = self.data.instruments().collect();
        for (i, scale) in self.scales {
            let name = names[*i];
            match scale.sigma {
                None => writeln!(out, "scale of {name}: cannot be told from the other unknowns: {TELLS}")?,
                Some(sigma) if scale.is_wrong() => {
                    let sense = if scale.value > 0.0 { "long" } else { "short" };
                    let percent = 100.0 * scale.value.abs();
                    writeln!(
                        out,
                        "warning: lengths of {name} are {percent:.3} % too {sense} (+- {:.3} %), or all of the arm's are wrong the other way: measure \
                         its board or its scale, or write scale = \"free\" in its [[measures]]",
                        100.0 * sigma
                    )?;
                }
                Some(sigma) => {
                    let [value, sigma, shows] =
                        [scale.value, sigma, Scale::shows(sigma)].map(|part| 100.0 * part);
                    let advice = if shows > BLIND { format!("; {TELLS}") } else { String::new() };
                    writeln!(
                        out,
                        "scale of {name}: nothing wrong is seen (found {value:+.3} +- {sigma:.3} %); an error below {shows:.2} % would not show{advice}"
                    )?;
                }
            }
        }
        Ok(())
    }

    fn local(&self, out: &mut String) -> core::fmt::Result {
        let Some(LocalTrial { taken, without, with, sure }) = self.local else { return Ok(()) };
        let (unit, before, after) = (self.unit(), 1e3 * without.mean, 1e3 * with.mean);
        let gain = format!(
            "mean error at postures left out {before:.4} without it, {after:.4} {unit} with it ({sure:.1} standard errors)"
        );
        let Some((correction, _)) = taken else {
            return writeln!(out, "local corrector: none, it would not help: {gain}");
        };
        writeln!(out, "local corrector: taken: {gain}; it counts at")?;
        for ((joint, [low, high, fade]), kind) in
            self.data.arm().chain.joints.iter().zip(&correction.range).zip(&correction.kinds)
        {
            let (factor, unit) = match kind {
                JointKind::Revolute => (180.0 / core::f64::consts::PI, "deg"),
                JointKind::Prismatic => (1e3, "mm"),
            };
            let [low, high, fade] = [low, high, fade].map(|one| factor * one);
            writeln!(
                out,
                "  {:28} {low:8.1} to {high:.1} {unit}, and fades out over {fade:.1} {unit} beside that",
                joint.name
            )?;
        }
        Ok(())
    }

    fn suspects(&self, out: &mut String) -> core::fmt::Result {
        let trial = &self.trials[self.chosen];
        let raw: Vec<(usize, Vec<f64>)> =
            self.fit().residuals().enumerate().map(|(i, (_, _, raw))| (i, raw.to_vec())).collect();
        let errors = lengths(&trial.stated.problem, &raw);
        // The median, which a few wrong ones do not move; of a length in space it is 1.54 of one axis' deviation, the rms 1.73.
        let mut sorted: Vec<f64> = errors.iter().map(|(_, error)| *error).collect();
        sorted.sort_by(f64::total_cmp);
        let usual = 1.12 * sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        for (i, error) in errors.into_iter().filter(|(_, error)| *error > SUSPECT * usual && *error > 1e-9) {
            let (instrument, point) = self.data.names_of(i);
            let unit = self.unit();
            writeln!(
                out,
                "warning: line {}: {instrument} has {point} off by {:.3} {unit}, {:.1} times the usual: is it measured, or written down, wrongly?",
                self.data.line_of(i),
                1e3 * error,
                error / usual
            )?;
        }
        Ok(())
    }
}

fn smallest(fit: &Fit) -> f64 {
    let information = fit.information();
    let of = |i: usize| information.singular_values.get(i).copied().unwrap_or(0.0);
    of(information.rank.saturating_sub(1)) / of(0).max(f64::MIN_POSITIVE)
}
