//! A touch probe.
