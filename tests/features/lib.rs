//! Nothing: its manifest has a meaning.
