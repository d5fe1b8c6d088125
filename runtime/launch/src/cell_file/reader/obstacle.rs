//! Entries `[obstacles.NAME]`.

use std::rc::Rc;

use mrroc_core::pose::Pose;
use mrroc_core::suggestion::suggestion;
use toml::de::{DeTable, DeValue};

use super::super::error::At;
use super::super::obstacle::{ObstacleEntry, ObstacleMesh, ObstacleShape};
use super::pose::IN_CELL;
use super::{Entry, Reader, Value};

pub(in super::super) const OBSTACLE_KEYS: [&str; 10] =
    ["box", "cylinder", "sphere", "capsule", "half_space", "cloud", "height_field", "mesh", "at", "frame"];
/// Reads a shape.
type ReadShape = fn(&mut Reader, &Value<'_>) -> Option<ObstacleShape>;
/// Of these keys those that say the shape, and what reads it.
const SHAPES: [(&str, ReadShape); 8] = [
    ("box", Reader::box_of),
    ("cylinder", Reader::cylinder),
    ("sphere", Reader::sphere),
    ("capsule", Reader::capsule),
    ("half_space", Reader::half_space),
    ("cloud", Reader::cloud),
    ("height_field", Reader::height_field),
    ("mesh", Reader::mesh),
];
/// The keys of all shapes.
#[cfg(test)]
pub(in super::super) const SHAPE_KEYS: [&str; 8] =
    ["size", "radius", "length", "height", "file", "cell", "excess", "scale"];

/// How a shape is written.
const BOX: &str = "box = { size = [1.2, 0.8, 0.05] } [m]";

impl Reader {
    /// Reads what stands in the cell. No robot may have its name.
    pub(super) fn obstacle(
        &mut self,
        Entry { name, table }: Entry<'_>,
        robots: &[String],
        frames: &[(String, Pose)],
    ) -> Option<ObstacleEntry> {
        self.known(table, &OBSTACLE_KEYS, "an obstacle has");
        if robots.contains(&name.value) {
            let what = format!("`{}` is a robot already", name.value);
            self.complain(&name.span, what, "give the obstacle a name of its own".to_owned());
        }
        let at = table.get("at").map_or(Some(Pose::identity()), |value| self.pose(value, IN_CELL));
        let frame = table.get("frame").map_or(Some(Pose::identity()), |value| self.frame_of(value, frames));
        let shapes: Vec<_> =
            SHAPES.iter().filter_map(|(key, read)| Some((*key, *read, table.get(*key)?))).collect();
        let shape = match shapes[..] {
            [(_, read, value)] => read(self, value).map(|shape| At { value: shape, span: value.span() }),
            [] => {
                let what = format!("obstacle `{}` has no shape", name.value);
                let help = format!(
                    "write {BOX}, or one of {}",
                    SHAPES[1..].iter().map(|(key, _)| *key).collect::<Vec<_>>().join(", ")
                );
                self.complain(&name.span, what, help);
                None
            }
            [(first, ..), (second, _, value), ..] => {
                let what = format!("obstacle `{}` has both `{first}` and `{second}`", name.value);
                self.complain(&value.span(), what, "write a table [obstacles.NAME] for each".to_owned());
                None
            }
        };
        let place = frame? * at?;
        Some(ObstacleEntry { source: Rc::clone(&self.source), name: name.value, place, shape: shape? })
    }

    /// Reads the name of one of the cell's frames.
    fn frame_of(&mut self, value: &Value<'_>, frames: &[(String, Pose)]) -> Option<Pose> {
        let name = self.text(value, "the name of a frame of the cell, in quotes")?;
        let found = frames.iter().find(|(known, _)| known == name);
        if found.is_none() {
            let names: Vec<_> = frames.iter().map(|(name, _)| &**name).collect();
            let help = match names.is_empty() {
                true => format!("write a table [frames.{name}], or leave `frame` out"),
                false => suggestion(name, &names, "the cell has"),
            };
            self.complain(&value.span(), format!("no frame `{name}`"), help);
        }
        found.map(|(_, pose)| *pose)
    }

    fn box_of(&mut self, value: &Value<'_>) -> Option<ObstacleShape> {
        let table = self.shape_table(value, BOX, &["size"])?;
        let size = self.required(table, value, "size", BOX)?;
        self.edges(size).map(|size| ObstacleShape::Box { size })
    }

    fn cylinder(&mut self, value: &Value<'_>) -> Option<ObstacleShape> {
        let (radius, length) = self.rod(value, "cylinder = { radius = 0.05, length = 1.0 } [m]")?;
        Some(ObstacleShape::Cylinder { radius, length })
    }

    fn capsule(&mut self, value: &Value<'_>) -> Option<ObstacleShape> {
        let (radius, length) = self.rod(value, "capsule = { radius = 0.05, length = 1.0 } [m]")?;
        Some(ObstacleShape::Capsule { radius, length })
    }

    fn rod(&mut self, value: &Value<'_>, form: &str) -> Option<(f64, f64)> {
        let table = self.shape_table(value, form, &["radius", "length"])?;
        let radius = self.length(table, value, "radius", form);
        let length = self.length(table, value, "length", form);
        Some((radius?, length?))
    }

    fn sphere(&mut self, value: &Value<'_>) -> Option<ObstacleShape> {
        const FORM: &str = "sphere = { radius = 0.1 } [m]";
        let table = self.shape_table(value, FORM, &["radius"])?;
        Some(ObstacleShape::Sphere { radius: self.length(table, value, "radius", FORM)? })
    }

    fn half_space(&mut self, value: &Value<'_>) -> Option<ObstacleShape> {
        const FORM: &str = "half_space = { height = 0.0 } [m]";
        let table = self.shape_table(value, FORM, &["height"])?;
        let height = self.required(table, value, "height", FORM)?;
        let height = self.number(height, "a height [m]")?;
        self.ask_about_place([0.0, 0.0, height.value], IN_CELL, &height.span);
        Some(ObstacleShape::HalfSpace { height: height.value })
    }

    fn cloud(&mut self, value: &Value<'_>) -> Option<ObstacleShape> {
        const FORM: &str = "cloud = { file = \"points.xyz\", radius = 0.01 } [m]";
        let table = self.shape_table(value, FORM, &["file", "radius", "cell"])?;
        let file = self.shape_file(table, value, FORM);
        let radius = self.length(table, value, "radius", FORM);
        let cell = match table.get("cell") {
            None => Some(None),
            Some(_) => self.length(table, value, "cell", FORM).map(Some),
        };
        Some(ObstacleShape::Cloud { file: file?, radius: radius?, cell: cell? })
    }

    fn height_field(&mut self, value: &Value<'_>) -> Option<ObstacleShape> {
        const FORM: &str = "height_field = { file = \"ground.txt\", cell = 0.05 } [m]";
        let table = self.shape_table(value, FORM, &["file", "cell"])?;
        let file = self.shape_file(table, value, FORM);
        let cell = self.length(table, value, "cell", FORM);
        Some(ObstacleShape::HeightField { file: file?, cell: cell? })
    }

    fn mesh(&mut self, value: &Value<'_>) -> Option<ObstacleShape> {
        const FORM: &str = "mesh = { file = \"fixture.stl\", excess = 0.005 } [m]";
        let table = self.shape_table(value, FORM, &["file", "excess", "scale"])?;
        let file = self.shape_file(table, value, FORM);
        let excess = match table.get("excess") {
            None => Some(ObstacleMesh::EXCESS),
            Some(_) => self.length(table, value, "excess", FORM),
        };
        let scale = table.get("scale").map_or(Some(1.0), |scale| self.scale(scale));
        Some(ObstacleShape::Mesh(ObstacleMesh { file: file?, excess: excess?, scale: scale? }))
    }

    /// How many metres a unit of a file is.
    fn scale(&mut self, value: &Value<'_>) -> Option<f64> {
        const EXPECTED: &str = "a scale above 0, such as 0.001 for a file in millimetres";
        let scale = self.number(value, EXPECTED)?;
        if scale.value > 0.0 {
            return Some(scale.value);
        }
        self.complain(&scale.span, format!("{} is no scale", scale.value), format!("write {EXPECTED}"));
        None
    }

    fn shape_table<'t>(
        &mut self,
        value: &'t Value<'_>,
        form: &str,
        keys: &[&str],
    ) -> Option<&'t DeTable<'t>> {
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong_type(value, form);
            return None;
        };
        self.known(table, keys, "this shape has");
        Some(table)
    }

    /// A value that a shape must have.
    fn required<'t>(
        &mut self,
        table: &'t DeTable<'_>,
        shape: &Value<'_>,
        key: &str,
        form: &str,
    ) -> Option<&'t Value<'t>> {
        let found = table.get(key);
        if found.is_none() {
            self.complain(&shape.span(), format!("a shape without `{key}`"), format!("write {form}"));
        }
        found
    }

    /// A length that a shape must have.
    fn length(&mut self, table: &DeTable<'_>, shape: &Value<'_>, key: &str, form: &str) -> Option<f64> {
        let article = if key == "excess" { "an" } else { "a" };
        let expected = format!("{article} {key} above 0 [m]");
        let value = self.required(table, shape, key, form)?;
        let length = self.number(value, &expected)?;
        self.ask_about_place([length.value; 3], IN_CELL, &length.span);
        self.above_0(&length, &expected)
    }

    fn above_0(&mut self, number: &At<f64>, expected: &str) -> Option<f64> {
        if number.value > 0.0 {
            return Some(number.value);
        }
        self.complain(&number.span, format!("{} m", number.value), format!("write {expected}"));
        None
    }

    /// The edges of a box.
    fn edges(&mut self, value: &Value<'_>) -> Option<[f64; 3]> {
        let edges = self.numbers(value, "three edges above 0 [m]")?;
        let [x, y, z] = edges.value.as_slice() else {
            let what = format!("`size` has {} numbers", edges.value.len());
            self.complain(&edges.span, what, format!("write three: {BOX}"));
            return None;
        };
        self.ask_about_place([x.value, y.value, z.value], IN_CELL, &edges.span);
        let [x, y, z] = [x, y, z].map(|edge| self.above_0(edge, "an edge above 0 [m]"));
        Some([x?, y?, z?])
    }

    fn shape_file(&mut self, table: &DeTable<'_>, shape: &Value<'_>, form: &str) -> Option<String> {
        let file = self.required(table, shape, "file", form)?;
        self.text(file, "the name of a file, in quotes").map(str::to_owned)
    }
}
