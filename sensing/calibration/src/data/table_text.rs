//! The text of a table that is to be filled in: joint positions in the columns and units that its header tells, measurements empty.

use super::header::{Header, Which};
use super::section::At;

/// Decimals of joint positions, in the header's units: below a thousandth of what any controller is told.
const DECIMALS: usize = 5;

pub(super) struct TableText<'h> {
    header: &'h Header,
    names: Vec<String>,
    separator: char,
    /// What says that nothing was measured.
    missing: &'h str,
    text: String,
}

impl<'h> TableText<'h> {
    /// `names` is the row of names that is there already.
    pub(super) fn new(lines: &str, names: Option<&str>, header: &'h Header) -> Result<Self, String> {
        let missing = header.missing.iter().find(|text| text.is_empty()).or(header.missing.first());
        let missing = missing.map_or("", String::as_str);
        if header.form.separator.is_none() && missing.is_empty() {
            let help = "write missing = [\"-\"] into the header, or another separator";
            return Err(format!("between blanks an empty cell cannot be seen\n help: {help}"));
        }
        let separator = header.form.separator.unwrap_or(' ');
        let split = |row: &str| -> Vec<String> {
            let cells: Vec<&str> = match header.form.separator {
                Some(separator) => row.split(separator).collect(),
                None => row.split_whitespace().collect(),
            };
            cells.into_iter().map(|cell| cell.trim().trim_matches('"').to_owned()).collect()
        };
        let named = header.columns.clone().or(names.map(split));
        let names = named.unwrap_or_else(|| all_columns(header));
        let mut text = lines.trim_end().to_owned() + "\n";
        if header.columns.is_none() {
            text += &(names.join(&separator.to_string()) + "\n");
        }
        Ok(Self { header, names, separator, missing, text })
    }

    pub(super) fn row(&mut self, q: &[f64], point: &str) {
        let joints = &self.header.joints;
        let cell = |name: &String| {
            if let Some(i) = joints.columns.iter().position(|column| column.value == *name) {
                let read = (q[i] - joints.offsets[i]) / joints.factors[i];
                let text = format!("{read:.DECIMALS$}");
                return text.replace('.', &self.header.form.point.to_string());
            }
            let names_points = self.header.measures.iter().any(|measure| match &measure.which {
                Which::Column(column) => column.value == *name,
                Which::Always(_) => false,
            });
            if names_points { point.to_owned() } else { self.missing.to_owned() }
        };
        let cells: Vec<String> = self.names.iter().map(cell).collect();
        self.text += &(cells.join(&self.separator.to_string()) + "\n");
    }

    pub(super) fn text(self) -> String {
        self.text
    }
}

/// The columns of which the header speaks: names of points, joints, measurements.
fn all_columns(header: &Header) -> Vec<String> {
    let which = header.measures.iter().filter_map(|measure| match &measure.which {
        Which::Column(column) => Some(column),
        Which::Always(_) => None,
    });
    let measured = header.measures.iter().flat_map(|measure| &measure.columns);
    let mut names: Vec<String> = Vec::new();
    for At { value, .. } in which.chain(&header.joints.columns).chain(measured) {
        if !names.contains(value) {
            names.push(value.clone());
        }
    }
    names
}
