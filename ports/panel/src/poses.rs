//! The poses that this panel teaches: a text file for each robot, beside the file of the cell, which programs read and people edit.
//!
//! In: a name, and the joint positions of a robot that stands. Out: the file; lines that are not touched stay as they are. It has the
//! form that `mrroc_generators::teach::Taught` reads:
//!
//! ```text
//! space joint
//! reference absolute
//! # name = velocity acceleration : coordinates
//! pick = 0.5 0.5 : 0 -1.57 0.16 -0.16 4.71 0
//! ```

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use mrroc_core::fault::Name;
use mrroc_core::files::replace;
use mrroc_launch::files;

/// What a new file begins with.
const HEAD: &str =
    "space joint\nreference absolute\n# name = velocity acceleration : coordinates [rad or m]\n";

/// Shares of the largest velocity and acceleration with which a program goes to a pose, until somebody edits them.
const SHARES: &str = "0.5 0.5";

/// The most poses of a robot.
const MOST: usize = 200;

/// A pose of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    pub name: Name,
    /// Joint positions [rad or m].
    pub joints: Vec<f64>,
}

/// The files of a cell.
#[derive(Debug)]
pub struct Poses {
    cell: PathBuf,
    /// One changes them at a time.
    changes: Mutex<()>,
}

impl Poses {
    /// Of the cell of a file.
    pub fn of(cell: &Path) -> Poses {
        Poses { cell: cell.to_owned(), changes: Mutex::new(()) }
    }

    /// The poses of a robot, in the order of its file; none if there is no file.
    ///
    /// # Errors
    /// The file cannot be read, or has poses of another form.
    pub fn of_robot(&self, robot: &str) -> Result<Vec<Pose>, String> {
        let file = files::poses(&self.cell, robot);
        match fs::read_to_string(&file) {
            Ok(text) => read(&text).map_err(|why| format!("{}: {why}", file.display())),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
            Err(error) => Err(format!("{}: {error}", file.display())),
        }
    }

    /// Teaches a robot a pose, in the place of the one that had this name; the file that it is in.
    ///
    /// # Errors
    /// The file cannot be read or written, has poses of another form, or is full.
    pub fn teach(&self, robot: &str, name: Name, joints: &[f64]) -> Result<PathBuf, String> {
        self.change(robot, |text| taught(text, name, joints))
    }

    /// Forgets a pose.
    ///
    /// # Errors
    /// As of [`teach`](Poses::teach); or there is no such pose.
    pub fn forget(&self, robot: &str, name: Name) -> Result<PathBuf, String> {
        self.change(robot, |text| changed(text, name, |_| None))
    }

    /// Gives a pose another name.
    ///
    /// # Errors
    /// As of [`forget`](Poses::forget); or another pose has that name.
    pub fn rename(&self, robot: &str, name: Name, to: Name) -> Result<PathBuf, String> {
        self.change(robot, |text| {
            if read(text)?.iter().any(|pose| pose.name == to) {
                return Err(format!("there is a pose `{to}` already"));
            }
            changed(text, name, |rest| Some(format!("{to} ={rest}")))
        })
    }

    fn change(
        &self,
        robot: &str,
        change: impl FnOnce(&str) -> Result<String, String>,
    ) -> Result<PathBuf, String> {
        let _turn = self.changes.lock().unwrap_or_else(PoisonError::into_inner);
        let file = files::poses(&self.cell, robot);
        let told = |why: &dyn core::fmt::Display| format!("{}: {why}", file.display());
        let before = match fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => HEAD.to_owned(),
            Err(error) => return Err(told(&error)),
        };
        let after = change(&before).map_err(|why| told(&why))?;
        let folder = file.parent().map_or(Ok(()), fs::create_dir_all);
        folder.and_then(|()| replace(&file, &after)).map_err(|error| told(&error))?;
        Ok(file)
    }
}

/// How the lines of a text end.
fn line_end(text: &str) -> &'static str {
    if text.contains("\r\n") { "\r\n" } else { "\n" }
}

/// What stands behind the name of a line and its `=`, if it has one.
fn after_name(line: &str) -> Option<(&str, &str)> {
    let content = line.split('#').next().unwrap_or("");
    let (name, _) = content.split_once('=')?;
    line.split_once('=').map(|(_, rest)| (name.trim(), rest))
}

/// The poses with names in the text of a file.
fn read(text: &str) -> Result<Vec<Pose>, String> {
    let mut lines =
        text.lines().map(|line| line.split('#').next().unwrap_or("").trim()).filter(|line| !line.is_empty());
    for head in ["space joint", "reference absolute"] {
        let line = lines.next().unwrap_or("");
        if line.split_whitespace().ne(head.split(' ')) {
            return Err(format!("its poses are of another form: `{head}` must stand where `{line}` does"));
        }
    }
    let pose = |line: &str| {
        let (name, rest) = after_name(line)?;
        let joints = rest.split_once(':')?.1.split_whitespace().map(|word| word.parse().ok());
        Some(Pose { name: Name::new(name).ok()?, joints: joints.collect::<Option<_>>()? })
    };
    // A pose without a name, or one that is wrong, is the program's to tell of.
    Ok(lines.filter_map(pose).take(MOST).collect())
}

