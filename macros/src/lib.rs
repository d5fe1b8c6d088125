//! Attribute macros of `mrroc`.
