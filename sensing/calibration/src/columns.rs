//! A small table of numbers as a person writes it: columns with names that tell the units, without a header of its own.

use mrroc::console::quoted;
use mrroc::pose::Pose;
use nalgebra::Vector3;

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
    decimal_commas: bool,
}

/// Poses as a table has them: their numbers, and how they are read.
#[derive(Clone, Debug)]
pub struct Written {
    /// By row its line in the text, from 1.
    pub lines: Vec<usize>,
    /// Positions \[m\].
    pub(crate) places: Vec<Vector3<f64>>,
    /// The numbers of the orientations; angles \[rad\].
    pub(crate) turns: Vec<Vec<f64>>,
    pub(crate) spelling: Spelling,
}

impl Written {
    /// The poses.
    ///
    /// # Errors
    /// The first line whose orientation is none.
    pub fn poses(&self) -> Result<Vec<Pose>, WrongLine> {
        let pose = |((at, turn), line): ((&Vector3<f64>, &Vec<f64>), &usize)| {
            let turn = self.spelling.read(turn);
            let turn = turn.map_err(|what| wrong(*line, what, "compare the order of its columns"))?;
            Ok(Pose::from_parts((*at).into(), turn))
        };
        self.places.iter().zip(&self.turns).zip(&self.lines).map(pose).collect()
    }

    /// The same of some of the rows.
    #[must_use]
    pub fn of_rows(&self, rows: &[usize]) -> Self {
        Self {
            lines: rows.iter().map(|row| self.lines[*row]).collect(),
            places: rows.iter().map(|row| self.places[*row]).collect(),
            turns: rows.iter().map(|row| self.turns[*row].clone()).collect(),
            spelling: self.spelling,
        }
    }

    /// Poses that were not written but computed, such as those of a board in photos.
    #[must_use]
    pub fn of_poses(poses: &[Pose]) -> Self {
        let quaternion = |pose: &Pose| {
            let q = pose.rotation.quaternion();
            vec![q.w, q.i, q.j, q.k]
        };
        Self {
            lines: vec![0; poses.len()],
            places: poses.iter().map(|pose| pose.translation.vector).collect(),
            turns: poses.iter().map(quaternion).collect(),
            spelling: Spelling::Wxyz,
        }
    }

    /// The farthest of the places \[m\]; 0 without any.
    #[must_use]
    pub fn farthest(&self) -> f64 {
        self.places.iter().map(Vector3::norm).fold(0.0, f64::max)
    }
}

impl<'t> Columns<'t> {
    /// Reads a table whose first row has the columns' names; lines that begin with `#` are remarks. `example` is such a first row. Cells are separated by commas, by
    /// semicolons or by tabs, whichever the first row has; decimal commas may stand between the latter two. Rows without anything in them are skipped.
    ///
    /// # Errors
    /// The first line that cannot be read.
    pub fn parse(text: &'t str, example: &str) -> Result<Self, WrongLine> {
        // Blanks alone are trimmed: a tab may separate cells that are empty.
        let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
        let has_something = |line: &str| line.chars().any(|c| !c.is_whitespace() && !",;\"".contains(c));
        let mut lines = lines.filter(|(_, line)| has_something(line) && !line.trim_start().starts_with('#'));
        let Some((line, names)) = lines.next() else {
            return Err(wrong(
                1,
                "there is nothing in the table".to_owned(),
                &format!("begin with {example}"),
            ));
        };
        let separator = [',', ';', '\t'].into_iter().max_by_key(|c| (names.matches(*c).count(), *c == ','));
        let separator = separator.unwrap_or(',');
        let bare = |cell: &'t str| cell.trim().trim_matches('"').trim();
        let split = |row: &'t str| row.split(separator).map(bare).collect::<Vec<_>>();
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
        Ok(Self { line, names, rows, decimal_commas: separator != ',' })
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
        self.written(prefix, angles)?.poses()
    }

