//! Files of taught poses, of this library and of MRROC++.

use core::fmt;
use core::str::FromStr;

use mrroc::console::quoted;
use mrroc::fault::Name;
use thiserror::Error;

use super::{MAX_COORDINATES, Reference, Space, Taught, TaughtPose};

/// Why a file of taught poses cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("line {line}: {}", quoted(reason, 200))]
pub struct BadFile {
    /// The line, from 1; the last one where something is missing.
    pub line: usize,
    /// What is wrong there.
    pub reason: String,
}

fn bad<T>(line: usize, reason: impl Into<String>) -> Result<T, BadFile> {
    Err(BadFile { line, reason: reason.into() })
}

/// A line's words, and its number from 1.
type Line<'a> = (usize, Vec<&'a str>);

/// Words of a line that are looked at: more than any line may have, and no more memory for one that is longer.
const MOST_WORDS: usize = 2 * MAX_COORDINATES + 4;

/// Lines that hold something, without comments.
fn lines<'a>(text: &'a str, comment: &'a str) -> impl Iterator<Item = Line<'a>> {
    let content = move |line: &'a str| {
        line.split(comment).next().unwrap_or("").split_whitespace().take(MOST_WORDS).collect()
    };
    text.lines()
        .enumerate()
        .map(move |(i, line)| (i + 1, content(line)))
        .filter(|(_, words): &Line| !words.is_empty())
}

fn numbers((line, words): &Line<'_>) -> Result<Vec<f64>, BadFile> {
    let number = |word: &&str| match word.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) | Err(_) => bad(*line, format!("`{word}` is no finite number")),
    };
    let numbers: Vec<f64> = words.iter().map(number).collect::<Result<_, _>>()?;
    if (1..=MAX_COORDINATES).contains(&numbers.len()) {
        return Ok(numbers);
    }
    bad(*line, format!("{} numbers, there must be 1 to {MAX_COORDINATES}", numbers.len()))
}

/// The pose of a line, which must have as many coordinates as those before it.
fn add(
    poses: &mut Vec<TaughtPose>,
    space: Space,
    line: usize,
    velocity: f64,
    acceleration: f64,
    coordinates: &[f64],
) -> Result<(), BadFile> {
    for (name, share) in [("velocity", velocity), ("acceleration", acceleration)] {
        if !(share > 0.0 && share <= 1.0) {
            return bad(
                line,
                format!("the {name} {share} is no share of the largest one, above 0 and up to 1"),
            );
        }
    }
    let expected = match space {
        Space::Zyz | Space::AngleAxis => Some(6),
        Space::Motor | Space::Joint => poses.first().map(|pose| pose.coordinates().len()),
    };
    if let Some(expected) = expected.filter(|expected| *expected != coordinates.len()) {
        return bad(line, format!("{} coordinates, there must be {expected}", coordinates.len()));
    }
    match TaughtPose::new(velocity, acceleration, coordinates) {
        Some(pose) => poses.push(pose),
        None => return bad(line, "no pose"),
    }
    Ok(())
}

