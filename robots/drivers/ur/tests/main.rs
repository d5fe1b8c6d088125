//! The drives, the arms and their calibrations, through what the crate makes public: one executable.

mod calibration;
mod controller;
mod load;
mod network;
mod real_time;
mod wrench;

/// Counts for each thread, so that tests may run at the same time.
#[global_allocator]
static ALLOCATOR: mrroc_counting_allocator::Counting = mrroc_counting_allocator::Counting;
