//! Files that are written as a whole.

use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::Path;

/// Puts a text in the place of a file's: whoever reads it meanwhile reads the old one or the new one. It is written into a new file
/// beside it, with `.new` behind its name, never into one that is there, or that a link of this name leads to.
///
/// # Errors
/// The file beside it cannot be made, written or renamed.
///
/// # Example
/// ```
/// use mrroc::files::replace;
///
/// # let folder = std::env::temp_dir().join(format!("mrroc-files-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder)?;
/// let file = folder.join("poses.txt");
/// replace(&file, "one\n")?;
/// replace(&file, "two\n")?;
/// assert_eq!(std::fs::read_to_string(&file)?, "two\n");
/// # std::fs::remove_dir_all(&folder)?;
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn replace(file: &Path, text: &str) -> io::Result<()> {
    let mut beside = file.as_os_str().to_owned();
    beside.push(".new");
    let beside = Path::new(&beside);
    // One that a program left which was killed, or a link: what it leads to is left alone.
    match fs::remove_file(beside) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        Ok(()) | Err(_) => {}
    }
    let mut new = OpenOptions::new().write(true).create_new(true).open(beside)?;
    new.write_all(text.as_bytes())?;
    fs::rename(beside, file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn fault_203_a_link_beside_a_file_leads_no_text_elsewhere() {
        let folder = std::env::temp_dir().join(format!("mrroc-core-files-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let (elsewhere, file) = (folder.join("elsewhere"), folder.join("arm.txt"));
        fs::write(&elsewhere, "kept").expect("written");
        for beside in ["arm.txt.new", "arm.txt"] {
            std::os::unix::fs::symlink(&elsewhere, folder.join(beside)).expect("a link");
            replace(&file, "poses").expect("replaced");
            assert_eq!(fs::read_to_string(&elsewhere).expect("read"), "kept", "{beside}");
            assert_eq!(fs::read_to_string(&file).expect("read"), "poses", "{beside}");
            assert!(!fs::symlink_metadata(&file).expect("there").is_symlink());
            fs::remove_file(&file).expect("removed");
        }
        fs::remove_dir_all(&folder).expect("removed");
    }
}