    /// The same, as they are written.
    ///
    /// # Errors
    /// There are no such columns, or a cell is no number.
    pub fn written(&self, prefix: &str, angles: Option<Angles>) -> Result<Written, WrongLine> {
        const LENGTHS: [(&str, f64); 2] = [("mm", 1e-3), ("m", 1.0)];
        const ANGLES: [(&str, f64); 2] = [("deg", core::f64::consts::PI / 180.0), ("rad", 1.0)];
        let named = |names: [&str; 3]| names.map(|name| format!("{prefix}{name}"));
        let three = |names: [&str; 3], units: &[(&str, f64)]| {
            let names = named(names);
            self.three([&names[0], &names[1], &names[2]], units)
        };
        let numbers = |three: Vec<Vector3<f64>>| three.iter().map(|one| one.as_slice().to_vec()).collect();
        let places = three(["x", "y", "z"], &LENGTHS)?;
        let begins = |name: &str| self.names.iter().any(|own| own.starts_with(&format!("{prefix}{name}")));
        let (turns, spelling): (Vec<Vec<f64>>, _) = if begins("qw") {
            let of = |name: &str| self.numbers(&format!("{prefix}{name}"));
            let (w, x, y, z) = (of("qw")?, of("qx")?, of("qy")?, of("qz")?);
            ((0..w.len()).map(|i| vec![w[i], x[i], y[i], z[i]]).collect(), Spelling::Wxyz)
        } else if begins("rx_") {
            (numbers(three(["rx", "ry", "rz"], &ANGLES)?), Spelling::Vector)
        } else if begins("a_") {
            let three = three(["a", "b", "c"], &ANGLES)?;
            let order = angles.ok_or_else(|| {
                let help = "say how by --angles zyx (A, B, C of KUKA), xyz or zyz, each about the axes as turned before";
                wrong(self.line, "three angles may make an orientation by many conventions".to_owned(), help)
            })?;
            (numbers(three), order.0)
        } else {
            let what = format!("no columns of an orientation `{prefix}..`");
            let help = "write rx_rad,ry_rad,rz_rad (a rotation vector), qw,qx,qy,qz, or a_deg,b_deg,c_deg with --angles";
            return Err(wrong(self.line, what, help));
        };
        Ok(Written { lines: self.rows.iter().map(|(line, _)| *line).collect(), places, turns, spelling })
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
            let cell = cells[column];
            let number = if self.decimal_commas { cell.replace(',', ".").parse() } else { cell.parse() };
            let number = number.ok().filter(|number: &f64| number.is_finite());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_the_same_with_semicolons_tabs_quotes_and_rows_of_empty_cells() {
        let texts = [
            "x_mm,y_mm,z_mm,rx_rad,ry_rad,rz_rad\n\n# a remark\n1.5,2,3,0.1,0.2,0.3\n,,,,,\n",
            "x_mm;y_mm;z_mm;rx_rad;ry_rad;rz_rad\n1,5;2;3;0,1;0,2;0,3\n;;;;;\n",
            "x_mm\ty_mm\tz_mm\trx_rad\try_rad\trz_rad\n1.5\t2\t3\t0.1\t0.2\t0.3\n",
            "\"x_mm\",\"y_mm\",\"z_mm\",\"rx_rad\",\"ry_rad\",\"rz_rad\"\n\"1.5\",2,3,0.1,0.2,0.3\n",
        ];
        let expected = Pose::new(Vector3::new(0.0015, 0.002, 0.003), Vector3::new(0.1, 0.2, 0.3));
        for text in texts {
            let read = Columns::parse(text, "").and_then(|columns| columns.poses("", None));
            let [read] = read.expect(text)[..] else { panic!("{text}") };
            let off = expected.inv_mul(&read);
            assert!(off.translation.vector.norm() < 1e-12 && off.rotation.angle() < 1e-12, "{text}");
        }
    }
}
