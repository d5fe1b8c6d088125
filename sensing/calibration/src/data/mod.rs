//! Data of others: a table of joint positions and measurements, whose header says what its columns are.
//!
//! In: a file (`header.rs` says what may stand in its header, `table.rs` how rows are read), and the arm that it names. Out: a [`Problem`].
//! Every mistake is told with its line and column.

mod header;
mod mistake;
mod plan;
mod robot;
pub(crate) mod rotation;
mod section;
mod shape;
mod table;
mod table_text;

use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;

use mrroc::pose::Pose;
use mrroc::suggestion::suggestion;

use self::header::{Header, Kind, Measure, Which};
use self::mistake::Source;
use self::table::{Row, number, rows};
use crate::chain::{Chain, ChainArm, Detail, Tolerances};
use crate::device::{Angles, Device, Distance, FullPose, Plane, Points, Touch};
use crate::fit::NoFit;
use crate::problem::{ArmId, FrameId, Freedom, InstrumentId, Noise, Problem, TargetId};

pub use mistake::Mistakes;
pub use plan::Plan;
pub use robot::{Described, NoArm};

/// The tolerance of a scale that is to be found: a part of it.
const SCALE: f64 = 0.1;

/// A measure with the places of its columns, and of that which names the point.
type Placed = (Measure, Vec<Option<usize>>, Option<usize>);

/// What was measured in a row.
#[derive(Clone, Debug)]
struct Reading {
    posture: usize,
    instrument: usize,
    point: usize,
    read: Vec<f64>,
}

/// An instrument of the data.
#[derive(Clone, Debug)]
struct Reader {
    name: String,
    measure: Measure,
}

/// A file of measurements, read.
pub struct Data {
    header: Header,
    readers: Vec<Reader>,
    points: Vec<String>,
    /// Joint positions [rad or m], and the line that they stand in.
    postures: Vec<(Vec<f64>, usize)>,
    readings: Vec<Reading>,
}

/// Data as a problem.
pub struct Stated {
    /// The problem.
    pub problem: Problem,
    /// Its arm.
    pub arm: ArmId,
    /// The arm's model.
    pub model: ChainArm,
    /// The frame of the arm's base.
    pub base: FrameId,
    /// The instruments, in the order of [`Data::instruments`].
    pub instruments: Vec<InstrumentId>,
    /// The points, in the order of [`Data::points`].
    pub points: Vec<TargetId>,
}

/// Whether scales are found that the data do not say to be free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scales {
    /// As the header says.
    Declared,
    /// Of all instruments that read lengths.
    Free,
}

impl Data {
    /// Reads a file.
    ///
    /// # Errors
    /// All mistakes in it.
    pub fn read(path: &Path) -> Result<Data, Mistakes> {
        Self::of(&Source::read(path)?)
    }

    /// Reads the text of a file; `file` is its name, in whose folder the arm's file is looked for.
    ///
    /// # Errors
    /// All mistakes in it.
    pub fn parse(file: &str, text: &str) -> Result<Data, Mistakes> {
        Self::of(&Source::new(file, text))
    }

    fn of(source: &Source) -> Result<Data, Mistakes> {
        let header = header::read(source);
        source.done()?;
        let data = header.and_then(|header| rows_of(source, header));
        source.finish(data)
    }

    /// The arm, as it was designed.
    #[must_use]
    pub fn arm(&self) -> &Described {
        &self.header.arm
    }

    /// How much of the arm the header wants calibrated, if it says so.
    #[must_use]
    pub fn detail(&self) -> Option<Detail> {
        self.header.detail
    }

    /// How far the arm may be from its design.
    #[must_use]
    pub fn tolerances(&self) -> Tolerances {
        self.header.tolerances
    }

    /// The names of the instruments.
    pub fn instruments(&self) -> impl ExactSizeIterator<Item = &str> {
        self.readers.iter().map(|reader| reader.name.as_str())
    }

    /// Whether an instrument reads lengths, which a scale of its own may multiply.
    #[must_use]
    pub fn has_scale(&self, instrument: usize) -> bool {
        matches!(self.readers[instrument].measure.kind, Kind::Point | Kind::Pose { .. })
    }

