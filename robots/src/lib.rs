//! Robots for `mrroc`.
