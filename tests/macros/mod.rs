//! What a programmer writes with the macros: what becomes of it, and what mistakes are answered with.

mod behaviour;
#[allow(unreachable_pub, dead_code)]
mod cell;
mod diagnostics;
