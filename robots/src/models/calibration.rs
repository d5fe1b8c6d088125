//! The calibration of one arm, as a file that `calibration` of its entry in `cell.toml` names.
//!
//! In: the text of such a file, written by `mrroc-calibration`. Out: the arm's dimensions, [`Serial::calibrated_by`] and
//! [`Irp6::calibrated_by`]. Of any serial arm it holds the design (where each joint's frame is in the one before) and a small displacement behind
//! each joint; of an IRp-6 its lengths and drives. A file is refused where the design is not that of the arm.

use core::fmt::Write;

use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use nalgebra::{Quaternion, UnitQuaternion, Vector6};
use toml::de::{DeTable, DeValue};

use crate::models::irp6::{Irp6, Linear, Screw};
use crate::models::local::{LocalCorrection, NoCalibration};

/// What no number of a calibration exceeds [m, rad or mm²].
const MOST: f64 = 1e6;

/// The calibration of one arm.
#[derive(Clone, Debug, PartialEq)]
pub enum ArmCalibration {
    /// Of any serial arm.
    Chain(ChainCalibration),
    /// Of an IRp-6.
    Irp6(Irp6Calibration),
}

/// The calibration of a serial arm.
#[derive(Clone, Debug, PartialEq)]
pub struct ChainCalibration {
    /// The design: the frame of each joint, z along its axis, in the frame of the one before (the base), with all joints at 0.
    pub design: Vec<Pose>,
    /// The flange in the frame of the last joint, as designed.
    pub tip: Pose,
    /// Behind each joint x, y, z \[m\] in its own frame, and a rotation vector \[rad\].
    pub displacements: Vec<Vector6<f64>>,
    /// By joint what its encoder leaves out: a part of the position, and a cosine and a sine of it \[rad\]; empty if that was not found.
    pub encoders: Vec<[f64; 3]>,
    /// What joints are off by beside that, where it was measured; `None` if nothing is corrected.
    pub local: Option<LocalCorrection>,
}

/// The calibration of an IRp-6.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Irp6Calibration {
    /// a2, a3, d5 \[m\].
    pub lengths: [f64; 3],
    /// The offsets of column, T, V and N \[rad\].
    pub offsets: [f64; 4],
    /// `square`, `mu`, `nu` \[mm²\] and `reference` \[mm\] of the lower arm's [`Screw`], and of the upper arm's.
    pub screws: [[f64; 4]; 2],
}

