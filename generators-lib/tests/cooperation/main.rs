//! Cooperating simulated arms in whole cells.

mod drive;
//mod free;
mod kit;
//mod squeeze;
mod transfer;
