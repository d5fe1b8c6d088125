//! Why words are no request.

/// Words that are no request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}\n help: {help}")]
pub struct NoRequest {
    /// Why they were refused.
    pub what: String,
    /// What to do about it.
    pub help: String,
}

impl NoRequest {
    /// A known word with what cannot stand behind it, and what to write; without an example, the word alone.
    pub(super) fn of(word: &str, rest: &str, example: &str) -> NoRequest {
        let what = format!("`{}` is no request", format!("{word} {rest}").trim_end().escape_default());
        let help =
            if example.is_empty() { format!("write {word} alone") } else { format!("write {example}") };
        NoRequest { what, help }
    }

    /// In one line, for consoles and pages.
    #[must_use]
    pub fn in_a_line(&self) -> String {
        format!("{}: {}", self.what, self.help)
    }
}
