//! The header of a data file: TOML in its leading lines, each behind a `#`.

use core::ops::Range;
use std::path::{Path, PathBuf};

use nalgebra::UnitQuaternion;

use super::mistake::Source;
use super::robot::{ANGLES, Described, LENGTHS};
use super::rotation::{self, Spelling};
use super::section::{At, Section, parse};
use super::table::Form;
use crate::chain::{Detail, Tolerances};
use mrroc::pose::Pose;

/// What an instrument reads in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Point,
    Pose { spelling: Spelling, inverse: bool },
    Distance,
    Angles,
    Plane,
    Touch,
}

impl Kind {
    pub(super) const fn columns(self) -> usize {
        match self {
            Kind::Point => 3,
            Kind::Pose { spelling, .. } => 3 + spelling.columns(),
            Kind::Distance => 1,
            Kind::Angles => 2,
            Kind::Plane | Kind::Touch => 0,
        }
    }
}

/// Which point is measured.
#[derive(Clone, Debug)]
pub(super) enum Which {
    Always(String),
    Column(At<String>),
}

/// One measurement of each row.
#[derive(Clone, Debug)]
pub(super) struct Measure {
    pub(super) instrument: String,
    pub(super) kind: Kind,
    pub(super) columns: Vec<At<String>>,
    /// Factors to m and rad.
    pub(super) length: f64,
    pub(super) angle: f64,
    pub(super) which: Which,
    pub(super) sigma: Option<f64>,
    pub(super) angle_sigma: Option<f64>,
    pub(super) free_scale: bool,
    pub(super) span: Range<usize>,
}

/// Where something stands, as far as the header says it.
#[derive(Clone, Debug, Default)]
pub(super) struct Placed {
    pub(super) on_flange: Option<bool>,
    pub(super) at: Option<Pose>,
    pub(super) is_known: bool,
}

/// A distance of two points that is known.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub(super) between: [At<String>; 2],
    pub(super) length: f64,
    pub(super) sigma: f64,
}

/// The joints' columns, with the factor and the offset to rad or m.
#[derive(Clone, Debug)]
pub(super) struct Joints {
    pub(super) columns: Vec<At<String>>,
    pub(super) factors: Vec<f64>,
    pub(super) offsets: Vec<f64>,
}

/// All of it.
pub(super) struct Header {
    pub(super) arm: Described,
    pub(super) form: Form,
    /// Names of the columns, if the header and not the table's first row gives them.
    pub(super) columns: Option<Vec<String>>,
    pub(super) missing: Vec<String>,
    pub(super) joints: Joints,
    pub(super) measures: Vec<Measure>,
    pub(super) instruments: Vec<(String, Placed)>,
    pub(super) points: Vec<(String, Placed)>,
    pub(super) distances: Vec<Known>,
    pub(super) detail: Option<Detail>,
    pub(super) tolerances: Tolerances,
    /// Where the header ends.
    pub(super) end: usize,
}

pub(super) const DETAILS: [(&str, Detail); 4] = [
    ("frames", Detail::Frames),
    ("zeros", Detail::Zeros),
    ("geometry", Detail::Geometry),
    ("encoders", Detail::Encoders),
];

/// Reads the header of a data file.
pub(super) fn read(source: &Source) -> Option<Header> {
    let mut toml = String::new();
    for line in source.text.split_inclusive('\n') {
        let trimmed = line.trim_start();
        if let Some(rest) = trimmed.strip_prefix('#') {
            // A blank in its place keeps all places as they are.
            toml.push_str(&line[..line.len() - trimmed.len()]);
            toml.push(' ');
            toml.push_str(rest);
        } else if trimmed.is_empty() {
            toml.push_str(line);
        } else {
            break;
        }
    }
    let end = toml.len();
    if toml.trim().is_empty() {
        let help = "begin the file with lines such as # robot = \"arm.toml\" and # [joints]: see the book, Calibration";
        source.complain(&(0..0), "the file has no header that says what its columns are", help);
        return None;
    }
    parse(source, &toml, "the header", |root| header(source, root, end))
}

