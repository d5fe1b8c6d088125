//! The files that a run reads, and those that it writes: nothing that is read is ever overwritten.
//!
//! In: the path of every file that is read, when it is opened; before anything moves, the paths of all that is to be
//! written. Out: nothing, or the first path that would overwrite a file that was read, under whatever name, or that is to
//! be written twice. A task program makes one run, so the list of what was read is the program's.
//!
//! A file that is not read is written anew without a question if it is a picture or a summary. A recording is written anew
//! only if it is one, or empty: `mrroc_recording` sees to that.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use mrroc_core::cell::Cell;
use mrroc_core::observe::Recording;

/// The file in which the operator's panel keeps the poses that it teaches a robot: `poses/left.txt` beside the file of the cell.
#[must_use]
pub fn poses(cell: &Path, robot: &str) -> PathBuf {
    cell.parent().unwrap_or(Path::new("")).join("poses").join(format!("{robot}.txt"))
}

/// What is told of a file that cannot be written, with the options by which another one is given.
pub(crate) fn unwritable(file: &Path, error: &io::Error, instead: &str) -> String {
    format!("{}: cannot be written: {error}\n help: give another file by {instead}", file.display())
}

/// The file to which a cell is to be recorded.
pub(crate) fn recorded(cell: &Cell) -> Option<&Path> {
    cell.recording().map(Recording::file)
}

/// What was read so far, by whole paths.
static READ: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A file that would be overwritten.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Overwrites {
    /// A file that the run reads.
    #[error(
        "{}: it is {}, which this run reads: it is not overwritten\n help: write to another file",
        output.display(),
        if output == read { "a file".to_owned() } else { read.display().to_string() }
    )]
    Read {
        /// The path that was to be written.
        output: PathBuf,
        /// The path by which the same file was read.
        read: PathBuf,
    },
    /// A file that the run writes as well.
    #[error("{}: two results are to be written there\n help: write each to a file of its own", output.display())]
    Written {
        /// The path of the second one.
        output: PathBuf,
    },
}

/// Opens a file that the run reads, and remembers that it does.
///
/// # Errors
/// What the system says.
pub fn open(path: impl AsRef<Path>) -> io::Result<File> {
    let path = path.as_ref();
    let file = File::open(path)?;
    remember(path);
    Ok(file)
}

/// Remembers a file that the run will read.
pub fn remember(path: impl AsRef<Path>) {
    let path = path.as_ref();
    // A whole path stays right when the program enters another folder.
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    if !read.contains(&path) {
        read.push(path);
    }
}

/// Checks that none of the files that are to be written is one that the run has read, nor one of the others. Devices and
/// pipes may be written to as often as one likes.
///
/// # Errors
/// [`Overwrites`]: the first one that is.
pub fn check_outputs<'a>(outputs: impl IntoIterator<Item = &'a Path>) -> Result<(), Overwrites> {
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    let mut written: Vec<Identity> = Vec::new();
    for output in outputs {
        let Some(identity) = Identity::of(output) else { continue };
        // Asked anew for each: another file may bear the name by now, or none.
        let is_it = |read: &&PathBuf| read.is_file() && Identity::of(read).as_ref() == Some(&identity);
        if let Some(read) = read.iter().find(is_it) {
            let is_same = std::path::absolute(output).is_ok_and(|output| output == *read);
            let read = if is_same { output.to_owned() } else { read.clone() };
            return Err(Overwrites::Read { output: output.to_owned(), read });
        }
        if written.contains(&identity) {
            return Err(Overwrites::Written { output: output.to_owned() });
        }
        written.push(identity);
    }
    Ok(())
}

/// What a file is, whatever its names; or where it will be made.
#[derive(PartialEq, Eq)]
enum Identity {
    /// Its device and its number there.
    #[cfg(unix)]
    Inode(u64, u64),
    /// A path without links.
    Path(PathBuf),
}

impl Identity {
    /// `None` for what is no ordinary file.
    fn of(path: &Path) -> Option<Identity> {
        match path.metadata() {
            #[cfg(unix)]
            Ok(file) if file.is_file() => {
                use std::os::unix::fs::MetadataExt;
                Some(Identity::Inode(file.dev(), file.ino()))
            }
            #[cfg(not(unix))]
            Ok(file) if file.is_file() => path.canonicalize().ok().map(Identity::Path),
            Ok(_) => None,
            Err(_) => {
                let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
                let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
                Some(Identity::Path(folder.join(path.file_name()?)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// A folder of its own for one test.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("mrroc-files-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join("inner")).expect("a folder");
        folder
    }

    fn refused<const N: usize>(outputs: [&Path; N]) -> String {
        check_outputs(outputs).expect_err("refused").to_string()
    }

    #[cfg(unix)]
    #[test]
    fn fault_70_what_was_read_is_refused_under_each_of_its_names() {
        let folder = folder("read");
        let [read, hard, soft, other] = ["read", "hard", "soft", "other"].map(|name| folder.join(name));
        for file in [&read, &other] {
            fs::write(file, "text").expect("a file");
        }
        fs::hard_link(&read, &hard).expect("a link");
        std::os::unix::fs::symlink(&read, &soft).expect("a link");
        assert_eq!(check_outputs([&*read, &*other]), Ok(()), "it has not been read yet");
        drop(open(folder.join("inner/../read")).expect("a file"));
        for name in [&read, &hard, &soft, &folder.join("inner/../soft")] {
            let told = refused([&*other, name]);
            assert!(told.contains("which this run reads") && told.contains("\n help: "), "{told}");
        }
        assert_eq!(check_outputs([&*other, Path::new("/dev/null"), Path::new("/dev/null")]), Ok(()));
        // What bears the name of a file that was read, and is another one, may be written.
        fs::remove_file(&read).expect("removed");
        assert_eq!(check_outputs([&*read]), Ok(()));
        fs::remove_dir_all(folder).expect("removed");
    }

    #[test]
    fn two_results_do_not_go_to_one_file() {
        let folder = folder("written");
        let [new, same] = ["new", "inner/../new"].map(|name| folder.join(name));
        assert!(refused([&*new, &*same]).contains("two results are to be written there"));
        fs::write(&new, "text").expect("a file");
        assert!(refused([&*new, &*same]).contains("two results are to be written there"));
        assert_eq!(check_outputs([&*new, &*folder.join("other")]), Ok(()));
        fs::remove_dir_all(folder).expect("removed");
    }
}