    /// The names of the measured points.
    pub fn points(&self) -> impl ExactSizeIterator<Item = &str> {
        self.points.iter().map(String::as_str)
    }

    /// How many different postures there are.
    #[must_use]
    pub fn postures(&self) -> usize {
        self.postures.len()
    }

    /// How many measurements there are.
    #[must_use]
    pub fn measurements(&self) -> usize {
        self.readings.len()
    }

    /// The line of the file that a measurement stands in, counted as in the problem.
    #[must_use]
    pub fn line_of(&self, measurement: usize) -> usize {
        self.postures[self.readings[measurement].posture].1
    }

    /// The instrument and the point of a measurement.
    #[must_use]
    pub fn names_of(&self, measurement: usize) -> (&str, &str) {
        let reading = &self.readings[measurement];
        (&self.readers[reading.instrument].name, &self.points[reading.point])
    }

    /// The data as a problem, with this much of the arm to be found; instruments of which nothing is known are placed.
    ///
    /// # Errors
    /// [`NoFit::NoStart`] when no place is found for one.
    pub fn problem(&self, detail: Detail, tolerances: &Tolerances, scales: Scales) -> Result<Stated, NoFit> {
        let chain: Chain = self.header.arm.chain.clone();
        let model = chain.with(detail, tolerances);
        let mut problem = Problem::new();
        let arm = problem.arm("arm", model.clone(), Pose::identity(), Freedom::FIXED);
        let mut anchor = None;
        let mut unplaced = Vec::new();
        let mut instruments = Vec::new();
        for reader in &self.readers {
            let placed = self.placed_instrument(&reader.name);
            let on = placed.on_flange.unwrap_or(false).then_some(arm);
            let at = placed.at.unwrap_or_else(Pose::identity);
            let freedom = if placed.is_known { Freedom::FIXED } else { freedom_of(&reader.measure.kind) };
            let id = self.instrument(&mut problem, reader, on, at, freedom, scales);
            if placed.at.is_none() && !placed.is_known {
                unplaced.push(id);
            }
            let is_frame = freedom == Freedom::FRAME || placed.is_known;
            if on.is_none() && is_frame && anchor.is_none() {
                anchor = Some(problem.place_of(id));
            }
            instruments.push(id);
        }
        let mut points = Vec::new();
        for name in &self.points {
            let placed = self.placed_point(name);
            let on = placed.on_flange.unwrap_or(true).then_some(arm);
            let has_axes = self
                .readings
                .iter()
                .any(|reading| self.points[reading.point] == *name && reading.read.len() == 7);
            let freedom = match (placed.is_known, has_axes) {
                (true, _) => Freedom::FIXED,
                (false, true) => Freedom::FRAME,
                (false, false) => Freedom::POINT,
            };
            points.push(problem.target(name, on, placed.at.unwrap_or_else(Pose::identity), freedom));
        }
        let postures: Vec<_> = self.postures.iter().map(|(q, _)| problem.posture(arm, q)).collect();
        for reading in &self.readings {
            let posture = postures[reading.posture];
            let (instrument, point) = (instruments[reading.instrument], points[reading.point]);
            match self.other_device(reading, scales) {
                None => problem.measure(instrument, point, &[posture], &reading.read),
                Some(device) => problem.measure_by(instrument, device, point, &[posture], &reading.read),
            }
        }
        for known in &self.header.distances {
            let end = |name: &str| self.points.iter().position(|point| point == name).map(|i| points[i]);
            if let [Some(a), Some(b)] =
                [&known.between[0].value, &known.between[1].value].map(|name| end(name))
            {
                problem.bar([a, b], known.length, known.sigma);
            }
        }
        for instrument in unplaced {
            problem.find_start(instrument)?;
        }
        // The first instrument in the world is the world, so that the arm's base is what is found.
        let base = problem.base_of(arm);
        if let Some(anchor) = anchor {
            let is_known = self.readers.iter().any(|reader| self.placed_instrument(&reader.name).is_known);
            problem.anchor(anchor, is_known);
            problem.free(base, Freedom::FRAME);
        }
        Ok(Stated { problem, arm, model, base, instruments, points })
    }