impl Taught {
    /// Reads an MRROC++ `.trj` file.
    ///
    /// # Errors
    /// The first line that is wrong, and why.
    pub fn from_trj(text: &str) -> Result<Self, BadFile> {
        let last = text.lines().count().max(1);
        let mut lines = lines(text, "//");
        let mut head: Vec<(usize, &str)> = Vec::new();
        while head.len() < 3 {
            let Some((line, words)) = lines.next() else {
                return bad(last, "the head ends early: space, number of poses, ABSOLUTE or RELATIVE");
            };
            head.extend(words.into_iter().map(|word| (line, word)));
        }
        let [(space_line, space), (count_line, count), (reference_line, reference), more @ ..] = &head[..]
        else {
            return bad(last, "the head ends early");
        };
        if let Some((line, word)) = more.first() {
            return bad(*line, format!("`{word}` after the head"));
        }
        let space = match *space {
            "MOTOR" => Space::Motor,
            "JOINT" => Space::Joint,
            "XYZ_EULER_ZYZ" => Space::Zyz,
            "XYZ_ANGLE_AXIS" => Space::AngleAxis,
            other => {
                return bad(
                    *space_line,
                    format!("`{other}` is not MOTOR, JOINT, XYZ_EULER_ZYZ or XYZ_ANGLE_AXIS"),
                );
            }
        };
        let Ok(count) = count.parse::<usize>() else {
            return bad(*count_line, format!("`{count}` is no number of poses"));
        };
        let reference = match *reference {
            "ABSOLUTE" => Reference::Absolute,
            "RELATIVE" => Reference::Relative,
            other => return bad(*reference_line, format!("`{other}` is neither ABSOLUTE nor RELATIVE")),
        };
        // Room for all that can be there, so that a long list is not copied as it grows; a head may announce more than there is.
        let mut poses = Vec::with_capacity(count.min(last / 3).min(1 << 20));
        for number in 1..=count {
            let mut row = |what: &str| match lines.next() {
                Some(line) => Ok((line.0, numbers(&line)?)),
                None => bad(last, format!("pose {number} of {count} has no row of {what}")),
            };
            let least = |row: &[f64]| row.iter().copied().fold(f64::INFINITY, f64::min);
            let ((v_line, v), (a_line, a)) = (row("velocities")?, row("accelerations")?);
            let (line, coordinates) = row("coordinates")?;
            for (row_line, row) in [(v_line, &v), (a_line, &a)] {
                if row.len() != coordinates.len() {
                    let here = row.len();
                    let there = coordinates.len();
                    return bad(row_line, format!("{here} shares for {there} coordinates"));
                }
                if let Some(share) = row.iter().find(|share| !(**share > 0.0 && **share <= 1.0)) {
                    return bad(
                        row_line,
                        format!("{share} is no share of the largest one, above 0 and up to 1"),
                    );
                }
            }
            add(&mut poses, space, line, least(&v), least(&a), &coordinates)?;
        }
        match lines.next() {
            Some((line, _)) => bad(line, format!("more than the {count} poses that the head announces")),
            None => Ok(Taught { space, reference, poses }),
        }
    }
}

