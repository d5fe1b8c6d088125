//! The transfer, its command and what its README shows.

mod clear;
mod cli;
mod force;
mod four_arms;
mod lines;
mod readme;
mod support;
mod task;

/// Of the moments of a run that a test tries, every one with `MRROC_WHOLE=1` (`just test-whole`), and otherwise every so
/// manieth.
fn one_of(every: usize) -> usize {
    if std::env::var_os("MRROC_WHOLE").is_some() { 1 } else { every }
}
