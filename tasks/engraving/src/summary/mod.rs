//! What the run found, as `summary.json` and as a table for the terminal.

use crate::chosen::Chosen;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// A measured value with its bound.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bounded {
    /// What was measured.
    pub value: f64,
    /// What it must not exceed, in the same unit.
    pub limit: f64,
}

impl Bounded {
    /// Whether the bound is kept; a value that is not a number breaks it.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.value <= self.limit
    }
}

/// Distances from the drawing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PathDeviation {
    /// The largest distance \[mm\].
    pub max_mm: Bounded,
    /// The root of the mean square \[mm\].
    pub rms_mm: Bounded,
    /// Where the largest is \[mm\], in plate coordinates.
    pub worst_at_mm: [f64; 2],
    /// Points measured.
    pub points: u64,
    /// Points near corners that do not count.
    pub excepted: u64,
}

impl PathDeviation {
    /// From a measurement, with the bounds that its maximum and its RMS must keep \[mm\].
    #[must_use]
    pub fn new(report: &crate::deviation::DeviationReport, limit_mm: f64, rms_limit_mm: f64) -> Self {
        Self {
            max_mm: Bounded { value: report.max, limit: limit_mm },
            rms_mm: Bounded { value: report.rms, limit: rms_limit_mm },
            worst_at_mm: report.worst.map_or([0.0; 2], |w| [w.position.x, w.position.y]),
            points: report.points,
            excepted: report.excepted,
        }
    }
}

/// A joint's peaks as shares of its limits, 1 at the limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointPeaks {
    /// The joint's name.
    pub joint: String,
    /// Peak velocity over its limit.
    pub velocity_share: f64,
    /// Peak acceleration over its limit.
    pub acceleration_share: f64,
}

/// The plate's height as the arm found it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlateHeight {
    /// Where the touch reported the surface \[mm\].
    pub found_mm: f64,
    /// Where it truly is in the simulation \[mm\].
    pub true_mm: f64,
    /// The largest error that passes \[mm\].
    pub limit_mm: f64,
}

impl PlateHeight {
    /// Whether the plate was found well enough.
    #[must_use]
    pub fn holds(&self) -> bool {
        (self.found_mm - self.true_mm).abs() <= self.limit_mm
    }
}

/// The whole run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The file or text that was engraved.
    pub source: String,
    /// Strokes engraved.
    pub strokes: usize,
    /// Length of all strokes \[mm\].
    pub cut_length_mm: f64,
    /// Length of the travel between them \[mm\].
    pub travel_length_mm: f64,
    /// Width and height of the drawing on the plate \[mm\].
    pub drawing_size_mm: [f64; 2],
    /// How deep \[mm\], if it is not the default.
    #[serde(skip_serializing_if = "Chosen::is_default")]
    pub depth_mm: Chosen,
    /// How fast [mm/s], if it is not the default.
    #[serde(skip_serializing_if = "Chosen::is_default")]
    pub feed_mm_per_s: Chosen,
    /// At which height above the plate the tool travelled \[mm\], if it is not the default.
    #[serde(skip_serializing_if = "Chosen::is_default")]
    pub travel_height_mm: Chosen,
    /// Points of the spline.
    pub samples: u64,
    /// Steps of the controller.
    pub steps: u64,
    /// The step \[s\].
    pub step_s: f64,
    /// Simulated time \[s\].
    pub simulated_s: f64,
    /// Time on the wall \[s\].
    pub wall_s: f64,
    /// Demanded tip positions against the drawing.
    pub demanded: PathDeviation,
    /// Executed tip positions against the drawing.
    pub executed: PathDeviation,
    /// Peaks of each joint.
    pub joints: Vec<JointPeaks>,
    /// The plate's height, if it was searched for.
    pub plate_height: Option<PlateHeight>,
    /// Bounds that are broken, in words; empty if the run passes.
    pub broken: Vec<String>,
    /// Whether all bounds are kept.
    pub passed: bool,
}

impl Summary {
    /// Simulated time over time on the wall; infinite for no time.
    #[must_use]
    pub fn speed_up(&self) -> f64 {
        self.simulated_s / self.wall_s
    }

