//! Recordings: what is in the file, that a replay demands the same, and that nothing slow or broken reaches the step.

mod allocation;
mod cell;
mod files;
mod replay;
mod slow;