impl ArmCalibration {
    /// What the calibration is of, as its file says in `model`.
    #[must_use]
    pub const fn model(&self) -> &'static str {
        match self {
            ArmCalibration::Chain(_) => "chain",
            ArmCalibration::Irp6(_) => "irp6",
        }
    }

    /// The text of its file, with all digits; the program that found it may add tables with what it knows besides.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::from(
            "# The calibration of one arm: name this file as its `calibration` in cell.toml.\n# Lengths in m, angles in rad.\n",
        );
        // Writing into a text does not fail. `{:?}` gives back the same number, and always with a point.
        let _ = writeln!(text, "model = {:?}", self.model());
        match self {
            ArmCalibration::Chain(chain) => {
                let _ = writeln!(
                    text,
                    "# By joint where its frame is in the one before, as designed: x, y, z, and a quaternion w, x, y, z."
                );
                rows(&mut text, "design", chain.design.iter().map(seven));
                let _ = writeln!(text, "tip = {:?}", seven(&chain.tip));
                let _ = writeln!(
                    text,
                    "# What was found behind each joint, in its own frame: x, y, z, and a rotation vector."
                );
                rows(
                    &mut text,
                    "displacements",
                    chain.displacements.iter().map(|one| <[f64; 6]>::from(*one)),
                );
                if !chain.encoders.is_empty() {
                    let _ = writeln!(
                        text,
                        "# What each encoder leaves out: a part of the position, and its cosine and sine."
                    );
                    rows(&mut text, "encoders", chain.encoders.iter().copied());
                }
                if let Some(local) = &chain.local {
                    local_text(&mut text, local);
                }
            }
            ArmCalibration::Irp6(irp6) => {
                let Irp6Calibration { lengths, offsets, screws: [lower, upper] } = irp6;
                let _ = writeln!(text, "lengths = {lengths:?} # a2, a3, d5");
                let _ = writeln!(text, "offsets = {offsets:?} # of column, T, V, N");
                let _ = writeln!(text, "lower_screw = {lower:?} # square, mu, nu [mm2], reference [mm]");
                let _ = writeln!(text, "upper_screw = {upper:?}");
            }
        }
        text
    }

    /// Reads such a text. Its tables are not read here.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<ArmCalibration, NoCalibration> {
        let no = |what: &str| NoCalibration(what.to_owned());
        let table = DeTable::parse(text).map_err(|why| {
            let line =
                why.span().map_or(0, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
            NoCalibration(format!("it is no TOML, see its line {line}"))
        })?;
        let table = table.get_ref();
        let model = table.get("model").and_then(|model| model.get_ref().as_str());
        let known: &[&str] = match model {
            Some("chain") => {
                &["model", "design", "tip", "displacements", "encoders", "local", "local_range", "sliding"]
            }
            Some("irp6") => &["model", "lengths", "offsets", "lower_screw", "upper_screw"],
            Some(other) => {
                let other = mrroc::console::quoted(other, 40);
                return Err(NoCalibration(format!(
                    "it is the calibration of a `{other}`, not one that `calibrate` has made"
                )));
            }
            None => return Err(no("it has no `model`: it is no calibration")),
        };
        let is_table = |value: &DeValue<'_>| matches!(value, DeValue::Table(_));
        let mut others = table
            .iter()
            .filter(|(key, value)| !known.contains(&&**key.get_ref()) && !is_table(value.get_ref()));
        if let Some((key, _)) = others.find(|(key, _)| !DESCRIPTIVE.contains(&&**key.get_ref())) {
            let key = mrroc::console::quoted(key.get_ref(), 40);
            return Err(NoCalibration(format!("a calibration has no `{key}`")));
        }
        if model == Some("irp6") {
            return Ok(ArmCalibration::Irp6(Irp6Calibration {
                lengths: list(table, "lengths")?,
                offsets: list(table, "offsets")?,
                screws: [list(table, "lower_screw")?, list(table, "upper_screw")?],
            }));
        }
        let design = lists::<7>(table, "design")?.iter().map(pose).collect::<Result<Vec<_>, _>>()?;
        let displacements: Vec<Vector6<f64>> =
            lists::<6>(table, "displacements")?.into_iter().map(Vector6::from).collect();
        let encoders =
            if table.contains_key("encoders") { lists::<3>(table, "encoders")? } else { Vec::new() };
        if design.is_empty() || design.len() != displacements.len() {
            return Err(no("its `design` and `displacements` have not one row for each joint"));
        }
        let tip = pose(&list(table, "tip")?)?;
        let local = local(table, design.len())?;
        Ok(ArmCalibration::Chain(ChainCalibration { design, tip, displacements, encoders, local }))
    }
}

/// Keys that tell and do not count.
const DESCRIPTIVE: [&str; 3] = ["robot", "made", "data"];

fn local_text(text: &mut String, local: &LocalCorrection) {
    let _ = writeln!(
        text,
        "# By joint the lowest and the highest position that was measured, and how far beside that the correction below fades out."
    );
    rows(text, "local_range", local.range.iter().copied());
    let sliding = local.kinds.iter().enumerate().filter(|(_, kind)| **kind == JointKind::Prismatic);
    let sliding: Vec<usize> = sliding.map(|(joint, _)| joint + 1).collect();
    if !sliding.is_empty() {
        let _ = writeln!(text, "sliding = {sliding:?} # joints that slide, from 1");
    }
    let _ = writeln!(
        text,
        "# What each joint is off by: of the cosine and the sine of each joint, and of the products cc, cs, sc, ss of each two neighbours."
    );
    let _ = writeln!(text, "local = [");
    for row in &local.coefficients {
        let _ = writeln!(text, "    {row:?},");
    }
    text.push_str("]\n");
}

