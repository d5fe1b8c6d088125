//! Pictures of earlier runs in the folder of this one: those that it has not drawn are named, so that none is taken for its own.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Pictures that the program draws, besides `image-*.png`; `empty.png` and `raw-*.png` are images for `--images`.
const PICTURES: &[&str] = &[
    "belt.svg",
    "confusion.svg",
    "confusion-hard.svg",
    "confusion-usual.svg",
    "echoes.svg",
    "reliefs.svg",
    "reliefs-hard.svg",
    "reliefs-usual.svg",
    "scatter.svg",
    "time-line.svg",
];

fn is_picture(name: &str) -> bool {
    PICTURES.contains(&name) || name.starts_with("image-") && name.ends_with(".png")
}

/// Pictures in a folder that were written before `began`, in the order of their names.
#[must_use]
pub fn pictures(folder: &Path, began: SystemTime) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let is_old = |entry: &std::fs::DirEntry| {
        let written = entry.metadata().and_then(|data| data.modified());
        entry.file_name().to_str().is_some_and(is_picture) && written.is_ok_and(|written| written < began)
    };
    let mut left: Vec<_> = entries.filter(is_old).map(|entry| entry.path()).collect();
    left.sort();
    left
}

/// A line that names them; nothing where there are none.
#[must_use]
pub fn named(folder: &Path, began: SystemTime) -> String {
    let left: Vec<_> = pictures(folder, began).iter().map(|file| file.display().to_string()).collect();
    if left.is_empty() { String::new() } else { format!("of an earlier run: {}\n", left.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::time::Duration;

    #[test]
    fn pictures_that_were_there_before_are_named_and_other_files_are_not() {
        let folder = std::env::temp_dir().join(format!("mrroc-sorting-left-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let began = SystemTime::now();
        let (before, after) = (began - Duration::from_secs(9), began + Duration::from_secs(9));
        for (name, written) in [
            ("belt.svg", after),
            ("image-0.png", after),
            ("image-7.png", before),
            ("reliefs.svg", before),
            ("raw-1.png", before),
            ("empty.png", before),
            ("drawing.svg", before),
        ] {
            let file = std::fs::File::create(folder.join(name)).expect("a file");
            file.set_modified(written).expect("a time");
        }
        assert_eq!(pictures(&folder, began), ["image-7.png", "reliefs.svg"].map(|name| folder.join(name)));
        assert!(named(&folder, began).ends_with("reliefs.svg\n"));
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