fn header(source: &Source, root: &Section<'_>, end: usize) -> Option<Header> {
    root.text("title", "write title = \"..\"");
    let arm = robot(source, root);
    let separator =
        root.one_of("separator", &[(",", Some(',')), (";", Some(';')), ("tab", Some('\t')), ("blank", None)]);
    let point = root.one_of("decimal", &[(".", '.'), (",", ',')]).unwrap_or('.');
    let form = Form { separator: separator.unwrap_or(Some(if point == ',' { ';' } else { ',' })), point };
    let columns = root
        .texts("columns", "write the names of all columns, columns = [\"q1\", ..]")
        .map(|names| names.value.into_iter().map(|name| name.value).collect());
    let missing = root.texts("missing", "write missing = [\"\", \"nan\"]").map_or_else(
        || vec![String::new()],
        |texts| texts.value.into_iter().map(|text| text.value).collect(),
    );
    let joints = root.section("joints");
    if joints.is_none() {
        root.missing("joints", "write a table [joints] with columns = [..] and unit = \"deg\"");
    }
    let joints = joints.and_then(|section| joints_of(&section, arm.as_ref()));
    let sections = root.sections("measures");
    if sections.is_empty() {
        root.missing("measures", "write a table [[measures]] with kind, columns, unit and point");
    }
    let measures = sections.iter().filter_map(measure).collect();
    let instruments = placed(root, "instruments");
    let points = placed(root, "points");
    let distances = root.sections("distances").iter().filter_map(distance).collect();
    let detail = root.one_of("detail", &DETAILS);
    let tolerances =
        root.section("tolerances").map_or_else(Tolerances::default, |section| tolerances(&section));
    Some(Header {
        arm: arm?,
        form,
        columns,
        missing,
        joints: joints?,
        measures,
        instruments,
        points,
        distances,
        detail,
        tolerances,
        end,
    })
}

fn robot(source: &Source, root: &Section<'_>) -> Option<Described> {
    let help = "write robot = \"arm.toml\" (a table of Denavit-Hartenberg parameters) or \"arm.urdf\"";
    let base = root.text("base_link", "write the name of a link");
    let tip = root.text("tip", "write the name of a link");
    let Some(file) = root.text("robot", help) else {
        if source.is_good() {
            root.missing("robot", help);
        }
        return None;
    };
    let path: PathBuf = Path::new(&source.file).parent().unwrap_or(Path::new("")).join(&file.value);
    if path.extension().is_some_and(|extension| extension == "urdf") {
        let Some(tip) = tip else {
            root.missing("tip", "write tip = \"tool0\", the link of the URDF that is the flange");
            return None;
        };
        let read = Described::urdf(&path, base.as_ref().map(|base| &*base.value), &tip.value);
        return read
            .map_err(|why| {
                source.complain(
                    &file.span,
                    format!("{}: {why}", path.display()),
                    "mend it, or write another link",
                )
            })
            .ok();
    }
    Described::dh(&path).map_err(|why| source.complain(&file.span, format!("{why}"), "mend that file")).ok()
}

fn joints_of(section: &Section<'_>, arm: Option<&Described>) -> Option<Joints> {
    let columns = section.texts("columns", "write columns = [\"q1\", \"q2\", ..]");
    if columns.is_none() && section.source.is_good() {
        section.missing("columns", "write columns = [\"q1\", \"q2\", ..], from the base on");
    }
    let all: Vec<(&str, f64)> = ANGLES.into_iter().chain(LENGTHS).collect();
    let help = "write unit = \"deg\", \"rad\", \"mm\" or \"m\", or a list of them";
    let units = section.texts("unit", help);
    if units.is_none() && section.source.is_good() {
        section.missing("unit", help);
    }
    let signs = section.numbers("signs", "write signs = [1, -1, ..], one for each joint");
    let offsets = section.numbers("offsets", "write offsets = [..], one for each joint, in its unit");
    section.close();
    let (columns, units) = (columns?, units?);
    let n = columns.value.len();
    if let Some(wanted) = arm.map(|arm| arm.chain.joints.len()).filter(|wanted| *wanted != n) {
        let what = format!("{n} columns are named, and the arm has {wanted} joints");
        section.source.complain(&columns.span, what, "write one column for each joint, from the base on");
        return None;
    }
    let mut factors = Vec::new();
    for i in 0..n {
        let unit = units.value.get(i.min(units.value.len().saturating_sub(1)))?;
        match all.iter().find(|(name, _)| *name == unit.value) {
            Some((_, factor)) => factors.push(*factor),
            None => {
                section.source.complain(&unit.span, format!("no unit `{}`", unit.value), help);
                return None;
            }
        }
    }
    let list = |given: Option<At<Vec<f64>>>, default: f64| match given {
        None => Some(vec![default; n]),
        Some(given) if given.value.len() == n => Some(given.value),
        Some(given) => {
            let what = format!("{} numbers for {n} joints", given.value.len());
            section.source.complain(&given.span, what, "write one for each joint");
            None
        }
    };
    let (signs, offsets) = (list(signs, 1.0)?, list(offsets, 0.0)?);
    let offsets = offsets.iter().zip(&factors).map(|(offset, factor)| offset * factor).collect();
    let factors = signs.iter().zip(&factors).map(|(sign, factor)| sign * factor).collect();
    Some(Joints { columns: columns.value, factors, offsets })
}

