//! The table of the library's generators and their classes, made from the code.

use mrroc::generator::{Class, Level, Uses};

use crate::usage::registry::{Row, rows};

impl Row {
    /// What it does: the first line of its file.
    fn summary(&self) -> &'static str {
        let line = self.source.lines().next().unwrap_or_default().trim_start_matches("//!").trim();
        line.trim_end_matches('.')
    }

    /// Lines of code without comments, blank lines and tests.
    fn lines(&self) -> usize {
        let code = self.source.split_once("#[cfg(test)]").map_or(self.source, |(code, _)| code);
        code.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
    }
}

/// What a step uses besides the function's own state.
fn uses(level: Level, uses: Uses) -> String {
    let order = level == Level::Ecp && uses.order;
    let used =
        [(order, "order"), (uses.robots, "robots"), (uses.sensors, "sensors"), (uses.tick, "path time")];
    let used: Vec<_> = used.into_iter().filter_map(|(uses, name)| uses.then_some(name)).collect();
    if used.is_empty() { "nothing".to_owned() } else { used.join(", ") }
}

/// The table, in Markdown.
pub fn table() -> String {
    let mut table = String::from(
        "| generator | what it does | level | class | first step uses | next steps use | lines |\n|---|---|---|---|---|---|---|\n",
    );
    for row in rows() {
        let Class { level, first, next, .. } = row.class;
        let class = Class::new(level, next).to_string();
        let (name, function) = class.split_once(' ').unwrap_or(("", &class));
        let (first, next) = (uses(level, first), uses(level, next));
        let (kind, what, lines) = (row.type_name, row.summary(), row.lines());
        table += &format!("| [`{kind}`] | {what} | {name} | `{function}` | {first} | {next} | {lines} |\n");
    }
    table
}
