//! Paths as they are written in a shell.

use std::path::Path;

/// The path, quoted when it must be.
#[must_use]
pub fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "-_./".contains(c) || (cfg!(windows) && r"\:".contains(c));
    if text.starts_with('-') {
        return quoted(&Path::new(".").join(path));
    }
    if !text.is_empty() && text.chars().all(plain) {
        text
    } else if cfg!(windows) {
        format!("\"{text}\"")
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_quoted_when_it_must_be() {
        for (path, expected) in [
            ("a/b-1_c.d", "a/b-1_c.d"),
            ("my tasks/a", "'my tasks/a'"),
            ("it's", r"'it'\''s'"),
            ("-p", "./-p"),
        ] {
            assert_eq!(quoted(Path::new(path)), expected);
        }
    }
}
