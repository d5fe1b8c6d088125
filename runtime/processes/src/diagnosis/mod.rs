//! What can be found out about a machine before a cell runs on it.
//!
//! In: the limits of the machine, and times measured on it. Out: texts for a person ([`doctor`]); in tests, how long a round trip on the
//! link takes.

pub(crate) mod doctor;
#[cfg(test)]
mod latency;
