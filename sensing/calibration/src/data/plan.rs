//! A table that is still to be measured: its header alone, and what its instruments are expected to read.
//!
//! In: the header of a data file, with where instruments and points are about, and how well the instruments measure. Out: the same data as if they
//! had been measured at postures, with the arm as it was designed; and the table to fill in.

use std::path::Path;

use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use nalgebra::Vector3;

use super::header::{self, Kind, Which};
use super::mistake::{Mistakes, Source};
use super::table_text::TableText;
use super::{Data, Reader, Reading};
use crate::device::{Angles, Device, Distance, FullPose, Points};

/// A header without measurements.
pub struct Plan {
    pub(crate) data: Data,
    /// The lines of the header, as they are.
    text: String,
    /// The row of names below it, if it is there already.
    names: Option<String>,
    /// What may be seen of a posture: instrument, point, and the row's name.
    sights: Vec<Sight>,
}

/// A point as an instrument may see it.
#[derive(Clone, Debug)]
pub(crate) struct Sight {
    pub(crate) instrument: usize,
    pub(crate) point: usize,
    kind: Kind,
    is_in_a_row_of_its_own: bool,
}

impl Plan {
    /// Reads the header of a file; rows of measurements below it are not looked at.
    ///
    /// # Errors
    /// All mistakes in it, and what a plan needs and it does not say.
    pub fn read(path: &Path) -> Result<Plan, Mistakes> {
        Self::of(&Source::read(path)?)
    }

    /// Reads a text; `file` is its name, in whose folder the arm's file is looked for.
    ///
    /// # Errors
    /// As [`Plan::read`].
    pub fn parse(file: &str, text: &str) -> Result<Plan, Mistakes> {
        Self::of(&Source::new(file, text))
    }

    fn of(source: &Source) -> Result<Plan, Mistakes> {
        let header = header::read(source);
        source.done()?;
        let plan = header.and_then(|header| {
            let names = header.columns.is_none().then(|| source.text[header.end..].lines().next());
            let names = names.flatten().filter(|names| !names.trim().is_empty()).map(str::to_owned);
            let text = source.text[..header.end].to_owned();
            let data = Data {
                header,
                readers: Vec::new(),
                points: Vec::new(),
                postures: Vec::new(),
                readings: Vec::new(),
            };
            let mut plan = Plan { data, text, names, sights: Vec::new() };
            plan.check(source);
            source.is_good().then_some(plan)
        });
        source.finish(plan)
    }

    /// Complains about what is not said, and lists what may be seen.
    fn check(&mut self, source: &Source) {
        let Data { header, readers, points, .. } = &mut self.data;
        for (joint, limits) in header.arm.chain.joints.iter().zip(&header.arm.limits) {
            if limits.is_none() {
                let what = format!("joint `{}` of {} has no limits", joint.name, header.arm.name);
                let help = "write limits = [-170, 170] into its [[joints]], in angle_unit (length_unit where it slides), or <limit> into a URDF";
                source.complain(&(0..0), what, help);
            }
        }
        for measure in &header.measures {
            let name = &measure.instrument;
            let known = match measure.kind {
                Kind::Point | Kind::Distance => measure.sigma.is_some(),
                Kind::Angles => measure.angle_sigma.is_some(),
                Kind::Pose { .. } => measure.sigma.is_some() && measure.angle_sigma.is_some(),
                Kind::Plane | Kind::Touch => {
                    let help =
                        "leave it out here: choose sides as different as the arm reaches, and guide it there";
                    source.complain(&measure.span, "postures that touch something cannot be chosen", help);
                    continue;
                }
            };
            if !known {
                let what = format!("how well `{name}` measures is not said");
                let help = "write sigma = 0.05, the standard deviation in `unit`, or angle_sigma in `angle_unit`; both for poses";
                source.complain(&measure.span, what, help);
            }
            let is_placed = header.instruments.iter().any(|(own, placed)| own == name && placed.at.is_some());
            if matches!(measure.kind, Kind::Angles | Kind::Distance) && !is_placed {
                let help = "write [instruments.NAME] with position = [..] and unit, and rotation_vector for angles, about";
                source.complain(&measure.span, format!("nobody says where `{name}` stands"), help);
            }
            let instrument = readers.iter().position(|reader| reader.name == *name).unwrap_or_else(|| {
                readers.push(Reader { name: name.clone(), measure: measure.clone() });
                readers.len() - 1
            });
            let seen: Vec<String> = match &measure.which {
                Which::Always(name) => vec![name.clone()],
                Which::Column(_) => header.points.iter().map(|(name, _)| name.clone()).collect(),
            };
            if seen.is_empty() {
                let help =
                    "write [points.A] with position = [..] and unit for each point that the column will name";
                source.complain(&measure.span, "nobody says which points there are", help);
            }
            for name in seen {
                let is_placed = header.points.iter().any(|(own, placed)| *own == name && placed.at.is_some());
                if !is_placed {
                    let what = format!("nobody says where the point `{name}` is");
                    let help = format!(
                        "write [points.{name}] with position = [..] and unit, about, on the flange (or on = \"world\")"
                    );
                    source.complain(&measure.span, what, help);
                }
                let point = points.iter().position(|own| *own == name).unwrap_or_else(|| {
                    points.push(name);
                    points.len() - 1
                });
                let is_in_a_row_of_its_own = matches!(measure.which, Which::Column(_));
                self.sights.push(Sight { instrument, point, kind: measure.kind, is_in_a_row_of_its_own });
            }
        }
        // Of instruments that nobody placed, such as a tracker, it does not matter where they are.
        let unplaced =
            readers.iter().filter(|reader| header.instruments.iter().all(|(name, _)| *name != reader.name));
        let unplaced: Vec<_> =
            unplaced.map(|reader| (reader.name.clone(), header::Placed::default())).collect();
        header.instruments.extend(unplaced);
    }

