//! The arm that data are of: a URDF, or a table of Denavit-Hartenberg parameters in TOML.

use std::path::Path;

use mrroc::robot::JointKind;
use mrroc_robots::{Serial, UrdfError, UrdfText};
use nalgebra::SVector;

use super::mistake::{Mistakes, Source};
use super::section::{Section, parse};
use crate::chain::{Chain, DhRow};

/// An arm as it was designed.
#[derive(Clone, Debug, PartialEq)]
pub struct Described {
    /// Its name.
    pub name: String,
    /// Its joints.
    pub chain: Chain,
}

/// Why a URDF gives no arm to calibrate.
#[derive(Debug, thiserror::Error)]
pub enum NoArm {
    /// What is wrong with it.
    #[error(transparent)]
    Urdf(#[from] UrdfError),
    /// A joint follows another one.
    #[error(
        "a joint of the chain follows another one (<mimic>), which a calibration cannot describe: choose another tip"
    )]
    Mimic,
}

/// The words for units of length and angle, and what they are in m and rad.
pub(super) const LENGTHS: [(&str, f64); 4] = [("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6)];
pub(super) const ANGLES: [(&str, f64); 4] = [
    ("rad", 1.0),
    ("deg", core::f64::consts::PI / 180.0),
    ("mrad", 1e-3),
    ("gon", core::f64::consts::PI / 200.0),
];

impl Described {
    /// Reads a table of Denavit-Hartenberg parameters.
    ///
    /// # Errors
    /// All mistakes in it.
    pub fn dh(path: &Path) -> Result<Described, Mistakes> {
        let source = Source::read(path)?;
        Self::of_source(&source)
    }

    /// Reads the text of such a table; `file` is its name in messages.
    ///
    /// # Errors
    /// All mistakes in it.
    pub fn dh_text(file: &str, text: &str) -> Result<Described, Mistakes> {
        Self::of_source(&Source::new(file, text))
    }

    fn of_source(source: &Source) -> Result<Described, Mistakes> {
        let described = parse(source, &source.text, "an arm", |root| {
            let name = root.text("name", "write name = \"..\"").map(|name| name.value);
            let convention = root.one_of(
                "convention",
                &[("distal", false), ("proximal", true), ("standard", false), ("modified", true)],
            );
            let length = root.one_of("length_unit", &LENGTHS).unwrap_or(1.0);
            let angle = root.one_of("angle_unit", &ANGLES).unwrap_or(1.0);
            let joints = root.sections("joints");
            if convention.is_none() && source.is_good() {
                let help = "write convention = \"distal\" (a and alpha of a row follow its joint: \"standard\"), or \"proximal\" (they \
                            precede it: \"modified\", Craig)";
                root.missing("convention", help);
            }
            if joints.is_empty() {
                root.missing(
                    "joints",
                    "write a table [[joints]] with theta, d, a and alpha for each joint, from the base on",
                );
            }
            let rows: Vec<DhRow> =
                joints.iter().enumerate().map(|(i, joint)| row(joint, i, length, angle)).collect();
            let chain = if convention? { Chain::proximal(&rows) } else { Chain::distal(&rows) };
            Some(Described { name: name.unwrap_or_else(|| "arm".to_owned()), chain })
        });
        source.finish(described)
    }

    /// Reads an arm from a URDF: the joints that move from `base` (the root by default) to `tip`.
    ///
    /// # Errors
    /// What is wrong with the URDF.
    pub fn urdf(path: &Path, base: Option<&str>, tip: &str) -> Result<Described, NoArm> {
        let urdf = UrdfText::read(path)?;
        let base = match base {
            Some(base) => base.to_owned(),
            None => urdf.root()?,
        };
        let names = urdf.joints(&base, tip)?;
        let chain = match names.len() {
            1 => serial::<1>(&urdf, &base, tip)?,
            2 => serial::<2>(&urdf, &base, tip)?,
            3 => serial::<3>(&urdf, &base, tip)?,
            4 => serial::<4>(&urdf, &base, tip)?,
            5 => serial::<5>(&urdf, &base, tip)?,
            6 => serial::<6>(&urdf, &base, tip)?,
            7 => serial::<7>(&urdf, &base, tip)?,
            // More, or none, is refused with the reason.
            _ => serial::<8>(&urdf, &base, tip)?,
        };
        let mut chain = chain.ok_or(NoArm::Mimic)?;
        for (joint, name) in chain.joints.iter_mut().zip(names) {
            joint.name = name;
        }
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Ok(Described { name, chain })
    }
}

fn serial<const N: usize>(urdf: &UrdfText, base: &str, tip: &str) -> Result<Option<Chain>, UrdfError> {
    // Accelerations count for nothing here.
    let builder = Serial::<N>::from_urdf(urdf.as_str(), base, tip)?;
    let acceleration = builder.stated_acceleration().unwrap_or_else(|| SVector::repeat(1.0));
    Ok(Chain::of(&builder.with_acceleration(acceleration)?))
}

fn row(joint: &Section<'_>, i: usize, length: f64, angle: f64) -> DhRow {
    let mut value = |key: &'static str| {
        let read = joint.number(key, "write a number");
        if read.is_none() && joint.source.is_good() {
            joint.missing(key, "write 0 where it is none");
        }
        read.map_or(0.0, |read| read.value)
    };
    let [theta, d, a, alpha] = ["theta", "d", "a", "alpha"].map(&mut value);
    let kind = joint
        .one_of("kind", &[("revolute", JointKind::Revolute), ("prismatic", JointKind::Prismatic)])
        .unwrap_or(JointKind::Revolute);
    let name = joint
        .text("name", "write name = \"..\"")
        .map_or_else(|| format!("joint {}", i + 1), |name| name.value);
    joint.close();
    DhRow { name, kind, theta: theta * angle, d: d * length, a: a * length, alpha: alpha * angle }
}
