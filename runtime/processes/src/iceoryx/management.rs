//! The segment that the nodes of a session count themselves in, made before any node is.
//!
//! iceoryx2 lets all users write to this one segment, whatever the umask says, and the first node makes it. So the
//! launcher lets iceoryx2 make one under a name that nobody uses, and copies it to the name that the nodes will find, in a
//! file that only its user may open. That file is the user's alone from the moment in which it exists.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use super::fabric::{LinkError, node};
use crate::session::SHARED_MEMORY;

/// The longest segment that is copied \[bytes\]; it has 16.
const LONGEST: u64 = 4096;

/// Makes the segment for the nodes of the session whose files are in the folder `root` and whose shared memory has this
/// prefix.
///
/// # Errors
/// [`LinkError`]: it could not be made, or a file of its name is there.
pub(crate) fn make_management(root: &Path, prefix: &str) -> Result<(), LinkError> {
    let other = format!("{prefix}first_");
    drop(node(root, &other, "first")?);
    for entry in fs::read_dir(SHARED_MEMORY).map_err(LinkError::of(SHARED_MEMORY))?.flatten() {
        let name = entry.file_name();
        let Some(rest) = name.to_str().and_then(|name| name.strip_prefix(&other)) else { continue };
        let copied = copy(&entry.path(), &Path::new(SHARED_MEMORY).join(format!("{prefix}{rest}")));
        let removed = fs::remove_file(entry.path());
        copied.and(removed).map_err(LinkError::of("its management segment"))?;
    }
    Ok(())
}

/// Copies a segment to a new file. Nothing is followed that is a link.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    let from = File::options().read(true).custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK).open(from)?;
    let mut to = OpenOptions::new().write(true).create_new(true).mode(0o600).open(to)?;
    let about = from.metadata()?;
    if !about.is_file() || about.len() > LONGEST {
        return Err(io::Error::other("another program has put a file in its place"));
    }
    io::copy(&mut io::Read::take(from, LONGEST), &mut to).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::{MetadataExt, PermissionsExt};

    /// The files of a test in shared memory, by their names; removed at its end.
    struct Segments(String);

    impl Segments {
        fn all(&self) -> Vec<std::path::PathBuf> {
            let all = fs::read_dir(SHARED_MEMORY).expect("shared memory").flatten();
            let is_its = |name: &std::ffi::OsStr| name.to_str().is_some_and(|name| name.starts_with(&self.0));
            all.filter(|entry| is_its(&entry.file_name())).map(|entry| entry.path()).collect()
        }
    }

    impl Drop for Segments {
        fn drop(&mut self) {
            self.all().into_iter().for_each(|path| drop(fs::remove_file(path)));
        }
    }

    #[test]
    fn fault_73_no_segment_is_open_to_other_users_before_or_after_its_nodes_are_made() {
        let root = std::env::temp_dir().join(format!("mrroc-m{}", std::process::id()));
        fs::create_dir_all(&root).expect("a folder");
        let segments = Segments(format!("mrroc_management_test_{}_", std::process::id()));
        make_management(&root, &segments.0).expect("a segment");
        let made = segments.all();
        assert_eq!(made.len(), 1, "the management segment and nothing else: {made:?}");
        let about = made[0].metadata().expect("there");
        assert_eq!(about.permissions().mode() & 0o7777, 0o600);
        // The nodes take it as it is: they make no other one, and leave its mode alone.
        let nodes = ["a", "b"].map(|name| node(&root, &segments.0, name).expect("a node"));
        assert_eq!(segments.all(), made);
        let now = made[0].metadata().expect("there");
        assert_eq!((now.ino(), now.permissions().mode() & 0o7777), (about.ino(), 0o600));
        drop(nodes);
        // A file of its name that was there before is neither opened nor changed.
        assert!(make_management(&root, &segments.0).is_err());
        drop(fs::remove_dir_all(root));
    }
}