    /// The rows of another file, as measurements of a problem of this one.
    ///
    /// # Errors
    /// A name of an instrument or a point that this one does not have, or another number of joints.
    pub fn with_rows_of(&self, other: &Data, stated: &Stated) -> Result<Problem, String> {
        let mut problem = stated.problem.without_measurements();
        let find = |own: Vec<&str>, name: &str| {
            own.iter().position(|one| *one == name).ok_or_else(|| {
                format!("the data to be foretold have `{name}`, of which nothing was learned\n help: give the same names in both headers")
            })
        };
        let joints = self.header.arm.chain.joints.len();
        for reading in &other.readings {
            let (q, _) = &other.postures[reading.posture];
            if q.len() != joints {
                return Err(format!(
                    "the data to be foretold are of {} joints, the arm has {joints}",
                    q.len()
                ));
            }
            let instrument = find(self.instruments().collect(), &other.readers[reading.instrument].name)?;
            let point = find(self.points().collect(), &other.points[reading.point])?;
            let posture = problem.posture(stated.arm, q);
            let (instrument, point) = (stated.instruments[instrument], stated.points[point]);
            match other.other_device(reading, Scales::Declared) {
                None => problem.measure(instrument, point, &[posture], &reading.read),
                Some(device) => problem.measure_by(instrument, device, point, &[posture], &reading.read),
            }
        }
        Ok(problem)
    }

    /// What reads a point for an instrument that also reads poses.
    fn other_device(&self, reading: &Reading, scales: Scales) -> Option<Rc<dyn Device>> {
        let measure = &self.readers[reading.instrument].measure;
        let is_point = matches!(measure.kind, Kind::Pose { .. }) && reading.read.len() == 3;
        let scale = measure.free_scale || scales == Scales::Free;
        is_point.then(|| -> Rc<dyn Device> {
            if scale { Rc::new(Points::with_scale(Some(SCALE))) } else { Rc::new(Points::new()) }
        })
    }

    fn placed_instrument(&self, name: &str) -> header::Placed {
        of_name(&self.header.instruments, name)
    }

    fn placed_point(&self, name: &str) -> header::Placed {
        of_name(&self.header.points, name)
    }

    fn instrument(
        &self,
        problem: &mut Problem,
        reader: &Reader,
        on: Option<ArmId>,
        at: Pose,
        freedom: Freedom,
        scales: Scales,
    ) -> InstrumentId {
        let Measure { kind, sigma, angle_sigma, free_scale, .. } = &reader.measure;
        let scale = *free_scale || scales == Scales::Free;
        let known = |numbers: usize, sigma: &Option<f64>, default: f64| match sigma {
            Some(sigma) => Noise::Known(vec![*sigma; numbers]),
            None => Noise::Unknown(vec![default; numbers]),
        };
        let lengths = |numbers| known(numbers, sigma, 1e-4);
        let name = &reader.name;
        match kind {
            Kind::Point => {
                let device = if scale { Points::with_scale(Some(SCALE)) } else { Points::new() };
                problem.instrument(name, device, on, at, freedom, lengths(3))
            }
            Kind::Pose { .. } => {
                let device = if scale { FullPose::with_scale(Some(SCALE)) } else { FullPose::new() };
                let (length, angle) = (sigma.unwrap_or(1e-4), angle_sigma.unwrap_or(1e-3));
                let both = vec![length, length, length, angle, angle, angle];
                let noise = match (sigma, angle_sigma) {
                    (Some(_), Some(_)) => Noise::Known(both),
                    _ => Noise::Unknown(both),
                };
                problem.instrument(name, device, on, at, freedom, noise)
            }
            Kind::Distance => {
                problem.instrument(name, Distance::new(Some(1e-3)), on, at, freedom, lengths(1))
            }
            Kind::Angles => {
                let noise = known(2, angle_sigma, 1e-5);
                problem.instrument(name, Angles::both_faces(), on, at, freedom, noise)
            }
            Kind::Plane => problem.instrument(name, Plane, on, at, freedom, lengths(1)),
            Kind::Touch => problem.instrument(name, Touch, on, at, freedom, lengths(3)),
        }
    }
}

