//! The arm that data are of: a URDF, or a table of Denavit-Hartenberg parameters in TOML.

use std::path::Path;

use mrroc::robot::{JointKind, Robot};
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
    /// By joint between which positions it may be [rad or m], as far as its description says so; an endless joint within a turn.
    pub limits: Vec<Option<[f64; 2]>>,
    /// Where its shape may be written.
    pub(super) urdf: Option<Urdf>,
}

/// A chain of a URDF.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Urdf {
    pub(super) text: String,
    pub(super) base: String,
    pub(super) tip: String,
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
            let (rows, limits): (Vec<DhRow>, Vec<_>) =
                joints.iter().enumerate().map(|(i, joint)| row(joint, i, length, angle)).unzip();
            let chain = if convention? { Chain::proximal(&rows) } else { Chain::distal(&rows) };
            Some(Described { name: name.unwrap_or_else(|| "arm".to_owned()), chain, limits, urdf: None })
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
        let (mut chain, limits) = chain.ok_or(NoArm::Mimic)?;
        for (joint, name) in chain.joints.iter_mut().zip(names) {
            joint.name = name;
        }
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let urdf = Urdf { text: urdf.as_str().to_owned(), base, tip: tip.to_owned() };
        Ok(Described { name, chain, limits, urdf: Some(urdf) })
    }
}

/// A chain, and by joint between which positions it may be.
type Limited = (Chain, Vec<Option<[f64; 2]>>);

fn serial<const N: usize>(urdf: &UrdfText, base: &str, tip: &str) -> Result<Option<Limited>, UrdfError> {
    let robot = of_urdf::<N>(urdf.as_str(), base, tip)?;
    let limits = (0..N).map(|i| {
        let range = [robot.limits().lower[i], robot.limits().upper[i]];
        match robot.joint(i) {
            _ if range.iter().all(|limit| limit.is_finite()) => Some(range),
            JointKind::Revolute => Some([-core::f64::consts::PI, core::f64::consts::PI]),
            JointKind::Prismatic => None,
        }
    });
    let limits = limits.collect();
    Ok(Chain::of(&robot).map(|chain| (chain, limits)))
}

/// The arm of a URDF; accelerations count for nothing here.
pub(super) fn of_urdf<const N: usize>(text: &str, base: &str, tip: &str) -> Result<Serial<N>, UrdfError> {
    let builder = Serial::<N>::from_urdf(text, base, tip)?;
    let acceleration = builder.stated_acceleration().unwrap_or_else(|| SVector::repeat(1.0));
    builder.with_acceleration(acceleration)
}

fn row(joint: &Section<'_>, i: usize, length: f64, angle: f64) -> (DhRow, Option<[f64; 2]>) {
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
    let unit = if kind == JointKind::Prismatic { length } else { angle };
    let help =
        "write limits = [-170, 170], the lower one first, in angle_unit, or in length_unit where it slides";
    let limits = joint.numbers("limits", help).and_then(|read| match read.value[..] {
        [low, high] if low < high => Some([low * unit, high * unit]),
        _ => {
            joint.source.complain(&read.span, "limits are two numbers, the lower one first", help);
            None
        }
    });
    joint.close();
    (DhRow { name, kind, theta: theta * angle, d: d * length, a: a * length, alpha: alpha * angle }, limits)
}