/// The text with one more pose, or another one of that name.
fn taught(text: &str, name: Name, joints: &[f64]) -> Result<String, String> {
    let poses = read(text)?;
    if let Some(other) = poses.iter().find(|pose| pose.joints.len() != joints.len()) {
        return Err(format!("its poses have {} joints, this robot has {}", other.joints.len(), joints.len()));
    }
    let coordinates: String = joints.iter().map(|q| format!(" {q}")).collect();
    let line = format!(" {SHARES} :{coordinates}");
    if poses.iter().any(|pose| pose.name == name) {
        return changed(text, name, |_| Some(format!("{name} ={line}")));
    }
    if poses.len() >= MOST {
        return Err(format!("it has {MOST} poses already: delete one first"));
    }
    let line_end = line_end(text);
    let end = if text.is_empty() || text.ends_with('\n') { "" } else { line_end };
    Ok(format!("{text}{end}{name} ={line}{line_end}"))
}

/// The text with the line of a pose changed, or without it.
fn changed(text: &str, name: Name, change: impl Fn(&str) -> Option<String>) -> Result<String, String> {
    read(text)?;
    let mut found = false;
    let line = |line: &str| match after_name(line) {
        Some((known, rest)) if known == name.as_str() => {
            found = true;
            change(rest)
        }
        _ => Some(line.to_owned()),
    };
    let (lines, end): (Vec<String>, _) = (text.lines().filter_map(line).collect(), line_end(text));
    if found { Ok(lines.join(end) + end) } else { Err(format!("there is no pose `{name}`")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_generators::teach::{Reference, Space, Taught};

    fn name(text: &str) -> Name {
        Name::new(text).expect("a name")
    }

    #[test]
    fn what_a_page_teaches_a_program_reads_to_the_bit() {
        let joints = [0.1 + 0.2, -1.57, 1e-17, 4.71];
        let text =
            taught(HEAD, name("pick"), &joints).and_then(|text| taught(&text, name("place"), &[1.0; 4]));
        let text = text.expect("taught");
        let read_by_program: Taught = text.parse().expect("in order");
        assert_eq!((read_by_program.space, read_by_program.reference), (Space::Joint, Reference::Absolute));
        assert_eq!(read_by_program.select(&["pick"]).expect("there").poses[0].coordinates(), joints);
        assert_eq!(read(&text).expect("in order")[0], Pose { name: name("pick"), joints: joints.to_vec() });
        // A program writes what the panel reads, too.
        assert_eq!(read(&read_by_program.to_string()).map(|poses| poses.len()), Ok(2));
    }

    #[test]
    fn a_file_that_people_edit_keeps_their_lines() {
        let edited = "# of cell 3\nspace  joint # joints\nreference absolute\n\n0.1 0.1 : 1 2\nhome = 0.2 0.3 : 0 0 # the morning's\nend = 0.2 0.2 : 5 6";
        let text = taught(edited, name("pick"), &[1.0, 2.5]).expect("taught");
        assert_eq!(text, format!("{edited}\npick = 0.5 0.5 : 1 2.5\n"));
        let text = taught(&text, name("end"), &[7.0, 8.0]).expect("taught again");
        assert!(text.contains("\nend = 0.5 0.5 : 7 8\npick"), "{text}");
        let text = changed(&text, name("home"), |rest| Some(format!("rest ={rest}"))).expect("renamed");
        assert!(text.contains("\nrest = 0.2 0.3 : 0 0 # the morning's\n"), "{text}");
        let text = changed(&text, name("rest"), |_| None).expect("forgotten");
        assert!(text.contains("\n0.1 0.1 : 1 2\nend = "), "{text}");
        assert_eq!(text.parse::<Taught>().map(|taught| taught.poses.len()), Ok(3));
    }

    #[test]
    fn a_file_with_the_line_ends_of_windows_is_read_and_keeps_them() {
        let edited = "space joint\r\nreference absolute\r\nhome = 0.2 0.3 : 0 0\r\n";
        let text = taught(edited, name("pick"), &[1.0, 2.5]).expect("taught");
        assert_eq!(text, format!("{edited}pick = 0.5 0.5 : 1 2.5\r\n"));
        assert_eq!(read(&text).expect("in order")[1].joints, [1.0, 2.5]);
        let text = changed(&text, name("home"), |rest| Some(format!("rest ={rest}"))).expect("renamed");
        assert_eq!(text, format!("{edited}pick = 0.5 0.5 : 1 2.5\r\n").replace("home", "rest"));
        let read_by_program: Taught = text.parse().expect("in order");
        assert_eq!(read_by_program.select(&["rest"]).expect("there").poses[0].coordinates(), [0.0, 0.0]);
    }

    #[test]
    fn what_does_not_fit_is_refused_with_why() {
        let of_tool = "space angle-axis\nreference absolute\n";
        let full: String = (0..MOST).fold(HEAD.to_owned(), |text, i| text + &format!("p{i} = 1 1 : 0 0\n"));
        for (outcome, told) in [
            (taught(of_tool, name("a"), &[0.0; 6]), "of another form"),
            (
                taught("space joint\nreference absolute\nhome = 1 1 : 0 0 0\n", name("a"), &[0.0; 2]),
                "have 3 joints",
            ),
            (taught(&full, name("a"), &[0.0; 2]), "200 poses already"),
            (changed(HEAD, name("a"), |_| None), "there is no pose `a`"),
        ] {
            let why = outcome.expect_err("refused");
            assert!(why.contains(told), "{why}");
        }
    }
}