/// The local correction of a file, if it has one.
fn local(table: &DeTable<'_>, joints: usize) -> Result<Option<LocalCorrection>, NoCalibration> {
    if !["local", "local_range", "sliding"].iter().any(|key| table.contains_key(*key)) {
        return Ok(None);
    }
    let array = |name: &str| match table.get(name).map(|value| value.get_ref()) {
        Some(DeValue::Array(array)) => Some(array),
        _ => None,
    };
    let wrong = |name: &str| NoCalibration(format!("its `{name}` is not rows of {joints} numbers"));
    let numbers = |array: &toml::de::DeArray<'_>| -> Option<Vec<f64>> {
        array.iter().map(|value| number(value.get_ref()).filter(|number| number.abs() < MOST)).collect()
    };
    let rows = array("local").ok_or_else(|| wrong("local"))?;
    let coefficients: Option<Vec<Vec<f64>>> = rows
        .iter()
        .map(|row| match row.get_ref() {
            DeValue::Array(row) => numbers(row),
            _ => None,
        })
        .collect();
    let coefficients = coefficients.ok_or_else(|| wrong("local"))?;
    let range = lists::<3>(table, "local_range")?;
    if range.len() != joints {
        return Err(NoCalibration("its `local_range` has not one row for each joint".to_owned()));
    }
    let sliding = match table.contains_key("sliding") {
        true => array("sliding").and_then(numbers).ok_or_else(|| wrong("sliding"))?,
        false => Vec::new(),
    };
    let is_sliding = |joint: usize| sliding.contains(&((joint + 1) as f64));
    let kind = |joint| if is_sliding(joint) { JointKind::Prismatic } else { JointKind::Revolute };
    let local = LocalCorrection { range, kinds: (0..joints).map(kind).collect(), coefficients };
    local.check()?;
    Ok(Some(local))
}

fn seven(pose: &Pose) -> [f64; 7] {
    let (p, q) = (pose.translation.vector, pose.rotation.quaternion());
    [p.x, p.y, p.z, q.w, q.i, q.j, q.k]
}

fn pose(seven: &[f64; 7]) -> Result<Pose, NoCalibration> {
    let [x, y, z, w, i, j, k] = *seven;
    let quaternion = Quaternion::new(w, i, j, k);
    if (quaternion.norm() - 1.0).abs() > 1e-6 {
        return Err(NoCalibration("a quaternion of its `design` is not of length 1".to_owned()));
    }
    Ok(Pose::from_parts([x, y, z].into(), UnitQuaternion::new_normalize(quaternion)))
}

fn rows<const K: usize>(text: &mut String, name: &str, rows: impl Iterator<Item = [f64; K]>) {
    let _ = writeln!(text, "{name} = [");
    for row in rows {
        let _ = writeln!(text, "    {row:?},");
    }
    text.push_str("]\n");
}

fn list<const K: usize>(table: &DeTable<'_>, name: &str) -> Result<[f64; K], NoCalibration> {
    table.get(name).and_then(|value| numbers(value.get_ref())).ok_or_else(|| not_numbers(name, K))
}

fn lists<const K: usize>(table: &DeTable<'_>, name: &str) -> Result<Vec<[f64; K]>, NoCalibration> {
    let Some(DeValue::Array(rows)) = table.get(name).map(|value| value.get_ref()) else {
        return Err(not_numbers(name, K));
    };
    rows.iter().map(|row| numbers(row.get_ref()).ok_or_else(|| not_numbers(name, K))).collect()
}

fn not_numbers(name: &str, count: usize) -> NoCalibration {
    NoCalibration(format!("its `{name}` is not {count} numbers, or not {count} in a row"))
}