impl fmt::Display for Taught {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let space = match self.space {
            Space::Motor => "motor",
            Space::Joint => "joint",
            Space::Zyz => "zyz",
            Space::AngleAxis => "angle-axis",
        };
        let reference = match self.reference {
            Reference::Absolute => "absolute",
            Reference::Relative => "relative",
        };
        let named = self.poses.iter().any(|pose| pose.name.is_some());
        let names = if named { "name = " } else { "" };
        writeln!(f, "space {space}\nreference {reference}\n# {names}velocity acceleration : coordinates")?;
        for pose in &self.poses {
            if let Some(name) = pose.name {
                write!(f, "{name} = ")?;
            }
            write!(f, "{} {} :", pose.velocity, pose.acceleration)?;
            for x in pose.coordinates() {
                write!(f, " {x}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

impl FromStr for Taught {
    type Err = BadFile;

    fn from_str(text: &str) -> Result<Self, BadFile> {
        let last = text.lines().count().max(1);
        let mut lines = lines(text, "#");
        let mut named = |name: &str| match lines.next() {
            Some((line, words)) => match words[..] {
                [word, value] if word == name => Ok((line, value)),
                _ => bad(line, format!("`{name} ..` must stand here")),
            },
            None => bad(last, format!("there is no `{name} ..`")),
        };
        let space = match named("space")? {
            (_, "motor") => Space::Motor,
            (_, "joint") => Space::Joint,
            (_, "zyz") => Space::Zyz,
            (_, "angle-axis") => Space::AngleAxis,
            (line, other) => return bad(line, format!("`{other}` is not motor, joint, zyz or angle-axis")),
        };
        let reference = match named("reference")? {
            (_, "absolute") => Reference::Absolute,
            (_, "relative") => Reference::Relative,
            (line, other) => return bad(line, format!("`{other}` is neither absolute nor relative")),
        };
        // As in `from_trj`.
        let mut poses = Vec::with_capacity(text.lines().count().min(1 << 20));
        for (line, words) in lines {
            let (name, words) = match &words[..] {
                [name, "=", words @ ..] => (Some(name), words),
                words => (None, words),
            };
            let [v, a, ":", coordinates @ ..] = words else {
                return bad(
                    line,
                    "a pose is written `velocity acceleration : coordinates`, after a name `home =` or not",
                );
            };
            let shares = numbers(&(line, vec![*v, *a]))?;
            let coordinates = numbers(&(line, coordinates.to_vec()))?;
            add(&mut poses, space, line, shares[0], shares[1], &coordinates)?;
            if let (Some(name), Some(pose)) = (name, poses.last_mut()) {
                let name = Name::new(name).or_else(|error| bad(line, error.to_string()))?;
                *pose = pose.named(name);
                if poses[..poses.len() - 1].iter().any(|before| before.name == Some(name)) {
                    return bad(line, format!("two poses have the name `{name}`"));
                }
            }
        }
        Ok(Taught { space, reference, poses })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRJ: &str = "JOINT\n2\nABSOLUTE\n0.1 0.2\n0.07 0.07\n0 -1.57\n\n0.1 0.1\n0.1 0.07\n0.5 -1.5\n";

    #[test]
    fn a_trj_file_is_read_with_the_least_of_its_shares() {
        let taught = Taught::from_trj(TRJ).expect("in order");
        assert_eq!((taught.space, taught.reference), (Space::Joint, Reference::Absolute));
        let poses: Vec<_> =
            taught.poses.iter().map(|p| (p.velocity, p.acceleration, p.coordinates())).collect();
        assert_eq!(poses, [(0.1, 0.07, &[0.0, -1.57][..]), (0.1, 0.07, &[0.5, -1.5])]);
        let on_one_line = TRJ.replacen('\n', " ", 2);
        assert_eq!(Taught::from_trj(&on_one_line), Ok(taught));
    }

    #[test]
    fn what_is_written_is_read_again_to_the_bit() {
        for (space, c) in [(Space::Zyz, &[0.1, -2e-17, 1.0 / 3.0, 3.0, 2.0, 1.0][..]), (Space::Joint, &[0.7])]
        {
            let pose = TaughtPose::new(0.15, 1.0 / 7.0, c).expect("in range");
            let mut taught = Taught { space, reference: Reference::Relative, poses: vec![pose; 3] };
            assert_eq!(taught.to_string().parse(), Ok(taught.clone()));
            taught.poses[1] = pose.named(Name::new("pick").expect("a name"));
            assert_eq!(taught.to_string().parse(), Ok(taught));
        }
    }

    #[test]
    fn bad_files_are_refused_with_the_line_and_the_reason() {
        let edited = |from: &str, to: &str| Taught::from_trj(&TRJ.replacen(from, to, 1));
        for (file, line, reason) in [
            (edited("JOINT", "JOINTS"), 1, "`JOINTS` is not"),
            (edited("2\n", "two\n"), 2, "`two` is no number of poses"),
            (edited("ABSOLUTE", "absolute"), 3, "`absolute` is neither"),
            (edited("2\n", "3\n"), 10, "pose 3 of 3 has no row of velocities"),
            (edited("2\n", "1\n"), 8, "more than the 1 poses"),
            (edited("-1.57", "-1,57"), 6, "`-1,57` is no finite number"),
            (edited("-1.57", "nan"), 6, "`nan` is no finite number"),
            (edited("0.1 0.2", "0.1 1.2"), 4, "1.2 is no share"),
            (edited("0.1 0.2", "0.1"), 4, "1 shares for 2 coordinates"),
            (edited("0.1 0.1\n0.1 0.07\n0.5 -1.5", "0.1\n0.1\n0.5"), 10, "1 coordinates, there must be 2"),
            (edited("JOINT", "XYZ_EULER_ZYZ"), 6, "2 coordinates, there must be 6"),
            (Taught::from_trj(""), 1, "the head ends early"),
            ("space joint\n\n0.1 0.1 : 1\n".parse(), 3, "`reference ..` must stand here"),
            ("space joint\nreference relative\n0.1 : 1\n".parse(), 3, "a pose is written"),
            (
                "space joint\nreference relative\na = 0.1 0.1 : 1\na = 0.1 0.1 : 2\n".parse(),
                4,
                "two poses have the name",
            ),
            ("space joint\nreference relative\na.b = 0.1 0.1 : 1\n".parse(), 3, "`a.b` is no name"),
            ("space cube\nreference relative\n".parse(), 1, "`cube` is not"),
            ("space joint\nreference relative\n0 0.1 : 1\n".parse(), 3, "the velocity 0 is no share"),
        ] {
            let error = file.expect_err(reason);
            assert!(error.line == line && error.reason.contains(reason), "{error}");
        }
    }
}
