//! Whole-system tests of `mrroc`: see the folders under `tests/`, one per promise.
