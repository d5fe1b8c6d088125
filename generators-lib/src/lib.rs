//! Motion generators for `mrroc`.