/// What of an instrument's frame counts.
fn freedom_of(kind: &Kind) -> Freedom {
    match kind {
        Kind::Distance | Kind::Touch => Freedom::POINT,
        Kind::Point | Kind::Pose { .. } | Kind::Angles => Freedom::FRAME,
        Kind::Plane => Freedom { free: [false, false, true, true, true, false], ..Freedom::FIXED },
    }
}

fn of_name(all: &[(String, header::Placed)], name: &str) -> header::Placed {
    all.iter().find(|(other, _)| other == name).map(|(_, placed)| placed.clone()).unwrap_or_default()
}

/// Reads the rows below a header.
fn rows_of(source: &Source, header: Header) -> Option<Data> {
    let mut rows = rows(source, header.end, header.form).into_iter();
    let names: Vec<String> = match &header.columns {
        Some(names) => names.clone(),
        None => {
            let Some(first) = rows.next() else {
                let at = header.end..source.text.len();
                source.complain(
                    &at,
                    "below the header there is no row",
                    "write a row of column names, then one row for each posture",
                );
                return None;
            };
            first.cells.into_iter().map(|cell| cell.value).collect()
        }
    };
    let find = |wanted: &section::At<String>| {
        let found = names.iter().position(|name| *name == wanted.value);
        if found.is_none() {
            let what = format!("the table has no column `{}`", wanted.value);
            source.complain(&wanted.span, what, suggestion(&wanted.value, &names, "its columns are"));
        }
        found
    };
    let joints: Vec<Option<usize>> = header.joints.columns.iter().map(find).collect();
    let measures: Vec<Placed> = header
        .measures
        .iter()
        .map(|measure| {
            let columns = measure.columns.iter().map(find).collect();
            let which = match &measure.which {
                Which::Always(_) => None,
                Which::Column(column) => find(column),
            };
            (measure.clone(), columns, which)
        })
        .collect();
    let mut readers: Vec<Reader> = Vec::new();
    for measure in &header.measures {
        match readers.iter().find(|reader| reader.name == measure.instrument) {
            None => readers.push(Reader { name: measure.instrument.clone(), measure: measure.clone() }),
            // A device that sees poses may see points, too.
            Some(other) if matches!((other.measure.kind, measure.kind), (Kind::Pose { .. }, Kind::Point)) => {
            }
            Some(other)
                if core::mem::discriminant(&other.measure.kind) != core::mem::discriminant(&measure.kind) =>
            {
                let what = format!("the instrument `{}` reads two kinds of things", measure.instrument);
                source.complain(
                    &measure.span,
                    what,
                    "name poses before points, or give one of them another name: instrument = \"..\"",
                );
            }
            Some(_) => {}
        }
    }
    if !source.is_good() {
        return None;
    }
    let mut data = Data { header, readers, points: Vec::new(), postures: Vec::new(), readings: Vec::new() };
    let mut seen: BTreeMap<Vec<u64>, usize> = BTreeMap::new();
    for row in rows {
        data.take(source, &row, &names, &joints, &measures, &mut seen);
    }
    data.check(source);
    Some(data)
}

