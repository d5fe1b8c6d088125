//! `mrroc-new` as a newcomer meets it, and what becomes of what it makes.

#[cfg(target_os = "linux")]
mod disk;
mod generated;
mod generator;
mod project;
mod support;