    pub(crate) fn sights(&self) -> &[Sight] {
        &self.sights
    }

    /// Whether the header says where an instrument is.
    pub(crate) fn is_placed(&self, instrument: usize) -> bool {
        self.data.placed_instrument(&self.data.readers[instrument].name).at.is_some()
    }

    /// Whether a point is on the flange, and whether an instrument is.
    pub(crate) fn on_flange(&self, sight: &Sight) -> (bool, bool) {
        let point = self.data.placed_point(&self.data.points[sight.point]);
        let instrument = self.data.placed_instrument(&self.data.readers[sight.instrument].name);
        (point.on_flange.unwrap_or(true), instrument.on_flange.unwrap_or(false))
    }

    /// Where the point and the instrument of a sight are in the base, with the flange there, as far as is known.
    #[allow(non_snake_case)]
    pub(crate) fn both(&self, sight: &Sight, X_BF: &Pose) -> (Pose, Pose) {
        let point = self.data.placed_point(&self.data.points[sight.point]).at.unwrap_or_else(Pose::identity);
        let own = self.data.placed_instrument(&self.data.readers[sight.instrument].name);
        let own = own.at.unwrap_or_else(Pose::identity);
        let (moves, looks) = self.on_flange(sight);
        (if moves { X_BF * point } else { point }, if looks { X_BF * own } else { own })
    }

    /// The frames behind each joint, then the flange, in the base.
    #[must_use]
    pub fn frames(&self, q: &[f64]) -> Vec<Pose> {
        let chain = &self.data.header.arm.chain;
        let mut at = Pose::identity();
        let mut frames: Vec<Pose> = Vec::new();
        for (joint, q) in chain.joints.iter().zip(q) {
            at *= joint.X_before;
            at *= match joint.kind {
                JointKind::Revolute => Pose::rotation(Vector3::z() * *q),
                JointKind::Prismatic => Pose::translation(0.0, 0.0, *q),
            };
            frames.push(at);
        }
        frames.push(at * chain.X_tip);
        frames
    }

    /// Expects what would be read at these postures, with the arm as it was designed; `seen` are by posture the places of sights.
    pub(crate) fn expect<'p>(&mut self, postures: impl Iterator<Item = (&'p [f64], &'p [usize])>) {
        for name in self.data.readers.iter().map(|reader| &reader.name) {
            if let Some((_, placed)) = self.data.header.instruments.iter_mut().find(|(own, _)| own == name) {
                placed.at.get_or_insert_with(Pose::identity);
            }
        }
        (self.data.postures, self.data.readings) = (Vec::new(), Vec::new());
        for (posture, (q, seen)) in postures.enumerate() {
            let flange = self.frames(q).pop().unwrap_or_else(Pose::identity);
            for sight in seen.iter().map(|i| &self.sights[*i]) {
                let (point, own) = self.both(sight, &flange);
                let read = expected(sight.kind, &own.inv_mul(&point));
                let Sight { instrument, point, .. } = *sight;
                self.data.readings.push(Reading { posture, instrument, point, read });
            }
            self.data.postures.push((q.to_vec(), 0));
        }
    }

    /// The table to fill in: the header, names, and by posture a row, or one for each point that a column names.
    ///
    /// # Errors
    /// What the header must say for it.
    pub(crate) fn table<'p>(
        &self,
        postures: impl Iterator<Item = (&'p [f64], &'p [usize])>,
    ) -> Result<String, String> {
        let mut table = TableText::new(&self.text, self.names.as_deref(), &self.data.header)?;
        for (q, seen) in postures {
            let seen: Vec<&Sight> = seen.iter().map(|i| &self.sights[*i]).collect();
            let mut named: Vec<usize> =
                seen.iter().filter(|sight| sight.is_in_a_row_of_its_own).map(|sight| sight.point).collect();
            named.sort_unstable();
            named.dedup();
            if named.is_empty() {
                table.row(q, "");
            }
            named.into_iter().for_each(|point| table.row(q, &self.data.points[point]));
        }
        Ok(table.text())
    }
}

/// What is read of a point there, in the instrument's frame.
#[allow(non_snake_case)]
fn expected(kind: Kind, X_IT: &Pose) -> Vec<f64> {
    let predict = |device: &dyn Device, constants: &[f64]| {
        let mut read = vec![0.0; device.readings()];
        device.predict(X_IT, constants, &mut read);
        read
    };
    match kind {
        Kind::Point | Kind::Touch | Kind::Plane => predict(&Points::new(), &[]),
        Kind::Pose { .. } => predict(&FullPose::new(), &[]),
        Kind::Distance => predict(&Distance::new(None), &[0.0]),
        Kind::Angles => predict(&Angles::both_faces(), &[]),
    }
}
