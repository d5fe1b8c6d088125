//! What two machines compare before anything moves, and where a machine has its certificate.

use std::fs::File;
use std::hash::{DefaultHasher, Hasher};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mrroc_core::link::envelope::LAYOUT;

/// Version of what nodes say to one another; that of their processes' messages is beside it.
const VERSION: u64 = 1;

/// What must be the same on both machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Identity {
    /// Version of what nodes say.
    pub version: u64,
    /// Hash of the executable.
    pub program: u64,
    /// Hash of the cell's file.
    pub file: u64,
}

impl Identity {
    /// Of this process, for a cell file with this hash.
    pub fn here(file: u64) -> io::Result<Identity> {
        Ok(Identity { version: VERSION << 32 | LAYOUT, program: hash(Path::new("/proc/self/exe"))?, file })
    }

    /// What the node `name` has other than this one, and what to do about it.
    pub fn differs(self, other: Identity, name: &str) -> Option<String> {
        if self.version != other.version {
            return Some(format!(
                "it speaks version {}.{} of this protocol, and node {name} {}.{}\n help: build both from one version of mrroc",
                self.version >> 32,
                self.version & u64::from(u32::MAX),
                other.version >> 32,
                other.version & u64::from(u32::MAX)
            ));
        }
        if self.program != other.program {
            return Some(format!(
                "its program is another one than that of node {name} ({:016x}, {:016x})\n help: copy the executable to both machines",
                self.program, other.program
            ));
        }
        (self.file != other.file).then(|| {
            format!(
                "its cell.toml is another one than that of node {name}\n help: copy the file to both machines"
            )
        })
    }
}

/// A hash of a file's bytes. It tells files apart that nobody has made alike on purpose.
fn hash(file: &Path) -> io::Result<u64> {
    let mut file = File::open(file)?;
    let mut hasher = DefaultHasher::new();
    let mut bytes = vec![0; 1 << 20];
    loop {
        match file.read(&mut bytes)? {
            0 => return Ok(hasher.finish()),
            count => hasher.write(&bytes[..count]),
        }
    }
}

/// The folder in which the node of a cell file has its certificate.
pub(crate) fn keys(cell: &Path) -> PathBuf {
    cell.parent().unwrap_or(Path::new("")).join("certificates")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_142_what_differs_between_two_machines_is_told_with_what_to_do() {
        let own = Identity { version: 1 << 32 | 7, program: 5, file: 9 };
        assert_eq!(own.differs(own, "b"), None);
        for (other, told) in [
            (Identity { version: 1 << 32 | 8, ..own }, "version 1.7 of this protocol, and node b 1.8"),
            (
                Identity { program: 6, ..own },
                "another one than that of node b (0000000000000005, 0000000000000006)",
            ),
            (Identity { file: 8, ..own }, "its cell.toml is another one"),
        ] {
            let text = own.differs(other, "b").expect("different");
            assert!(text.contains(told) && text.contains("\n help: "), "{text}");
        }
    }
}
