//! The segment that the nodes of a session count themselves in, made before any node is.
//!
//! iceoryx2 lets all users write to this one segment, whatever the umask says, and the first node makes it. So the launcher makes it in
//! place of that node, as iceoryx2 would: a file that only its user may open, from the moment in which it exists. What iceoryx2 makes is known
//! for the version that is used, and a test compares it.

use std::fs::OpenOptions;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use super::fabric::LinkError;
use crate::machine::capacity::SHARED_MEMORY;

/// Its name behind the prefix of a session.
const NAME: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";

/// What is in it behind its first node, which is gone: the version, and the count of nodes that there have been.
const EMPTY: [u8; 16] = [0, 0, 10, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0];

/// Makes the segment for the nodes of a session whose shared memory has this prefix.
///
/// # Errors
/// [`LinkError`]: it could not be made, or a file of its name is there.
pub(crate) fn make_management(prefix: &str) -> Result<(), LinkError> {
    let path = Path::new(SHARED_MEMORY).join(format!("{prefix}{NAME}"));
    // Nothing is followed that is a link, and nothing opened that is there.
    let made = OpenOptions::new().write(true).create_new(true).mode(0o600).open(path);
    made.and_then(|mut file| file.write_all(&EMPTY)).map_err(LinkError::of("its management segment"))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::os::unix::fs::{MetadataExt, PermissionsExt};

    use super::*;
    use crate::link::fabric::node;

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
        // As iceoryx2 leaves its own behind its only node.
        let own = Segments(format!("mrroc_management_own_{}_", std::process::id()));
        drop(node(&root, &own.0, "first").expect("a node"));
        let made = own.all();
        assert_eq!(made.len(), 1, "{made:?}");
        assert!(made[0].ends_with(format!("{}{NAME}", own.0)), "iceoryx2 calls it otherwise: {made:?}");
        assert_eq!(fs::read(&made[0]).expect("read"), EMPTY, "iceoryx2 has something else in it");
        make_management(&segments.0).expect("a segment");
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
        assert!(make_management(&segments.0).is_err());
        drop(fs::remove_dir_all(root));
    }
}
