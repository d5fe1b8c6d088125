//! How many lines the task's programs and generators have.
//!
//! A line counts if it is neither blank nor a comment alone. Of a generator all lines of its functions count, from `fn` to
//! the closing brace; of a program those of its functions' bodies. The functions of the path are no part of a generator and
//! are counted apart.

use core::fmt;

/// Lines of code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Of an arm's generator that only transmits.
    pub transmit: usize,
    /// Of the coordinator's generator, which makes of the body's trajectory those of both arms.
    pub trajectory: usize,
    /// Of the path that this generator and the arms' go along: the functions of `paths.rs`.
    pub path: usize,
    /// Of the coordinator's program and the programs of arms and hands together.
    pub programs: usize,
}

/// The most that there may be. The paper needs 15 lines of C to transmit and fewer than 100 for the trajectory; generator and
/// path together are to be fewer, too.
pub const LIMITS: Counts = Counts { transmit: 5, trajectory: 40, path: 60, programs: 30 };

impl Counts {
    /// Counts the sources of this task, as they were compiled.
    #[must_use]
    pub fn of_this_task() -> Counts {
        let transmit = include_str!("generators/ecp_common.rs");
        let trajectory = include_str!("generators/mp_common.rs");
        let path = include_str!("paths.rs");
        let mp = include_str!("mp.rs");
        let ecp = include_str!("ecp.rs");
        // The body of a function is all of it but its first and its last line.
        let bodies = |source: &str, names: &[&str]| -> usize {
            names.iter().map(|name| body(&function(source, name))).sum()
        };
        let all = |source: &str, names: &[&str]| -> usize {
            names.iter().map(|name| lines(&function(source, name))).sum()
        };
        Counts {
            transmit: all(transmit, &["next_step"]),
            trajectory: all(trajectory, &["along", "grasp", "carry"]),
            path: all(path, &["between", "duration", "pose", "soft"]),
            programs: bodies(mp, &["coordinate"]) + bodies(ecp, &["arm", "hand"]),
        }
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Counts { transmit, trajectory, path, programs } = self;
        writeln!(
            f,
            "lines of code: {transmit} to transmit (at most {}), {trajectory} of the generator of the trajectory (at most {}),",
            LIMITS.transmit, LIMITS.trajectory
        )?;
        write!(
            f,
            "  {path} of its path's functions, apart (at most {}), {programs} of both main programs (at most {})",
            LIMITS.path, LIMITS.programs
        )
    }
}

/// The lines of the function `name`, from `fn` to its closing brace, which stands where `fn` begins its line.
fn function<'a>(source: &'a str, name: &str) -> Vec<&'a str> {
    let begins = |line: &str| {
        let line = line.trim_start().trim_start_matches("pub ").trim_start_matches("const ");
        line.strip_prefix("fn ")
            .and_then(|rest| rest.strip_prefix(name))
            .is_some_and(|rest| rest.starts_with('(') || rest.starts_with('<'))
    };
    let from = source.lines().skip_while(|line| !begins(line));
    let indent = from.clone().next().map_or(0, |line| line.len() - line.trim_start().len());
    let mut lines = Vec::new();
    for line in from {
        lines.push(line);
        if line.len() == indent + 1 && line.ends_with('}') {
            break;
        }
    }
    lines
}

fn lines(of: &[&str]) -> usize {
    of.iter().map(|line| line.trim()).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

/// Lines after the one that ends with the opening brace, without the closing one.
fn body(function: &[&str]) -> usize {
    let head = function.iter().position(|line| line.ends_with('{')).map_or(0, |i| i + 1);
    lines(function.get(head..function.len().saturating_sub(1)).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_blank_lines_do_not_count_and_a_function_ends_with_its_brace() {
        let source = "fn other() {}\n    pub fn one<R>(\n        a: R,\n    ) {\n        // why\n\n        if a {\n            b();\n        }\n    }\n}\nfn two() {\n";
        let one = function(source, "one");
        assert_eq!((lines(&one), body(&one)), (7, 3));
        assert_eq!(function(source, "three").len(), 0);
    }
}