    /// Checks every bound and sets `broken` and `passed`.
    #[must_use]
    pub fn checked(mut self) -> Self {
        let mut broken = Vec::new();
        for (name, deviation) in [("demanded", &self.demanded), ("executed", &self.executed)] {
            let bound = deviation.max_mm;
            if !bound.holds() {
                broken.push(format!(
                    "{name} path: {:.4} mm from the drawing at ({:.2}, {:.2}), more than {:.4} mm",
                    bound.value, deviation.worst_at_mm[0], deviation.worst_at_mm[1], bound.limit
                ));
            }
            let bound = deviation.rms_mm;
            if !bound.holds() {
                broken
                    .push(format!("{name} path: {:.4} mm RMS, more than {:.4} mm", bound.value, bound.limit));
            }
        }
        for joint in &self.joints {
            for (name, share) in
                [("velocity", joint.velocity_share), ("acceleration", joint.acceleration_share)]
            {
                if !(Bounded { value: share, limit: 1.0 }).holds() {
                    broken.push(format!(
                        "joint {}: {name} at {:.0} % of its limit",
                        joint.joint,
                        share * 100.0
                    ));
                }
            }
        }
        if let Some(height) = self.plate_height
            && !height.holds()
        {
            broken
                .push(format!("plate found at {:.3} mm, it is at {:.3} mm", height.found_mm, height.true_mm));
        }
        self.passed = broken.is_empty();
        self.broken = broken;
        self
    }

    /// Writes the summary as JSON.
    ///
    /// # Errors
    /// What the file system reports.
    pub fn write_json(&self, path: &Path) -> std::io::Result<()> {
        let mut text = serde_json::to_string_pretty(self).map_err(std::io::Error::other)?;
        text.push('\n');
        std::fs::write(path, text)
    }

    /// The table for the terminal, without colours.
    #[must_use]
    pub fn table(&self) -> String {
        let mut rows: Vec<(String, String, Option<bool>)> = Vec::new();
        let mut row = |name: &str, value: String, holds| rows.push((name.to_owned(), value, holds));
        let [width, height] = self.drawing_size_mm;
        row(
            "drawing",
            format!("{}, {width:.1} x {height:.1} mm, {} strokes", self.source, self.strokes),
            None,
        );
        row(
            "path",
            format!("{:.1} mm cut, {:.1} mm travel", self.cut_length_mm, self.travel_length_mm),
            None,
        );
        row("depth", self.depth_mm.told("mm", "by --depth"), None);
        row("feed", self.feed_mm_per_s.told("mm/s", "by --feed"), None);
        row("travel height", self.travel_height_mm.told("mm", ""), None);
        row(
            "steps",
            format!("{} of {} ms from {} points", self.steps, self.step_s * 1e3, self.samples),
            None,
        );
        row(
            "time",
            format!(
                "{:.1} s simulated in {:.2} s, {:.0} x real time",
                self.simulated_s,
                self.wall_s,
                self.speed_up()
            ),
            None,
        );
        for (name, d) in [("demanded path", &self.demanded), ("executed path", &self.executed)] {
            let text = format!(
                "max {:.4} mm (bound {:.4}), rms {:.4} mm (bound {:.4})",
                d.max_mm.value, d.max_mm.limit, d.rms_mm.value, d.rms_mm.limit
            );
            row(name, text, Some(d.max_mm.holds() && d.rms_mm.holds()));
        }
        let peak = |share: fn(&JointPeaks) -> f64| {
            self.joints
                .iter()
                .max_by(|a, b| share(a).total_cmp(&share(b)))
                .map(|j| (j.joint.as_str(), share(j)))
        };
        for (name, found) in [
            ("peak velocity", peak(|j| j.velocity_share)),
            ("peak acceleration", peak(|j| j.acceleration_share)),
        ] {
            if let Some((joint, share)) = found {
                row(name, format!("{:.1} % of the limit, joint {joint}", share * 100.0), Some(share <= 1.0));
            }
        }
        if let Some(h) = self.plate_height {
            let error = h.found_mm - h.true_mm;
            row(
                "plate height",
                format!("{:.3} mm, {:+.1} µm from true", h.found_mm, error * 1e3),
                Some(h.holds()),
            );
        }
        let mut out = String::new();
        for (name, value, holds) in rows {
            let verdict = match holds {
                None => "    ",
                Some(true) => "ok  ",
                Some(false) => "FAIL",
            };
            let _ = writeln!(out, "  {verdict} {name:<18} {value}");
        }
        for broken in &self.broken {
            let _ = writeln!(out, "  FAIL {broken}");
        }
        out
    }
}

#[cfg(test)]
mod tests;
