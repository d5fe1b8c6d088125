//! A small table of numbers as a person writes it: comma-separated columns with names that tell the units, without a header of its own.

use mrroc::console::quoted;
use mrroc::pose::Pose;
use nalgebra::{UnitQuaternion, Vector3};

use crate::data::rotation::Spelling;

/// A line that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what}\n help: {help}")]
pub struct WrongLine {
    /// Which, from 1.
    pub line: usize,
    /// What is wrong.
    pub what: String,
    /// What to write.
    pub help: String,
}

/// How three angles `a`, `b`, `c` make an orientation: turns one after another, each about an axis as turned before. `zyx` are A, B, C of KUKA.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Angles(Spelling);

/// A table.
#[derive(Clone, Debug)]
pub struct Columns<'t> {
    line: usize,
    names: Vec<&'t str>,
    rows: Vec<(usize, Vec<&'t str>)>,
}

impl<'t> Columns<'t> {
    /// Reads a table whose first row has the columns' names; lines that begin with `#` are remarks. `example` is such a first row.
    ///
    /// # Errors
    /// The first line that cannot be read.
    pub fn parse(text: &'t str, example: &str) -> Result<Self, WrongLine> {
        let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
        let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let Some((line, names)) = lines.next() else {
            return Err(wrong(
                1,
                "there is nothing in the table".to_owned(),
                &format!("begin with {example}"),
            ));
        };
        let split = |row: &'t str| row.split(',').map(str::trim).collect::<Vec<_>>();
        let names = split(names);
        let mut rows = Vec::new();
        for (line, row) in lines {
            let cells = split(row);
            if cells.len() != names.len() {
                let what = format!("{} cells in a table of {} columns", cells.len(), names.len());
                return Err(wrong(line, what, "separate cells by commas, and write decimal points"));
            }
            rows.push((line, cells));
        }
        Ok(Self { line, names, rows })
    }

    /// The texts of a column.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn texts(&self, name: &str) -> Result<Vec<&'t str>, WrongLine> {
        let column = self.column(name)?;
        Ok(self.rows.iter().map(|(_, cells)| cells[column]).collect())
    }

    /// By row three numbers in SI, of columns `x`, `y`, `z`, say, with this prefix and `_` and one of these units.
    ///
    /// # Errors
    /// There are no such columns, or a cell is no number.
    pub fn three(&self, names: [&str; 3], units: &[(&str, f64)]) -> Result<Vec<Vector3<f64>>, WrongLine> {
        let has = |unit: &str| self.names.contains(&&*format!("{}_{unit}", names[0]));
        let (unit, factor) = units.iter().find(|(unit, _)| has(unit)).unwrap_or(&units[0]);
        let mut three = vec![Vector3::zeros(); self.rows.len()];
        for (axis, name) in names.iter().enumerate() {
            for (three, number) in three.iter_mut().zip(self.numbers(&format!("{name}_{unit}"))?) {
                three[axis] = number * factor;
            }
        }
        Ok(three)
    }

    /// By row a pose, of columns with this prefix: `x_mm`, `y_mm`, `z_mm` (or `_m`), and an orientation as a rotation vector (`rx_rad`, `ry_rad`, `rz_rad`, or `_deg`),
    /// a quaternion (`qw`, `qx`, `qy`, `qz`), or three angles (`a_deg`, `b_deg`, `c_deg`, or `_rad`) whose order `angles` says.
    ///
    /// # Errors
    /// There are no such columns, or a cell is no number.
    pub fn poses(&self, prefix: &str, angles: Option<Angles>) -> Result<Vec<Pose>, WrongLine> {
        const LENGTHS: [(&str, f64); 2] = [("mm", 1e-3), ("m", 1.0)];
        const ANGLES: [(&str, f64); 2] = [("deg", core::f64::consts::PI / 180.0), ("rad", 1.0)];
        let named = |names: [&str; 3]| names.map(|name| format!("{prefix}{name}"));
        let three = |names: [&str; 3], units: &[(&str, f64)]| {
            let names = named(names);
            self.three([&names[0], &names[1], &names[2]], units)
        };
        let places = three(["x", "y", "z"], &LENGTHS)?;
        let begins = |name: &str| self.names.iter().any(|own| own.starts_with(&format!("{prefix}{name}")));
        let turns: Vec<UnitQuaternion<f64>> = if begins("qw") {
            let of = |name: &str| self.numbers(&format!("{prefix}{name}"));
            let (w, x, y, z) = (of("qw")?, of("qx")?, of("qy")?, of("qz")?);
            let read = |i: usize| {
                let read = Spelling::Wxyz.read(&[w[i], x[i], y[i], z[i]]);
                read.map_err(|what| wrong(self.rows[i].0, what, "compare the order of its columns"))
            };
            (0..w.len()).map(read).collect::<Result<_, _>>()?
        } else if begins("rx_") {
            three(["rx", "ry", "rz"], &ANGLES)?.into_iter().map(UnitQuaternion::from_scaled_axis).collect()
        } else if begins("a_") {
            let three = three(["a", "b", "c"], &ANGLES)?;
            let order = angles.ok_or_else(|| {
                let help = "say how by --angles zyx (A, B, C of KUKA), xyz or zyz, each about the axes as turned before";
                wrong(self.line, "three angles may make an orientation in many ways".to_owned(), help)
            })?;
            let turns = three.iter().map(|angles| order.0.read(angles.as_slice()));
            turns.collect::<Result<_, _>>().map_err(|what| wrong(self.line, what, "compare the columns"))?
        } else {
            let what = format!("no columns of an orientation `{prefix}..`");
            let help = "write rx_rad,ry_rad,rz_rad (a rotation vector), qw,qx,qy,qz, or a_deg,b_deg,c_deg with --angles";
            return Err(wrong(self.line, what, help));
        };
        Ok(places.into_iter().zip(turns).map(|(at, turn)| Pose::from_parts(at.into(), turn)).collect())
    }

    fn column(&self, name: &str) -> Result<usize, WrongLine> {
        let found = self.names.iter().position(|own| *own == name);
        found.ok_or_else(|| {
            let help =
                format!("name the columns in the first row; it has {}", quoted(&self.names.join(", "), 200));
            wrong(self.line, format!("no column `{name}`"), &help)
        })
    }

    fn numbers(&self, name: &str) -> Result<Vec<f64>, WrongLine> {
        let column = self.column(name)?;
        let read = |(line, cells): &(usize, Vec<&str>)| {
            let number = cells[column].parse().ok().filter(|number: &f64| number.is_finite());
            let what = || format!("`{}` is no number", quoted(cells[column], 40));
            number.ok_or_else(|| wrong(*line, what(), "write one such as 812.35"))
        };
        self.rows.iter().map(read).collect()
    }
}

impl Angles {
    /// The order of this name: `zyx`, `xyz` or `zyz`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let known = ["zyx", "xyz", "zyz"].contains(&name);
        known.then(|| Spelling::parse(&format!("euler {name} moving"))).flatten().map(Self)
    }
}

fn wrong(line: usize, what: String, help: &str) -> WrongLine {
    WrongLine { line, what, help: help.to_owned() }
}
