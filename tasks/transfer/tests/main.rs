//! The transfer, its command and what its README shows.

mod clear;
mod cli;
mod force;
mod four_arms;
mod lines;
mod readme;
mod support;
mod task;
