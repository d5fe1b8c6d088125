//! What keeps robots within their limits and brings them to a standstill.
//!
//! In: demands, limits, causes of stops. Out: accepted demands, motions to a standstill, the latch. Pure functions of states;
//! nothing here knows a process.

pub(crate) mod advice;
pub(crate) mod braking;
pub(crate) mod common_twist;
pub(crate) mod latch;
pub(crate) mod limits;
pub(crate) mod ramp;
pub(crate) mod rate;
pub(crate) mod stopping;