fn measure(section: &Section<'_>) -> Option<Measure> {
    #[derive(Clone, Copy)]
    enum Word {
        Point,
        Pose,
        Distance,
        Angles,
        Plane,
        Touch,
    }
    let words = [
        ("point", Word::Point),
        ("pose", Word::Pose),
        ("distance", Word::Distance),
        ("angles", Word::Angles),
        ("plane", Word::Plane),
        ("touch", Word::Touch),
    ];
    let word = section.one_of("kind", &words);
    if word.is_none() && section.source.is_good() {
        section.missing(
            "kind",
            "write kind = \"point\", \"pose\", \"distance\", \"angles\", \"plane\" or \"touch\"",
        );
    }
    let spelling = section.text("rotation", rotation::HELP).and_then(|text| {
        let spelling = Spelling::parse(&text.value);
        if spelling.is_none() {
            section.source.complain(
                &text.span,
                format!("no convention for orientations is `{}`", text.value),
                rotation::HELP,
            );
        }
        spelling
    });
    let inverse = section.truth("inverse").unwrap_or(false);
    let instrument = section
        .text("instrument", "write instrument = \"..\"")
        .map_or_else(|| "instrument".to_owned(), |name| name.value);
    let columns = section
        .texts("columns", "write columns = [..]")
        .unwrap_or_else(|| At { value: Vec::new(), span: section.span.clone() });
    let length = section.one_of("unit", &LENGTHS);
    let angle = section.one_of("angle_unit", &ANGLES);
    let sigma = section.positive("sigma", "write the standard deviation, more than 0, in `unit`");
    let angle_sigma =
        section.positive("angle_sigma", "write the standard deviation, more than 0, in `angle_unit`");
    let free_scale = section.one_of("scale", &[("free", true), ("right", false)]).unwrap_or(false);
    let which = if section.is_text("point") {
        section.text("point", "").map(|name| Which::Always(name.value))
    } else {
        section.section("point").and_then(|of| {
            let column = of.text("column", "write point = { column = \"..\" }");
            of.close();
            column.map(Which::Column)
        })
    };
    section.close();
    let kind = match word? {
        Word::Point => Kind::Point,
        Word::Pose => match spelling {
            Some(spelling) => Kind::Pose { spelling, inverse },
            None => {
                if section.source.is_good() {
                    section.missing("rotation", rotation::HELP);
                }
                return None;
            }
        },
        Word::Distance => Kind::Distance,
        Word::Angles => Kind::Angles,
        Word::Plane => Kind::Plane,
        Word::Touch => Kind::Touch,
    };
    let lengths = matches!(kind, Kind::Point | Kind::Pose { .. } | Kind::Distance);
    if lengths && length.is_none() && section.source.is_good() {
        section.missing("unit", "write unit = \"mm\" or \"m\"");
    }
    let angles = match kind {
        Kind::Pose { spelling, .. } => spelling.is_angles(),
        Kind::Angles => true,
        _ => false,
    };
    if angles && angle.is_none() && section.source.is_good() {
        section.missing("angle_unit", "write angle_unit = \"deg\" or \"rad\"");
    }
    if columns.value.len() != kind.columns() {
        let what = format!("{} columns, where {} are read", columns.value.len(), kind.columns());
        let help = match kind {
            Kind::Pose { .. } => "write x, y, z, and then those of the orientation",
            Kind::Point => "write x, y, z",
            Kind::Angles => "write the horizontal angle, counted from x to y, and the elevation",
            Kind::Distance => "write the column of the distance",
            Kind::Plane | Kind::Touch => "leave `columns` out: a touched point is where it is",
        };
        section.source.complain(&columns.span, what, help);
        return None;
    }
    Some(Measure {
        instrument,
        kind,
        columns: columns.value,
        length: length.unwrap_or(1.0),
        angle: angle.unwrap_or(1.0),
        which: which.unwrap_or_else(|| Which::Always("point".to_owned())),
        sigma: sigma.map(|sigma| sigma * length.unwrap_or(1.0)),
        angle_sigma: angle_sigma.map(|sigma| sigma * angle.unwrap_or(1.0)),
        free_scale,
        span: section.span.clone(),
    })
}

