//! What a cell asks of its machine.
//!
//! In: a cell's file, its hardware, and how many processes it has. Out: names that only one cell at a time has ([`identity`]),
//! priorities, cores and locked memory ([`scheduling`]), enough shared memory and open files ([`capacity`]), the signals of a
//! terminal ([`signals`]); or what the machine does not grant.

pub(crate) mod capacity;
pub(crate) mod identity;
pub(crate) mod scheduling;
pub(crate) mod signals;
