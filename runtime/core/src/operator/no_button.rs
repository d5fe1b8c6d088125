//! Why words are no button.

/// A word that is no button.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}\n help: {help}")]
pub struct NoButton {
    /// Why it was refused.
    pub what: String,
    /// What to do about it.
    pub help: String,
}