fn placed(root: &Section<'_>, key: &'static str) -> Vec<(String, Placed)> {
    let read = |(name, section): (At<String>, Section<'_>)| {
        let on_flange = section.one_of("on", &[("flange", true), ("world", false)]);
        let length = section.one_of("unit", &LENGTHS).unwrap_or(1.0);
        let angle = section.one_of("angle_unit", &ANGLES).unwrap_or(1.0);
        let three = |key: &'static str| {
            let help = "write three numbers, [x, y, z]";
            let read = section.numbers(key, help)?;
            if read.value.len() != 3 {
                section.source.complain(
                    &read.span,
                    format!("`{key}` has {} numbers", read.value.len()),
                    help,
                );
            }
            <[f64; 3]>::try_from(read.value).ok()
        };
        let position = three("position");
        let vector = three("rotation_vector");
        let is_known = section.truth("known").unwrap_or(false);
        section.close();
        let at = (position.is_some() || vector.is_some()).then(|| {
            let [p, v] = [position, vector].map(Option::unwrap_or_default);
            let turn = UnitQuaternion::from_scaled_axis(nalgebra::Vector3::from(v) * angle);
            Pose::from_parts((nalgebra::Vector3::from(p) * length).into(), turn)
        });
        (name.value, Placed { on_flange, at, is_known })
    };
    root.named(key).into_iter().map(read).collect()
}

fn distance(section: &Section<'_>) -> Option<Known> {
    let help = "write between = [\"A\", \"B\"], two points";
    let between = section.texts("between", help);
    let unit = section.one_of("unit", &LENGTHS);
    let length = section.positive("length", "write the distance, more than 0");
    let sigma = section.positive("sigma", "write the standard deviation, more than 0, in `unit`");
    section.close();
    for (key, is_there) in
        [("between", between.is_some()), ("unit", unit.is_some()), ("length", length.is_some())]
    {
        if !is_there && section.source.is_good() {
            section.missing(key, "write between = [\"A\", \"B\"], length = 100.0, unit = \"mm\"");
        }
    }
    let between = between?;
    let span = between.span.clone();
    let Ok(between) = <[At<String>; 2]>::try_from(between.value) else {
        section.source.complain(&span, "a distance is between two points", help);
        return None;
    };
    let unit = unit?;
    Some(Known { between, length: length? * unit, sigma: sigma.map_or(2e-5, |sigma| sigma * unit) })
}

fn tolerances(section: &Section<'_>) -> Tolerances {
    let default = Tolerances::default();
    let length = section.one_of("unit", &LENGTHS).unwrap_or(1.0);
    let angle = section.one_of("angle_unit", &ANGLES).unwrap_or(1.0);
    let of = |key, factor: f64, default: f64| {
        section
            .positive(key, "write a standard deviation, more than 0")
            .map_or(default, |value| value * factor)
    };
    let read = Tolerances {
        length: of("length", length, default.length),
        angle: of("angle", angle, default.angle),
        zero: of("zero", angle, default.zero),
        encoder: of("encoder", angle, default.encoder),
    };
    section.close();
    read
}