impl Data {
    fn take(
        &mut self,
        source: &Source,
        row: &Row,
        names: &[String],
        joints: &[Option<usize>],
        measures: &[Placed],
        seen: &mut BTreeMap<Vec<u64>, usize>,
    ) {
        if row.cells.len() != names.len() {
            let what = format!("{} cells, where the table has {} columns", row.cells.len(), names.len());
            source.complain(
                &row.span,
                what,
                "write one cell for each column; `separator` in the header says what is between them",
            );
            return;
        }
        let form = self.header.form;
        let value = |column: &Option<usize>| {
            let i = (*column)?;
            number(source, &row.cells[i], &names[i], form)
        };
        let read: Option<Vec<f64>> = joints.iter().map(value).collect();
        let Some(read) = read else { return };
        let Header { joints: units, missing, .. } = &self.header;
        let q: Vec<f64> =
            read.iter().enumerate().map(|(i, read)| units.factors[i] * read + units.offsets[i]).collect();
        let line = source.text[..row.span.start].matches('\n').count() + 1;
        let key = q.iter().map(|q| q.to_bits()).collect();
        let posture = *seen.entry(key).or_insert_with(|| {
            self.postures.push((q, line));
            self.postures.len() - 1
        });
        for (measure, columns, which) in measures {
            let cells = columns.iter().filter_map(|column| column.map(|i| &row.cells[i]));
            if cells.clone().any(|cell| missing.contains(&cell.value)) {
                continue;
            }
            let numbers: Option<Vec<f64>> = columns.iter().map(value).collect();
            let Some(numbers) = numbers else { continue };
            let first = cells.clone().next().map_or_else(|| row.span.clone(), |cell| cell.span.clone());
            let read = match reading(measure, &numbers) {
                Ok(read) => read,
                Err(what) => {
                    source.complain(&first, what, "see `rotation` and `angle_unit` in the header");
                    continue;
                }
            };
            let name = match (&measure.which, which) {
                (Which::Always(name), _) => name.clone(),
                (Which::Column(_), Some(i)) => row.cells[*i].value.clone(),
                (Which::Column(_), None) => continue,
            };
            let point = self.points.iter().position(|point| *point == name).unwrap_or_else(|| {
                self.points.push(name);
                self.points.len() - 1
            });
            let instrument = self.readers.iter().position(|reader| reader.name == measure.instrument);
            let Some(instrument) = instrument else { continue };
            self.readings.push(Reading { posture, instrument, point, read });
        }
    }

    /// What can only be seen when all rows are read.
    fn check(&self, source: &Source) {
        if self.readings.is_empty() && source.is_good() {
            let help = "write at least some rows; `missing` in the header says which texts mean that nothing was measured";
            source.complain(&(self.header.end..self.header.end), "nothing was measured in any row", help);
        }
        for known in &self.header.distances {
            for name in &known.between {
                if !self.points.contains(&name.value) {
                    let what = format!("no point `{}` is measured", name.value);
                    source.complain(
                        &name.span,
                        what,
                        suggestion(&name.value, &self.points, "the points are"),
                    );
                }
            }
        }
        for (name, _) in &self.header.points {
            if !self.points.contains(name) {
                let what = format!("[points.{name}] is of no point that is measured");
                source.complain(&(0..0), what, suggestion(name, &self.points, "the points are"));
            }
        }
        let names: Vec<&str> = self.instruments().collect();
        for (name, _) in &self.header.instruments {
            if !names.contains(&name.as_str()) {
                let what = format!("[instruments.{name}] is of no instrument that measures");
                source.complain(&(0..0), what, suggestion(name, &names, "the instruments are"));
            }
        }
        for reader in &self.readers {
            let is_placed = self.placed_instrument(&reader.name).at.is_some();
            if reader.measure.kind == Kind::Angles && !is_placed {
                let what = format!("nobody says where `{}` stands", reader.name);
                let help = "angles alone do not show it: write [instruments.NAME] with position = [..], unit, and rotation_vector, about; and \
                            the first theodolite's known = true";
                source.complain(&reader.measure.span, what, help);
            }
        }
    }
}

/// What an instrument read, in m and rad.
fn reading(measure: &Measure, numbers: &[f64]) -> Result<Vec<f64>, String> {
    let Measure { kind, length, angle, .. } = measure;
    Ok(match kind {
        Kind::Point | Kind::Distance => numbers.iter().map(|number| number * length).collect(),
        Kind::Angles => numbers.iter().map(|number| number * angle).collect(),
        Kind::Plane => vec![0.0],
        Kind::Touch => vec![0.0; 3],
        Kind::Pose { spelling, inverse } => {
            let factor = if spelling.is_angles() { *angle } else { 1.0 };
            let rest: Vec<f64> = numbers[3..].iter().map(|number| number * factor).collect();
            let rotation = spelling.read(&rest)?;
            let position = nalgebra::Vector3::new(numbers[0], numbers[1], numbers[2]) * *length;
            let read = Pose::from_parts(position.into(), rotation);
            let read = if *inverse { read.inverse() } else { read };
            let (p, q) = (read.translation.vector, read.rotation.quaternion());
            vec![p.x, p.y, p.z, q.w, q.i, q.j, q.k]
        }
    })
}