fn numbers<const K: usize>(value: &DeValue<'_>) -> Option<[f64; K]> {
    let DeValue::Array(array) = value else { return None };
    let all: Option<Vec<f64>> = array.iter().map(|value| number(value.get_ref())).collect();
    let all: [f64; K] = all?.try_into().ok()?;
    all.iter().all(|number| number.abs() < MOST).then_some(all)
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|whole| whole as f64)
        }
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => None,
    }
}

impl ChainCalibration {
    /// The frames of the joints in those before with the displacements, and the flange in the last.
    #[must_use]
    pub fn calibrated(&self) -> (Vec<Pose>, Pose) {
        let mut behind = Pose::identity();
        let frames = self.design.iter().zip(&self.displacements).map(|(design, displacement)| {
            let frame = behind * design;
            let turn = UnitQuaternion::from_scaled_axis(displacement.fixed_rows::<3>(3).into_owned());
            behind = Pose::from_parts(displacement.fixed_rows::<3>(0).into_owned().into(), turn);
            frame
        });
        let frames = frames.collect();
        (frames, behind * self.tip)
    }
}

impl Irp6Calibration {
    /// That of an arm.
    #[must_use]
    pub fn of(arm: &Irp6) -> Self {
        let drives = arm.transmission();
        let screw = |screw: &Screw| [screw.square, screw.mu, screw.nu, screw.reference];
        Self {
            lengths: arm.lengths(),
            offsets: [drives.column, drives.t, drives.v, drives.n].map(|axis: Linear| axis.offset),
            screws: [screw(&drives.lower), screw(&drives.upper)],
        }
    }
}

impl Irp6 {
    /// The same arm with the dimensions of a calibration; its encoders keep their marks.
    #[must_use]
    pub fn calibrated_by(self, calibration: &Irp6Calibration) -> Self {
        let mut drives = *self.transmission();
        let [column, t, v, n] = calibration.offsets;
        drives.column.offset = column;
        drives.t.offset = t;
        drives.v.offset = v;
        drives.n.offset = n;
        for (screw, [square, mu, nu, reference]) in
            [&mut drives.lower, &mut drives.upper].into_iter().zip(calibration.screws)
        {
            *screw = Screw { synchro: screw.synchro, square, mu, nu, reference };
        }
        self.with_dimensions(calibration.lengths, drives)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_calibration_is_read_as_it_was_written() {
        let chain = ChainCalibration {
            design: vec![Pose::translation(0.1, 0.0, 0.3), Pose::rotation(nalgebra::Vector3::x() * 0.7)],
            tip: Pose::translation(0.0, 0.0, 0.1),
            displacements: vec![Vector6::repeat(1e-3), Vector6::zeros()],
            encoders: Vec::new(),
            local: Some(LocalCorrection {
                range: vec![[-1.0, 1.0, 0.2], [0.0, 0.5, 0.1]],
                kinds: vec![JointKind::Revolute, JointKind::Prismatic],
                coefficients: (0..8).map(|k| vec![1e-5 * f64::from(k), -3e-6]).collect(),
            }),
        };
        for calibration in
            [ArmCalibration::Chain(chain), ArmCalibration::Irp6(Irp6Calibration::of(&Irp6::calibrated()))]
        {
            assert_eq!(ArmCalibration::parse(&calibration.text()), Ok(calibration));
        }
    }

    #[test]
    fn what_is_no_calibration_is_refused_with_the_reason() {
        let good = ArmCalibration::Irp6(Irp6Calibration::of(&Irp6::nominal())).text();
        for (text, told) in [
            ("step_ms = 2".to_owned(), "has no `model`"),
            ("model = \"ur5e\"".to_owned(), "the calibration of a `ur5e`"),
            (good.replace("lengths", "length"), "a calibration has no `length`"),
            (good.replace("a2, a3, d5\n", "\nmodel = 1\n"), "no TOML, see its line"),
            (good.replace("[0.455, ", "["), "`lengths` is not 3 numbers"),
        ] {
            let why = ArmCalibration::parse(&text).expect_err(told).to_string();
            assert!(why.contains(told), "{why}");
        }
    }
}
