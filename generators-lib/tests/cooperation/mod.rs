//! Cooperating simulated arms in whole cells.
#![allow(non_snake_case)]

mod drive;
mod follow;
mod free;
mod kit;
mod physics;
mod squeeze;
mod transfer;
